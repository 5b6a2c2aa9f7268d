// SPDX-License-Identifier: LGPL-2.1-or-later
#include "initial_state.h"
#include "stiffness.h"

#include <feib/position_fault.h>
#include <feib/failure.h>
#include <feib/message.h>
#include <feib/structure_model/elastic_structure.h>

#include <deal.II/base/derivative_form.h>
#include <deal.II/base/mpi.h>

#include <cmath>
#include <limits>
#include <sstream>

namespace feib
{
  template <int structure_dim, int dim>
  ElasticStructure<structure_dim, dim>::ElasticStructure(const Parameters &parameters,
                                                         std::unique_ptr<Law> constitutive_law)
    : structure_name(parameters.word("name"))
    , reference_mesh(make_structure_mesh<dim>(parameters, m, this->positions))
    , first(reference_mesh.local_elements().first)
    , last(reference_mesh.local_elements().second)
    , law_name(parameters.child("law").choice().first)
    , law(std::move(constitutive_law))
    , faces(reference_mesh,
            parameters.child("face_quadrature"),
            parameters.boolean("boundary_faces"))
    , points(faces.points())
    , forces(reference_mesh, structure_name, points)
    , node_masses(lumped_masses(parameters, reference_mesh))
  {
    this->initial_positions = this->positions;
    set_points();
    this->velocities = initial_velocities(parameters, reference_mesh, !node_masses.empty());
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
    if (const std::string fault = position_fault(reference_mesh, this->positions); !fault.empty())
      parameters.fail(parameters.has("initial_position") ? "initial_position" : "mesh", fault);
  }


  template <int structure_dim, int dim>
  void
  ElasticStructure<structure_dim, dim>::set_points()
  {
    std::vector<typename Law::MaterialPoint> material_points;
    for (unsigned int e = first; e < last; ++e)
      {
        const auto &element = reference_mesh.elements()[e];
        material_points.emplace_back();
        material_points.back().place       = element.centroid;
        material_points.back().material_id = element.material_id;
        for (const auto &[name, id] : reference_mesh.material_names())
          if (id == element.material_id)
            material_points.back().material = name;
        for (unsigned int k = 0; k < m; ++k)
          material_points.back().frame[k] = element.frame[k];
        for (const auto &[data, values] : reference_mesh.element_data())
          material_points.back().data[data] = values[e];
      }
    std::pair<std::string, std::string> issue; // pointer and message
    try
      {
        law->set_points(material_points);
      }
    catch (const Error &error)
      {
        issue = {error.issues().front().pointer, error.issues().front().message};
      }
    catch (const std::exception &failure)
      {
        issue = {"",
                 "the law \"" + law_name + "\" of structure \"" + structure_name +
                   "\" fails with its points: " + failure.what()};
      }
    for (const auto &[pointer, message] :
         dealii::Utilities::MPI::all_gather(reference_mesh.communicator(), issue))
      if (!message.empty())
        throw Error(pointer, message);
    for (const auto &variable : law->state_variables())
      {
        state_names.push_back(variable.name);
        moment.state.emplace_back(material_points.size(), variable.initial);
      }
    tell_moment();
  }


  template <int structure_dim, int dim>
  const std::string &
  ElasticStructure<structure_dim, dim>::name() const
  {
    return structure_name;
  }


  template <int structure_dim, int dim>
  const typename ElasticStructure<structure_dim, dim>::Mesh &
  ElasticStructure<structure_dim, dim>::mesh() const
  {
    return reference_mesh;
  }


  template <int structure_dim, int dim>
  void
  ElasticStructure<structure_dim, dim>::archive(Archive &archive)
  {
    StructureModel<dim>::archive(archive);
    archive("law", *law);
    archive("time", moment.time);
    archive("elapsed", moment.elapsed);
    for (unsigned int v = 0; v < state_names.size(); ++v)
      {
        std::vector<double> values = all_elements(moment.state[v]);
        archive("state_" + state_names[v], values);
        std::copy(values.begin() + first, values.begin() + last, moment.state[v].begin());
      }
    archive("forces", forces);
    if (archive.reading())
      moment_has_changed();
  }


  template <int structure_dim, int dim>
  void
  ElasticStructure<structure_dim, dim>::set_forces(Forces new_forces)
  {
    forces.set(std::move(new_forces));
    moment_has_changed();
  }


