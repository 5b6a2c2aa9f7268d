// SPDX-License-Identifier: LGPL-2.1-or-later
#include "schema_walk.h"

#include <feib/message.h>

#include <algorithm>
#include <functional>
#include <limits>

namespace feib
{
  namespace
  {
    std::string
    shown(const Json &value)
    {
      if (value.is_object() && !value.empty())
        return "an object";
      if (value.is_array() && !value.empty())
        return "an array";
      const std::string text = readable(value.dump());
      return text.size() > 60 ? readable(value.dump(), 57) : text;
    }


    std::string
    shown_with_type(const Json &value)
    {
      return (value.is_string()   ? "the string "
              : value.is_number() ? "the number "
                                  : "") +
             shown(value);
    }


    std::vector<std::string>
    keys(const Json &object)
    {
      std::vector<std::string> names;
      for (const auto &[name, value] : object.items())
        names.push_back(name);
      return names;
    }


    /// Equality whatever the order of keys.
    bool
    same(const Json &a, const Json &b)
    {
      return nlohmann::json(a) == nlohmann::json(b);
    }


    bool
    is_type(const Json &value, const std::string &type)
    {
      return type == "object"    ? value.is_object()
             : type == "array"   ? value.is_array()
             : type == "string"  ? value.is_string()
             : type == "number"  ? value.is_number()
             : type == "integer" ? is_integer(value)
                                 : value.is_boolean();
    }


    const Json &
    member(const Json &object, const char *const key)
    {
      static const Json nothing = Json::object();
      return object.contains(key) ? object[key] : nothing;
    }


    std::string
    slot(const Json &schema)
    {
      return schema["slot"].get<std::string>();
    }


    /// What a slot may hold.
    std::string
    available(const Json &schema)
    {
      const auto names = keys(member(schema, "properties"));
      return names.empty() ? "no plugin provides any " + slot(schema)
                           : "available are " + quoted_list(names);
    }


    std::string
    with_article(const std::string &type)
    {
      return type == "boolean"                                          ? "true or false"
             : type == "object" || type == "array" || type == "integer" ? "an " + type
                                                                        : "a " + type;
    }


    std::string
    unknown(const std::string &what,
            const std::string &name,
            const std::vector<std::string> &known,
            const std::string &otherwise)
    {
      const std::string guess = nearest(name, known);
      return what + " " + quoted(name) + "; " +
             (guess.empty() ? otherwise : "did you mean \"" + guess + "\"?");
    }


    /// The number of things a value must have, when it has another.
    std::string
    count(const std::size_t n,
          const Json &schema,
          const char *const minimum,
          const char *const maximum,
          const std::string &thing,
          const std::string &things)
    {
      const std::size_t least = schema.value(minimum, std::size_t(0));
      const std::size_t most  = schema.value(maximum, static_cast<std::size_t>(-1));
      if (n >= least && n <= most)
        return "";
      const std::size_t bound = n < least ? least : most;
      return "must have " +
             std::string(least == most ? "exactly "
                         : n < least   ? "at least "
                                       : "at most ") +
             std::to_string(bound) + " " + (bound == 1 ? thing : things) + ", found " +
             std::to_string(n);
    }


    void
    explain_number(const Json &value,
                   const Json &schema,
                   const std::string &pointer,
                   Issues &issues)
    {
      const double x = value.get<double>();
      // The largest that components can hold; validators stop at other bounds.
      using Limits = std::numeric_limits<int>;
      if (is_integer(value) && member(schema, "type") == "integer" &&
          (x < Limits::min() || x > Limits::max()))
        {
          issues.push_back({pointer,
                            "must be an integer from " + std::to_string(Limits::min()) + " to " +
                              std::to_string(Limits::max()) + ", found " + value.dump()});
          return;
        }
      const auto check =
        [&](const char *const keyword, const char *const words, const auto &holds) {
          if (schema.contains(keyword) && !holds(x, schema[keyword].template get<double>()))
            issues.push_back({pointer,
                              std::string("must be ") + words + " " + schema[keyword].dump() +
                                ", found " + value.dump()});
        };
      check("minimum", "at least", std::greater_equal<double>());
      check("maximum", "at most", std::less_equal<double>());
      check("exclusiveMinimum", "greater than", std::greater<double>());
      check("exclusiveMaximum", "less than", std::less<double>());
    }
  } // namespace


  SchemaWalk::SchemaWalk(const Json &root)
    : root(root)
  {}


  std::vector<std::string>
  SchemaWalk::types(const Json &schema)
  {
    const auto type = schema.find("type");
    if (type == schema.end())
      return {};
    if (type->is_string())
      return {type->get<std::string>()};
    return type->get<std::vector<std::string>>();
  }


  std::string
  SchemaWalk::list(const Json &values)
  {
    std::string text;
    for (const Json &value : values)
      text += (text.empty() ? "" : ", ") + value.dump();
    return text;
  }


