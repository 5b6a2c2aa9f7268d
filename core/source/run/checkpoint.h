// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_source_checkpoint_h
#define feib_source_checkpoint_h

#include "json.h"

#include <feib/archive.h>
#include <feib/eulerian_space.h>

#include <chrono>
#include <functional>

namespace feib
{
  /// Writes the state of a run into a folder: what is the same on all ranks into the file `values`,
  /// by path, and fields of the space into the file `fields`, in the order of their unknowns, which
  /// is that of the forest.
  template <int dim>
  class CheckpointWriter : public Archive
  {
  public:
    /// Throws RunFailure. All functions are collective.
    CheckpointWriter(const EulerianSpace<dim> &space, const std::string &folder);
    ~CheckpointWriter() override;

    /// Writes what is left and waits until all is on the disk.
    void finish();

    bool
    persistent() const override
    {
      return true;
    }

  protected:
    using Vector = Archive::Vector;

    std::any *
    slot() override
    {
      return nullptr;
    }

    bool
    contains(const std::string &) const override
    {
      return false;
    }

    void write(const std::string &bytes) override;
    std::string read() override;
    void field(Vector &values) override;

  private:
    const EulerianSpace<dim> &space;
    const std::string folder;
    std::string values; // on rank 0
    std::map<std::string, bool> written;
    MPI_File file           = MPI_FILE_NULL;
    std::uint64_t n_in_file = 0; // numbers
  };


  /// Reads it again, on any number of ranks.
  template <int dim>
  class CheckpointReader : public Archive
  {
  public:
    /// The fields are read into a space whose mesh is the one that was written, by the time they
    /// are asked for. Throws RunFailure. All functions are collective.
    CheckpointReader(const EulerianSpace<dim> &space, const std::string &folder);
    ~CheckpointReader() override;

    bool
    persistent() const override
    {
      return true;
    }

  protected:
    using Vector = Archive::Vector;

    std::any *
    slot() override
    {
      return nullptr;
    }

    bool contains(const std::string &path) const override;
    void write(const std::string &bytes) override;
    std::string read() override;
    void field(Vector &values) override;

  private:
    const EulerianSpace<dim> &space;
    std::map<std::string, std::string> values;
    MPI_File file = MPI_FILE_NULL;
  };


  /// The checkpoints of a run: which are written when, how many are kept, and which one to go on
  /// from. They are folders in `checkpoints` of the run's folder, named by the step.
  class Checkpoints
  {
  public:
    /// From the block "checkpoint" of a case.
    explicit Checkpoints(const Parameters &parameters);

    /// Whether one is due after this step; the same on all ranks. Collective.
    bool due(unsigned int step, MPI_Comm communicator) const;

    /// Writes one: @p fill gets the archive and the state's folder, which takes the name it is
    /// found by when all is on the disk; those beyond the number to keep go. @p manifest: what the
    /// checkpoint says of itself. Throws RunFailure. Collective.
    void write(const std::string &run_folder,
               unsigned int step,
               Json manifest,
               MPI_Comm communicator,
               const std::function<void(const std::string &folder)> &fill);

    /// The newest sound checkpoint of a run's folder and its manifest; warns of damaged ones.
    /// Throws Error when there is none. Collective.
    static std::pair<std::string, Json> newest(const std::string &run_folder);

  private:
    const unsigned int interval, keep;
    const double seconds;
    std::chrono::steady_clock::time_point last;
    int last_step = -1;
  };
} // namespace feib

#endif
