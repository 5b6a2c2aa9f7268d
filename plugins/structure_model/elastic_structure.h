// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_elastic_structure_h
#define feib_elastic_structure_h

#include <feib/body_fault.h>
#include <feib/constitutive_law.h>
#include <feib/expression.h>
#include <feib/failure.h>
#include <feib/message.h>
#include <feib/reference_mesh.h>
#include <feib/structure_model.h>

#include <deal.II/base/derivative_form.h>
#include <deal.II/base/mpi.h>
#include <deal.II/base/quadrature_lib.h>

#include <cmath>
#include <limits>
#include <memory>
#include <utility>

namespace feib
{
  /// A hyperelastic structure of dimension m = dim or dim-1 on P1 simplices: what the components
  /// `hyperelastic` and `membrane` share. P is constant on an element, so integration by parts is
  /// exact and the load lives on the faces:
  ///   <F_h, v> = - sum_f int_f [[P]] . v(X),  [[P]] = P+ N+ + P- N-,  P N at the boundary.
  template <int structure_dim, int dim>
  class ElasticStructure : public StructureModel<dim>
  {
  public:
    static constexpr unsigned int m = structure_dim;

    using Law    = ConstitutiveLaw<structure_dim, dim>;
    using Matrix = typename Law::Matrix;
    using Mesh   = LagrangianMesh<dim>;

    /// The component makes the law, from the slot "law" of the same block.
    ElasticStructure(const Parameters &parameters, std::unique_ptr<Law> constitutive_law);

    const std::string &
    name() const override
    {
      return structure_name;
    }

    const Mesh &
    mesh() const override
    {
      return reference_mesh;
    }

    double energy(const Positions<dim> &X) const override;

    const LagrangianPoints &
    load_points() const override
    {
      return points;
    }

    void load(const Positions<dim> &X, NodalField<dim> &load) const override;

    void load_derivative(const Positions<dim> &X,
                         const NodalField<dim> &dX,
                         NodalField<dim> &dload) const override;

    MatrixEntries tangent(const Positions<dim> &X) const override;

    bool
    linear() const override
    {
      return law->linear();
    }

    bool
    conservative() const override
    {
      return face_weights.empty() && (boundary_faces || reference_mesh.closed());
    }

    const std::vector<double> &
    excess_mass() const override
    {
      return node_masses;
    }

    typename StructureModel<dim>::Stiffness stiffness(const Positions<dim> &X) const override;

    double measure(const Positions<dim> &X) const override;

    dealii::Point<dim> centroid(const Positions<dim> &X) const override;

    std::vector<double> energy_density(const Positions<dim> &X) const override;

  private:
    /// An element is inverted, or its determinant is not a number: the worst one.
    struct Inverted
    {
      double determinant;
      unsigned int element;
    };

    Positions<dim> initial_positions(const Parameters &parameters) const;

    /// Throws Error where elements are inverted that must not be, and where a body is none.
    void check_initial_positions(const Parameters &parameters) const;

    /// At rest when not given.
    NodalField<dim> initial_velocities(const Parameters &parameters) const;

    void set_materials(const Parameters &parameters);

    /// Gives the law its points. What it throws on one rank is thrown on all.
    void set_points(const std::vector<typename Law::MaterialPoint> &material_points);

    void make_face_quadrature(const Parameters &quadrature);

    /// The gradient of a nodal field on the elements of this rank.
    template <typename Field>
    std::vector<Matrix> gradients(const Field &field) const;

    /// The element of smallest det F when that is not positive and the law needs it. Collective.
    std::unique_ptr<Inverted> find_inverted(const std::vector<Matrix> &F) const;

    /// The deformation gradients at X. Throws RunFailure on all ranks where an element is inverted.
    std::vector<Matrix> deformation_gradients(const Positions<dim> &X) const;

    /// Calls a function of the law that fills @p values, one for each element of this rank. What it
    /// throws on any rank, or a value that is not finite, is a RunFailure on all. Collective.
    template <typename Value, typename Function>
    void evaluate(const char *what, const Function &function, std::vector<Value> &values) const;

    /// From the stresses of this rank's elements to the load of all. Collective.
    void face_loads(const std::vector<Matrix> &P, NodalField<dim> &load) const;

