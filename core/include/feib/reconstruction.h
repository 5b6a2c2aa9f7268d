// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_reconstruction_h
#define feib_reconstruction_h

#include <feib/eulerian_space.h>

namespace feib
{
  /// Legendre coefficients, on [-1, 1], of the three shape functions of Q2 on a line:
  /// [degree][function].
  constexpr double line_modes[3][3] = {{1 / 6., 2 / 3., 1 / 6.},
                                       {-.5, 0., .5},
                                       {1 / 3., -2 / 3., 1 / 3.}};

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
  /// mode in direction i, and zero for n = 0. As N_n = beta L_{n-1} with the bubble
  /// beta(x) = (x^2 - 1)/2 for n = 1 and 2, component i of R v is
  ///   sum_m (v_i^m + beta(x_i) g_i^m) L_m(x),
  /// two sets of coefficients of the same products L_m.
  ///
  /// R is the same in all cells of equal proportions. Tangential components of R v jump between
  /// cells: do not differentiate it.
  template <int dim>
  class Reconstruction
  {
  public:
    /// The products L_m are numbered like nodes, the degree in x fastest.
    static constexpr unsigned int n_modes    = EulerianSpace<dim>::n_nodes;
    static constexpr unsigned int n_velocity = EulerianSpace<dim>::n_velocity;

    /// @p size: the edges of a cell; only their ratios matter.
    explicit Reconstruction(const dealii::Tensor<1, dim> &size);

    /// L_m and beta(x_i) at a place of the unit cell.
    static void
    modes(const dealii::Point<dim> &unit, double (&L)[n_modes], dealii::Tensor<1, dim> &bubble);

    /// Coefficients of L_m and of beta(x_i) L_m in component i, [component][mode].
    struct Coefficients
    {
      double values[dim][n_modes];
      double bubbles[dim][n_modes];
    };

    /// The coefficients of R v for the velocity unknowns v of a cell, in the order of
    /// EulerianSpace::velocity_dofs.
    void coefficients(const double *v, Coefficients &result) const;

    /// The transpose: what a linear functional of R v makes of each velocity unknown.
    /// @p functional: what it makes of L_m and beta(x_i) L_m in component i.
    void weights(const Coefficients &functional, double *weights) const;

    /// Component i of R v at a place of the unit cell is sum_j weights[i][j] v_j.
    void weights(const dealii::Point<dim> &unit, double (&weights)[dim][n_velocity]) const;

    /// c_i h_i/2 of component i for a mode: -d_m times this is its part of the bubbles g_i. Zero
    /// for modes of P1.
    double
    factor(const unsigned int component, const unsigned int mode) const
    {
      return factors[component][mode];
    }

  private:
    double legendre[n_modes][n_modes]; // [mode][node]: Legendre coefficients of the shape functions
    dealii::Tensor<1, dim> size;
    double factors[dim][n_modes]; // c_i h_i/2, zero for modes of P1
  };
} // namespace feib

#endif
