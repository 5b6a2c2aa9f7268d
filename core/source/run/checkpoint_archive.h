// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_source_checkpoint_archive_h
#define feib_source_checkpoint_archive_h

#include <feib/archive.h>
#include <feib/eulerian_space.h>

#include <map>
#include <string>

namespace feib
{
  /// The state of a run in a folder: what is the same on all ranks in the file `values`, by path,
  /// and fields of the space in the file `fields`, in the order of their unknowns, which is that of
  /// the forest. All functions are collective and throw RunFailure.
  template <int dim>
  class CheckpointArchive : public Archive
  {
  public:
    static constexpr const char *values_file = "values";
    static constexpr const char *fields_file = "fields";

    bool
    persistent() const override
    {
      return true;
    }

  protected:
    /// Opens the fields in one of MPI's modes.
    CheckpointArchive(bool reading,
                      const EulerianSpace<dim> &space,
                      const std::string &folder,
                      int mode);
    ~CheckpointArchive() override;

    std::any *
    slot() override
    {
      return nullptr;
    }

    /// The place in the file of this rank's part of a field that begins at number @p begin.
    static MPI_Offset offset(std::uint64_t begin, const Archive::Vector &values);

    const EulerianSpace<dim> &space;
    const std::string folder;
    MPI_File file = MPI_FILE_NULL;
  };


  template <int dim>
  class CheckpointWriter : public CheckpointArchive<dim>
  {
  public:
    CheckpointWriter(const EulerianSpace<dim> &space, const std::string &folder);

    /// Writes what is left and waits until all is on the disk.
    void finish();

  protected:
    bool
    contains(const std::string &) const override
    {
      return false;
    }

    void write(const std::string &bytes) override;
    std::string read() override;
    void field(Archive::Vector &values) override;

  private:
    std::string values; // on rank 0
    std::map<std::string, bool> written;
    std::uint64_t n_in_file = 0; // numbers
  };


  /// Reads it again, on any number of ranks. Fields are read into a space whose mesh is the one
  /// that was written, by the time they are asked for.
  template <int dim>
  class CheckpointReader : public CheckpointArchive<dim>
  {
  public:
    CheckpointReader(const EulerianSpace<dim> &space, const std::string &folder);

  protected:
    bool contains(const std::string &path) const override;
    void write(const std::string &bytes) override;
    std::string read() override;
    void field(Archive::Vector &values) override;

  private:
    std::map<std::string, std::string> values;
  };
} // namespace feib

#endif
