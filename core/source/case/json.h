// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_json_h
#define feib_json_h

#include <feib/parameters.h>

#include <nlohmann/json.hpp>

#include <optional>

namespace feib
{
  /// The order of keys is the user's order.
  using Json = nlohmann::ordered_json;

  /// A key as a part of a JSON pointer: "/" + key, with ~ and / escaped.
  std::string pointer_part(const std::string &key);

  /// The keys (and indices) a JSON pointer is made of.
  std::vector<std::string> pointer_parts(const std::string &pointer);

  /// A name from outside in quotes, for a message: readable, not longer than a line.
  std::string quoted(const std::string &name);

  /// "a", "b", "c"
  std::string quoted_list(const std::vector<std::string> &names);

  /// The entry of @p names that @p name was probably meant to be, or "".
  std::string nearest(const std::string &name, const std::vector<std::string> &names);

  /// What views of a case share.
  struct Document
  {
    Json root;
    const Registry *registry;
    std::map<std::string, double> constants;
    std::map<std::string, std::shared_ptr<const TimeSeries>> series;
    std::string directory;
    MPI_Comm communicator;
  };

  /// Where a text nests objects and arrays deeper than any case does (the limit is 100), or
  /// nothing. What walks through documents does so by recursion.
  std::optional<std::size_t> too_deep(const std::string &text);

  /// pi and e, which every expression knows.
  std::map<std::string, double> mathematical_constants();

  struct Parameters::Node
  {
    std::shared_ptr<const Document> document;
    const Json *value;
    std::string pointer;
    double cell_edge = 0;
  };
} // namespace feib

#endif
