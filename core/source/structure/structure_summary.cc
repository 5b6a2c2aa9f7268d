// SPDX-License-Identifier: LGPL-2.1-or-later
#include "structure_summary.h"

#include <algorithm>
#include <cmath>

namespace feib
{
  namespace
  {
    /// dim! times the measure of an element of a body.
    template <int dim>
    double
    determinant_of(const typename LagrangianMesh<dim>::Element &element, const Positions<dim> &X)
    {
      dealii::Tensor<2, dim> edges;
      for (unsigned int k = 0; k < dim; ++k)
        edges[k] = X[element.nodes[k + 1]] - X[element.nodes[0]];
      return determinant(edges);
    }

    /// The relative changes of the measures of a body's elements: root of the mean square, with
    /// their reference measures as weights, and largest.
    template <int dim>
    Json
    element_changes(const StructureModel<dim> &model, const Positions<dim> &initial)
    {
      double squares = 0, weights = 0, largest = 0;
      for (const auto &element : model.mesh().elements())
        {
          const double before = determinant_of<dim>(element, initial);
          if (before == 0) // collapsed from the start: no relative change
            continue;
          const double change = determinant_of<dim>(element, model.positions) / before - 1;
          squares += element.measure * change * change;
          weights += element.measure;
          largest = std::max(largest, std::abs(change));
        }
      return {{"rms", weights > 0 ? std::sqrt(squares / weights) : 0.}, {"largest", largest}};
    }
  } // namespace


  template <int dim>
  Json
  structure_summary(const StructureModel<dim> &model, const double leak, const double time_error)
  {
    const double measure_initial      = model.measure(model.initial_positions);
    const double measure              = model.measure(model.positions);
    const dealii::Point<dim> centroid = model.centroid(model.positions);
    Json centre = Json::array(), extent = Json::array();
    for (unsigned int a = 0; a < dim; ++a)
      {
        const Positions<dim> &X = model.positions;
        centre.push_back(centroid[a]);
        extent.push_back(X.largest([&](const unsigned int i) { return X[i][a]; }) +
                         X.largest([&](const unsigned int i) { return -X[i][a]; }));
      }
    Json result = {{"name", model.name()},
                   {"measure_initial", measure_initial},
                   {"measure_final", measure},
                   {"relative_measure_change", measure / measure_initial - 1},
                   {"relative_leak", leak / measure_initial},
                   {"relative_time_error", time_error / measure_initial},
                   {"centroid", centre},
                   {"extent", extent}};
    if (model.mesh().structure_dim() == dim)
      result["relative_element_change"] = element_changes(model, model.initial_positions);
    return result;
  }


  template Json structure_summary(const StructureModel<2> &, double, double);
  template Json structure_summary(const StructureModel<3> &, double, double);
} // namespace feib
