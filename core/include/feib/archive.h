// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_archive_h
#define feib_archive_h

#include <feib/error.h>

#include <deal.II/base/point.h>
#include <deal.II/base/tensor.h>
#include <deal.II/lac/la_parallel_vector.h>

#include <any>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace feib
{
  class Archive;

  namespace internal
  {
    template <typename T, typename = void>
    struct HasArchive : std::false_type
    {};

    template <typename T>
    struct HasArchive<T,
                      std::void_t<decltype(std::declval<T &>().archive(std::declval<Archive &>()))>>
      : std::true_type
    {};
  } // namespace internal

  /// Where the state of a run is written to and read from. Whatever an object carries from one step
  /// to the next it names in one function, for both:
  /// @code
  /// void archive(Archive &archive)
  /// {
  ///   archive("positions", positions);
  ///   archive("past", past);
  /// }
  /// @endcode
  /// Values are numbers, truth values, strings, points and tensors, vectors of velocity and
  /// pressure, objects that have such a function themselves, and containers and shared constants of
  /// these. What can be computed from other state is no state.
  ///
  /// There are two media. One in memory undoes a step that failed. A persistent one is a
  /// checkpoint, from which another program goes on, perhaps with another number of ranks: fields
  /// of the space are divided between ranks, all else must be the same on all ranks. Both are
  /// collective.
  class Archive
  {
  public:
    virtual ~Archive() = default;

    /// Whether values are being read.
    bool
    reading() const
    {
      return is_reading;
    }

    /// Whether another program may read this. What only saves time (a factorisation) and changes
    /// results within tolerances must be dropped then, in writing as in reading.
    virtual bool persistent() const = 0;

    /// Writes or reads a value. @p name is unique within the object. Reading throws RunFailure when
    /// there is no such value.
    template <typename T>
    void
    operator()(const std::string &name, T &value)
    {
      const Scope scope(*this, name);
      visit(value);
    }

    /// Whether there is something of that name to read.
    bool
    has(const std::string &name) const
    {
      return contains(path + "/" + name);
    }

  protected:
    using Vector = dealii::LinearAlgebra::distributed::Vector<double>;

    explicit Archive(const bool is_reading)
      : is_reading(is_reading)
    {}

    /// In memory: the place of the value at the path; null on other media.
    virtual std::any *slot() = 0;

    virtual bool contains(const std::string &path) const = 0;

    /// On other media: the bytes of the value at the path, the same on all ranks.
    virtual void write(const std::string &bytes) = 0;
    virtual std::string read()                   = 0;

    /// On other media: a field of the space.
    virtual void field(Vector &values) = 0;

    std::string path; // of the value at hand
    bool is_reading;

  private:
    /// The path goes deeper by a name.
    class Scope
    {
    public:
      Scope(Archive &archive, const std::string &name)
        : archive(archive)
        , length(archive.path.size())
      {
        archive.path += "/" + name;
      }

      ~Scope()
      {
        archive.path.resize(length);
      }

    private:
      Archive &archive;
      const std::size_t length;
    };

    template <typename T>
    void
    visit(T &value)
    {
      if constexpr (internal::HasArchive<T>::value)
        value.archive(*this);
      else if (std::any *const place = slot())
        {
          if (is_reading)
            value = std::any_cast<const T &>(*place);
          else if (T *const before = std::any_cast<T>(place))
            *before = value; // with the memory there is
          else
            *place = value;
        }
      else
        transfer(value);
    }

    /// Values of a fixed size.
    template <typename T>
    void
    transfer(T &value)
    {
      static_assert(is_plain<T>, "give the class a function archive(Archive &)");
      if (!is_reading)
        return write(std::string(reinterpret_cast<const char *>(&value), sizeof(T)));
      const std::string bytes = read();
      check_size(bytes, sizeof(T));
      bytes.copy(reinterpret_cast<char *>(&value), sizeof(T));
    }

    void
    transfer(std::string &value)
    {
      if (is_reading)
        value = read();
      else
        write(value);
    }

    void
    transfer(Vector &values)
    {
      field(values);
    }

    template <typename T>
    void
    transfer(std::vector<T> &values)
    {
      if constexpr (is_plain<T>)
        {
          if (!is_reading)
            return write(std::string(reinterpret_cast<const char *>(values.data()),
                                     sizeof(T) * values.size()));
          const std::string bytes = read();
          check_size(bytes, bytes.size() / sizeof(T) * sizeof(T));
          values.resize(bytes.size() / sizeof(T));
          bytes.copy(reinterpret_cast<char *>(values.data()), bytes.size());
        }
      else
        sequence(values);
    }

    template <typename T>
    void
    transfer(std::deque<T> &values)
    {
      sequence(values);
    }

    template <typename T>
    void
    transfer(std::optional<T> &value)
    {
      std::vector<T> content;
      if (value)
        content.push_back(*value);
      sequence(content);
      if (is_reading)
        value = content.empty() ? std::optional<T>() : std::optional<T>(content[0]);
    }

    template <typename T>
    void
    transfer(std::map<std::string, T> &values)
    {
      std::vector<std::string> keys;
      for (const auto &[key, value] : values)
        keys.push_back(key);
      (*this)("keys", keys);
      if (is_reading)
        {
          values.clear();
          for (const std::string &key : keys)
            values[key];
        }
      for (auto &[key, value] : values)
        (*this)(key, value);
    }

    template <typename T>
    void
    transfer(std::shared_ptr<const T> &value)
    {
      T content = value ? *value : T();
      visit(content);
      if (is_reading)
        value = std::make_shared<const T>(std::move(content));
    }

    template <typename Sequence>
    void
    sequence(Sequence &values)
    {
      std::uint64_t size = values.size();
      (*this)("size", size);
      if (is_reading)
        values.resize(size);
      for (std::uint64_t i = 0; i < size; ++i)
        (*this)(std::to_string(i), values[i]);
    }

    /// Whether the bytes of an object are its value.
    template <typename T>
    struct Plain : std::bool_constant<std::is_arithmetic_v<T> || std::is_enum_v<T>>
    {};
    template <int rank, int dim>
    struct Plain<dealii::Tensor<rank, dim>> : std::true_type
    {};
    template <int dim>
    struct Plain<dealii::Point<dim>> : std::true_type
    {};
    template <typename T>
    static constexpr bool is_plain = Plain<T>::value;

    void check_size(const std::string &bytes, std::size_t size) const;
  };


  /// An archive in memory: written once or again, then read as often as wanted.
  class MemoryArchive : public Archive
  {
  public:
    MemoryArchive();

    /// What follows is written, or read.
    void start_writing();
    void start_reading();

    bool
    persistent() const override
    {
      return false;
    }

  protected:
    std::any *slot() override;
    bool contains(const std::string &path) const override;
    void write(const std::string &) override;
    std::string read() override;
    void field(Vector &) override;

  private:
    std::map<std::string, std::any> values;
  };
} // namespace feib

#endif
