// SPDX-License-Identifier: LGPL-2.1-or-later
#include "../elastic_structure.h"

#include <feib/plugin.h>

#include "hyperelastic_schema.h"

namespace feib
{
  /// The elastic structure a thick body, m = dim.
  template <int dim>
  class Hyperelastic : public ElasticStructure<dim, dim>
  {
  public:
    using ElasticStructure<dim, dim>::ElasticStructure;
  };
} // namespace feib

FEIB_PLUGIN("hyperelastic", "1.0", registry)
{
  registry.add<feib::StructureModel, feib::Hyperelastic>("hyperelastic", hyperelastic_schema);
}