  template <int structure_dim, int dim>
  std::vector<std::string>
  ElasticStructure<structure_dim, dim>::force_names() const
  {
    return forces.names();
  }


  template <int structure_dim, int dim>
  std::vector<double>
  ElasticStructure<structure_dim, dim>::force_energies(const Positions<dim> &X) const
  {
    return forces.energies(X);
  }


  template <int structure_dim, int dim>
  std::vector<NodalField<dim>>
  ElasticStructure<structure_dim, dim>::force_loads(const Positions<dim> &X,
                                                    const Positions<dim> &geometry,
                                                    const NodalField<dim> &U) const
  {
    return forces.loads(X, geometry, U);
  }


  template <int structure_dim, int dim>
  bool
  ElasticStructure<structure_dim, dim>::external() const
  {
    return forces.external();
  }


  template <int structure_dim, int dim>
  void
  ElasticStructure<structure_dim, dim>::external_load(const Positions<dim> &X,
                                                      NodalField<dim> &load) const
  {
    load = NodalField<dim>(points);
    forces.add_external_load(X, load);
  }


  template <int structure_dim, int dim>
  std::string
  ElasticStructure<structure_dim, dim>::law_fails(const char *what) const
  {
    return "the law \"" + law_name + "\" of structure \"" + structure_name + "\" fails in its " +
           what;
  }


  template <int structure_dim, int dim>
  void
  ElasticStructure<structure_dim, dim>::tell_moment()
  {
    agree(
      reference_mesh.communicator(), [&] { law->set_moment(moment); }, law_fails("moment"));
  }


  template <int structure_dim, int dim>
  void
  ElasticStructure<structure_dim, dim>::moment_has_changed()
  {
    tell_moment();
    forces.set_moment(moment.time, moment.elapsed);
    if (!law->time_dependent() && state_names.empty() && forces.empty())
      return;
    last_energy.forget();
    last_stiffness.forget();
  }


  template <int structure_dim, int dim>
  void
  ElasticStructure<structure_dim, dim>::set_moment(const double time, const double elapsed)
  {
    moment.time    = time;
    moment.elapsed = elapsed;
    moment_has_changed();
  }


  template <int structure_dim, int dim>
  void
  ElasticStructure<structure_dim, dim>::update_state(const Positions<dim> &X)
  {
    forces.update_state(X);
    if (state_names.empty())
      return;
    const std::vector<Matrix> F = deformation_gradients(X);
    auto next                   = moment.state;
    std::vector<double> sums; // for evaluate(), not finite where one of the values is not
    evaluate(
      "state",
      [&] {
        law->update_state(F, next);
        if (next.size() != state_names.size())
          throw Incurable("it gives " + std::to_string(next.size()) + " state variables, it has " +
                          std::to_string(state_names.size()));
        for (const std::vector<double> &values : next)
          {
            if (values.size() != sums.size())
              throw Incurable("it gives " + std::to_string(values.size()) + " values for " +
                              std::to_string(sums.size()) + " elements");
            for (unsigned int q = 0; q < values.size(); ++q)
              sums[q] += values[q];
          }
      },
      sums);
    moment.state = std::move(next);
    moment_has_changed();
  }


  template <int structure_dim, int dim>
  std::vector<double>
  ElasticStructure<structure_dim, dim>::all_elements(const std::vector<double> &local) const
  {
    std::vector<double> all(reference_mesh.n_elements());
    std::copy(local.begin(), local.end(), all.begin() + first);
    dealii::Utilities::MPI::sum(all, reference_mesh.communicator(), all);
    return all;
  }


  template <int structure_dim, int dim>
  std::vector<std::pair<std::string, std::vector<double>>>
  ElasticStructure<structure_dim, dim>::state() const
  {
    std::vector<std::pair<std::string, std::vector<double>>> result;
    for (unsigned int v = 0; v < state_names.size(); ++v)
      result.emplace_back(state_names[v], all_elements(moment.state[v]));
    return result;
  }


  template <int structure_dim, int dim>
  const LagrangianPoints &
  ElasticStructure<structure_dim, dim>::load_points() const
  {
    return points;
  }


  template <int structure_dim, int dim>
  bool
  ElasticStructure<structure_dim, dim>::linear() const
  {
    return law->linear() && forces.linear();
  }


