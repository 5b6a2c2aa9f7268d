// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_testing_output_writer_kit_h
#define feib_testing_output_writer_kit_h

#include <feib/output_writer.h>
#include <feib/testing/examples.h>
#include <feib/testing/fields.h>
#include <feib/testing/memory_checkpoint.h>
#include <feib/testing/temporary_folder.h>

#include <gtest/gtest.h>

#include <cerrno>
#include <cstring>
#include <functional>
#include <memory>

namespace feib::testing
{
  /// A fluid and a structure that change from step to step, and a writer of them.
  template <int dim>
  class WriterTrial
  {
  public:
    /// Throws Error where the writer refuses its block in this dimension.
    WriterTrial(const std::string &name, const std::string &block)
      : writer(registry().create<OutputWriter<dim>>(name, block))
      , space(make_state<dim>())
      , structures(1)
    {
      structures[0].model = registry().create<StructureModel<dim>>(
        "hyperelastic",
        std::string(R"({"name": "body", "law": {"neo_hookean": {"shear_modulus": 1}}, "mesh": )") +
          (dim == 2 ? R"({"disc": {"radius": 0.25, "rings": 1}}})"
                    : R"({"ball": {"radius": 0.25, "refinements": 0}}})"));
      start = structures[0].model->positions;
      writer->check({*space, structures, {0.}});
    }

    /// Writes the state of a step.
    void
    write(const unsigned int step, const std::string &directory)
    {
      const double factor = 1 + .1 * step;
      set_velocity(*space, space->velocity, [&](const dealii::Point<dim> &x) {
        return factor * exact_velocity<dim>(x);
      });
      set_pressure(*space, space->pressure, [&](const dealii::Point<dim> &x) {
        return factor * exact_pressure<dim>(x);
      });
      for (unsigned int i = 0; i < start.size(); ++i)
        structures[0].model->positions[i][0] = start[i][0] + .01 * step;
      ledger.add({{"step", step}, {"time", .25 * step}});
      writer->write({step, .25 * step, directory, *space, structures, ledger});
    }

    void
    archive(Archive &archive)
    {
      archive("ledger", ledger);
      archive("writer", *writer);
    }

    std::unique_ptr<OutputWriter<dim>> writer;
    std::unique_ptr<EulerianSpace<dim>> space;
    std::vector<ImmersedStructure<dim>> structures;
    Ledger ledger;

  private:
    Positions<dim> start;
  };


  using Files = std::map<std::string, std::string>;

  /// The files that were there before and have another content now, or that are new.
  inline std::vector<std::string>
  changed_files(const Files &before, const Files &now, const bool new_ones)
  {
    std::vector<std::string> result;
    for (const auto &[name, content] : now)
      {
        const auto old = before.find(name);
        if (old == before.end() ? new_ones : old->second != content)
          result.push_back(name);
      }
    return result;
  }


  /// Goes on in a folder where a run was killed: from a checkpoint of step 2, after step 3 and in
  /// the middle of writing more.
  template <int dim>
  void
  check_reopen(const std::string &name, const std::string &block)
  {
    const TemporaryFolder folder, of_one_run;
    Files expected;
    {
      WriterTrial<dim> trial(name, block);
      for (unsigned int step = 0; step < 6; ++step)
        {
          trial.write(step, of_one_run.path);
          const Files before = std::exchange(expected, of_one_run.contents());
          EXPECT_FALSE(changed_files(before, expected, true).empty())
            << "nothing is written at step " << step;
        }
    }

    MemoryCheckpoint<dim> checkpoint;
    {
      WriterTrial<dim> trial(name, block);
      for (unsigned int step = 0; step < 3; ++step)
        trial.write(step, folder.path);
      trial.archive(checkpoint);
      const Files before = folder.contents();
      trial.write(3, folder.path);
      for (const std::string &file : changed_files(before, folder.contents(), true))
        folder.on_first_rank([&] {
          std::ofstream(folder.path + "/" + file, std::ios::app) << "4,1.0, and the middle of";
        });
    }
    WriterTrial<dim> resumed(name, block);
    checkpoint.start_reading(*resumed.space);
    resumed.archive(checkpoint);
    resumed.writer->reopen(folder.path, resumed.space->communicator());
    for (unsigned int step = 3; step < 6; ++step)
      resumed.write(step, folder.path);

    const Files found = folder.contents();
    for (const auto &[file, content] : expected)
      {
        ASSERT_EQ(found.count(file), 1u) << file << " is missing";
        EXPECT_TRUE(found.at(file) == content)
          << file << " is not that of a run that was not killed: " << found.at(file).size()
          << " instead of " << content.size() << " bytes";
      }
    for (const auto &[file, content] : found)
      EXPECT_EQ(expected.count(file), 1u) << file << " is not of a run that was not killed";
  }


