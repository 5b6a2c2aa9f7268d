// SPDX-License-Identifier: LGPL-2.1-or-later
// Checks that the tests of `hyperelastic` and `membrane` share.
#ifndef feib_elastic_structure_test_h
#define feib_elastic_structure_test_h

#include <feib/constitutive_law.h>
#include <feib/testing/structure_model_kit.h>

#include <cstdio>
#include <fstream>

#include <unistd.h>

namespace feib::testing
{
  template <int dim>
  std::unique_ptr<StructureModel<dim>>
  make_model(const std::string &component,
             const std::string &mesh,
             const std::string &law,
             const std::string &more = "")
  {
    return registry().create<StructureModel<dim>>(component,
                                                  R"({"name": "body", "mesh": )" + mesh +
                                                    R"(, "law": )" + law +
                                                    (more.empty() ? "" : ", " + more) + "}");
  }

  /// The nodal positions, disturbed by a fraction of the mesh size.
  template <int dim>
  Positions<dim>
  shaken(const StructureModel<dim> &model, const double fraction = .1)
  {
    return moved(model.positions,
                 random_field<dim>(model.mesh().n_nodes(), fraction * model.mesh().diameter(), 3));
  }

  /// f_i = - sum_T |T| P grad phi_i, all elements on every rank: no faces, no sum over ranks.
  template <int structure_dim, int dim>
  NodalField<dim>
  element_wise_load(const LagrangianMesh<dim> &mesh,
                    const Positions<dim> &X,
                    const std::string &law_name,
                    const std::string &law_parameters)
  {
    using Law      = ConstitutiveLaw<structure_dim, dim>;
    const auto law = registry().create<Law>(law_name, law_parameters);
    std::vector<typename Law::MaterialPoint> points(mesh.n_elements());
    std::vector<typename Law::Matrix> F(mesh.n_elements()), P;
    for (unsigned int e = 0; e < mesh.n_elements(); ++e)
      {
        const auto &element = mesh.elements()[e];
        points[e].place     = element.centroid;
        for (unsigned int l = 0; l < structure_dim; ++l)
          points[e].frame[l] = element.frame[l];
        for (unsigned int k = 0; k <= structure_dim; ++k)
          for (unsigned int i = 0; i < dim; ++i)
            for (unsigned int l = 0; l < structure_dim; ++l)
              F[e][i][l] += X[element.nodes[k]][i] * element.shape_gradients[k][l];
      }
    law->set_points(points);
    law->stress(F, P);
    NodalField<dim> load(mesh);
    for (unsigned int e = 0; e < mesh.n_elements(); ++e)
      for (unsigned int k = 0; k <= structure_dim; ++k)
        for (unsigned int i = 0; i < dim; ++i)
          for (unsigned int l = 0; l < structure_dim; ++l)
            load[mesh.elements()[e].nodes[k]][i] -=
              mesh.elements()[e].measure * P[e][i][l] * mesh.elements()[e].shape_gradients[k][l];
    return load;
  }

  /// What a mesh must keep, whatever it is. Returns the reference measure. @p glued: some nodes
  /// have two reference places.
  template <int dim>
  double
  check_mesh(const LagrangianMesh<dim> &mesh, const bool glued = false)
  {
    const unsigned int m = mesh.structure_dim();
    double measure       = 0;
    for (const auto &element : mesh.elements())
      {
        measure += element.measure;
        EXPECT_GT(element.measure, 0);
        dealii::Tensor<1, dim> sum;
        for (unsigned int k = 0; k <= m; ++k)
          sum += element.shape_gradients[k];
        EXPECT_LT(sum.norm() * element.diameter, 1e-12);
        // The derivative of the place along a vector of the frame is that vector.
        for (unsigned int l = 0; l < m && !glued; ++l)
          {
            dealii::Tensor<1, dim> derivative;
            for (unsigned int k = 0; k <= m; ++k)
              derivative += element.shape_gradients[k][l] * mesh.nodes()[element.nodes[k]];
            EXPECT_LT((derivative - element.frame[l]).norm(), 1e-12);
          }
        for (unsigned int k = 0; k < m; ++k)
          for (unsigned int l = 0; l < m; ++l)
            EXPECT_NEAR(element.frame[k] * element.frame[l], k == l, 1e-12);
      }
    // |f| N = - m |T| grad phi_opposite: the length of a face is the same from both sides.
    bool boundary = false;
    for (const auto &face : mesh.faces())
      {
        boundary = boundary || face.at_boundary();
        double size[2];
        for (unsigned int side = 0; side < (face.at_boundary() ? 1 : 2); ++side)
          {
            const auto &element = mesh.elements()[face.elements[side]];
            size[side] = m * element.measure * element.shape_gradients[face.opposite[side]].norm();
            for (unsigned int k = 0; k < m; ++k)
              EXPECT_NE(element.nodes[face.opposite[side]], face.nodes[k]);
          }
        if (!face.at_boundary())
          {
            EXPECT_NEAR(size[0], size[1], 1e-12 * size[0]);
          }
      }
    EXPECT_EQ(mesh.closed(), !boundary);
    return measure;
  }

  /// The worst shape of any element: measure / diameter^m, 1 for the equilateral one.
  template <int dim>
  double
  worst_shape(const LagrangianMesh<dim> &mesh)
  {
    double worst = 1e300;
    for (const auto &element : mesh.elements())
      worst = std::min(worst, element.measure / std::pow(element.diameter, mesh.structure_dim()));
    return worst / (mesh.structure_dim() == 2 ? std::sqrt(3.) / 4 : std::sqrt(2.) / 12);
  }

  /// "pointer: message" of the error that building the model gives; "" for none.
  template <int dim>
  std::string
  error_of(const std::string &component,
           const std::string &mesh,
           const std::string &law,
           const std::string &more = "")
  {
    try
      {
        make_model<dim>(component, mesh, law, more);
      }
    catch (const Error &error)
      {
        return error.issues().front().pointer + ": " + error.issues().front().message;
      }
    return "";
  }

  inline ::testing::AssertionResult
  contains(const std::string &text, const std::string &part)
  {
    return text.find(part) != std::string::npos
             ? ::testing::AssertionSuccess()
             : ::testing::AssertionFailure() << '"' << part << "\" is not in \"" << text << '"';
  }

  /// A file in the temporary folder, one for each rank, gone at the end.
  class TemporaryFile
  {
  public:
    explicit TemporaryFile(const std::string &text)
      : name(::testing::TempDir() + "feib_" +
             ::testing::UnitTest::GetInstance()->current_test_info()->name() + "_" +
             std::to_string(dealii::Utilities::MPI::this_mpi_process(MPI_COMM_WORLD)) + "_" +
             std::to_string(getpid()) + ".msh")
    {
      std::ofstream(name) << text;
    }

    ~TemporaryFile()
    {
      std::remove(name.c_str());
    }

    const std::string name;
  };

  inline std::string
  gmsh(const TemporaryFile &file)
  {
    return R"({"gmsh": {"file": ")" + file.name + R"("}})";
  }
} // namespace feib::testing

#endif