    /// d2W/dF2 of this rank's elements: [c][e] is dP for the unit dF of component c / m, column
    /// c % m.
    std::array<std::vector<Matrix>, m * dim> tangent_columns(const std::vector<Matrix> &F) const;

    /// R of F = Q R, upper triangular, Q with orthonormal columns.
    static std::array<std::array<double, structure_dim>, structure_dim> triangle(const Matrix &F);

    /// The measure of the structure (with the sign of its orientation) and its first moment about
    /// X[0].
    std::pair<double, dealii::Tensor<1, dim>> moments(const Positions<dim> &X) const;

    std::string structure_name;
    Mesh reference_mesh;
    unsigned int first, last; // the elements of this rank
    std::string law_name;
    std::unique_ptr<Law> law;
    LagrangianPoints points;
    bool boundary_faces;
    std::vector<double> node_masses;         // lumped excess mass; empty: none
    std::vector<double> face_weights;        // of the points of one face; empty: vertex rule
    std::vector<unsigned int> element_faces; // face opposite vertex k of element e: [e (m+1) + k]
  };


  template <int structure_dim, int dim>
  ElasticStructure<structure_dim, dim>::ElasticStructure(const Parameters &parameters,
                                                         std::unique_ptr<Law> constitutive_law)
    : structure_name(parameters.string("name"))
    , reference_mesh(make_reference_mesh<dim>(parameters.child("mesh"), m))
    , law_name(parameters.child("law").choice().first)
    , law(std::move(constitutive_law))
    , boundary_faces(parameters.boolean("boundary_faces"))
  {
    const std::string letters = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_";
    if (structure_name.empty() || structure_name.find_first_not_of(letters) != std::string::npos)
      parameters.fail(
        "name",
        "must be made of letters, digits and _, as columns of the ledger carry it; found \"" +
          structure_name + "\"");

    if constexpr (m == dim)
      if (parameters.has("material"))
        set_materials(parameters);
    this->positions = initial_positions(parameters);
    reference_mesh.orient_closed_parts(this->positions);
    std::tie(first, last) = reference_mesh.local_elements();
    element_faces.resize(reference_mesh.n_elements() * (m + 1));
    for (unsigned int f = 0; f < reference_mesh.faces().size(); ++f)
      {
        const auto &face = reference_mesh.faces()[f];
        for (unsigned int side = 0; side < 2; ++side)
          if (face.elements[side] != Mesh::invalid)
            element_faces[face.elements[side] * (m + 1) + face.opposite[side]] = f;
      }
    make_face_quadrature(parameters.child("face_quadrature"));

    std::vector<typename Law::MaterialPoint> material_points;
    for (unsigned int e = first; e < last; ++e)
      {
        const auto &element = reference_mesh.elements()[e];
        material_points.emplace_back();
        material_points.back().place       = element.centroid;
        material_points.back().material_id = element.material_id;
        for (unsigned int k = 0; k < m; ++k)
          material_points.back().frame[k] = element.frame[k];
      }
    set_points(material_points);

    if (const double excess = parameters.number("excess_density"); excess > 0)
      {
        node_masses.assign(reference_mesh.n_nodes(), 0.);
        for (const auto &element : reference_mesh.elements())
          for (unsigned int k = 0; k <= m; ++k)
            node_masses[element.nodes[k]] += excess * element.measure / (m + 1);
      }
    this->velocities = initial_velocities(parameters);
    check_initial_positions(parameters);
  }

  template <int structure_dim, int dim>
  void
  ElasticStructure<structure_dim, dim>::check_initial_positions(const Parameters &parameters) const
  {
    if (const auto inverted = find_inverted(gradients(this->positions)))
      {
        const auto &element = reference_mesh.elements()[inverted->element];
        std::string place;
        for (unsigned int i = 0; i < dim; ++i)
          place += (i ? ", " : "") + readable(element.centroid[i]);
        parameters.fail("initial_position",
                        "inverts element " + std::to_string(element.number) +
                          " at the reference place (" + place + "): det F = " +
                          readable(inverted->determinant) + "; the law needs det F > 0 everywhere");
      }
    if constexpr (m == dim)
      if (const std::string fault = body_fault(reference_mesh, this->positions); !fault.empty())
        parameters.fail(parameters.has("initial_position") ? "initial_position" : "mesh", fault);
  }

