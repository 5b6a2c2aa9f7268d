// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/constitutive_law.h>
#include <feib/message.h>
#include <feib/plugin.h>
#include <feib/registry.h>

#include "by_material_schema.h"

#include <algorithm>
#include <memory>
#include <string>

namespace feib
{
  /// Other laws, each at the points of its materials. The state variables of all are its own, each
  /// with values at its law's points and 0 elsewhere.
  template <int structure_dim, int dim>
  class ByMaterial : public ConstitutiveLaw<structure_dim, dim>
  {
  public:
    using Law           = ConstitutiveLaw<structure_dim, dim>;
    using Matrix        = typename Law::Matrix;
    using MaterialPoint = typename Law::MaterialPoint;
    using Moment        = typename Law::Moment;
    using StateVariable = typename Law::StateVariable;
    using State         = std::vector<std::vector<double>>;

    explicit ByMaterial(const Parameters &parameters)
      : pointer(parameters.pointer())
    {
      std::vector<std::string> all;
      for (const Parameters &block : parameters.children("laws"))
        {
          parts.emplace_back();
          Part &part     = parts.back();
          part.pointer   = block.pointer() + "/materials";
          part.materials = block.expressions("materials");
          part.law       = block.child("law").create<Law>();
          for (const std::string &material : part.materials)
            {
              if (std::count(all.begin(), all.end(), material) > 0)
                block.fail("materials",
                           "lists the material " + readable(material) +
                             " a second time; each has one law");
              all.push_back(material);
            }
        }
    }

    void
    set_points(const std::vector<MaterialPoint> &points) override
    {
      n_points = points.size();
      for (Part &part : parts)
        part.points.clear();
      for (unsigned int q = 0; q < points.size(); ++q)
        part_of(points[q]).points.push_back(q);
      for (Part &part : parts)
        part.law->set_points(at(part, points));
    }

    std::vector<StateVariable>
    state_variables() const override
    {
      std::vector<StateVariable> result;
      for (unsigned int k = 0; k < parts.size(); ++k)
        for (StateVariable variable : parts[k].law->state_variables())
          {
            variable.name += "_" + std::to_string(k);
            result.push_back(variable);
          }
      return result;
    }

    void
    set_moment(const Moment &moment) override
    {
      Law::set_moment(moment);
      unsigned int v = 0;
      for (Part &part : parts)
        {
          part.moment.time    = moment.time;
          part.moment.elapsed = moment.elapsed;
          part.moment.state.clear();
          // Before the structure has a state there is none.
          for (std::size_t n = part.law->state_variables().size(); n > 0 && v < moment.state.size();
               --n, ++v)
            part.moment.state.push_back(at(part, moment.state[v]));
          part.law->set_moment(part.moment);
        }
    }

    void
    energy(const std::vector<Matrix> &F, std::vector<double> &W) const override
    {
      W.resize(n_points);
      for (const Part &part : parts)
        {
          std::vector<double> values(part.points.size());
          part.law->energy(at(part, F), values);
          put(part, values, W);
        }
    }

    void
    stress(const std::vector<Matrix> &F, std::vector<Matrix> &P) const override
    {
      P.resize(n_points);
      for (const Part &part : parts)
        {
          std::vector<Matrix> values(part.points.size());
          part.law->stress(at(part, F), values);
          put(part, values, P);
        }
    }

    void
    stress_derivative(const std::vector<Matrix> &F,
                      const std::vector<Matrix> &dF,
                      std::vector<Matrix> &dP) const override
    {
      dP.resize(n_points);
      for (const Part &part : parts)
        {
          std::vector<Matrix> values(part.points.size());
          part.law->stress_derivative(at(part, F), at(part, dF), values);
          put(part, values, dP);
        }
    }

    void
    update_state(const std::vector<Matrix> &F, State &state) const override
    {
      unsigned int v = 0;
      for (const Part &part : parts)
        {
          State values = part.moment.state;
          part.law->update_state(at(part, F), values);
          for (const std::vector<double> &variable : values)
            put(part, variable, state[v++]);
        }
    }

    bool
    viscous() const override
    {
      return any([](const Law &law) { return law.viscous(); });
    }

    void
    viscous_stress(const std::vector<Matrix> &F,
                   const std::vector<Matrix> &rate,
                   std::vector<Matrix> &P) const override
    {
      P.resize(n_points);
      for (const Part &part : parts)
        {
          std::vector<Matrix> values(part.points.size());
          part.law->viscous_stress(at(part, F), at(part, rate), values);
          put(part, values, P);
        }
    }

    void
    archive(Archive &archive) override
    {
      for (unsigned int k = 0; k < parts.size(); ++k)
        archive("law_" + std::to_string(k), *parts[k].law);
    }

    bool
    time_dependent() const override
    {
      return any([](const Law &law) { return law.time_dependent(); });
    }

    bool
    linear() const override
    {
      return !any([](const Law &law) { return !law.linear(); });
    }

    double
    tested_strain() const override
    {
      double least = parts[0].law->tested_strain();
      for (const Part &part : parts)
        least = std::min(least, part.law->tested_strain());
      return least;
    }

    bool
    needs_positive_determinant() const override
    {
      return any([](const Law &law) { return law.needs_positive_determinant(); });
    }

  private:
    struct Part
    {
      std::string pointer;
      std::vector<std::string> materials; // ids, and names in the mesh file
      std::unique_ptr<Law> law;
      std::vector<unsigned int> points; // indices
      Moment moment;                    // at these
    };

    Part &
    part_of(const MaterialPoint &point)
    {
      const std::string id = std::to_string(point.material_id);
      const std::string material =
        id + (point.material.empty() ? "" : " (\"" + readable(point.material) + "\")");
      std::string known;
      Part *result = nullptr;
      for (Part &part : parts)
        for (const std::string &listed : part.materials)
          {
            known += (known.empty() ? "" : ", ") + readable(listed);
            if (listed != id && (listed != point.material || point.material.empty()))
              continue;
            if (result && result != &part)
              throw Error(pointer + "/laws",
                          "has two laws for the material " + material +
                            " of the mesh, one by its id and one by its name");
            result = &part;
          }
      if (!result)
        throw Error(pointer + "/laws",
                    "has no law for the material " + material +
                      " of the mesh; there are laws for " + known);
      return *result;
    }

    template <typename Value>
    static std::vector<Value>
    at(const Part &part, const std::vector<Value> &values)
    {
      std::vector<Value> result;
      result.reserve(part.points.size());
      for (const unsigned int q : part.points)
        result.push_back(values[q]);
      return result;
    }

    template <typename Value>
    static void
    put(const Part &part, const std::vector<Value> &values, std::vector<Value> &all)
    {
      for (unsigned int i = 0; i < part.points.size(); ++i)
        all[part.points[i]] = values.at(i);
    }

    template <typename Question>
    bool
    any(const Question &question) const
    {
      return std::any_of(parts.begin(), parts.end(), [&](const Part &part) {
        return question(*part.law);
      });
    }

    const std::string pointer;
    std::vector<Part> parts;
    std::size_t n_points = 0;
  };
} // namespace feib

FEIB_PLUGIN("by_material", "1.0", registry)
{
  registry.add<feib::ConstitutiveLaw, feib::ByMaterial>("by_material", by_material_schema);
}
