// SPDX-License-Identifier: LGPL-2.1-or-later
#include "earlier_flow.h"

#include "checkpoint_archive.h"
#include "json.h"

#include <feib/error.h>
#include <feib/failure.h>
#include <feib/message.h>
#include <feib/simulation.h>

#include <algorithm>
#include <sstream>

namespace feib
{
  template <int dim>
  EarlierFlow<dim>::EarlierFlow(const Parameters &parameters, const Domain<dim> &box)
  {
    const std::string run = parameters.path("run");
    Json earlier;
    try
      {
        const CheckpointInfo checkpoint = CheckpointInfo::newest(run, parameters.communicator());
        folder                          = checkpoint.folder;
        earlier                         = Json::parse(checkpoint.case_text);
      }
    catch (const Error &error)
      {
        parameters.fail("run", error.issues().front().message);
      }
    if (earlier["dimension"] != dim)
      parameters.fail("run",
                      "the run \"" + readable(run) + "\" has the dimension " +
                        earlier["dimension"].dump() + ", this case " + std::to_string(dim));
    const Json &domain = earlier["domain"];
    for (unsigned int a = 0; a < dim; ++a)
      {
        lower[a]          = domain.contains("lower") ? domain["lower"][a].get<double>() : 0.;
        upper[a]          = domain.contains("upper") ? domain["upper"][a].get<double>() : 1.;
        cells[a]          = domain["cells"][a].get<unsigned int>();
        const double near = round_off(lower[a], upper[a]);
        if (box.lower[a] < lower[a] - near || box.upper[a] > upper[a] + near)
          {
            std::ostringstream message;
            message << "the box of the run \"" << readable(run) << "\" goes from (" << lower
                    << ") to (" << upper << ") and does not hold that of this case, (" << box.lower
                    << ") to (" << box.upper << ')';
            parameters.fail("run", message.str());
          }
      }
  }


  template <int dim>
  void
  EarlierFlow<dim>::interpolate(EulerianSpace<dim> &space) const
  {
    constexpr unsigned int n = EulerianSpace<dim>::n_nodes;
    // Places and numbers of nodes do not depend on what holds on faces.
    EulerianSpace<dim> earlier(Domain<dim>(lower, upper, cells), MPI_COMM_SELF);
    agree(space.communicator(), [&] {
      CheckpointReader<dim> reader(earlier, folder);
      reader("space", earlier);
    });
    earlier.velocity.update_ghost_values();
    space.velocity.zero_out_ghost_values();
    const unsigned int n_owned = space.velocity.locally_owned_size();
    double shapes[n];
    for (unsigned int c = 0; c < space.cells().size(); ++c)
      for (unsigned int i = 0; i < n; ++i)
        {
          if (space.velocity_dofs(c)[i] >= n_owned)
            continue;
          dealii::Point<dim> x = space.cells()[c].lower, unit;
          unsigned int rest    = i;
          for (unsigned int a = 0; a < dim; ++a, rest /= 3)
            x[a] =
              std::clamp(x[a] + space.cells()[c].size[a] * (rest % 3) / 2., lower[a], upper[a]);
          const unsigned int cell = earlier.forest().locate(x, unit);
          AssertThrow(cell != CartesianForest<dim>::not_here, dealii::ExcInternalError());
          EulerianSpace<dim>::shape_values(unit, shapes);
          for (unsigned int a = 0; a < dim; ++a)
            {
              double value = 0;
              for (unsigned int j = 0; j < n; ++j)
                value += shapes[j] *
                         earlier.velocity.local_element(earlier.velocity_dofs(cell)[a * n + j]);
              space.velocity.local_element(space.velocity_dofs(c)[a * n + i]) = value;
            }
        }
  }


  template class EarlierFlow<2>;
  template class EarlierFlow<3>;
} // namespace feib
