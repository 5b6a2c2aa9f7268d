// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_reconstruction_h
#define feib_reconstruction_h

#include <feib/eulerian_space.h>

namespace feib
{
  /// R, which makes a discretely divergence-free velocity pointwise divergence-free, cell by cell.
  ///
  /// With d_m the Legendre coefficients of div v for the modes m that P1 does not hold,
  ///   R v = v - sum_m d_m w_m,
  /// and w_m the smallest field (in L2) of the Raviart-Thomas space RT_[2] with the divergence
  /// L_a(x) L_b(y) [L_c(z)] of mode m and no normal component on the cell's faces. So R v keeps the
  /// normal trace of v and div R v is the P1 projection of div v: zero, when v is discretely
  /// divergence-free. The role of R is that of Linke, CMAME 268 (2014) 782; the closed form is
  ///   w_m = (c_1 N_a L_b L_c, c_2 L_a N_b L_c, c_3 L_a L_b N_c),  N_n' = L_n,  N_n(+-1) = 0,
  /// where sum c_i = 1, c_i is proportional to |L_n|^2 / (h_i^2 |N_n|^2) for the degree n of the
  /// mode in direction i, and zero for n = 0.
  ///
  /// R is the same in all cells of equal proportions. Tangential components of R v jump between
  /// cells: do not differentiate it.
  template <int dim>
  class Reconstruction
  {
  public:
    /// Modes are numbered like nodes, the degree in x fastest; those of P1 have no correction.
    static constexpr unsigned int n_modes    = EulerianSpace<dim>::n_nodes;
    static constexpr unsigned int n_velocity = EulerianSpace<dim>::n_velocity;

    /// @p size: the edges of a cell; only their ratios matter.
    explicit Reconstruction(const dealii::Tensor<1, dim> &size);

    /// d = D v: the n_modes Legendre coefficients of the divergence of a cell's velocity unknowns
    /// (in the order of EulerianSpace::velocity_dofs), times the edge in x.
    void divergence_modes(const double *v, double *d) const;

    /// v -= D^T d
    void subtract_transpose(const double *d, double *v) const;

    /// w[i][m], component i of w_m at a place of the unit cell, over the edge in x.
    void corrections(const dealii::Point<dim> &unit, double (&w)[dim][n_modes]) const;

    /// Component i of R v at a place of the unit cell is sum_j weights[i][j] v_j.
    void weights(const dealii::Point<dim> &unit, double (&weights)[dim][n_velocity]) const;

  private:
    double divergence[n_modes][n_velocity];
    double factors[dim][n_modes]; // c_i h_i / (2 h_1)
  };
} // namespace feib

#endif
