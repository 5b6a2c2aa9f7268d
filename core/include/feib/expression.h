// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_expression_h
#define feib_expression_h

#include <feib/parameters.h>

#include <deal.II/base/function.h>
#include <deal.II/base/mpi.h>

#include <memory>

namespace feib
{
  /// The variables an expression of a case may use.
  enum class Variables
  {
    /// x, y, z (as many as the space has dimensions) and t, the time.
    space_time,
    /// t alone.
    time,
    /// s1, s2, s3 (as many as the space has dimensions): reference coordinates of a structure.
    reference,
    /// The same, and t.
    reference_time
  };

  /// Expressions of a case as a function of place and time, which remembers where it was not
  /// finite, or beyond 1e100.
  template <int dim>
  class Expressions : public dealii::Function<dim>
  {
  public:
    using dealii::Function<dim>::Function;

    /// For each component that was not finite somewhere since the last call, the place (the first
    /// in lexicographic order, whatever the number of ranks) and the time. Collective.
    virtual Issues not_finite(MPI_Comm communicator) = 0;
  };

  /// The function whose components are the expressions at @p key (muParser syntax; pi, e and the
  /// constants of the case are known). Throws Error at the expression that does not parse, names an
  /// unknown variable, or when there are not @p n_components of them.
  template <int dim>
  std::unique_ptr<Expressions<dim>> parse_expressions(const Parameters &parameters,
                                                      const std::string &key,
                                                      unsigned int n_components,
                                                      Variables variables);

  /// Whether any of the expressions at @p key depends on the time.
  bool depends_on_time(const Parameters &parameters, const std::string &key);

  /// Whether the name means something in every expression (a function, a variable, pi or e), so
  /// that no constant of a case can have it.
  bool is_expression_word(const std::string &name);
} // namespace feib

#endif