  template <int structure_dim, int dim>
  void
  ElasticStructure<structure_dim, dim>::set_materials(const Parameters &parameters)
  {
    const auto material = parse_expressions<dim>(parameters, "material", 1, Variables::reference);
    std::vector<unsigned int> ids;
    for (const auto &element : reference_mesh.elements())
      {
        const double id = material->value(element.centroid);
        if (!(id > -.5 && id < 1e9))
          {
            std::string place;
            for (unsigned int i = 0; i < dim; ++i)
              place += (i ? ", " : "") + readable(element.centroid[i]);
            parameters.fail("material",
                            "is " + readable(id) + " at the reference place (" + place +
                              "); it must be 0, 1, 2, ... there");
          }
        ids.push_back(std::lround(id));
      }
    reference_mesh.set_materials(ids);
  }

  template <int structure_dim, int dim>
  void
  ElasticStructure<structure_dim, dim>::set_points(
    const std::vector<typename Law::MaterialPoint> &material_points)
  {
    std::pair<std::string, std::string> issue; // pointer and message
    try
      {
        law->set_points(material_points);
      }
    catch (const Error &error)
      {
        issue = {error.issues().front().pointer, error.issues().front().message};
      }
    for (const auto &[pointer, message] :
         dealii::Utilities::MPI::all_gather(reference_mesh.communicator(), issue))
      if (!message.empty())
        throw Error(pointer, message);
  }

  template <int structure_dim, int dim>
  Positions<dim>
  ElasticStructure<structure_dim, dim>::initial_positions(const Parameters &parameters) const
  {
    const std::vector<dealii::Point<dim>> &nodes = reference_mesh.nodes();
    const auto [mesh_name, block]                = parameters.child("mesh").choice();
    const bool glued = mesh_name == "closed_curve" || mesh_name == "periodic_strip";
    if (!parameters.has("initial_position"))
      {
        if (glued || mesh_name == "open_curve")
          parameters.fail("",
                          "lacks \"initial_position\": the reference coordinates of the mesh " +
                            mesh_name + " are not places");
        return nodes;
      }

    const auto X0 =
      parse_expressions<dim>(parameters, "initial_position", dim, Variables::reference);
    const auto position = [&](const dealii::Point<dim> &s) {
      dealii::Point<dim> x;
      for (unsigned int i = 0; i < dim; ++i)
        x[i] = X0->value(s, i);
      if (!std::isfinite(x.norm()))
        throw Error(X0->not_finite(MPI_COMM_SELF));
      return x;
    };
    Positions<dim> X;
    double extent = 0;
    for (const dealii::Point<dim> &s : nodes)
      {
        X.push_back(position(s));
        extent = std::max(extent, X.back().distance(X.front()));
      }
    if (glued)
      for (unsigned int i = 0; i < nodes.size(); ++i)
        if (nodes[i][0] == 0)
          {
            dealii::Point<dim> end = nodes[i];
            end[0]                 = block.number("length");
            const double gap       = position(end).distance(X[i]);
            if (gap > 1e-6 * extent)
              parameters.fail("initial_position",
                              "does not close: s1 = 0 and s1 = " + readable(end[0]) +
                                " are the same place of the mesh " + mesh_name +
                                ", but their positions are " + readable(gap) + " apart");
          }
    return X;
  }

  template <int structure_dim, int dim>
  NodalField<dim>
  ElasticStructure<structure_dim, dim>::initial_velocities(const Parameters &parameters) const
  {
    NodalField<dim> V(reference_mesh.n_nodes());
    if (!parameters.has("initial_velocity"))
      return V;
    if (node_masses.empty())
      parameters.fail(
        "initial_velocity",
        "needs an excess_density greater than 0: without one the structure moves with "
        "the fluid, whose initial_velocity it has");
    const auto V0 =
      parse_expressions<dim>(parameters, "initial_velocity", dim, Variables::reference);
    for (unsigned int i = 0; i < V.size(); ++i)
      {
        for (unsigned int a = 0; a < dim; ++a)
          V[i][a] = V0->value(reference_mesh.nodes()[i], a);
      }
    if (const Issues issues = V0->not_finite(MPI_COMM_SELF); !issues.empty())
      throw Error(issues);
    return V;
  }