  void
  SchemaWalk::explain(const Json &value,
                      const Json &reference,
                      const std::string &pointer,
                      Issues &issues) const
  {
    const Json &schema = resolve(reference);
    const auto wrong   = [&](const std::string &message) { issues.push_back({pointer, message}); };

    if (const auto allowed = types(schema);
        !allowed.empty() && std::none_of(allowed.begin(), allowed.end(), [&](const auto &type) {
          return is_type(value, type);
        }))
      {
        if (schema.contains("slot"))
          wrong("must name a " + slot(schema) + " as its key, {\"name\": {...}}, found " +
                shown_with_type(value) + "; " + available(schema));
        else
          {
            std::string text;
            for (const std::string &type : allowed)
              text += (text.empty() ? "" : " or ") + with_article(type);
            wrong("must be " + text + ", found " + shown_with_type(value));
          }
        return;
      }
    if (schema.contains("enum") &&
        std::none_of(schema["enum"].begin(), schema["enum"].end(), [&](const Json &entry) {
          return same(entry, value);
        }))
      wrong("must be one of " + list(schema["enum"]) + ", found " + shown(value));
    if (schema.contains("const") && !same(schema["const"], value))
      wrong("must be " + schema["const"].dump() + ", found " + shown(value));

    if (value.is_number())
      explain_number(value, schema, pointer, issues);
    else if (value.is_array())
      explain_array(value, schema, pointer, issues);
    else if (value.is_object())
      explain_object(value, schema, pointer, issues);

    if (schema.contains("allOf"))
      for (const Json &part : schema["allOf"])
        explain(value, part, pointer, issues);
    if (schema.contains("if"))
      {
        Issues refusals;
        explain(value, schema["if"], pointer, refusals);
        const char *const branch = refusals.empty() ? "then" : "else";
        if (schema.contains(branch))
          explain(value, schema[branch], pointer, issues);
      }
  }


  void
  SchemaWalk::explain_array(const Json &value,
                            const Json &schema,
                            const std::string &pointer,
                            Issues &issues) const
  {
    if (const std::string problem =
          count(value.size(), schema, "minItems", "maxItems", "entry", "entries");
        !problem.empty())
      issues.push_back({pointer, problem});
    if (schema.contains("items"))
      for (std::size_t i = 0; i < value.size(); ++i)
        explain(value[i], schema["items"], pointer + "/" + std::to_string(i), issues);
  }


  void
  SchemaWalk::explain_object(const Json &value,
                             const Json &schema,
                             const std::string &pointer,
                             Issues &issues) const
  {
    const Json &properties = member(schema, "properties");
    const auto known       = keys(properties);
    const bool is_slot     = schema.contains("slot");

    if (const std::string problem =
          count(value.size(), schema, "minProperties", "maxProperties", "key", "keys");
        !problem.empty())
      {
        const std::string found = value.empty() ? "" : ": " + quoted_list(keys(value));
        if (is_slot)
          issues.push_back({pointer,
                            "must name exactly one " + slot(schema) + ", found " +
                              std::to_string(value.size()) + found + "; " + available(schema)});
        else
          issues.push_back(
            {pointer,
             problem + found + (known.empty() ? "" : "; allowed are " + quoted_list(known))});
      }
    if (schema.contains("required"))
      for (const Json &name : schema["required"])
        if (!value.contains(name.get<std::string>()))
          issues.push_back({pointer, "the required key " + name.dump() + " is missing"});

    for (const auto &[key, entry] : value.items())
      {
        const std::string place = pointer + pointer_part(key);
        const Json &rest        = member(schema, "additionalProperties");
        if (properties.contains(key))
          explain(entry, properties[key], place, issues);
        else if (rest.is_object())
          explain(entry, rest, place, issues);
        else if (is_slot)
          issues.push_back(
            {place,
             unknown("no plugin provides the " + slot(schema), key, known, available(schema))});
        else if (rest == false)
          issues.push_back({place,
                            unknown("unknown key",
                                    key,
                                    known,
                                    known.empty() ? "nothing is allowed here"
                                                  : "allowed are " + quoted_list(known))});
      }
  }


  void
  SchemaWalk::fill(Json &value, const Json &reference, const unsigned int depth) const
  {
    if (depth > 100)
      throw Error("the defaults of the schema never end");
    const Json &schema = resolve(reference);
    if (value.is_array() && schema.contains("items"))
      for (Json &entry : value)
        fill(entry, schema["items"], depth + 1);
    if (!value.is_object())
      return;
    const Json &properties = member(schema, "properties");
    const Json &rest       = member(schema, "additionalProperties");
    for (const auto &[key, property] : properties.items())
      if (!value.contains(key) && property.contains("default"))
        value[key] = property["default"];
    for (auto &[key, entry] : value.items())
      if (properties.contains(key))
        fill(entry, properties[key], depth + 1);
      else if (rest.is_object())
        fill(entry, rest, depth + 1);
  }


  const Json &
  SchemaWalk::resolve(const Json &schema) const
  {
    return schema.contains("$ref")
             ? resolve(root.at(Json::json_pointer(schema["$ref"].get<std::string>().substr(1))))
             : schema;
  }
} // namespace feib