  template <int structure_dim, int dim>
  bool
  ElasticStructure<structure_dim, dim>::conservative() const
  {
    return faces.conservative();
  }


  template <int structure_dim, int dim>
  const std::vector<double> &
  ElasticStructure<structure_dim, dim>::excess_mass() const
  {
    return node_masses;
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
    MPI_Allreduce(
      MPI_IN_PLACE, &worst, 1, MPI_DOUBLE_INT, MPI_MINLOC, reference_mesh.communicator());
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
      law_fails(what));
  }


  template <int structure_dim, int dim>
  void
  ElasticStructure<structure_dim, dim>::load(const Positions<dim> &X, NodalField<dim> &load) const
  {
    std::vector<Matrix> P;
    const std::vector<Matrix> F = deformation_gradients(X);
    evaluate(
      "stress", [&] { law->stress(F, P); }, P);
    faces.load(P, load);
    forces.add_load(X, load);
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
    faces.load(dP, dload);
    forces.add_load_derivative(X, dX, dload);
  }


  template <int structure_dim, int dim>
  std::vector<double>
  ElasticStructure<structure_dim, dim>::local_energy_density(const Positions<dim> &X) const
  {
    std::vector<double> W;
    const std::vector<Matrix> F = deformation_gradients(X);
    evaluate(
      "energy", [&] { law->energy(F, W); }, W);
    return W;
  }


  template <int structure_dim, int dim>
  double
  ElasticStructure<structure_dim, dim>::energy(const Positions<dim> &X) const
  {
    return last_energy.at(X, [&] {
      const std::vector<double> W = local_energy_density(X);
      double sum                  = 0;
      for (unsigned int e = first; e < last; ++e)
        sum += W[e - first] * reference_mesh.elements()[e].measure;
      sum = dealii::Utilities::MPI::sum(sum, reference_mesh.communicator());
      for (const double force_energy : force_energies(X))
        sum += force_energy;
      return sum;
    });
  }


  template <int structure_dim, int dim>
  std::vector<double>
  ElasticStructure<structure_dim, dim>::energy_density(const Positions<dim> &X) const
  {
    return all_elements(local_energy_density(X));
  }


  template <int structure_dim, int dim>
  template <typename Function>
  typename ElasticStructure<structure_dim, dim>::Columns
  ElasticStructure<structure_dim, dim>::columns(const char *what, const Function &function) const
  {
    Columns result;
    std::vector<Matrix> dF(last - first);
    for (unsigned int c = 0; c < m * dim; ++c)
      {
        for (Matrix &direction : dF)
          {
            direction               = Matrix();
            direction[c / m][c % m] = 1;
          }
        evaluate(
          what, [&] { function(dF, result[c]); }, result[c]);
      }
    return result;
  }


  template <int structure_dim, int dim>
  typename ElasticStructure<structure_dim, dim>::Columns
  ElasticStructure<structure_dim, dim>::tangent_columns(const std::vector<Matrix> &F) const
  {
    return columns("derivative of the stress",
                   [&](const std::vector<Matrix> &dF, std::vector<Matrix> &dP) {
                     law->stress_derivative(F, dF, dP);
                   });
  }


  template <int structure_dim, int dim>
  MatrixEntries
  ElasticStructure<structure_dim, dim>::tangent(const Positions<dim> &X) const
  {
    MatrixEntries entries = faces.tangent(tangent_columns(deformation_gradients(X)));
    forces.add_tangent(X, entries);
    return entries;
  }


  template <int structure_dim, int dim>
  bool
  ElasticStructure<structure_dim, dim>::viscous() const
  {
    return law->viscous() || forces.viscous();
  }


  template <int structure_dim, int dim>
  void
  ElasticStructure<structure_dim, dim>::viscous_load(const Positions<dim> &X,
                                                     const NodalField<dim> &U,
                                                     NodalField<dim> &load) const
  {
    load = NodalField<dim>(points);
    if (law->viscous())
      {
        std::vector<Matrix> P;
        const std::vector<Matrix> F = deformation_gradients(X), rate = gradients(U);
        evaluate(
          "viscous stress", [&] { law->viscous_stress(F, rate, P); }, P);
        faces.load(P, load);
      }
    forces.add_viscous_load(X, U, load);
  }


  template <int structure_dim, int dim>
  MatrixEntries
  ElasticStructure<structure_dim, dim>::viscous_tangent(const Positions<dim> &X) const
  {
    MatrixEntries entries;
    if (law->viscous())
      {
        const std::vector<Matrix> F = deformation_gradients(X);
        entries                     = faces.tangent(
          columns("viscous stress", [&](const std::vector<Matrix> &rate, std::vector<Matrix> &P) {
            law->viscous_stress(F, rate, P);
          }));
      }
    forces.add_viscous_tangent(X, entries);
    return entries;
  }


  template <int structure_dim, int dim>
  typename ElasticStructure<structure_dim, dim>::Stiffness
  ElasticStructure<structure_dim, dim>::stiffness(const Positions<dim> &X) const
  {
    return last_stiffness.at(X, [&]() -> Stiffness {
      const std::vector<Matrix> F = deformation_gradients(X);
      const Stiffness local       = largest_stiffness<structure_dim, dim>(F, tangent_columns(F));
      const MPI_Comm communicator = reference_mesh.communicator();
      return {dealii::Utilities::MPI::max(local.reference, communicator),
              dealii::Utilities::MPI::max(local.spatial, communicator),
              forces.stiffness(X)};
    });
  }


  template <int structure_dim, int dim>
  const Moments<dim> &
  ElasticStructure<structure_dim, dim>::measure_moments(const Positions<dim> &X) const
  {
    return last_moments.at(X, [&] { return moments<structure_dim>(reference_mesh, X); });
  }


  template <int structure_dim, int dim>
  double
  ElasticStructure<structure_dim, dim>::measure(const Positions<dim> &X) const
  {
    return std::abs(measure_moments(X).measure);
  }


  template <int structure_dim, int dim>
  dealii::Point<dim>
  ElasticStructure<structure_dim, dim>::centroid(const Positions<dim> &X) const
  {
    const Moments<dim> &moments = measure_moments(X);
    if (moments.measure != 0)
      return X[0] + moments.first / moments.measure;
    dealii::Point<dim> centre;
    for (unsigned int a = 0; a < dim; ++a)
      {
        const auto coordinate = [&](const unsigned int i) { return X[i][a]; };
        const auto opposite   = [&](const unsigned int i) { return -X[i][a]; };
        centre[a]             = (X.largest(coordinate) - X.largest(opposite)) / 2;
      }
    return centre;
  }


  template <int structure_dim, int dim>
  dealii::SymmetricTensor<2, dim>
  ElasticStructure<structure_dim, dim>::second_moments(const Positions<dim> &X) const
  {
    const Moments<dim> &moments = measure_moments(X);
    if (moments.measure == 0)
      return {};
    const dealii::Tensor<1, dim> centroid = moments.first / moments.measure;
    return moments.second / moments.measure - symmetrize(outer_product(centroid, centroid));
  }


  template <int structure_dim, int dim>
  std::vector<dealii::SymmetricTensor<2, dim>>
  ElasticStructure<structure_dim, dim>::cauchy_stress(const Positions<dim> &X) const
  {
    std::vector<Matrix> P;
    const std::vector<Matrix> F = deformation_gradients(X);
    evaluate(
      "stress", [&] { law->stress(F, P); }, P);
    std::vector<double> entries[dim][dim];
    for (unsigned int i = 0; i < dim; ++i)
      for (unsigned int j = 0; j <= i; ++j)
        {
          std::vector<double> &entry = entries[i][j];
          for (unsigned int e = 0; e < F.size(); ++e)
            entry.push_back(
              (P[e][i] * F[e][j] + P[e][j] * F[e][i]) / 2 /
              std::abs(dealii::DerivativeForm<1, structure_dim, dim>(F[e]).determinant()));
          entry = all_elements(entry);
        }
    std::vector<dealii::SymmetricTensor<2, dim>> stress(reference_mesh.n_elements());
    for (unsigned int e = 0; e < stress.size(); ++e)
      for (unsigned int i = 0; i < dim; ++i)
        for (unsigned int j = 0; j <= i; ++j)
          stress[e][i][j] = entries[i][j][e];
    return stress;
  }


  template class ElasticStructure<1, 2>;
  template class ElasticStructure<2, 2>;
  template class ElasticStructure<2, 3>;
  template class ElasticStructure<3, 3>;
} // namespace feib