  template <int structure_dim, int dim>
  void
  ElasticStructure<structure_dim, dim>::make_face_quadrature(const Parameters &quadrature)
  {
    const auto [rule, block] = quadrature.choice();
    points                   = LagrangianPoints::nodes(reference_mesh.n_nodes());
    if constexpr (m > 1)
      if (rule == "gauss")
        {
          const unsigned int n                  = block.integer("points");
          const dealii::Quadrature<m - 1> gauss = [&] {
            if constexpr (m == 2)
              return dealii::QGauss<1>(n);
            else
              return dealii::QWitherdenVincentSimplex<2>(n);
          }();
          points                 = {};
          points.nodes_per_point = m;
          for (const auto &face : reference_mesh.faces())
            for (const dealii::Point<m - 1> &unit : gauss.get_points())
              {
                points.weight.push_back(1);
                for (unsigned int k = 0; k + 1 < m; ++k)
                  {
                    points.weight.push_back(unit[k]);
                    points.weight[points.weight.size() - k - 2] -= unit[k];
                  }
                points.node.insert(points.node.end(), face.nodes.begin(), face.nodes.begin() + m);
              }
          face_weights     = gauss.get_weights();
          double reference = 0; // measure of the unit face
          for (const double weight : face_weights)
            reference += weight;
          for (double &weight : face_weights)
            weight /= reference;
        }
  }

  template <int structure_dim, int dim>
  template <typename Field>
  std::vector<typename ElasticStructure<structure_dim, dim>::Matrix>
  ElasticStructure<structure_dim, dim>::gradients(const Field &field) const
  {
    AssertDimension(field.size(), reference_mesh.n_nodes());
    std::vector<Matrix> result(last - first);
    for (unsigned int e = first; e < last; ++e)
      {
        const auto &element = reference_mesh.elements()[e];
        Matrix &F           = result[e - first];
        for (unsigned int k = 0; k <= m; ++k)
          for (unsigned int i = 0; i < dim; ++i)
            for (unsigned int l = 0; l < m; ++l)
              F[i][l] += field[element.nodes[k]][i] * element.shape_gradients[k][l];
      }
    return result;
  }

  template <int structure_dim, int dim>
  std::unique_ptr<typename ElasticStructure<structure_dim, dim>::Inverted>
  ElasticStructure<structure_dim, dim>::find_inverted(const std::vector<Matrix> &F) const
  {
    if (!law->needs_positive_determinant())
      return nullptr;
    struct
    {
      double value;
      int element;
    } worst{std::numeric_limits<double>::max(), -1};
    for (unsigned int e = first; e < last; ++e)
      {
        double J = dealii::DerivativeForm<1, structure_dim, dim>(F[e - first]).determinant();
        if (std::isnan(J))
          J = -std::numeric_limits<double>::infinity();
        if (J < worst.value)
          worst = {J, static_cast<int>(e)};
      }
    const int ierr = MPI_Allreduce(
      MPI_IN_PLACE, &worst, 1, MPI_DOUBLE_INT, MPI_MINLOC, reference_mesh.communicator());
    AssertThrowMPI(ierr);
    if (worst.value > 0)
      return nullptr;
    return std::make_unique<Inverted>(
      Inverted{worst.value, static_cast<unsigned int>(worst.element)});
  }

  template <int structure_dim, int dim>
  std::vector<typename ElasticStructure<structure_dim, dim>::Matrix>
  ElasticStructure<structure_dim, dim>::deformation_gradients(const Positions<dim> &X) const
  {
    std::vector<Matrix> F = gradients(X);
    if (const auto inverted = find_inverted(F))
      throw RunFailure("structure " + structure_name + ": element " +
                       std::to_string(reference_mesh.elements()[inverted->element].number) +
                       " is inverted (det F = " + readable(inverted->determinant) +
                       "), where its law has no energy; a smaller time step may help");
    return F;
  }

