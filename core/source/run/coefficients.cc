// SPDX-License-Identifier: LGPL-2.1-or-later
#include "coefficients.h"

#include <feib/error.h>
#include <feib/message.h>

#include <cmath>
#include <string>
#include <vector>

namespace feib
{
  namespace
  {
    /// A direction of the case, of length 1; axis @p axis when not given.
    template <int dim>
    dealii::Tensor<1, dim>
    direction(const Parameters &parameters, const std::string &key, const unsigned int axis)
    {
      dealii::Tensor<1, dim> result;
      result[axis] = 1;
      if (!parameters.has(key))
        return result;
      const std::vector<double> numbers = parameters.numbers(key);
      if (numbers.size() != dim)
        parameters.fail(key,
                        "found " + std::to_string(numbers.size()) +
                          " components, the dimension is " + std::to_string(dim));
      for (unsigned int a = 0; a < dim; ++a)
        result[a] = numbers[a];
      if (!(result.norm() > 0))
        parameters.fail(key, "is zero; a direction is needed");
      return result / result.norm();
    }
  } // namespace


  template <int dim>
  Coefficients<dim>::Coefficients(const Parameters &parameters, const double density)
    : velocity(parameters.number("velocity"))
    , length(parameters.number("length"))
    , flow(direction<dim>(parameters, "flow", 0))
    , across(direction<dim>(parameters, "lift", 1))
  {
    const double area =
      parameters.has("area") ? parameters.number("area") : std::pow(length, dim - 1);
    reference_force = density / 2 * velocity * velocity * area;
    if (!(reference_force > 1e-100 && reference_force < 1e100))
      parameters.fail("velocity",
                      "gives the reference force density/2 velocity^2 " +
                        std::string(dim == 2 ? "length" : "area") + " = " +
                        readable(reference_force) + "; from 1e-100 to 1e+100 are allowed");
    if (std::abs(flow * across) > 1 - 1e-6)
      parameters.fail(parameters.has("lift") ? "lift" : "flow",
                      "makes lift the same as drag: the directions of flow and lift (x and y when "
                      "not given) must differ");
  }


  template struct Coefficients<2>;
  template struct Coefficients<3>;
} // namespace feib
