// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_plugins_navier_stokes_cell_operators_h
#define feib_plugins_navier_stokes_cell_operators_h

#include <feib/eulerian_space.h>

#include <vector>

namespace feib
{
  /// The forms of the Navier-Stokes equations on one Cartesian cell, by matrices of the unit cell.
  /// Unknowns of a cell come component by component, nodes lexicographic, as in
  /// EulerianSpace::velocity_dofs(). Sizes: n = 3^dim nodes, dim * n velocity and dim + 1 pressure
  /// unknowns, n_q = 4^dim Gauss points (exact for the products of three Q2 functions in
  /// convection).
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

    /// The matrix (n_u x n_u, row by row) of alpha (u, v) + mu a(u, v), with
    /// a(u, v) = 2 (D(u), D(v)) if @p symmetric, else (grad u, grad v).
    std::vector<double>
    velocity_matrix(const Size &size, double alpha, double mu, bool symmetric) const;

    /// The matrix (n_p x n_u) of (div u, q).
    std::vector<double> divergence_matrix(const Size &size) const;

    /// The matrix (n x n) of one component of rho b(w; u, v), the convection with velocity w
    /// (n_u values): rho/2 [(w . grad u, v) - (w . grad v, u)] if @p skew, else rho (w . grad u,
    /// v). The skew form alone would put a traction rho/2 (w . n) u on faces that fluid crosses
    /// freely; rho/2 int (w . n) u . v over the faces f with bit f set in @p outflow_faces takes it
    /// away.
    std::vector<double> convection_matrix(const Size &size,
                                          const double *w,
                                          double rho,
                                          bool skew,
                                          unsigned int outflow_faces = 0) const;

    /// result += rho b(w; u, v) for all v.
    void add_convection(const Size &size,
                        const double *w,
                        const double *u,
                        double rho,
                        bool skew,
                        double *result,
                        unsigned int outflow_faces = 0) const;

    /// Integrals of the shape functions, int phi_i, and of x_a phi_i with x from the cell's corner,
    /// on the unit cell.
    double mean[n];
    double moment[dim][n];

    /// Gauss points of the unit cell with shape values, unit gradients and weights.
    std::vector<dealii::Point<dim>> points;
    double weights[n_q];
    double phi[n_q][n];
    double dphi[dim][n_q][n];

  private:
    /// w . n times the measure of face f, at its Gauss point q.
    double face_flux(const Size &size, unsigned int f, unsigned int q, const double *w) const;

    static constexpr unsigned int n_face_q = dim == 2 ? 4 : 16;

    double face_phi[2 * dim][n_face_q][n]; // at the Gauss points of each face
    double face_weights[n_face_q];

    double mass[n][n];
    double stiffness[dim][dim][n][n]; // [a][b][i][j]: int d_a phi_i d_b phi_j
    double divergence[dim][n_p][n];   // [a][k][j]: int q_k d_a phi_j
  };
} // namespace feib

#endif
