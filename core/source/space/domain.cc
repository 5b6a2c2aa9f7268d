// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/domain.h>

#include <feib/error.h>
#include <feib/lattice.h>
#include <feib/message.h>

#include <cmath>
#include <limits>
#include <set>
#include <string>

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

    std::string
    face_name(const unsigned int face)
    {
      return std::string(direction_names[face / 2]) + (face % 2 == 0 ? "_min" : "_max");
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
    std::array<bool, dim> directions{};
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
        directions[a] = true;
      }
    read_boundary(parameters.child("boundary"), directions);
    try
      {
        Lattice<dim>(*this, 1);
      }
    catch (const RunFailure &failure)
      {
        parameters.fail("cells", failure.what());
      }
  }


  template <int dim>
  Domain<dim>::Domain(const dealii::Point<dim> &lower,
                      const dealii::Point<dim> &upper,
                      const std::array<unsigned int, dim> &cells)
    : lower(lower)
    , upper(upper)
    , cells(cells)
    , conditions(2 * dim)
  {
    for (unsigned int f = 0; f < 2 * dim; ++f)
      {
        first_of_face[f]   = f;
        conditions[f].face = f;
        conditions[f].name = face_name(f);
      }
  }


  template <int dim>
  void
  Domain<dim>::read_boundary(const Parameters &boundary, const std::array<bool, dim> &is_periodic)
  {
    for (unsigned int f = 2 * dim; f < 6; ++f)
      if (boundary.has(face_name(f)))
        boundary.fail(face_name(f), "there is no such face in dimension " + std::to_string(dim));
    std::set<std::string> names;
    for (unsigned int f = 0; f < 2 * dim; ++f)
      {
        const std::string name = face_name(f);
        first_of_face[f]       = conditions.size();
        if (is_periodic[f / 2])
          {
            if (boundary.has(name))
              boundary.fail(name,
                            std::string("the box is periodic in ") + direction_names[f / 2] +
                              "; such a face takes no condition");
            conditions.emplace_back();
            conditions.back().kind  = BoundaryCondition<dim>::Kind::periodic;
            conditions.back().tight = false;
          }
        else if (boundary.has(name))
          read_face(boundary.child(name), f);
        else if (boundary.has("all"))
          read_face(boundary.child("all"), f);
        else
          conditions.emplace_back();
        for (unsigned int i = first_of_face[f]; i < conditions.size(); ++i)
          {
            conditions[i].face = f;
            if (conditions[i].name.empty())
              conditions[i].name = name;
            if (!names.insert(conditions[i].name).second)
              boundary.fail("",
                            "has two conditions called \"" + conditions[i].name +
                              "\"; results need a name for each");
          }
      }
    check_regulated();
  }


  template <int dim>
  void
  Domain<dim>::read_face(const Parameters &parameters, const unsigned int face)
  {
    const auto [type, block] = parameters.choice();
    if (type != "parts")
      {
        conditions.emplace_back(parameters, face);
        return;
      }
    unsigned int number = 0;
    for (const Parameters &part : block.children("list"))
      {
        conditions.emplace_back(part.child("condition"), face);
        conditions.back().where = parse_expressions<dim>(part, "where", 1, Variables::space_time);
        if (depends_on_time(part, "where"))
          part.fail("where", "depends on the time; a part of a face stays where it is");
        conditions.back().name =
          part.has("name") ? part.word("name") : face_name(face) + "_" + std::to_string(++number);
      }
    conditions.emplace_back(block.child("elsewhere"), face);
  }


  template <int dim>
  void
  Domain<dim>::check_regulated() const
  {
    const BoundaryCondition<dim> *flux = nullptr;
    for (const auto &condition : conditions)
      {
        if (condition.open() && !condition.flux)
          return;
        if (condition.flux)
          flux = &condition;
      }
    if (flux)
      throw Error(flux->pointer,
                  "prescribes a flux, but no other face lets the pressure be known: one needs the "
                  "condition outflow, pressure, traction or windkessel; with fluxes alone, "
                  "prescribe a velocity instead");
  }


  template <int dim>
  bool
  Domain<dim>::enclosed() const
  {
    for (const auto &condition : conditions)
      if (condition.open())
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
        result[a]         = (x[a] <= lower[a] + near && conditions[condition_at(2 * a, x)].tight) ||
                    (x[a] >= upper[a] - near && conditions[condition_at(2 * a + 1, x)].tight);
      }
    return result;
  }


  template <int dim>
  bool
  Domain<dim>::time_dependent() const
  {
    for (const auto &condition : conditions)
      if (condition.time_dependent)
        return true;
    return false;
  }


  template struct Domain<2>;
  template struct Domain<3>;
} // namespace feib
