// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_testing_memory_checkpoint_h
#define feib_testing_memory_checkpoint_h

#include <feib/eulerian_space.h>

#include <gtest/gtest.h>

#include <map>
#include <string>

namespace feib::testing
{
  /// A checkpoint that stays in memory: what objects write, others that are made anew read and go
  /// on with, on the same number of ranks. A name that is used twice, and one that is written and
  /// never read, are failures of the test.
  template <int dim>
  class MemoryCheckpoint : public Archive
  {
  public:
    MemoryCheckpoint()
      : Archive(false)
    {}

    ~MemoryCheckpoint() override
    {
      for (const auto &[place, is_read] : read_at)
        EXPECT_TRUE(is_read || !is_reading)
          << "the state \"" << place << "\" is written and not read";
    }

    /// What follows is read. @p new_space: that of the fields.
    void
    start_reading(const EulerianSpace<dim> &new_space)
    {
      is_reading = true;
      space      = &new_space;
    }

    bool
    persistent() const override
    {
      return true;
    }

  protected:
    using Archive::path;

    std::any *
    slot() override
    {
      return nullptr;
    }

    bool
    contains(const std::string &place) const override
    {
      const auto below = bytes.lower_bound(place + "/");
      return bytes.count(place) > 0 ||
             (below != bytes.end() && below->first.rfind(place + "/", 0) == 0);
    }

    void
    write(const std::string &value) override
    {
      EXPECT_EQ(bytes.count(path), 0u) << "the name of the state \"" << path << "\" is used twice";
      bytes[path]   = value;
      read_at[path] = false;
    }

    std::string
    read() override
    {
      if (bytes.count(path) == 0)
        throw RunFailure("there is no state \"" + path + "\"");
      read_at[path] = true;
      return bytes[path];
    }

    void
    field(Vector &values) override
    {
      if (!is_reading)
        {
          write("");
          fields[path] = values;
          return;
        }
      read();
      const Vector &written = fields[path];
      if (written.size() == 0)
        {
          values.reinit(0);
          return;
        }
      values.reinit(written.size() == space->velocity.size() ? space->velocity.get_partitioner()
                                                             : space->pressure.get_partitioner());
      ASSERT_EQ(values.locally_owned_size(), written.locally_owned_size());
      std::copy_n(written.begin(), written.locally_owned_size(), values.begin());
      values.update_ghost_values();
    }

  private:
    const EulerianSpace<dim> *space = nullptr;
    std::map<std::string, std::string> bytes;
    std::map<std::string, Vector> fields;
    std::map<std::string, bool> read_at;
  };


  /// What a component keeps to save time, and may change results within tolerances, is dropped, as
  /// a checkpoint does.
  template <int dim, class Component>
  void
  drop_caches(Component &component)
  {
    MemoryCheckpoint<dim> nowhere;
    component.archive(nowhere);
  }
} // namespace feib::testing

#endif