  template <int structure_dim, int dim>
  template <typename Value, typename Function>
  void
  ElasticStructure<structure_dim, dim>::evaluate(const char *what,
                                                 const Function &function,
                                                 std::vector<Value> &values) const
  {
    const auto finite = [](const Value &value) {
      if constexpr (std::is_same_v<Value, double>)
        return std::isfinite(value);
      else
        {
          double sum = 0;
          for (unsigned int i = 0; i < dim; ++i)
            sum += value[i].norm_square();
          return std::isfinite(sum);
        }
    };
    agree(
      reference_mesh.communicator(),
      [&] {
        values.assign(last - first, Value());
        function();
        if (values.size() != last - first)
          throw Incurable("it gives " + std::to_string(values.size()) + " values for " +
                          std::to_string(last - first) + " elements");
        for (unsigned int e = first; e < last; ++e)
          if (!finite(values[e - first]))
            {
              std::ostringstream text;
              text << "it is not finite in element " << reference_mesh.elements()[e].number
                   << ", at the reference place (" << reference_mesh.elements()[e].centroid << ")";
              throw RunFailure(text.str());
            }
      },
      "the law \"" + law_name + "\" of structure \"" + structure_name + "\" fails in its " + what);
  }

  template <int structure_dim, int dim>
  void
  ElasticStructure<structure_dim, dim>::face_loads(const std::vector<Matrix> &P,
                                                   NodalField<dim> &load) const
  {
    // |f| [[P]]: the outward normal of the face opposite vertex k is |f| N = - m |T| grad phi_k.
    const auto &faces = reference_mesh.faces();
    NodalField<dim> jumps(faces.size());
    for (unsigned int e = first; e < last; ++e)
      {
        const auto &element = reference_mesh.elements()[e];
        for (unsigned int k = 0; k <= m; ++k)
          {
            dealii::Tensor<1, dim> &jump = jumps[element_faces[e * (m + 1) + k]];
            for (unsigned int i = 0; i < dim; ++i)
              for (unsigned int l = 0; l < m; ++l)
                jump[i] -= m * element.measure * P[e - first][i][l] * element.shape_gradients[k][l];
          }
      }
    // At most two elements add to a face, so the sum does not depend on the number of ranks.
    static_assert(sizeof(dealii::Tensor<1, dim>) == dim * sizeof(double));
    const int ierr = MPI_Allreduce(MPI_IN_PLACE,
                                   jumps.data(),
                                   jumps.size() * dim,
                                   MPI_DOUBLE,
                                   MPI_SUM,
                                   reference_mesh.communicator());
    AssertThrowMPI(ierr);

    load.assign(points.size(), {});
    for (unsigned int f = 0; f < faces.size(); ++f)
      {
        if (faces[f].at_boundary() && !boundary_faces)
          continue;
        if (face_weights.empty())
          for (unsigned int k = 0; k < m; ++k)
            load[faces[f].nodes[k]] -= jumps[f] / m;
        else
          for (unsigned int q = 0; q < face_weights.size(); ++q)
            load[f * face_weights.size() + q] = -face_weights[q] * jumps[f];
      }
  }

  template <int structure_dim, int dim>
  void
  ElasticStructure<structure_dim, dim>::load(const Positions<dim> &X, NodalField<dim> &load) const
  {
    std::vector<Matrix> P;
    const std::vector<Matrix> F = deformation_gradients(X);
    evaluate(
      "stress", [&] { law->stress(F, P); }, P);
    face_loads(P, load);
  }

  template <int structure_dim, int dim>
  void
  ElasticStructure<structure_dim, dim>::load_derivative(const Positions<dim> &X,
                                                        const NodalField<dim> &dX,
                                                        NodalField<dim> &dload) const
  {
    std::vector<Matrix> dP;
    const std::vector<Matrix> F = deformation_gradients(X), dF = gradients(dX);
    evaluate(
      "derivative of the stress", [&] { law->stress_derivative(F, dF, dP); }, dP);
    face_loads(dP, dload);
  }

