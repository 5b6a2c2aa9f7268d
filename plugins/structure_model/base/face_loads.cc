// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/structure_model/face_loads.h>

#include <deal.II/base/quadrature_lib.h>

namespace feib
{
  template <int structure_dim, int dim>
  FaceLoads<structure_dim, dim>::FaceLoads(const LagrangianMesh<dim> &mesh,
                                           const Parameters &quadrature,
                                           const bool boundary_faces)
    : mesh(mesh)
    , first(mesh.local_elements().first)
    , last(mesh.local_elements().second)
    , boundary_faces(boundary_faces)
    , load_points(LagrangianPoints::nodes(mesh.n_nodes()))
    , element_faces(mesh.n_elements() * (m + 1))
  {
    for (unsigned int f = 0; f < mesh.faces().size(); ++f)
      {
        const auto &face = mesh.faces()[f];
        for (unsigned int side = 0; side < 2; ++side)
          if (face.elements[side] != LagrangianMesh<dim>::invalid)
            element_faces[face.elements[side] * (m + 1) + face.opposite[side]] = f;
      }
    const auto [rule, block] = quadrature.choice();
    if (m > 1 && rule == "gauss")
      make_gauss_points(block.integer("points"));
  }


  template <int structure_dim, int dim>
  void
  FaceLoads<structure_dim, dim>::make_gauss_points(const unsigned int n)
  {
    if constexpr (m > 1)
      {
        const dealii::Quadrature<m - 1> gauss = [&] {
          if constexpr (m == 2)
            return dealii::QGauss<1>(n);
          else
            return dealii::QWitherdenVincentSimplex<2>(n);
        }();
        load_points                 = {};
        load_points.nodes_per_point = m;
        for (const auto &face : mesh.faces())
          for (const dealii::Point<m - 1> &unit : gauss.get_points())
            {
              load_points.weight.push_back(1);
              for (unsigned int k = 0; k + 1 < m; ++k)
                {
                  load_points.weight.push_back(unit[k]);
                  load_points.weight[load_points.weight.size() - k - 2] -= unit[k];
                }
              load_points.node.insert(load_points.node.end(),
                                      face.nodes.begin(),
                                      face.nodes.begin() + m);
            }
        weights          = gauss.get_weights();
        double reference = 0; // measure of the unit face
        for (const double weight : weights)
          reference += weight;
        for (double &weight : weights)
          weight /= reference;
      }
  }


  template <int structure_dim, int dim>
  const LagrangianPoints &
  FaceLoads<structure_dim, dim>::points() const
  {
    return load_points;
  }


  template <int structure_dim, int dim>
  bool
  FaceLoads<structure_dim, dim>::conservative() const
  {
    return weights.empty() && (boundary_faces || mesh.closed());
  }


  template <int structure_dim, int dim>
  void
  FaceLoads<structure_dim, dim>::load(const std::vector<Matrix> &P, NodalField<dim> &load) const
  {
    // |f| [[P]]: the outward normal of the face opposite vertex k is |f| N = - m |T| grad phi_k.
    const auto &faces = mesh.faces();
    NodalField<dim> jumps(faces.size());
    for (unsigned int e = first; e < last; ++e)
      {
        const auto &element = mesh.elements()[e];
        for (unsigned int k = 0; k <= m; ++k)
          {
            dealii::Tensor<1, dim> &jump = jumps[element_faces[e * (m + 1) + k]];
            for (unsigned int i = 0; i < dim; ++i)
              for (unsigned int l = 0; l < m; ++l)
                jump[i] -= m * element.measure * P[e - first][i][l] * element.shape_gradients[k][l];
          }
      }
    // At most two elements add to a face, so the sum does not depend on the number of ranks.
    jumps.compress(mesh.communicator());
    jumps.update_ghosts();

    // Every rank has all faces.
    load = NodalField<dim>(load_points);
    for (unsigned int f = 0; f < faces.size(); ++f)
      {
        if (faces[f].at_boundary() && !boundary_faces)
          continue;
        if (weights.empty())
          for (unsigned int k = 0; k < m; ++k)
            load[faces[f].nodes[k]] -= jumps[f] / m;
        else
          for (unsigned int q = 0; q < weights.size(); ++q)
            load[f * weights.size() + q] = -weights[q] * jumps[f];
      }
  }


  template <int structure_dim, int dim>
  MatrixEntries
  FaceLoads<structure_dim, dim>::tangent(const Columns &columns) const
  {
    // As load() with dP = d2W/dF2 [e_b (x) grad phi_j], once for each node j of an element.
    const auto &faces = mesh.faces();
    MatrixEntries entries;
    for (unsigned int e = first; e < last; ++e)
      {
        const auto &element = mesh.elements()[e];
        for (unsigned int j = 0; j <= m; ++j)
          for (unsigned int b = 0; b < dim; ++b)
            {
              Matrix dP;
              for (unsigned int l = 0; l < m; ++l)
                dP += element.shape_gradients[j][l] * columns[b * m + l][e - first];
              const std::uint64_t column = std::uint64_t(element.nodes[j]) * dim + b;
              for (unsigned int k = 0; k <= m; ++k)
                {
                  const unsigned int f = element_faces[e * (m + 1) + k];
                  if (faces[f].at_boundary() && !boundary_faces)
                    continue;
                  for (unsigned int i = 0; i < dim; ++i)
                    {
                      double jump = 0;
                      for (unsigned int l = 0; l < m; ++l)
                        jump -= m * element.measure * dP[i][l] * element.shape_gradients[k][l];
                      if (weights.empty())
                        for (unsigned int v = 0; v < m; ++v)
                          entries.push_back(
                            {std::uint64_t(faces[f].nodes[v]) * dim + i, column, jump / m});
                      else
                        for (unsigned int q = 0; q < weights.size(); ++q)
                          entries.push_back({(std::uint64_t(f) * weights.size() + q) * dim + i,
                                             column,
                                             weights[q] * jump});
                    }
                }
            }
      }
    return entries;
  }


  template class FaceLoads<1, 2>;
  template class FaceLoads<2, 2>;
  template class FaceLoads<2, 3>;
  template class FaceLoads<3, 3>;
} // namespace feib
