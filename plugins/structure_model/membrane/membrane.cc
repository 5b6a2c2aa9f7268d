// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/plugin.h>
#include <feib/reference_mesh.h>
#include <feib/registry.h>
#include <feib/structure_model/elastic_structure.h>

#include "membrane_schema.h"

namespace feib
{
  /// The elastic structure a curve or surface, m = dim - 1.
  template <int dim>
  class Membrane : public ElasticStructure<dim - 1, dim>
  {
  public:
    explicit Membrane(const Parameters &parameters)
      : ElasticStructure<dim - 1, dim>(parameters, make_law(parameters))
    {}

  private:
    static std::unique_ptr<ConstitutiveLaw<dim - 1, dim>>
    make_law(const Parameters &parameters)
    {
      try
        {
          return parameters.child("law").create<ConstitutiveLaw<dim - 1, dim>>();
        }
      catch (const Error &)
        {
          // What a law lacks does not matter where the mesh is for other dimensions, as a curve is.
          make_reference_mesh<dim>(parameters.child("mesh"), dim - 1);
          throw;
        }
    }
  };
} // namespace feib

FEIB_PLUGIN("membrane", "1.0", registry)
{
  registry.add<feib::StructureModel, feib::Membrane>("membrane", membrane_schema);
}