  template <int structure_dim, int dim>
  double
  ElasticStructure<structure_dim, dim>::energy(const Positions<dim> &X) const
  {
    std::vector<double> W;
    const std::vector<Matrix> F = deformation_gradients(X);
    evaluate(
      "energy", [&] { law->energy(F, W); }, W);
    double sum = 0;
    for (unsigned int e = first; e < last; ++e)
      sum += W[e - first] * reference_mesh.elements()[e].measure;
    return dealii::Utilities::MPI::sum(sum, reference_mesh.communicator());
  }

  template <int structure_dim, int dim>
  std::vector<double>
  ElasticStructure<structure_dim, dim>::energy_density(const Positions<dim> &X) const
  {
    std::vector<double> W, all(reference_mesh.n_elements());
    const std::vector<Matrix> F = deformation_gradients(X);
    evaluate(
      "energy", [&] { law->energy(F, W); }, W);
    std::copy(W.begin(), W.end(), all.begin() + first);
    dealii::Utilities::MPI::sum(all, reference_mesh.communicator(), all);
    return all;
  }

  template <int structure_dim, int dim>
  std::array<std::vector<typename ElasticStructure<structure_dim, dim>::Matrix>,
             ElasticStructure<structure_dim, dim>::m * dim>
  ElasticStructure<structure_dim, dim>::tangent_columns(const std::vector<Matrix> &F) const
  {
    std::array<std::vector<Matrix>, m * dim> columns;
    std::vector<Matrix> dF(F.size());
    for (unsigned int c = 0; c < m * dim; ++c)
      {
        for (Matrix &direction : dF)
          {
            direction               = Matrix();
            direction[c / m][c % m] = 1;
          }
        evaluate(
          "derivative of the stress",
          [&] { law->stress_derivative(F, dF, columns[c]); },
          columns[c]);
      }
    return columns;
  }

