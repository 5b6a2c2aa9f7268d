// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_source_schema_walk_h
#define feib_source_schema_walk_h

#include "json.h"

#include <cmath>
#include <string>
#include <vector>

namespace feib
{
  /// Whether a JSON value counts as an integer: 2.0 does in draft 7.
  template <typename Value>
  bool
  is_integer(const Value &value)
  {
    return value.is_number_integer() ||
           (value.is_number_float() &&
            std::trunc(value.template get<double>()) == value.template get<double>());
  }


  /// Walks a document along a schema: what is wrong with it, in sentences, and the defaults that it
  /// lacks.
  class SchemaWalk
  {
  public:
    /// @p root: what references within schemas start from. It must outlive the object.
    explicit SchemaWalk(const Json &root);

    /// Adds what is wrong with a value, which has that place in its document.
    void explain(const Json &value,
                 const Json &schema,
                 const std::string &pointer,
                 Issues &issues) const;

    /// Gives a value the defaults of its schema. Throws Error when they never end.
    void fill(Json &value, const Json &schema, unsigned int depth = 0) const;

    /// The names of the keyword "type", one or several.
    static std::vector<std::string> types(const Json &schema);

    /// JSON values with commas between them.
    static std::string list(const Json &values);

  private:
    const Json &resolve(const Json &schema) const;

    void explain_array(const Json &value,
                       const Json &schema,
                       const std::string &pointer,
                       Issues &issues) const;

    void explain_object(const Json &value,
                        const Json &schema,
                        const std::string &pointer,
                        Issues &issues) const;

    const Json &root;
  };
} // namespace feib

#endif
