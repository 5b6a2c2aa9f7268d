// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/plugin.h>
#include <feib/registry.h>
#include <feib/structure_model/elastic_structure.h>
#include <feib/structure_model/volumetric_split.h>

#include "hyperelastic_schema.h"

namespace feib
{
  /// The elastic structure a thick body, m = dim.
  template <int dim>
  class Hyperelastic : public ElasticStructure<dim, dim>
  {
  public:
    explicit Hyperelastic(const Parameters &parameters)
      : ElasticStructure<dim, dim>(parameters, make_law(parameters))
    {}

  private:
    /// The law as chosen, or split when one of the options asks for it.
    static std::unique_ptr<ConstitutiveLaw<dim, dim>>
    make_law(const Parameters &parameters)
    {
      auto law              = parameters.child("law").create<ConstitutiveLaw<dim, dim>>();
      const bool deviatoric = parameters.boolean("deviatoric");
      const double k        = parameters.number("volumetric_modulus");
      if (deviatoric || k > 0)
        return std::make_unique<VolumetricSplit<dim>>(std::move(law), deviatoric, k);
      return law;
    }
  };
} // namespace feib

FEIB_PLUGIN("hyperelastic", "1.0", registry)
{
  registry.add<feib::StructureModel, feib::Hyperelastic>("hyperelastic", hyperelastic_schema);
}
