// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/fluid_solver.h>
#include <feib/testing/coupling_operator_kit.h>

FEIB_TEST_COUPLING_OPERATOR("divergence_free")

namespace
{
  using namespace feib;

  /// The boundary of a mesh, a closed curve or surface.
  template <int dim>
  LagrangianMesh<dim>
  boundary(const LagrangianMesh<dim> &mesh)
  {
    std::vector<unsigned int> number(mesh.n_nodes(), LagrangianMesh<dim>::invalid);
    std::vector<dealii::Point<dim>> nodes;
    std::vector<typename LagrangianMesh<dim>::Simplex> simplices;
    for (const auto &facet : mesh.surface())
      {
        simplices.emplace_back();
        for (unsigned int v = 0; v < dim; ++v)
          {
            if (number[facet[v]] == LagrangianMesh<dim>::invalid)
              {
                number[facet[v]] = nodes.size();
                nodes.push_back(mesh.nodes()[facet[v]]);
              }
            simplices.back().nodes[v]   = number[facet[v]];
            simplices.back().corners[v] = mesh.nodes()[facet[v]];
          }
      }
    return LagrangianMesh<dim>(dim - 1, nodes, simplices);
  }

  /// N_i: the force of a uniform pressure of one, and the gradient of what the facets enclose.
  template <int dim>
  NodalField<dim>
  vector_areas(const std::vector<typename LagrangianMesh<dim>::Facet> &facets,
               const Positions<dim> &X)
  {
    NodalField<dim> N(X.size());
    for (const auto &facet : facets)
      {
        dealii::Tensor<1, dim> n;
        if constexpr (dim == 2)
          n = cross_product_2d(X[facet[1]] - X[facet[0]]);
        else
          n = .5 * cross_product_3d(X[facet[1]] - X[facet[0]], X[facet[2]] - X[facet[0]]);
        for (const unsigned int i : facet)
          N[i] += n / dim;
      }
    return N;
  }

  enum class Shape
  {
    ragged, // nodes anywhere
    aligned // facets in the faces, edges and corners of the cells
  };

  template <int dim>
  struct Setting
  {
    Setting(const Shape shape,
            const bool body,
            const bool refined,
            const std::string &periodic = "[]")
      : space(feib::testing::make_space<dim>(
          std::string(dim == 2 ? "{\"cells\": [8, 8]" : "{\"cells\": [4, 4, 4]") +
          ", \"periodic\": " + periodic + "}"))
      , mesh(feib::testing::make_simplex_mesh<dim>(dim, dim == 2 ? 12 : 4))
      , fluid(feib::testing::registry().create<FluidSolver<dim>>(
          "navier_stokes",
          "{\"density\": 1, \"viscosity\": 0.01, \"convection\": \"none\", "
          "\"linear_solver\": \"direct\"}"))
    {
      if (!body)
        mesh = boundary(mesh);
      if (refined)
        feib::testing::refine_where(*space, [](const auto &x) { return x[0] + x[1] < .8; });
      std::mt19937 random(3);
      std::uniform_real_distribution<double> uniform(-1, 1);
      X = Positions<dim>(mesh);
      for (unsigned int i = 0; i < X.size(); ++i)
        for (unsigned int a = 0; a < dim; ++a)
          {
            const dealii::Point<dim> &s = mesh.nodes()[i];
            X[i][a] =
              .25 + .5 * s[a] +
              (shape == Shape::ragged ? .07 * s[0] + .1 * s[a] * s[1] + .008 * uniform(random)
                                      : 0.);
          }
      fluid->initialize(*space);
    }

    /// A curve instead, of n segments, parameter in [0, 1].
    template <typename Place>
    void
    set_curve(const unsigned int n, const Place &place)
    {
      mesh = feib::testing::make_simplex_mesh<dim>(1, n);
      X    = Positions<dim>(mesh);
      for (unsigned int i = 0; i < X.size(); ++i)
        X[i] = place(mesh.nodes()[i][0]);
    }

    /// One step of the fluid under a load.
    void
    advance(const VelocityVector &load)
    {
      space->old_velocity   = space->velocity;
      space->older_velocity = space->velocity;
      fluid->advance(*space, {.01, .01, load});
    }

    /// Two materials: where all reference coordinates are in (low, high), and elsewhere. Pressure
    /// acts on the interface then, and the volume is that inside.
    void
    set_inclusion(const double low, const double high)
    {
      std::vector<unsigned int> ids;
      for (const auto &element : mesh.elements())
        {
          bool inside = true;
          for (unsigned int a = 0; a < dim; ++a)
            inside = inside && element.centroid[a] > low && element.centroid[a] < high;
          ids.push_back(inside ? 1 : 2);
        }
      mesh.set_materials(ids);
      inclusion = true;
    }

