// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_tests_components_h
#define feib_tests_components_h

#include <feib/constitutive_law.h>
#include <feib/registry.h>

/// Small components to try registry, schemas and cases with.
namespace feib::testing
{
  /// W = c |F|^2 / 2
  template <int structure_dim, int dim>
  class Spring : public ConstitutiveLaw<structure_dim, dim>
  {
  public:
    using Matrix = typename ConstitutiveLaw<structure_dim, dim>::Matrix;

    explicit Spring(const Parameters &parameters)
      : c(parameters.number("c"))
    {}

    void
    energy(const std::vector<Matrix> &F, std::vector<double> &W) const override
    {
      for (std::size_t q = 0; q < F.size(); ++q)
        {
          W[q] = 0;
          for (unsigned int i = 0; i < dim; ++i)
            W[q] += c / 2 * (F[q][i] * F[q][i]);
        }
    }

    void
    stress(const std::vector<Matrix> &F, std::vector<Matrix> &P) const override
    {
      for (std::size_t q = 0; q < F.size(); ++q)
        P[q] = c * F[q];
    }

    void
    stress_derivative(const std::vector<Matrix> &,
                      const std::vector<Matrix> &dF,
                      std::vector<Matrix> &dP) const override
    {
      stress(dF, dP);
    }

  private:
    const double c;
  };


  /// c times the law in its slot.
  template <int structure_dim, int dim>
  class Scaled : public ConstitutiveLaw<structure_dim, dim>
  {
  public:
    using Matrix = typename ConstitutiveLaw<structure_dim, dim>::Matrix;

    explicit Scaled(const Parameters &parameters)
      : factor(parameters.number("factor"))
      , law(parameters.child("law").create<ConstitutiveLaw<structure_dim, dim>>())
    {}

    void
    energy(const std::vector<Matrix> &F, std::vector<double> &W) const override
    {
      law->energy(F, W);
      for (double &w : W)
        w *= factor;
    }

    void
    stress(const std::vector<Matrix> &F, std::vector<Matrix> &P) const override
    {
      law->stress(F, P);
      for (Matrix &p : P)
        p *= factor;
    }

    void
    stress_derivative(const std::vector<Matrix> &F,
                      const std::vector<Matrix> &dF,
                      std::vector<Matrix> &dP) const override
    {
      law->stress_derivative(F, dF, dP);
      for (Matrix &p : dP)
        p *= factor;
    }

  private:
    const double factor;
    std::unique_ptr<ConstitutiveLaw<structure_dim, dim>> law;
  };


  /// A component of any kind that only keeps its parameters.
  template <int dim>
  struct Interface
  {
    explicit Interface(const Parameters &parameters)
      : parameters(parameters)
    {}
    virtual ~Interface() = default;

    Parameters parameters;
  };

#define FEIB_TEST_KIND(name)                       \
  template <int dim>                               \
  struct name##_interface : Interface<dim>         \
  {                                                \
    static constexpr const char *kind = #name;     \
    using Interface<dim>::Interface;               \
  };                                               \
  template <int dim>                               \
  struct name##_component : name##_interface<dim>  \
  {                                                \
    using name##_interface<dim>::name##_interface; \
  };

  FEIB_TEST_KIND(fluid_solver)
  FEIB_TEST_KIND(structure_model)
  FEIB_TEST_KIND(coupling_operator)
  FEIB_TEST_KIND(time_integrator)
  FEIB_TEST_KIND(refinement_strategy)
  FEIB_TEST_KIND(output_writer)
#undef FEIB_TEST_KIND

