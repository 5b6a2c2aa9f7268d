// SPDX-License-Identifier: LGPL-2.1-or-later
#include "multigrid/key_table.h"

#include <utility>

namespace feib
{
  KeyTable::KeyTable(const std::size_t n_expected)
  {
    std::size_t capacity = 16;
    while (capacity < 2 * n_expected)
      capacity *= 2;
    keys.assign(capacity, 0);
    numbers.assign(capacity, none);
    mask = capacity - 1;
  }


  unsigned int
  KeyTable::insert(const std::uint64_t key, const unsigned int number)
  {
    if (4 * (size + 1) > 3 * keys.size())
      {
        KeyTable larger(2 * keys.size());
        for (std::size_t i = 0; i < keys.size(); ++i)
          if (numbers[i] != none)
            larger.insert(keys[i], numbers[i]);
        *this = std::move(larger);
      }
    std::size_t i = hash(key) & mask;
    for (; numbers[i] != none; i = (i + 1) & mask)
      if (keys[i] == key)
        return numbers[i];
    keys[i]    = key;
    numbers[i] = number;
    ++size;
    return number;
  }
} // namespace feib
