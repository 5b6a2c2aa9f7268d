// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/domain.h>

#include <feib/error.h>
#include <feib/expression.h>
#include <feib/lattice.h>
#include <feib/message.h>

#include <deal.II/base/function.h>

#include <cmath>
#include <limits>

namespace feib
{
  namespace
  {
    const char *const direction_names[] = {"x", "y", "z"};

    template <int dim>
    dealii::Point<dim>
    corner(const Parameters &parameters, const std::string &key, const double value_when_not_given)
    {
      dealii::Point<dim> result;
      for (unsigned int a = 0; a < dim; ++a)
        result[a] = value_when_not_given;
      if (!parameters.has(key))
        return result;
      const std::vector<double> numbers = parameters.numbers(key);
      if (numbers.size() != dim)
        parameters.fail(key,
                        "found " + std::to_string(numbers.size()) +
                          " coordinates, the dimension is " + std::to_string(dim));
      for (unsigned int a = 0; a < dim; ++a)
        result[a] = numbers[a];
      return result;
    }

    template <int dim>
    typename Domain<dim>::Face
    make_face(const Parameters &parameters, const unsigned int direction)
    {
      typename Domain<dim>::Face face;
      const auto [name, block] = parameters.choice();
      if (name == "no_slip")
        face.condition = BoundaryCondition::no_slip;
      else if (name == "free_slip")
        face.condition = BoundaryCondition::free_slip;
      else if (name == "outflow")
        {
          face.condition = BoundaryCondition::outflow;
          face.tight     = false;
        }
      else
        {
          face.condition      = BoundaryCondition::velocity;
          face.velocity       = parse_expressions<dim>(block, "value", dim, Variables::space_time);
          face.time_dependent = depends_on_time(block, "value");
          const std::string across = block.expressions("value")[direction];
          face.tight               = across == "0" || across == "0.0" || across == "-0.0";
        }
      return face;
    }
    /// Cells so flat, or so small beside their coordinates, that arithmetic loses them.
    template <int dim>
    void
    check_cells(const Parameters &parameters,
                const dealii::Point<dim> &lower,
                const dealii::Point<dim> &upper,
                const std::array<unsigned int, dim> &cells)
    {
      double shortest = std::numeric_limits<double>::infinity(), longest = 0, far = 0;
      for (unsigned int a = 0; a < dim; ++a)
        {
          const double h = (upper[a] - lower[a]) / cells[a];
          shortest       = std::min(shortest, h);
          longest        = std::max(longest, h);
          far            = std::max({far, std::abs(lower[a]), std::abs(upper[a])});
        }
      if (!(longest <= 1e6 * shortest))
        parameters.fail("cells",
                        "the cells are from " + readable(shortest) + " to " + readable(longest) +
                          " long; at most 1e+06 times as long as thick are allowed");
      if (!(far <= 1e12 * shortest))
        parameters.fail("cells",
                        "the cells are " + readable(shortest) + " long, and coordinates up to " +
                          readable(far) + " cannot tell them apart: move the box to the origin");
    }
  } // namespace


  template <int dim>
  Domain<dim>::Domain(const Parameters &parameters)
    : pointer(parameters.pointer())
    , lower(corner<dim>(parameters, "lower", 0.))
    , upper(corner<dim>(parameters, "upper", 1.))
  {
    for (unsigned int a = 0; a < dim; ++a)
      if (!(lower[a] < upper[a]))
        parameters.fail(parameters.has("upper") ? "upper" : "lower",
                        std::string("the box is empty in ") + direction_names[a] + ": from " +
                          readable(lower[a]) + " to " + readable(upper[a]) +
                          "; upper must be greater than lower");
    // Products of lengths of the order of dim, and their squares, stay finite and positive.
    constexpr double longest = 1e50;
    for (unsigned int a = 0; a < dim; ++a)
      if (!(std::abs(lower[a]) <= longest && std::abs(upper[a]) <= longest &&
            upper[a] - lower[a] >= 1 / longest))
        parameters.fail(parameters.has("upper") ? "upper" : "lower",
                        std::string("the box reaches from ") + readable(lower[a]) + " to " +
                          readable(upper[a]) + " in " + direction_names[a] +
                          "; coordinates may be at most 1e+50, and lengths at least 1e-50: "
                          "choose other units");

    const std::vector<int> numbers = parameters.integers("cells");
    if (numbers.size() != dim)
      parameters.fail("cells",
                      "found " + std::to_string(numbers.size()) +
                        " numbers of cells, the dimension is " + std::to_string(dim));
    for (unsigned int a = 0; a < dim; ++a)
      cells[a] = numbers[a];

    check_cells<dim>(parameters, lower, upper, cells);

    double n_cells = 1;
    for (unsigned int a = 0; a < dim; ++a)
      n_cells *= cells[a];
    if (n_cells > most_cells)
      parameters.fail("cells",
                      "found " + readable(n_cells) + " cells in all, at most 1e8 are allowed");

    const std::vector<std::string> periodic_directions = parameters.expressions("periodic");
    for (unsigned int i = 0; i < periodic_directions.size(); ++i)
      {
        unsigned int a = 0;
        while (periodic_directions[i] != direction_names[a])
          ++a;
        if (a >= dim)
          parameters.fail("periodic/" + std::to_string(i),
                          "found \"" + periodic_directions[i] + "\", the dimension is " +
                            std::to_string(dim));
        if (cells[a] < 2)
          parameters.fail("cells/" + std::to_string(a),
                          "found 1, a periodic direction needs at least 2 base cells");
        for (const unsigned int f : {2 * a, 2 * a + 1})
          {
            faces[f].condition = BoundaryCondition::periodic;
            faces[f].tight     = false;
          }
      }
    try
      {
        Lattice<dim>(*this, 1);
      }
    catch (const RunFailure &failure)
      {
        parameters.fail("cells", failure.what());
      }

    const Parameters boundary = parameters.child("boundary");
    for (unsigned int f = 0; f < 6; ++f)
      {
        const std::string name =
          std::string(direction_names[f / 2]) + (f % 2 == 0 ? "_min" : "_max");
        if (!boundary.has(name))
          continue;
        if (f / 2 >= dim)
          boundary.fail(name, "there is no such face in dimension " + std::to_string(dim));
        if (periodic(f / 2))
          boundary.fail(name,
                        std::string("the box is periodic in ") + direction_names[f / 2] +
                          "; such a face takes no condition");
        faces[f] = make_face<dim>(boundary.child(name), f / 2);
      }
    for (unsigned int f = 0; f < 2 * dim; ++f)
      faces[f].normal = f / 2;
  }


  template <int dim>
  bool
  Domain<dim>::enclosed() const
  {
    for (const Face &face : faces)
      if (face.open())
        return false;
    return true;
  }


  template <int dim>
  std::array<bool, dim>
  Domain<dim>::held(const dealii::Point<dim> &x) const
  {
    std::array<bool, dim> result;
    for (unsigned int a = 0; a < dim; ++a)
      {
        const double near = round_off(lower[a], upper[a]);
        result[a]         = (faces[2 * a].tight && x[a] <= lower[a] + near) ||
                    (faces[2 * a + 1].tight && x[a] >= upper[a] - near);
      }
    return result;
  }


  template <int dim>
  bool
  Domain<dim>::time_dependent() const
  {
    for (const Face &face : faces)
      if (face.time_dependent)
        return true;
    return false;
  }


  template struct Domain<2>;
  template struct Domain<3>;
} // namespace feib