  const char *const spring_schema = R"({
    "type": "object", "additionalProperties": false, "description": "A spring.",
    "required": ["c"],
    "properties": {
      "c": { "type": "number", "exclusiveMinimum": 0, "description": "Stiffness [force/area]." }
    },
    "examples": [ { "c": 2 } ]
  })";

  const char *const scaled_schema = R"({
    "type": "object", "additionalProperties": false, "description": "Another law times a number.",
    "properties": {
      "factor": { "type": "number", "description": "The number [1].", "default": 1 },
      "law": { "slot": "constitutive_law", "description": "The law.", "default": { "spring": { "c": 3 } } }
    },
    "examples": [ {}, { "law": { "scaled": { "law": { "spring": { "c": 1 } } } } } ]
  })";

  const char *const empty_schema = R"({
    "type": "object", "additionalProperties": false, "description": "Nothing to choose.",
    "properties": {}, "examples": [ {} ]
  })";

  const char *const stokes_schema = R"({
    "type": "object", "additionalProperties": false, "description": "A fluid.",
    "required": ["viscosity"],
    "properties": {
      "viscosity": { "type": "number", "exclusiveMinimum": 0, "description": "Viscosity [1]." },
      "density": { "type": "number", "minimum": 0, "maximum": 100, "description": "Density [1].", "default": 1 },
      "convection": { "type": "string", "enum": ["none", "explicit"], "description": "Convection.", "default": "none" },
      "steady": { "type": "boolean", "description": "Whether.", "default": false },
      "sweeps": { "type": "integer", "minimum": 1, "description": "Sweeps.", "default": 2 },
      "force": {
        "type": "array", "minItems": 2, "maxItems": 3, "description": "Force; zero when not given.",
        "items": { "type": ["string", "number"], "description": "Expression." }
      },
      "solver": {
        "type": "object", "additionalProperties": false, "description": "Solver.", "default": {},
        "properties": { "tolerance": { "type": "number", "description": "Tolerance.", "default": 1e-10 } }
      },
      "probes": {
        "type": "array", "description": "Probes.", "default": [],
        "items": {
          "type": "object", "additionalProperties": false, "required": ["at"], "description": "A probe.",
          "properties": {
            "at": { "type": "number", "description": "Place." },
            "weight": { "type": "number", "description": "Weight.", "default": 0.5 }
          }
        }
      },
      "marks": {
        "type": "object", "description": "Named marks.", "default": {}, "additionalProperties": {
          "type": "object", "additionalProperties": false, "description": "A mark.",
          "properties": { "size": { "type": "integer", "description": "Size.", "default": 7 } }
        }
      }
    },
    "examples": [ { "viscosity": 1 } ]
  })";

  const char *const body_schema = R"({
    "type": "object", "additionalProperties": false, "description": "A body.",
    "required": ["law"],
    "properties": { "law": { "slot": "constitutive_law", "description": "The law." } },
    "examples": [ { "law": { "spring": { "c": 1 } } } ]
  })";

  /// A registry with which the smallest case is valid.
  inline Registry
  small_registry()
  {
    Registry registry;
    registry.add<ConstitutiveLaw, Spring>("spring", spring_schema);
    registry.add<ConstitutiveLaw, Scaled>("scaled", scaled_schema);
    registry.add<fluid_solver_interface, fluid_solver_component>("stokes", stokes_schema);
    registry.add<structure_model_interface, structure_model_component>("body", body_schema);
    registry.add<coupling_operator_interface, coupling_operator_component>("divergence_free",
                                                                           empty_schema);
    registry.add<time_integrator_interface, time_integrator_component>("midpoint", empty_schema);
    registry.add<refinement_strategy_interface, refinement_strategy_component>("uniform",
                                                                               empty_schema);
    registry.add<output_writer_interface, output_writer_component>("vtu", empty_schema);
    registry.add<output_writer_interface, output_writer_component>("ledger_csv", empty_schema);
    return registry;
  }

  /// The smallest case.
  const char *const small_case = R"({
  "dimension": 2,
  "domain": { "cells": [4, 4] },
  "fluid": { "stokes": { "viscosity": 1.0 } },
  "time": { "step": 0.1, "end": 1.0 }
}
)";
} // namespace feib::testing

#endif
