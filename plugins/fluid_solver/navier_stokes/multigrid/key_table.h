// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_plugins_navier_stokes_key_table_h
#define feib_plugins_navier_stokes_key_table_h

#include <cstddef>
#include <cstdint>
#include <vector>

namespace feib
{
  /// An index from 64 bit keys to numbers.
  class KeyTable
  {
  public:
    static constexpr unsigned int none = static_cast<unsigned int>(-1);

    explicit KeyTable(std::size_t n_expected = 0);

    /// The number of the key, or none.
    unsigned int
    find(const std::uint64_t key) const
    {
      for (std::size_t i = hash(key) & mask;; i = (i + 1) & mask)
        if (numbers[i] == none || keys[i] == key)
          return numbers[i];
    }

    /// The number of the key, which becomes @p number when the key is new.
    unsigned int insert(std::uint64_t key, unsigned int number);

  private:
    static std::size_t
    hash(std::uint64_t key)
    {
      key = (key ^ (key >> 30)) * 0xbf58476d1ce4e5b9;
      return key ^ (key >> 27);
    }

    std::vector<std::uint64_t> keys;
    std::vector<unsigned int> numbers;
    std::size_t mask, size = 0;
  };
} // namespace feib

#endif
