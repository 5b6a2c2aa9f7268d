// SPDX-License-Identifier: LGPL-2.1-or-later
#include "checkpoint_archive.h"

#include "synced_file.h"
#include <feib/text_file.h>

#include <feib/failure.h>

#include <deal.II/base/mpi.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>

namespace feib
{
  namespace
  {
    void
    check(const int code, const std::string &file)
    {
      if (code == MPI_SUCCESS)
        return;
      // Some MPI libraries say no more than that writing failed; the system knows why.
      for (const int reason : {EFBIG, ENOSPC, EDQUOT, EIO})
        if (errno == reason)
          throw RunFailure(file + ": " + std::strerror(reason));
      char text[MPI_MAX_ERROR_STRING];
      int length = 0;
      MPI_Error_string(code, text, &length);
      throw RunFailure(file + ": " + std::string(text, length));
    }


    template <typename Number>
    void
    append(std::string &bytes, const Number number)
    {
      bytes.append(reinterpret_cast<const char *>(&number), sizeof(number));
    }


    std::uint64_t
    take_number(const std::string &bytes, std::size_t &at)
    {
      std::uint64_t number;
      if (bytes.size() - at < sizeof(number))
        throw RunFailure("a checkpoint ends too early");
      std::memcpy(&number, bytes.data() + at, sizeof(number));
      at += sizeof(number);
      return number;
    }


    std::string
    take_text(const std::string &bytes, std::size_t &at)
    {
      const std::uint64_t size = take_number(bytes, at);
      if (bytes.size() - at < size)
        throw RunFailure("a checkpoint ends too early");
      at += size;
      return bytes.substr(at - size, size);
    }
  } // namespace


  template <int dim>
  CheckpointArchive<dim>::CheckpointArchive(const bool reading,
                                            const EulerianSpace<dim> &space,
                                            const std::string &folder,
                                            const int mode)
    : Archive(reading)
    , space(space)
    , folder(folder)
  {
    const std::string name = folder + "/" + fields_file;
    check(MPI_File_open(space.communicator(), name.c_str(), mode, MPI_INFO_NULL, &file), name);
  }


  template <int dim>
  CheckpointArchive<dim>::~CheckpointArchive()
  {
    if (file != MPI_FILE_NULL)
      MPI_File_close(&file);
  }


  template <int dim>
  MPI_Offset
  CheckpointArchive<dim>::offset(const std::uint64_t begin, const Archive::Vector &values)
  {
    const dealii::IndexSet owned = values.locally_owned_elements();
    return (begin + (owned.n_elements() > 0 ? *owned.begin() : 0)) * sizeof(double);
  }


  template <int dim>
  CheckpointWriter<dim>::CheckpointWriter(const EulerianSpace<dim> &space,
                                          const std::string &folder)
    : CheckpointArchive<dim>(false, space, folder, MPI_MODE_CREATE | MPI_MODE_WRONLY)
  {}


  template <int dim>
  void
  CheckpointWriter<dim>::write(const std::string &bytes)
  {
    if (!written.emplace(this->path, true).second)
      throw std::logic_error("two states are called \"" + this->path + "\"");
    if (dealii::Utilities::MPI::this_mpi_process(this->space.communicator()) != 0)
      return;
    append(values, std::uint64_t(this->path.size()));
    values += this->path;
    append(values, std::uint64_t(bytes.size()));
    values += bytes;
  }


  template <int dim>
  std::string
  CheckpointWriter<dim>::read()
  {
    throw std::logic_error("nothing is read while a checkpoint is written");
  }


  template <int dim>
  void
  CheckpointWriter<dim>::field(Archive::Vector &vector)
  {
    const auto partitioner = vector.get_partitioner();
    const char kind        = partitioner == this->space.velocity.get_partitioner()   ? 'v'
                             : partitioner == this->space.pressure.get_partitioner() ? 'p'
                             : vector.size() == 0                                    ? '0'
                                                                                     : '?';
    if (kind == '?')
      throw std::logic_error("the field \"" + this->path + "\" is not of this mesh");
    std::string entry(1, kind);
    append(entry, n_in_file);
    append(entry, std::uint64_t(vector.size()));
    write(entry);
    if (kind == '0')
      return;
    errno = 0;
    check(MPI_File_write_at_all(this->file,
                                this->offset(n_in_file, vector),
                                vector.begin(),
                                vector.locally_owned_size(),
                                MPI_DOUBLE,
                                MPI_STATUS_IGNORE),
          this->folder + "/" + this->fields_file);
    n_in_file += vector.size();
  }


  template <int dim>
  void
  CheckpointWriter<dim>::finish()
  {
    check(MPI_File_sync(this->file), this->folder + "/" + this->fields_file);
    check(MPI_File_close(&this->file), this->folder + "/" + this->fields_file);
    agree(this->space.communicator(), [&] {
      if (dealii::Utilities::MPI::this_mpi_process(this->space.communicator()) == 0)
        write_synced(this->folder + "/" + this->values_file, values);
    });
  }


  template <int dim>
  CheckpointReader<dim>::CheckpointReader(const EulerianSpace<dim> &space,
                                          const std::string &folder)
    : CheckpointArchive<dim>(true, space, folder, MPI_MODE_RDONLY)
  {
    const std::string name  = folder + "/" + this->values_file;
    const std::string bytes = read_text_file(name, name, true, space.communicator());
    for (std::size_t at = 0; at < bytes.size();)
      {
        const std::string place = take_text(bytes, at);
        values[place]           = take_text(bytes, at);
      }
  }


  template <int dim>
  bool
  CheckpointReader<dim>::contains(const std::string &place) const
  {
    const auto below = values.lower_bound(place + "/");
    return values.count(place) > 0 ||
           (below != values.end() && below->first.rfind(place + "/", 0) == 0);
  }


  template <int dim>
  void
  CheckpointReader<dim>::write(const std::string &)
  {
    throw std::logic_error("nothing is written while a checkpoint is read");
  }


  template <int dim>
  std::string
  CheckpointReader<dim>::read()
  {
    const auto entry = values.find(this->path);
    if (entry == values.end())
      throw RunFailure("the checkpoint has no state \"" + this->path + "\"");
    return entry->second;
  }


  template <int dim>
  void
  CheckpointReader<dim>::field(Archive::Vector &vector)
  {
    const std::string entry = read();
    std::size_t at          = 1;
    const auto begin        = take_number(entry, at);
    const auto size         = take_number(entry, at);
    if (entry[0] == '0')
      {
        vector.reinit(0);
        return;
      }
    vector.reinit(entry[0] == 'v' ? this->space.velocity.get_partitioner()
                                  : this->space.pressure.get_partitioner());
    if (vector.size() != size)
      throw RunFailure("the field \"" + this->path + "\" has " + std::to_string(size) +
                       " unknowns, the mesh " + std::to_string(vector.size()));
    check(MPI_File_read_at_all(this->file,
                               this->offset(begin, vector),
                               vector.begin(),
                               vector.locally_owned_size(),
                               MPI_DOUBLE,
                               MPI_STATUS_IGNORE),
          this->fields_file);
    vector.update_ghost_values();
  }


  template class CheckpointArchive<2>;
  template class CheckpointArchive<3>;
  template class CheckpointWriter<2>;
  template class CheckpointWriter<3>;
  template class CheckpointReader<2>;
  template class CheckpointReader<3>;
} // namespace feib
