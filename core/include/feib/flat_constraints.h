// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_flat_constraints_h
#define feib_flat_constraints_h

#include <deal.II/base/index_set.h>
#include <deal.II/base/partitioner.h>
#include <deal.II/lac/affine_constraints.h>
#include <deal.II/lac/la_parallel_vector.h>

#include <vector>

namespace feib
{
  /// Constraints x_i = b_i + sum_k w_ik x_k by local indices, in arrays: for what runs in every
  /// step. Ranks hold the lines of all unknowns they know.
  class FlatConstraints
  {
  public:
    using Vector = dealii::LinearAlgebra::distributed::Vector<double>;

    FlatConstraints() = default;

    /// Of closed @p constraints the lines of @p unknowns; @p partitioner knows these and their
    /// masters.
    FlatConstraints(const dealii::AffineConstraints<double> &constraints,
                    const dealii::IndexSet &unknowns,
                    const dealii::Utilities::MPI::Partitioner &partitioner);

    /// The @p unknowns and what their constraints make values from.
    static dealii::IndexSet with_masters(dealii::IndexSet unknowns,
                                         const dealii::AffineConstraints<double> &constraints);

    /// C^T v: values of constrained unknowns go to their masters and become zero. Ghost entries
    /// must be zero. Collective.
    void condense(Vector &v) const;

    /// Sets constrained entries from their masters, with @p homogeneous as if all b were zero.
    /// Collective.
    void distribute(Vector &v, bool homogeneous) const;

    /// Each b goes the @p share of the way from what @p v has in its place to itself. Collective.
    void approach(const Vector &v, double share);

  private:
    struct Line
    {
      unsigned int unknown, begin, end; // its masters and weights
      double value;
    };

    /// Without b.
    double value(const Vector &v, const Line &line) const;

    std::vector<Line> lines;
    std::vector<unsigned int> masters;
    std::vector<double> weights;
  };
} // namespace feib

#endif