  template <int structure_dim, int dim>
  MatrixEntries
  ElasticStructure<structure_dim, dim>::tangent(const Positions<dim> &X) const
  {
    // As face_loads() with dP = d2W/dF2 [e_b (x) grad phi_j], once for each node j of an element.
    const auto columns = tangent_columns(deformation_gradients(X));
    const auto &faces  = reference_mesh.faces();
    MatrixEntries entries;
    for (unsigned int e = first; e < last; ++e)
      {
        const auto &element = reference_mesh.elements()[e];
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
                      if (face_weights.empty())
                        for (unsigned int v = 0; v < m; ++v)
                          entries.push_back(
                            {std::uint64_t(faces[f].nodes[v]) * dim + i, column, jump / m});
                      else
                        for (unsigned int q = 0; q < face_weights.size(); ++q)
                          entries.push_back({(std::uint64_t(f) * face_weights.size() + q) * dim + i,
                                             column,
                                             face_weights[q] * jump});
                    }
                }
            }
      }
    return entries;
  }

  template <int structure_dim, int dim>
  typename StructureModel<dim>::Stiffness
  ElasticStructure<structure_dim, dim>::stiffness(const Positions<dim> &X) const
  {
    constexpr unsigned int n    = m * dim;
    const std::vector<Matrix> F = deformation_gradients(X);
    const auto columns          = tangent_columns(F);
    using Square                = std::array<std::array<double, n>, n>;

    // Whether all eigenvalues of A are below lambda: whether lambda I - A has a Cholesky factor.
    Square L;
    const auto bounds = [&](const Square &A, const double lambda) {
      for (unsigned int i = 0; i < n; ++i)
        for (unsigned int j = 0; j <= i; ++j)
          {
            double sum = (i == j ? lambda : 0) - A[i][j];
            for (unsigned int k = 0; k < j; ++k)
              sum -= L[i][k] * L[j][k];
            if (i != j)
              L[i][j] = sum / L[j][j];
            else if (sum > 0)
              L[i][i] = std::sqrt(sum);
            else
              return false;
          }
      return true;
    };
    // One factorisation an element, and a bisection for the few that raise the maximum.
    const auto raise = [&](const Square &A, double &largest) {
      double norm = 0;
      for (const auto &row : A)
        for (const double a : row)
          norm += a * a;
      norm = std::sqrt(norm);
      if (norm <= largest || bounds(A, largest * (1 + 1e-12)))
        return;
      double above = norm * (1 + 1e-12);
      while (above - largest > 1e-13 * above)
        {
          const double middle                   = (largest + above) / 2;
          (bounds(A, middle) ? above : largest) = middle;
        }
    };

    typename StructureModel<dim>::Stiffness largest;
    for (unsigned int e = 0; e < F.size(); ++e)
      {
        // Index: row of F * m + column.
        Square A, B = {};
        for (unsigned int i = 0; i < n; ++i)
          for (unsigned int j = 0; j < n; ++j)
            A[i][j] = columns[j][e][i / m][i % m];
        raise(A, largest.reference);

        // F = Q R with R of the size of the structure: dF = (H Q) R, and H Q is as large as H.
        const auto R = triangle(F[e]);
        double J     = 1;
        for (unsigned int k = 0; k < m; ++k)
          J *= R[k][k];
        for (unsigned int i = 0; i < n; ++i)
          for (unsigned int j = 0; j < n; ++j)
            for (unsigned int k = 0; k < m; ++k)
              for (unsigned int l = 0; l < m; ++l)
                B[i][j] +=
                  R[i % m][k] * A[i / m * m + k][j / m * m + l] * R[j % m][l] / std::max(J, 1e-12);
        raise(B, largest.spatial);
      }
    const MPI_Comm communicator = reference_mesh.communicator();
    return {dealii::Utilities::MPI::max(largest.reference, communicator),
            dealii::Utilities::MPI::max(largest.spatial, communicator)};
  }

  template <int structure_dim, int dim>
  std::array<std::array<double, structure_dim>, structure_dim>
  ElasticStructure<structure_dim, dim>::triangle(const Matrix &F)
  {
    std::array<std::array<double, m>, m> R = {};
    for (unsigned int j = 0; j < m; ++j)
      for (unsigned int i = 0; i <= j; ++i)
        {
          double sum = 0;
          for (unsigned int a = 0; a < dim; ++a)
            sum += F[a][i] * F[a][j];
          for (unsigned int k = 0; k < i; ++k)
            sum -= R[k][i] * R[k][j];
          R[i][j] = i == j ? std::sqrt(std::max(sum, 0.)) : R[i][i] > 0 ? sum / R[i][i] : 0;
        }
    return R;
  }

  template <int structure_dim, int dim>
  std::pair<double, dealii::Tensor<1, dim>>
  ElasticStructure<structure_dim, dim>::moments(const Positions<dim> &X) const
  {
    // A closed curve or surface encloses the cones over its elements with a common tip, X[0].
    const bool cones = m < dim && reference_mesh.closed();
    std::pair<double, dealii::Tensor<1, dim>> result;
    for (const auto &element : reference_mesh.elements())
      {
        dealii::Tensor<2, dim> edges;
        dealii::Tensor<1, dim> sum;
        for (unsigned int k = 0; k <= m; ++k)
          sum += X[element.nodes[k]] - X[0];
        double size;
        if (m == dim || cones)
          {
            for (unsigned int k = 0; k < dim; ++k)
              edges[k] =
                cones ? X[element.nodes[k]] - X[0] : X[element.nodes[k + 1]] - X[element.nodes[0]];
            size = determinant(edges) / (dim == 2 ? 2 : 6);
          }
        else
          {
            dealii::DerivativeForm<1, structure_dim, dim> map;
            for (unsigned int k = 0; k < m; ++k)
              for (unsigned int i = 0; i < dim; ++i)
                map[i][k] = X[element.nodes[k + 1]][i] - X[element.nodes[0]][i];
            size = map.determinant() / m;
          }
        result.first += size;
        result.second += size / (cones ? dim + 1 : m + 1) * sum;
      }
    return result;
  }

  template <int structure_dim, int dim>
  double
  ElasticStructure<structure_dim, dim>::measure(const Positions<dim> &X) const
  {
    return std::abs(moments(X).first);
  }

  template <int structure_dim, int dim>
  dealii::Point<dim>
  ElasticStructure<structure_dim, dim>::centroid(const Positions<dim> &X) const
  {
    const auto [size, moment] = moments(X);
    return X[0] + moment / size;
  }
} // namespace feib

#endif