    const std::vector<typename LagrangianMesh<dim>::Facet> &
    facets() const
    {
      return inclusion ? mesh.interfaces() : mesh.surface();
    }

    std::unique_ptr<EulerianSpace<dim>> space;
    bool inclusion = false;
    LagrangianMesh<dim> mesh;
    Positions<dim> X;
    std::unique_ptr<FluidSolver<dim>> fluid;
  };

  template <int dim>
  std::unique_ptr<CouplingOperator<dim>>
  make_coupling(const std::string &name, const Setting<dim> &setting)
  {
    auto coupling = feib::testing::registry().create<CouplingOperator<dim>>(name);
    coupling->set_geometry(*setting.space,
                           setting.mesh,
                           setting.X,
                           LagrangianPoints::nodes(setting.X.size()));
    return coupling;
  }

  /// The largest velocity that a uniform pressure of one on the surface makes in a step.
  template <int dim>
  double
  spurious_velocity(const std::string &coupling, Setting<dim> &&setting)
  {
    VelocityVector load = setting.space->make_velocity();
    make_coupling(coupling, setting)
      ->spread(*setting.space, vector_areas<dim>(setting.facets(), setting.X), load);
    setting.advance(load);
    return setting.space->velocity.linfty_norm();
  }

  /// The change of what the surface encloses, over the sum of its parts, in a velocity that some
  /// load has made, after a relative disturbance that is not divergence-free.
  template <int dim>
  double
  volume_rate(const std::string &coupling, Setting<dim> &&setting, const double disturbance = 0)
  {
    VelocityVector load = setting.space->make_velocity();
    std::mt19937 random(5);
    std::uniform_real_distribution<double> uniform(-1, 1);
    for (dealii::types::global_dof_index i = 0; i < load.size(); ++i)
      {
        const double value = uniform(random); // the same on any number of ranks
        if (load.in_local_range(i))
          load(i) = value;
      }
    setting.advance(load);
    VelocityVector &u = setting.space->velocity;
    load *= disturbance * u.linfty_norm() / load.linfty_norm();
    setting.space->distribute(load, true);
    u.zero_out_ghost_values();
    u += load;
    u.update_ghost_values();
    NodalField<dim> U;
    make_coupling(coupling, setting)->interpolate(*setting.space, u, U);
    const NodalField<dim> N = vector_areas<dim>(setting.facets(), setting.X);
    double sum = 0, scale = 0;
    for (unsigned int i = 0; i < U.size(); ++i)
      {
        sum += N[i] * U[i];
        scale += std::abs(N[i] * U[i]);
      }
    EXPECT_GT(scale, 0);
    return std::abs(sum) / scale;
  }

  template <int dim>
  void
  check_all(const bool body)
  {
    for (const bool refined : {false, true})
      for (const Shape shape : {Shape::ragged, Shape::aligned})
        {
          SCOPED_TRACE("dim " + std::to_string(dim) + (body ? ", body" : "") +
                       (refined ? ", refined" : "") + (shape == Shape::aligned ? ", aligned" : ""));
          EXPECT_LT(spurious_velocity("divergence_free", Setting<dim>(shape, body, refined)),
                    1e-12);
          EXPECT_LT(volume_rate("divergence_free", Setting<dim>(shape, body, refined)), 1e-12);
        }
    EXPECT_GT(spurious_velocity("variational", Setting<dim>(Shape::ragged, body, true)), 1e-5);
    EXPECT_GT(volume_rate("variational", Setting<dim>(Shape::ragged, body, true)), 1e-5);
  }
} // namespace

TEST(DivergenceFree, AllOptionsAreDual)
{
  for (const char *const parameters : {"{\"quadrature\": {\"vertex\": {}}}",
                                       "{\"quadrature\": {\"gauss\": {\"points\": 2}}}",
                                       "{\"reconstruction\": false}",
                                       "{\"flux_exact\": false}"})
    for (const unsigned int codimension : {0, 1})
      {
        SCOPED_TRACE(parameters);
        feib::testing::check_duality<2>("divergence_free", 2 - codimension, true, true, parameters);
        feib::testing::check_duality<3>(
          "divergence_free", 3 - codimension, true, false, parameters);
      }
}

