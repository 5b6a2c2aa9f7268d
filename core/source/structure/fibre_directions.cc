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
      functions.push_back(parse_expressions<dim>(
        parameters, "fibres/" + std::to_string(k), dim, Variables::reference));
    if (functions.empty() && structure_dim > 1)
      parameters.fail(
        "fibres",
        "is empty; a body or surface needs at least one direction, e.g. [[\"1\", \"0\"" +
          std::string(dim == 3 ? ", \"0\"" : "") + "]]");
    families = functions.empty() ? 1 : functions.size();
  }

  template <int structure_dim, int dim>
  void
  FibreDirections<structure_dim, dim>::set_points(
    const std::vector<typename ConstitutiveLaw<structure_dim, dim>::MaterialPoint> &points)
  {
    Direction along_the_curve;
    along_the_curve[0] = 1;
    directions.clear();
    directions.reserve(points.size() * families);
    for (const auto &point : points)
      {
        if (functions.empty())
          directions.push_back(along_the_curve);
        for (unsigned int f = 0; f < functions.size(); ++f)
          {
            dealii::Tensor<1, dim> given;
            for (unsigned int i = 0; i < dim; ++i)
              given[i] = functions[f]->value(point.place, i);
            Direction direction;
            for (unsigned int k = 0; k < structure_dim; ++k)
              direction[k] = given * point.frame[k];
            const double length = direction.norm();
            if (!(length > 1e-12 * given.norm()) || !std::isfinite(length))
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
