// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_testing_structure_force_requirements_h
#define feib_testing_structure_force_requirements_h

#include <feib/registry.h>
#include <feib/schema.h>
#include <feib/structure_model.h>
#include <feib/testing/derivative.h>
#include <feib/testing/findings.h>

#include <cmath>
#include <map>
#include <memory>
#include <random>

namespace feib::testing
{
  /// A structure that forces are tried on: "curve", "surface" or "body", with an excess mass.
  template <int dim>
  std::unique_ptr<StructureModel<dim>>
  structure_for_forces(const Registry &registry, const std::string &kind)
  {
    const std::string common =
      R"("name": "s", "law": {"neo_hookean": {"shear_modulus": 1}}, "excess_density": 0.5, "mesh": )";
    std::string mesh;
    if (kind == "open curve")
      mesh = R"j({"open_curve": {"length": 1, "elements": 9}},
                 "initial_position": ["s1", "0.2 * s1^2"])j";
    else if (kind == "closed curve")
      mesh = R"j({"closed_curve": {"length": 1, "elements": 11}},
                 "initial_position": ["0.5 + 0.2*cos(2*pi*s1)", "0.4 + 0.3*sin(2*pi*s1)"])j";
    else if (kind == "surface")
      mesh = R"j({"sphere": {"centre": [0.5, 0.5, 0.5], "radius": 0.3, "refinements": 1}})j";
    else
      mesh = dim == 2
               ? R"j({"disc": {"centre": [0.5, 0.5], "radius": 0.3, "rings": 3}})j"
               : R"j({"ball": {"centre": [0.5, 0.5, 0.5], "radius": 0.3, "refinements": 1}})j";
    return registry.create<StructureModel<dim>>(kind == "body" ? "hyperelastic" : "membrane",
                                                "{" + common + mesh + "}");
  }

  /// A box that these structures are in, with walls.
  template <int dim>
  Domain<dim>
  unit_box()
  {
    dealii::Point<dim> upper;
    std::array<unsigned int, dim> cells;
    for (unsigned int a = 0; a < dim; ++a)
      {
        upper[a] = 1;
        cells[a] = 8;
      }
    return Domain<dim>(dealii::Point<dim>(), upper, cells);
  }

  /// What every force on structures must keep, tried for one block of it on one structure.
  template <int dim>
  class StructureForceRequirements
  {
  public:
    explicit StructureForceRequirements(const Registry &registry)
      : registry(registry)
      , box(unit_box<dim>())
    {}

    /// Whether the force was attached: it may refuse a structure.
    bool
    attach(const std::string &name, const std::string &block, const std::string &structure)
    {
      model = structure_for_forces<dim>(registry, structure);
      try
        {
          force       = registry.create<StructureForce<dim>>(name, block);
          force->name = name;
          force->attach({model->mesh(), model->positions, model->excess_mass(), {0., 1.}, box});
        }
      catch (const Error &error)
        {
          refusal = error.what();
          return false;
        }
      force->set_moment(.3, .1);
      X                = model->positions;
      U                = random(1);
      const auto shake = random(7);
      for (unsigned int i = 0; i < X.size(); ++i)
        X[i] += .05 * model->mesh().diameter() * shake[i];
      return true;
    }

    Findings
    check()
    {
      Findings findings;
      findings.run([&] { load_is_derivative(findings); });
      findings.run([&] { derivative_is_right(findings); });
      findings.run([&] { stiffness_bounds(findings); });
      findings.run([&] { damps(findings); });
      findings.run([&] { same_again(findings); });
      return findings;
    }

    std::string refusal;

  private:
    NodalField<dim>
    random(const unsigned int seed) const
    {
      std::mt19937 generator(seed);
      std::uniform_real_distribution<double> number(-1, 1);
      NodalField<dim> field(model->mesh());
      for (auto &vector : field)
        for (unsigned int a = 0; a < dim; ++a)
          vector[a] = number(generator);
      return field;
    }

    Positions<dim>
    moved(const double h) const
    {
      Positions<dim> Y = X;
      for (unsigned int i = 0; i < Y.size(); ++i)
        Y[i] += h * model->mesh().diameter() * U[i];
      return Y;
    }

    NodalField<dim>
    load(const Positions<dim> &Y) const
    {
      NodalField<dim> result(model->mesh());
      force->load(Y, result);
      return result;
    }

    static double
    norm(const NodalField<dim> &field)
    {
      return std::sqrt(field * field);
    }

    void
    load_is_derivative(Findings &findings) const
    {
      const double h        = model->mesh().diameter();
      const double work     = h * (load(X) * U),
                   expected = -derivative([&](const double t) { return force->energy(moved(t)); });
      const double scale    = h * norm(load(X)) * norm(U) + std::abs(force->energy(X));
      findings.below(std::abs(work - expected),
                     1e-8 * scale + 1e-300,
                     "load() is not - d energy/dX: a force that comes from no energy is an "
                     "external_load()");
    }

    void
    derivative_is_right(Findings &findings) const
    {
      NodalField<dim> by_function(model->mesh()), by_entries(model->mesh());
      NodalField<dim> dX = U;
      for (auto &vector : dX)
        vector *= model->mesh().diameter();
      force->load_derivative(X, dX, by_function);
      const auto test = random(3);
      const double expected =
        derivative([&](const double t) { return load(moved(t)) * test; }, 1e-3);
      const double scale = norm(by_function) * norm(test) + norm(load(X)) * norm(test);
      findings.below(std::abs(by_function * test - expected),
                     1e-7 * scale + 1e-300,
                     "load_derivative() is not the derivative of load()");
      check_entries(
        findings,
        [&](MatrixEntries &entries) { force->tangent(X, entries); },
        dX,
        by_function,
        "tangent()",
        "load_derivative()");
      NodalField<dim> elsewhere(model->mesh());
      force->load_derivative(moved(.3), dX, elsewhere);
      if (force->linear())
        for (unsigned int i = 0; i < elsewhere.size(); ++i)
          findings.below((elsewhere[i] - by_function[i]).norm(),
                         1e-10 * norm(by_function) + 1e-300,
                         "linear() is said of a load whose derivative depends on X");
    }

    template <typename Function>
    void
    check_entries(Findings &findings,
                  const Function &function,
                  const NodalField<dim> &direction,
                  const NodalField<dim> &expected,
                  const std::string &entries_name,
                  const std::string &name) const
    {
      MatrixEntries entries;
      function(entries);
      NodalField<dim> product(model->mesh());
      std::map<std::pair<std::uint64_t, std::uint64_t>, double> sum;
      for (const MatrixEntry &entry : entries)
        {
          if (entry.row >= dim * X.size() || entry.column >= dim * X.size())
            {
              findings.add(entries_name + " has entries of nodes that are not there");
              return;
            }
          product[entry.row / dim][entry.row % dim] -=
            entry.value * direction[entry.column / dim][entry.column % dim];
          sum[{entry.row, entry.column}] += entry.value;
        }
      product.compress(model->mesh().communicator());
      for (unsigned int i = 0; i < product.size(); ++i)
        findings.below((product[i] - expected[i]).norm(),
                       1e-10 * norm(expected) + 1e-300,
                       entries_name + " does not hold the entries of - " + name +
                         " (on several ranks: each gives a part)");
      if (dealii::Utilities::MPI::n_mpi_processes(model->mesh().communicator()) > 1)
        return;
      double largest = 0;
      for (const auto &[place, value] : sum)
        largest = std::max(largest, std::abs(value));
      for (const auto &[place, value] : sum)
        findings.below(std::abs(value - sum[{place.second, place.first}]),
                       1e-10 * largest + 1e-300,
                       entries_name + " is not symmetric");
    }

    /// What is said to the forecast of the step bounds what displacements are resisted by.
    void
    stiffness_bounds(Findings &findings) const
    {
      const auto stiffness               = force->stiffness(X);
      const auto &mesh                   = model->mesh();
      const std::vector<double> measures = mesh.node_measures();
      double smallest                    = std::numeric_limits<double>::max();
      for (const auto &element : mesh.elements())
        smallest = std::min(smallest, element.measure);
      const double edge  = std::pow(smallest, 1. / mesh.structure_dim());
      const double bound = stiffness.nodal + 64 * stiffness.bending / std::pow(edge, 4);
      for (unsigned int seed = 11; seed < 14; ++seed)
        {
          const auto dX = random(seed);
          NodalField<dim> df(mesh);
          force->load_derivative(X, dX, df);
          double square = 0;
          for (unsigned int i = 0; i < measures.size(); ++i)
            square += measures[i] * dX[i].norm_square();
          findings.below(-(df * dX),
                         bound * square * (1 + 1e-10) + 1e-300,
                         "stiffness() says less than what displacements are resisted by: explicit "
                         "schemes would take steps that are too large");
        }
    }

    void
    damps(Findings &findings) const
    {
      NodalField<dim> f(model->mesh()), half(model->mesh());
      force->viscous_load(X, U, f);
      NodalField<dim> slow = U;
      for (auto &vector : slow)
        vector *= .5;
      force->viscous_load(X, slow, half);
      findings.expect(norm(f) == 0 || force->viscous(),
                      "viscous() is false, but there is a viscous_load()");
      findings.below(f * U, 1e-300, "viscous_load() does not dissipate: its power is positive");
      for (unsigned int i = 0; i < f.size(); ++i)
        findings.below((f[i] - 2. * half[i]).norm(),
                       1e-10 * norm(f) + 1e-300,
                       "viscous_load() is not linear in the velocities");
      check_entries(
        findings,
        [&](MatrixEntries &entries) { force->viscous_tangent(X, entries); },
        U,
        f,
        "viscous_tangent()",
        "viscous_load()");
      NodalField<dim> external(model->mesh());
      force->external_load(X, external);
      findings.expect(norm(external) == 0 || force->external(),
                      "external() is false, but there is an external_load()");
    }

    /// What moved on and was undone by an archive is as it was.
    void
    same_again(Findings &findings)
    {
      MemoryArchive before;
      before.start_writing();
      force->archive(before);
      const auto first = load(X);
      force->update_state(moved(.2));
      before.start_reading();
      force->archive(before);
      force->set_moment(7., .2);
      force->set_moment(.3, .1);
      const auto second = load(X);
      for (unsigned int i = 0; i < first.size(); ++i)
        findings.expect(first[i] == second[i],
                        "load() is another one when the state and the time are the same again: "
                        "what a force remembers belongs into archive()");
    }

    const Registry &registry;
    const Domain<dim> box; // which the structure is in
    std::unique_ptr<StructureModel<dim>> model;
    std::unique_ptr<StructureForce<dim>> force;
    Positions<dim> X;
    NodalField<dim> U;
  };

  /// What is found wrong with a force for one example of its schema, on each structure that it
  /// takes.
  inline Findings
  check_structure_force(const Registry &registry,
                        const std::string &name,
                        const std::string &example)
  {
    Findings all;
    bool taken = false;
    std::string refusals;
    const auto try_on = [&](auto requirements, const std::string &structure) {
      if (!requirements.attach(name, example, structure))
        {
          refusals += "; " + structure + ": " + requirements.refusal;
          return;
        }
      taken             = true;
      Findings findings = requirements.check();
      for (std::string &sentence : findings.sentences)
        sentence = "on a " + structure + ": " + sentence;
      all.append(findings);
    };
    for (const char *structure : {"open curve", "closed curve", "body"})
      try_on(StructureForceRequirements<2>(registry), structure);
    for (const char *structure : {"surface", "body"})
      try_on(StructureForceRequirements<3>(registry), structure);
    if (!taken)
      all.add("no structure takes it" + refusals);
    return all;
  }
} // namespace feib::testing

#endif
