// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/testing/structure_force_kit.h>
#include <feib/testing/temporary_folder.h>

#include <fstream>

FEIB_TEST_STRUCTURE_FORCE("spring_network");

namespace
{
  using namespace feib;
  using feib::testing::registry;
  using feib::testing::structure_for_forces;
  using feib::testing::TemporaryFolder;

  std::unique_ptr<StructureForce<2>>
  springs(const StructureModel<2> &model, const std::string &block)
  {
    auto force            = registry().create<StructureForce<2>>("spring_network", block);
    static const auto box = feib::testing::unit_box<2>();
    force->attach({model.mesh(), model.positions, {}, {0.}, box});
    return force;
  }

  /// A file of springs.
  std::string
  write(const TemporaryFolder &folder, const std::string &text)
  {
    const std::string file = folder.path + "/springs.txt";
    if (dealii::Utilities::MPI::this_mpi_process(MPI_COMM_WORLD) == 0)
      std::ofstream(file) << text;
    MPI_Barrier(MPI_COMM_WORLD);
    return file;
  }
} // namespace


TEST(SpringNetwork, EnergyOfSpringsOfAFile)
{
  const TemporaryFolder folder;
  const std::string file = write(folder, "# two springs\n0 5\n\n 2 9 0.1 7 # stiff\n");
  const auto model       = structure_for_forces<2>(registry(), "closed curve");
  const auto force =
    springs(*model, R"({"stiffness": 3, "rest_length": 0.2, "file": ")" + file + "\"}");
  const auto length = [&](const unsigned int i, const unsigned int j) {
    return model->positions[i].distance(model->positions[j]);
  };
  EXPECT_NEAR(force->energy(model->positions),
              3. / 2 * std::pow(length(0, 5) - .2, 2) + 7. / 2 * std::pow(length(2, 9) - .1, 2),
              1e-14);
}


TEST(SpringNetwork, FilesThatWillNotDo)
{
  const TemporaryFolder folder;
  const auto model = structure_for_forces<2>(registry(), "closed curve");
  for (const auto &[text, sentence] : std::map<std::string, std::string>{
         {"", "has no springs"},
         {"0\n", ":1: lacks the numbers of two nodes"},
         {"0 1\n0 99\n", ":2: the structure has no node 99"},
         {"4 4", ":1: a spring needs two nodes"},
         {"0 1 -2", ":1: found \"-2\" where a rest length"},
         {"0 1 1 nan", ":1: found \"nan\" where a stiffness"},
         {"0 1 1 1 1", ":1: found \"1\" after all"},
         {"0 -1", ":1: found \"-1\" where the number of a node must stand"},
         {"0 1.5 0.1", ":1: found \"1.5\" where the number"}})
    try
      {
        springs(*model, R"({"stiffness": 1, "file": ")" + write(folder, text) + "\"}");
        ADD_FAILURE() << text;
      }
    catch (const Error &error)
      {
        EXPECT_NE(std::string(error.what()).find(sentence), std::string::npos) << error.what();
      }
  EXPECT_THROW(springs(*model, R"({"stiffness": 1, "file": "/nowhere"})"), Error);
}


/// A spring that was too long is gone, until an archive brings it back.
TEST(SpringNetwork, SpringsBreak)
{
  const auto model    = structure_for_forces<2>(registry(), "closed curve");
  const auto force    = springs(*model, R"({"stiffness": 1, "breaking_stretch": 1.5})");
  Positions<2> pulled = model->positions;
  pulled[0][0] += .3;
  const double whole = force->energy(pulled);
  EXPECT_GT(whole, 0);
  MemoryArchive before;
  before.start_writing();
  force->archive(before);
  force->update_state(pulled);
  EXPECT_LT(force->energy(pulled), 1e-20); // both springs at the node
  before.start_reading();
  force->archive(before);
  EXPECT_EQ(force->energy(pulled), whole);
}