/// An unstable step may throw a node far along a periodic direction: that ends it, at once.
TEST(DivergenceFree, ATornStructureIsAFailure)
{
  const auto space = feib::testing::make_space<2>("{\"cells\": [8, 8], \"periodic\": [\"x\"]}");
  const LagrangianMesh<2> mesh = feib::testing::make_simplex_mesh<2>(1, 10);
  Positions<2> X(mesh);
  for (unsigned int i = 0; i < X.size(); ++i)
    X[i] = {.3 + .4 * mesh.nodes()[i][0], .4};
  X[5][0]             = 1e7;
  const auto coupling = feib::testing::registry().create<CouplingOperator<2>>("divergence_free");
  EXPECT_THROW(coupling->set_geometry(*space, mesh, X, LagrangianPoints::nodes(X.size())),
               RunFailure);
}

TEST(DivergenceFree, UniformPressureMovesNothingAndVolumeStays)
{
  check_all<2>(false);
  check_all<3>(false);
}

TEST(DivergenceFree, SoDoesTheBoundaryOfABody)
{
  check_all<2>(true);
  check_all<3>(true);
}

/// So do the interfaces of its materials; where they end at the boundary, that stays exact.
TEST(DivergenceFree, SoDoTheMaterialsOfABody)
{
  const auto inclusion = [](auto setting) {
    setting.set_inclusion(.2, .8);
    EXPECT_FALSE(setting.mesh.interfaces().empty());
    return setting;
  };
  const auto corner = [](auto setting) {
    setting.set_inclusion(0, .6);
    setting.inclusion = false;
    return setting;
  };
  EXPECT_LT(spurious_velocity("divergence_free", inclusion(Setting<2>(Shape::ragged, true, true))),
            1e-12);
  EXPECT_LT(spurious_velocity("divergence_free", inclusion(Setting<3>(Shape::ragged, true, true))),
            1e-12);
  EXPECT_LT(volume_rate("divergence_free", inclusion(Setting<2>(Shape::ragged, true, true))),
            1e-12);
  EXPECT_LT(volume_rate("divergence_free", inclusion(Setting<3>(Shape::ragged, true, true))),
            1e-12);
  EXPECT_LT(spurious_velocity("divergence_free", corner(Setting<2>(Shape::ragged, true, true))),
            1e-12);
  EXPECT_LT(volume_rate("divergence_free", corner(Setting<2>(Shape::ragged, true, true))), 1e-12);
}

/// How tightly the divergence must be solved: what leaks is proportional to what is left of it.
TEST(DivergenceFree, LeakIsLinearInTheDivergence)
{
  for (const double disturbance : {1e-2, 1e-4, 1e-6, 1e-8})
    {
      const double rate =
        volume_rate("divergence_free", Setting<2>(Shape::ragged, false, true), disturbance);
      std::cout << "relative disturbance " << disturbance << ": relative leak " << rate
                << std::endl;
      EXPECT_LT(rate, 10 * disturbance);
      EXPECT_GT(rate, disturbance / 1000);
    }
}

/// An open curve that stands on a wall with both ends encloses fluid with it.
TEST(DivergenceFree, AnArchOnAWallKeepsItsFluid)
{
  const auto rate = [](const std::string &coupling) {
    Setting<2> setting(Shape::ragged, false, true);
    setting.set_curve(40, [](const double s) -> dealii::Point<2> {
      return {.2 + .6 * s, s == 0 || s == 1 ? 0 : 2.4 * s * (1 - s)};
    });
    return volume_rate(coupling, std::move(setting));
  };
  EXPECT_LT(rate("divergence_free"), 1e-12);
  EXPECT_GT(rate("variational"), 1e-5);
}

/// A body that stands in a corner of the box, and one between two walls.
TEST(DivergenceFree, ABodyOnWallsKeepsItsVolumeAndUniformPressureMovesNothing)
{
  const auto standing = [](auto setting, const bool between) {
    for (unsigned int i = 0; i < setting.X.size(); ++i)
      for (unsigned int a = 0; a < 2; ++a)
        {
          const double s = setting.mesh.nodes()[i][a];
          double &x      = setting.X[i][a];
          x              = s == 0 ? 0 : s == 1 && a == 1 && between ? 1 : 1.25 * (x - .25);
        }
    return setting;
  };
  for (const bool refined : {false, true})
    for (const bool body : {false, true})
      for (const Shape shape : {Shape::ragged, Shape::aligned})
        for (const bool between : {false, true})
          {
            SCOPED_TRACE((refined ? "refined" : "uniform") + std::string(body ? ", body" : "") +
                         (shape == Shape::aligned ? ", aligned" : "") +
                         (between ? ", between walls" : ""));
            EXPECT_LT(spurious_velocity("divergence_free",
                                        standing(Setting<2>(shape, body, refined), between)),
                      1e-12);
            EXPECT_LT(volume_rate("divergence_free",
                                  standing(Setting<2>(shape, body, refined), between)),
                      1e-12);
            // In 3D a triangle would have all its nodes on walls, on different ones.
            if (between)
              continue;
            EXPECT_LT(volume_rate("divergence_free",
                                  standing(Setting<3>(shape, body, refined), between)),
                      1e-12);
          }
}