  /// A file that a run goes on with and that is not there any more is a failure on all ranks, which
  /// names it.
  template <int dim>
  void
  check_missing_files(const std::string &name, const std::string &block)
  {
    const TemporaryFolder folder;
    MemoryCheckpoint<dim> checkpoint;
    std::vector<std::string> appended;
    {
      WriterTrial<dim> trial(name, block);
      trial.write(0, folder.path);
      const Files before = folder.contents();
      trial.archive(checkpoint);
      trial.write(1, folder.path);
      appended = changed_files(before, folder.contents(), false);
    }
    WriterTrial<dim> resumed(name, block);
    checkpoint.start_reading(*resumed.space);
    resumed.archive(checkpoint);
    if (appended.empty())
      return; // each state has files of its own
    folder.on_first_rank([&] { std::filesystem::remove(folder.path + "/" + appended[0]); });
    const std::string message =
      failure_of([&] { resumed.writer->reopen(folder.path, resumed.space->communicator()); });
    EXPECT_NE(message.find(folder.path + "/" + appended[0]), std::string::npos)
      << "without " << appended[0] << ", reopen() says \"" << message << '"';
  }


  /// What cannot be written is a failure on all ranks, which names the file and the
  /// reason: all files on a full disk, one after the other, and a folder that is not there.
  template <int dim>
  void
  check_unwritable(const std::string &name, const std::string &block)
  {
    Files written;
    {
      const TemporaryFolder folder;
      WriterTrial<dim>(name, block).write(0, folder.path);
      written = folder.contents();
    }
    EXPECT_FALSE(written.empty());
    for (const auto &[file, content] : written)
      {
        const TemporaryFolder folder;
        folder.make_full(file);
        WriterTrial<dim> trial(name, block);
        const std::string message = failure_of([&] { trial.write(0, folder.path); });
        EXPECT_NE(message.find(folder.path + "/" + file), std::string::npos)
          << "with " << file << " on a full disk, write() says \"" << message << '"';
        EXPECT_NE(message.find(std::strerror(ENOSPC)), std::string::npos) << message;
      }
    const TemporaryFolder folder;
    const std::string nowhere = folder.path + "/not there";
    WriterTrial<dim> trial(name, block);
    const std::string message = failure_of([&] { trial.write(0, nowhere); });
    EXPECT_NE(message.find(nowhere), std::string::npos)
      << "in a folder that is not there, write() says \"" << message << '"';
  }


  /// interval() is the parameter of that name where there is one, else 1.
  template <int dim>
  void
  check_interval(const std::string &name, const std::string &block)
  {
    const WriterTrial<dim> trial(name, block);
    const Parameters filled = filled_block("output", name, block);
    EXPECT_EQ(int(trial.writer->interval()),
              filled.has("interval") ? filled.integer("interval") : 1);
  }


  /// What every output writer must keep, tried for each example of its schema in 2 and 3
  /// dimensions. Include it in one source of a test program; with navier_stokes, hyperelastic and
  /// neo_hookean among the plugins.
  class OutputWriterKit : public ::testing::TestWithParam<std::string>
  {
  protected:
    using Requirement = std::function<void(const std::string &, const std::string &)>;

    void
    check(const Requirement &in_2d, const Requirement &in_3d) const
    {
      for_each_example<OutputWriter<2>>(GetParam(), [&](const std::string &block) {
        // An example may be of one dimension, and refused in the other.
        std::string refusal;
        const auto try_in = [&](const std::string &dimension, const Requirement &requirement) {
          SCOPED_TRACE("dimension " + dimension);
          try
            {
              requirement(GetParam(), block);
            }
          catch (const Error &error)
            {
              refusal += std::string(error.what()) + "; ";
              return false;
            }
          return true;
        };
        const bool accepted = try_in("2", in_2d) | try_in("3", in_3d);
        EXPECT_TRUE(accepted) << "no dimension accepts this example: " << refusal;
      });
    }
  };

  TEST_P(OutputWriterKit, GoesOnWithItsFiles)
  {
    check(check_reopen<2>, check_reopen<3>);
  }

  TEST_P(OutputWriterKit, MissesFilesThatAreGone)
  {
    check(check_missing_files<2>, check_missing_files<3>);
  }

  TEST_P(OutputWriterKit, SaysWhatCannotBeWritten)
  {
    check(check_unwritable<2>, check_unwritable<3>);
  }

  TEST_P(OutputWriterKit, HasTheIntervalOfItsBlock)
  {
    check(check_interval<2>, check_interval<3>);
  }
} // namespace feib::testing

/// Runs the conformance kit for the output writer of that name.
#define FEIB_TEST_OUTPUT_WRITER(name) FEIB_TEST_OUTPUT_WRITER_(name, __LINE__)
#define FEIB_TEST_OUTPUT_WRITER_(name, line) FEIB_TEST_OUTPUT_WRITER__(name, line)
#define FEIB_TEST_OUTPUT_WRITER__(name, line)                              \
  namespace feib::testing                                                  \
  {                                                                        \
    INSTANTIATE_TEST_SUITE_P(Line##line,                                   \
                             OutputWriterKit,                              \
                             ::testing::Values(std::string(name)),         \
                             [](const auto &info) { return info.param; }); \
  }                                                                        \
  static_assert(true, "")

#endif
