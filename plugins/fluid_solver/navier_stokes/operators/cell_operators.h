// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_plugins_navier_stokes_cell_operators_h
#define feib_plugins_navier_stokes_cell_operators_h

#include "operators/convection_kernels.h"

#include <feib/reconstruction.h>

#include <vector>

namespace feib
{
  /// Component a of v, or of R v when there is a @p reconstruction, at a place of the unit cell is
  /// sum_j values[a][j] v_j over the velocity unknowns of the cell.
  template <int dim>
  void velocity_values(const Reconstruction<dim> *reconstruction,
                       const dealii::Point<dim> &unit,
                       double (&values)[dim][EulerianSpace<dim>::n_velocity]);


  /// The forms of the Navier-Stokes equations on one Cartesian cell, by matrices of the unit cell.
  /// Unknowns of a cell come component by component, nodes lexicographic, as in
  /// EulerianSpace::velocity_dofs(). Sizes: n = 3^dim nodes, n_u = dim * n velocity and n_p = dim +
  /// 1 pressure unknowns, n_q = 4^dim Gauss points.
  template <int dim>
  class CellOperators
  {
  public:
    static constexpr unsigned int n   = EulerianSpace<dim>::n_nodes;
    static constexpr unsigned int n_u = EulerianSpace<dim>::n_velocity;
    static constexpr unsigned int n_p = EulerianSpace<dim>::n_pressure;
    static constexpr unsigned int n_q = dim == 2 ? 16 : 64;

    using Size = dealii::Tensor<1, dim>;

    CellOperators();

    /// The matrix (n_u x n_u, row by row) of alpha (u, v) + mu a(u, v) + gamma (div u, div v),
    /// with a(u, v) = 2 (D(u), D(v)) if @p symmetric, else (grad u, grad v).
    std::vector<double> velocity_matrix(const Size &size,
                                        double alpha,
                                        double mu,
                                        bool symmetric,
                                        double gamma = 0) const;

    /// The matrix (n_p x n_u) of (div u, q).
    std::vector<double> divergence_matrix(const Size &size) const;

    /// result += the traction of convection on the faces f with bit f set in @p faces, which fluid
    /// crosses freely: rho/2 int max(w . n, 0) u . v, and for the rotational form also
    /// rho/2 int [(w . u) (v . n) - (w . v) (u . n)]. Value: double, or a batch of values of cells
    /// that have size and faces in common.
    ///
    /// With w = u, what convection leaves on such a face is then no traction where fluid goes out,
    /// and -rho/2 |u . n| u where it comes in (the directional do-nothing condition of Braack and
    /// Mucha, J. Comput. Math. 32 (2014) 507). The power with v = u is rho/2 int max(w . n, 0)
    /// |u|^2 whatever w is: energy leaves, and none comes in. On those of the faces in @p
    /// static_faces w . n stands for max(w . n, 0), so that there is no traction where fluid comes
    /// in either, and energy comes in with it.
    template <typename Value>
    void add_open_boundary(const Size &size,
                           unsigned int faces,
                           unsigned int static_faces,
                           double rho,
                           ConvectiveForm form,
                           const Value *w,
                           const Value *by,
                           const Value *u,
                           Value *result) const;

    /// Integrals over the unit cell of the n shape functions, and of x_b times them with x from the
    /// cell's corner.
    double mean[n];
    double moment[dim][n];

    /// Weights and unit gradients of the n shape functions at the Gauss points of the unit cell.
    double weights[n_q];
    double dphi[dim][n_q][n];

  private:
    static constexpr unsigned int n_face_q = dim == 2 ? 4 : 16;

    double face_phi[2 * dim][n_face_q][n]; // at the Gauss points of each face
    double face_weights[n_face_q];

    double mass[n][n];                // int phi_i phi_j
    double stiffness[dim][dim][n][n]; // [a][b][i][j]: int d_a phi_i d_b phi_j
    double divergence[dim][n_p][n];   // [a][k][j]: int q_k d_a phi_j
  };
} // namespace feib

#endif
