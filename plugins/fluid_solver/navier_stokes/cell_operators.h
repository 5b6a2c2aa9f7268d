// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_plugins_navier_stokes_cell_operators_h
#define feib_plugins_navier_stokes_cell_operators_h

#include <feib/reconstruction.h>

#include <vector>

namespace feib
{
  enum class ConvectiveForm
  {
    skew_symmetric,
    convective,
    rotational
  };


  /// Component a of v, or of R v when there is a @p reconstruction, at a place of the unit cell is
  /// sum_j values[a][j] v_j over the velocity unknowns of the cell.
  template <int dim>
  void velocity_values(const Reconstruction<dim> *reconstruction,
                       const dealii::Point<dim> &unit,
                       double (&values)[dim][EulerianSpace<dim>::n_velocity]);


  /// The forms of the Navier-Stokes equations on one Cartesian cell, by matrices of the unit cell.
  /// Unknowns of a cell come component by component, nodes lexicographic, as in
  /// EulerianSpace::velocity_dofs(). Sizes: n = 3^dim nodes, n_u = dim * n velocity and n_p = dim +
  /// 1 pressure unknowns, n_q = 4^dim Gauss points (exact for the products in convection: each
  /// factor is of degree 2 in every direction, R v of degree 3, but then the derivative there is
  /// of degree 1).
  ///
  /// R below is the reconstruction given to the constructor, or the identity.
  template <int dim>
  class CellOperators
  {
  public:
    static constexpr unsigned int n   = EulerianSpace<dim>::n_nodes;
    static constexpr unsigned int n_u = EulerianSpace<dim>::n_velocity;
    static constexpr unsigned int n_p = EulerianSpace<dim>::n_pressure;
    static constexpr unsigned int n_q = dim == 2 ? 16 : 64;

    using Size = dealii::Tensor<1, dim>;

    explicit CellOperators(const Reconstruction<dim> *reconstruction = nullptr);

    /// The matrix (n_u x n_u, row by row) of alpha (R u, R v) + mu a(u, v) + gamma (div u, div v),
    /// with a(u, v) = 2 (D(u), D(v)) if @p symmetric, else (grad u, grad v).
    std::vector<double> velocity_matrix(const Size &size,
                                        double alpha,
                                        double mu,
                                        bool symmetric,
                                        double gamma = 0) const;

    /// The matrix (n_p x n_u) of (div u, q).
    std::vector<double> divergence_matrix(const Size &size) const;

    /// The matrix (n_u x n_u) of rho b(w; u, v), the convection with velocity w (n_u values):
    ///   skew_symmetric  rho/2 [(R w . grad u, v) - (R w . grad v, u)], for R = identity only
    ///   convective      rho (R w . grad u, R v)
    ///   rotational      rho (curl u x R w, R v)
    /// The skew form alone would put a traction rho/2 (w . n) u on faces that fluid crosses freely;
    /// rho/2 int (w . n) u . v over the faces f with bit f set in @p outflow_faces takes it away.
    std::vector<double> convection_matrix(const Size &size,
                                          const double *w,
                                          double rho,
                                          ConvectiveForm form,
                                          unsigned int outflow_faces = 0) const;

    /// result += rho b(w; u, v) for all v. Value: double, or a batch of values of cells that have
    /// size and outflow faces in common.
    template <typename Value>
    void add_convection(const Size &size,
                        const Value *w,
                        const Value *u,
                        double rho,
                        ConvectiveForm form,
                        Value *result,
                        unsigned int outflow_faces = 0) const;

    /// Integrals over the unit cell, int (R v)_a = sum_j mean[a][j] v_j and int x_b (R v)_a =
    /// sum_j moment[b][a][j] v_j with x from the cell's corner.
    double mean[dim][n_u];
    double moment[dim][dim][n_u];

    /// Component a of R v depends on the unknowns first[a], ..., last[a] - 1 of a cell.
    unsigned int first[dim], last[dim];

    /// Weights and unit gradients of the n shape functions at the Gauss points of the unit cell.
    double weights[n_q];
    double dphi[dim][n_q][n];

  private:
    /// Component a of R w at Gauss point q.
    template <typename Value>
    Value
    value(const unsigned int a, const unsigned int q, const Value *w) const
    {
      Value result = {};
      for (unsigned int j = first[a]; j < last[a]; ++j)
        result += values[a][q][j] * w[j];
      return result;
    }

    /// w . n times the measure of face f, at its Gauss point q.
    template <typename Value>
    Value face_flux(const Size &size, unsigned int f, unsigned int q, const Value *w) const;


    static constexpr unsigned int n_face_q = dim == 2 ? 4 : 16;

    double face_phi[2 * dim][n_face_q][n]; // at the Gauss points of each face
    double face_weights[n_face_q];

    // Component a of R v at Gauss point q is sum_j values[a][q][j] v_j, first[a] <= j < last[a].
    double values[dim][n_q][n_u];

    double mass[n_u][n_u];            // int R v_i . R v_j
    double stiffness[dim][dim][n][n]; // [a][b][i][j]: int d_a phi_i d_b phi_j
    double divergence[dim][n_p][n];   // [a][k][j]: int q_k d_a phi_j
  };
} // namespace feib

#endif