/// A wavy sheet, or a thick one, across a periodic box: what it parts stays parted, and both ends
/// are one.
template <int dim>
void
check_across(const bool body, const bool refined)
{
  SCOPED_TRACE("dim " + std::to_string(dim) + (body ? ", body" : "") +
               (refined ? ", refined" : ""));
  const auto across = [&](const double shift) {
    Setting<dim> setting(Shape::ragged, true, refined, dim == 2 ? "[\"x\"]" : "[\"x\", \"y\"]");
    const unsigned int m = body ? dim : dim - 1;
    setting.mesh         = feib::testing::make_simplex_mesh<dim>(m, dim == 2 ? 12 : 4);
    setting.X            = Positions<dim>(setting.mesh);
    for (unsigned int i = 0; i < setting.X.size(); ++i)
      {
        const dealii::Point<dim> &s = setting.mesh.nodes()[i];
        double wave                 = 0;
        for (unsigned int a = 0; a + 1 < dim; ++a)
          {
            setting.X[i][a] = s[a] + shift;
            wave += .1 * std::sin(2 * dealii::numbers::PI * setting.X[i][a] + a);
          }
        setting.X[i][dim - 1] = .4 + wave + (body ? .17 * s[dim - 1] : 0.);
      }
    return setting;
  };
  EXPECT_LT(spurious_velocity("divergence_free", across(.3)), 1e-12);
  EXPECT_LT(volume_rate("divergence_free", across(.3)), 1e-12);
  EXPECT_GT(spurious_velocity("variational", across(.3)), 1e-6);
  EXPECT_GT(volume_rate("variational", across(.3)), 1e-6);

  Setting<dim> setting = across(.3);
  VelocityVector load  = setting.space->make_velocity();
  std::mt19937 random(5);
  for (unsigned int i = 0; i < load.locally_owned_size(); ++i)
    load.local_element(i) = random() % 100;
  setting.advance(load);
  const VelocityVector &u = setting.space->velocity;
  NodalField<dim> U;
  make_coupling("divergence_free", setting)->interpolate(*setting.space, u, U);
  const double largest = u.linfty_norm();
  EXPECT_GT(largest, 1e-3);
  unsigned int n_images = 0;
  for (unsigned int i = 0; i < U.size(); ++i)
    for (unsigned int j = 0; j < i; ++j)
      {
        dealii::Tensor<1, dim> apart = setting.mesh.nodes()[i] - setting.mesh.nodes()[j];
        for (unsigned int a = 0; a + 1 < dim; ++a)
          apart[a] -= std::round(apart[a]);
        if (apart.norm() > 1e-9)
          continue;
        ++n_images;
        EXPECT_LT((U[i] - U[j]).norm(), 1e-14 * largest) << i << ' ' << j;
      }
  EXPECT_GT(n_images, 0u);

  // What the first node is does not matter.
  if (dim == 2 && !body)
    {
      Setting<dim> turned = across(.3 + 5. / 12);
      NodalField<dim> V;
      make_coupling("divergence_free", turned)->interpolate(*setting.space, u, V);
      for (unsigned int i = 0; i < 12; ++i)
        EXPECT_LT((U[(i + 5) % 12] - V[i]).norm(), 1e-13 * largest) << i;
    }
}

