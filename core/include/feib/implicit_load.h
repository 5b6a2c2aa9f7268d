// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_implicit_load_h
#define feib_implicit_load_h

#include <feib/eulerian_space.h>
#include <feib/matrix_entry.h>

namespace feib
{
  /// A load <F(u), v> that depends on the velocity being computed: what implicit coupling adds to
  /// the fluid's equations. All functions are collective.
  template <int dim>
  class ImplicitLoad
  {
  public:
    virtual ~ImplicitLoad() = default;

    /// load += <F(u), v> on all degrees of freedom, compressed, before condensing; fixes where
    /// apply() and matrix() differentiate. @p u has its constraints distributed and its ghost
    /// values up to date. Throws RunFailure where F is not defined (an inverted element).
    virtual void evaluate(const VelocityVector &u, VelocityVector &load) = 0;

    /// Of the forces that evaluate() has added up last, which may cancel, the norm of the largest:
    /// what is left of a sum that should be nothing is judged by it.
    virtual double
    largest_part() const
    {
      return 0;
    }

    /// dst += - dF/du [du], over the degrees of freedom as in evaluate(); constraints count as
    /// homogeneous.
    virtual void apply(VelocityVector &dst, const VelocityVector &du) const = 0;

    /// Whether dF/du does not depend on u.
    virtual bool linear() const = 0;

    /// - dF/du as a sum of products left^T middle right, for preconditioners. Columns of left and
    /// right are global velocity unknowns, constrained ones too. Each rank gives a part of the
    /// entries. An empty list: not available.
    struct Product
    {
      std::uint64_t n_left, n_right; // rows of left and of right
      MatrixEntries left, middle, right;
      bool symmetric; // left and right are the same and middle is symmetric; left is then not given
    };
    virtual std::vector<Product> matrix() const = 0;
  };
} // namespace feib

#endif
