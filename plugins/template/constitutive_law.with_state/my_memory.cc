#include <feib/energy_law.h>
#include <feib/plugin.h>

#include "my_memory_schema.h"

#include <algorithm>

namespace my_memory_plugin
{
  /// W = mu/2 phi(w), w = I1 - m, a material that remembers M, the largest w so far: it is softer
  /// below it,
  ///   phi' = 1 for w >= M,   s + (1 - s) <w>/M for w < M,   <x> = max(x, 0).
  /// Its integral, phi = s w + (1 - s)/2 (<w>^2 - <w - M>^2)/M, counts beyond M what is stored and
  /// what is lost on the way there. C = F^T F has m rows, m being the dimension of the structure.
  template <int m, int dim>
  class MyMemory : public feib::EnergyLaw<MyMemory<m, dim>, m, dim>
  {
  public:
    using Base   = feib::EnergyLaw<MyMemory<m, dim>, m, dim>;
    using Matrix = typename Base::Matrix;

    explicit MyMemory(const feib::Parameters &parameters)
      : mu(parameters.number("shear_modulus"))
      , s(parameters.number("softened"))
      , onset(parameters.number("onset"))
    {}

    template <typename Number>
    Number
    density(const feib::SymmetricMatrix<m, Number> &C, const feib::PointBatch &points) const
    {
      const auto M      = points(this->moment().state[0]);
      const Number w    = trace(C) - m;
      const Number up   = positive_part(w);
      const Number more = positive_part(w - M);
      return (.5 * mu) * (s * w + .5 * (1 - s) * (up * up - more * more) / M);
    }

    /// Kept by the structure for each element: a name for the output, and the value at the start.
    std::vector<typename Base::StateVariable>
    state_variables() const override
    {
      return {{"largest_w", onset}};
    }

    /// At the end of a step; @p state comes as it was during the step.
    void
    update_state(const std::vector<Matrix> &F,
                 std::vector<std::vector<double>> &state) const override
    {
      for (std::size_t q = 0; q < F.size(); ++q)
        {
          double w = -m;
          for (int i = 0; i < dim; ++i)
            w += F[q][i] * F[q][i];
          state[0][q] = std::max(state[0][q], w);
        }
    }

  private:
    const double mu, s, onset;
  };
} // namespace my_memory_plugin

FEIB_PLUGIN("my_memory", "1.0", registry)
{
  registry.add<feib::ConstitutiveLaw, my_memory_plugin::MyMemory>("my_memory", my_memory_schema);
}
