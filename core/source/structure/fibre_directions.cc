// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/fibre_directions.h>

#include <feib/expression.h>
#include <feib/message.h>

#include <cmath>

namespace feib
{
  template <int structure_dim, int dim>
  FibreDirections<structure_dim, dim>::FibreDirections(const Parameters &parameters)
    : pointer(parameters.pointer() + "/fibres")
  {
    for (unsigned int k = 0; parameters.has("fibres/" + std::to_string(k)); ++k)
      {
        const std::string key = "fibres/" + std::to_string(k);
        given_families.emplace_back();
        if (parameters.has(key + "/0"))
          given_families.back().expressions =
            parse_expressions<dim>(parameters, key, dim, Variables::reference);
        else
          given_families.back().data = parameters.string(key);
      }
    if (given_families.empty() && structure_dim > 1)
      parameters.fail(
        "fibres",
        "is empty; a body or surface needs at least one direction, e.g. [[\"1\", \"0\"" +
          std::string(dim == 3 ? ", \"0\"" : "") + "]]");
    families = given_families.empty() ? 1 : given_families.size();
  }

  template <int structure_dim, int dim>
  dealii::Tensor<1, dim>
  FibreDirections<structure_dim, dim>::given(const unsigned int family,
                                             const MaterialPoint &point) const
  {
    const auto &[expressions, name] = given_families[family];
    dealii::Tensor<1, dim> result;
    if (expressions)
      {
        for (unsigned int i = 0; i < dim; ++i)
          result[i] = expressions->value(point.place, i);
        return result;
      }
    const auto found = point.data.find(name);
    if (found == point.data.end())
      {
        std::string known;
        for (const auto &[other, value] : point.data)
          known += (known.empty() ? "" : ", ") + ('"' + readable(other) + '"');
        throw Error(pointer + "/" + std::to_string(family),
                    "names data of the mesh file, \"" + readable(name) + "\"; its elements have " +
                      (known.empty() ? "none" : known));
      }
    for (unsigned int i = 0; i < dim; ++i)
      result[i] = found->second[i];
    return result;
  }

  template <int structure_dim, int dim>
  void
  FibreDirections<structure_dim, dim>::set_points(const std::vector<MaterialPoint> &points)
  {
    Direction along_the_curve;
    along_the_curve[0] = 1;
    directions.clear();
    directions.reserve(points.size() * families);
    for (const MaterialPoint &point : points)
      {
        if (given_families.empty())
          directions.push_back(along_the_curve);
        for (unsigned int f = 0; f < given_families.size(); ++f)
          {
            const dealii::Tensor<1, dim> whole = given(f, point);
            Direction direction;
            for (unsigned int k = 0; k < structure_dim; ++k)
              direction[k] = whole * point.frame[k];
            const double length = direction.norm();
            if (!(length > 1e-12 * whole.norm()) || !std::isfinite(length))
              {
                std::string found;
                for (unsigned int i = 0; i < dim; ++i)
                  found += (i ? ", " : "") + readable(point.place[i]);
                throw Error(pointer + "/" + std::to_string(f),
                            "has no direction in the structure at the reference place (" + found +
                              "); it must be finite and not zero there");
              }
            directions.push_back(direction / length);
          }
      }
  }

  template class FibreDirections<1, 2>;
  template class FibreDirections<2, 2>;
  template class FibreDirections<2, 3>;
  template class FibreDirections<3, 3>;
} // namespace feib