/// Two thick sheets across the box, one on the other: the ends of each are one, and the coupling
/// stays dual.
TEST(DivergenceFree, SheetsThatTouchAreJoinedOneByOne)
{
  Setting<2> setting(Shape::ragged, true, false, "[\"x\"]");
  const LagrangianMesh<2> one = feib::testing::make_simplex_mesh<2>(2, 4);
  const unsigned int n        = one.n_nodes();
  std::vector<dealii::Point<2>> nodes;
  std::vector<LagrangianMesh<2>::Simplex> simplices;
  for (unsigned int part = 0; part < 2; ++part)
    {
      const dealii::Tensor<1, 2> shift({0, double(part)});
      for (const auto &node : one.nodes())
        nodes.push_back(node + shift);
      for (const auto &element : one.elements())
        {
          simplices.emplace_back();
          for (unsigned int v = 0; v < 3; ++v)
            {
              simplices.back().nodes[v]   = element.nodes[v] + part * n;
              simplices.back().corners[v] = nodes[element.nodes[v] + part * n];
            }
        }
    }
  setting.mesh = LagrangianMesh<2>(2, nodes, simplices);
  setting.X    = Positions<2>(setting.mesh);
  for (unsigned int i = 0; i < nodes.size(); ++i)
    setting.X[i] = {.3 + nodes[i][0],
                    .3 + .15 * nodes[i][1] + .1 * std::sin(2 * dealii::numbers::PI * nodes[i][0])};
  const auto coupling = make_coupling("divergence_free", setting);

  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(-1, 1);
  // The same forces on all ranks.
  NodalField<2> f(setting.mesh), U, by_entries(setting.mesh);
  for (auto &force : f)
    for (unsigned int a = 0; a < 2; ++a)
      force[a] = uniform(random);
  VelocityVector v = setting.space->make_velocity();
  for (unsigned int i = 0; i < v.locally_owned_size(); ++i)
    v.local_element(i) = uniform(random);
  setting.space->distribute(v, true);
  coupling->interpolate(*setting.space, v, U);
  VelocityVector load = setting.space->make_velocity();
  coupling->spread(*setting.space, f, load);
  EXPECT_NEAR(load * v, f * U, 1e-12);
  for (const MatrixEntry &entry : coupling->entries(*setting.space))
    by_entries[entry.row / 2][entry.row % 2] +=
      entry.value * v.local_element(v.get_partitioner()->global_to_local(entry.column));
  by_entries.compress(MPI_COMM_WORLD);
  by_entries.update_ghosts();
  for (unsigned int i = 0; i < U.size(); ++i)
    EXPECT_LT((by_entries[i] - U[i]).norm(), 1e-12) << i;
  double apart = 0;
  for (unsigned int i = 0; i < n; ++i)
    for (unsigned int j = 0; j < n; ++j)
      {
        for (const unsigned int part : {0u, n})
          if (std::abs(nodes[i][0] - nodes[j][0]) == 1 && nodes[i][1] == nodes[j][1] &&
              (nodes[i][1] == 0 || nodes[i][1] == 1)) // inside, both move with u(X_i)
            {
              EXPECT_EQ((U[i + part] - U[j + part]).norm(), 0) << i << ' ' << j << ' ' << part;
            }
        if (nodes[i].distance(nodes[j + n]) == 0)
          apart = std::max(apart, (U[i] - U[j + n]).norm());
      }
  EXPECT_LT(apart, 1e-14); // the facets between them are the same
}

TEST(DivergenceFree, ASheetAcrossAPeriodicBoxIsWhole)
{
  for (const bool body : {false, true})
    for (const bool refined : {false, true})
      {
        check_across<2>(body, refined);
        check_across<3>(body, refined);
      }
}

/// A curve that lies in a wall stays in it, where it is when the fluid does not slip.
TEST(DivergenceFree, ACurveInAWallStaysInIt)
{
  Setting<2> setting(Shape::ragged, false, false);
  setting.set_curve(10, [](const double s) -> dealii::Point<2> { return {.1 + .7 * s, 1.}; });
  VelocityVector load = setting.space->make_velocity();
  std::mt19937 random(5);
  for (unsigned int i = 0; i < load.locally_owned_size(); ++i)
    load.local_element(i) = random() % 100;
  setting.advance(load);
  NodalField<2> U;
  make_coupling("divergence_free", setting)
    ->interpolate(*setting.space, setting.space->velocity, U);
  ASSERT_GT(setting.space->velocity.linfty_norm(), 1e-2);
  for (unsigned int i = 0; i < U.size(); ++i)
    EXPECT_EQ(U[i].norm(), 0);
}

/// Where segments fold back on each other the map would be large: it becomes the plain average.
TEST(DivergenceFree, FoldsAreHarmless)
{
  Setting<2> setting(Shape::ragged, false, false);
  setting.set_curve(10, [](const double s) -> dealii::Point<2> {
    return {.3 + .4 * (s <= .5 ? s : 1 - s), .4};
  });
  const auto coupling = make_coupling("divergence_free", setting);
  NodalField<2> sums(setting.mesh);
  for (const MatrixEntry &entry : coupling->entries(*setting.space))
    sums[entry.row / 2][entry.row % 2] += std::abs(entry.value);
  sums.compress(MPI_COMM_WORLD);
  sums.update_ghosts();
  for (const auto &sum : sums)
    for (unsigned int a = 0; a < 2; ++a)
      {
        EXPECT_LT(sum[a], 10);
        EXPECT_GT(sum[a], .9);
      }
}
