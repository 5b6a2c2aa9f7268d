// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_structure_model_face_loads_h
#define feib_structure_model_face_loads_h

#include <feib/constitutive_law.h>
#include <feib/lagrangian_points.h>
#include <feib/matrix_entry.h>
#include <feib/parameters.h>

#include <array>
#include <vector>

namespace feib
{
  /// From stresses P, constant on each element, to the load on the faces between elements,
  ///   <F_h, v> = - sum_f int_f [[P]] . v(X),  [[P]] = P+ N+ + P- N-,  P N at the boundary,
  /// as forces at points: the nodes (the vertex rule), or Gauss points of the faces.
  template <int structure_dim, int dim>
  class FaceLoads
  {
  public:
    static constexpr unsigned int m = structure_dim;

    using Matrix = typename ConstitutiveLaw<structure_dim, dim>::Matrix;

    /// @p quadrature: the block of a rule, {"vertex": {}} or {"gauss": {"points": ...}}.
    /// @p boundary_faces: whether the load has the terms at the boundary. The mesh must outlive the
    /// object.
    FaceLoads(const LagrangianMesh<dim> &mesh, const Parameters &quadrature, bool boundary_faces);

    const LagrangianPoints &points() const;

    /// Whether the load is the derivative of the energy whose stresses it is made from.
    bool conservative() const;

    /// From the stresses of this rank's elements to the load of all. Collective.
    void load(const std::vector<Matrix> &P, NodalField<dim> &load) const;

    /// d2W/dF2 of this rank's elements: [c][e] is dP for the unit dF of component c / m, column
    /// c % m.
    using Columns = std::array<std::vector<Matrix>, m * dim>;

    /// - d load/dX, this rank's part: row = point * dim + component, column = node * dim +
    /// component.
    MatrixEntries tangent(const Columns &columns) const;

  private:
    void make_gauss_points(unsigned int n);

    const LagrangianMesh<dim> &mesh;
    const unsigned int first, last; // the elements of this rank
    const bool boundary_faces;
    LagrangianPoints load_points;
    std::vector<double> weights;             // of the points of one face; empty: vertex rule
    std::vector<unsigned int> element_faces; // face opposite vertex k of element e: [e (m+1) + k]
  };
} // namespace feib

#endif
