// SPDX-License-Identifier: LGPL-2.1-or-later
#include "json.h"

#include <feib/message.h>
#include <feib/registry.h>
#include <feib/schema.h>

#define VALIJSON_USE_EXCEPTIONS 1 // instead of abort()
#include <valijson/adapters/nlohmann_json_adapter.hpp>
#include <valijson/schema.hpp>
#include <valijson/schema_parser.hpp>
#include <valijson/validator.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "case_schema.h"
#include "component_schema.h"

namespace feib
{
  namespace
  {
    Json
    parse(const std::string &text)
    {
      if (too_deep(text))
        throw Error("not JSON for Feib: objects and arrays are nested deeper than 100 levels");
      try
        {
          return Json::parse(text);
        }
      catch (const Json::exception &failure)
        {
          const std::string what = failure.what();
          throw Error((what.find("UTF-8") != std::string::npos ? "is not UTF-8: " : "not JSON: ") +
                      what);
        }
    }


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


    std::string
    list(const Json &values)
    {
      std::string text;
      for (const Json &value : values)
        text += (text.empty() ? "" : ", ") + value.dump();
      return text;
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


    /// 2.0 is one in draft 7.
    template <typename Value>
    bool
    is_integer(const Value &value)
    {
      return value.is_number_integer() ||
             (value.is_number_float() &&
              std::trunc(value.template get<double>()) == value.template get<double>());
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


    /// The names of the keyword "type", one or several.
    std::vector<std::string>
    types(const Json &schema)
    {
      const auto type = schema.find("type");
      if (type == schema.end())
        return {};
      if (type->is_string())
        return {type->get<std::string>()};
      return type->get<std::vector<std::string>>();
    }


    /// Walks a document along a schema.
    class Walk
    {
    public:
      explicit Walk(const Json &root)
        : root(root)
      {}

      void
      explain(const Json &value,
              const Json &reference,
              const std::string &pointer,
              Issues &issues) const
      {
        const Json &schema = resolve(reference);
        const auto wrong   = [&](const std::string &message) {
          issues.push_back({pointer, message});
        };

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
      fill(Json &value, const Json &reference, const unsigned int depth = 0) const
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
      resolve(const Json &schema) const
      {
        return schema.contains("$ref")
                 ? resolve(root.at(Json::json_pointer(schema["$ref"].get<std::string>().substr(1))))
                 : schema;
      }

    private:
      const Json &root;

      static const Json &
      member(const Json &object, const char *const key)
      {
        static const Json nothing = Json::object();
        return object.contains(key) ? object[key] : nothing;
      }

      static std::string
      slot(const Json &schema)
      {
        return schema["slot"].get<std::string>();
      }

      /// What a slot may hold.
      static std::string
      available(const Json &schema)
      {
        const auto names = keys(member(schema, "properties"));
        return names.empty() ? "no plugin provides any " + slot(schema)
                             : "available are " + quoted_list(names);
      }

      static std::string
      with_article(const std::string &type)
      {
        return type == "boolean"                                          ? "true or false"
               : type == "object" || type == "array" || type == "integer" ? "an " + type
                                                                          : "a " + type;
      }

      static std::string
      unknown(const std::string &what,
              const std::string &name,
              const std::vector<std::string> &known,
              const std::string &otherwise)
      {
        const std::string guess = nearest(name, known);
        return what + " " + quoted(name) + "; " +
               (guess.empty() ? otherwise : "did you mean \"" + guess + "\"?");
      }

      static void
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

      /// The number of things a value must have, when it has another.
      static std::string
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
      explain_array(const Json &value,
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
      explain_object(const Json &value,
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
    };


    /// Replaces the slots and fragments of a schema.
    class Expansion
    {
    public:
      Expansion(Json skeleton, const Registry *registry)
        : document(std::move(skeleton))
      {
        if (document.contains("fragments"))
          {
            fragments = document["fragments"];
            document.erase("fragments");
          }
        if (registry != nullptr)
          entries = registry->entries();
        any_name = registry == nullptr;
        expand(document);
        if (!definitions.empty())
          document["definitions"] = definitions;
      }

      Json document;

    private:
      Json fragments, definitions;
      std::vector<Registry::Entry> entries;
      bool any_name;

      void
      expand(Json &schema)
      {
        if (schema.contains("fragment"))
          schema = Json(fragments.at(schema["fragment"].get<std::string>()));
        if (schema.contains("slot"))
          fill_slot(schema);
        else
          {
            if (schema.contains("properties"))
              for (auto &[key, property] : schema["properties"].items())
                expand(property);
            if (schema.contains("items"))
              expand(schema["items"]);
            if (schema.contains("additionalProperties") &&
                schema["additionalProperties"].is_object())
              expand(schema["additionalProperties"]);
          }
      }

      /// The keyword slot stays, as a note of the kind.
      void
      fill_slot(Json &schema)
      {
        const auto kind         = schema["slot"].get<std::string>();
        schema["type"]          = "object";
        schema["minProperties"] = 1;
        schema["maxProperties"] = 1;
        if (any_name)
          {
            schema["additionalProperties"] = {{"type", "object"}};
            return;
          }
        schema["additionalProperties"] = false;
        schema["properties"]           = Json::object();
        for (const Registry::Entry &entry : entries)
          if (entry.kind == kind)
            {
              const std::string key            = kind + "." + entry.name;
              schema["properties"][entry.name] = {{"$ref", "#/definitions/" + key}};
              if (!definitions.contains(key))
                {
                  definitions[key] = nullptr; // ends the recursion of a kind that holds itself
                  Json component   = parse(entry.schema);
                  expand(component);
                  definitions[key] = std::move(component);
                }
            }
      }
    };


    /// What component.schema.json cannot say, for a schema without slots.
    void
    check_component(const Json &root,
                    const Json &schema,
                    const std::string &pointer,
                    Issues &issues)
    {
      const Walk walk(root);
      const auto check = [&](const Json &value, const std::string &place) {
        walk.explain(value, schema, pointer + place, issues);
      };
      if (schema.contains("default"))
        check(schema["default"], "/default");
      if (schema.contains("examples"))
        for (std::size_t i = 0; i < schema["examples"].size(); ++i)
          check(schema["examples"][i], "/examples/" + std::to_string(i));

      const auto required = schema.value("required", std::vector<std::string>());
      for (const std::string &name : required)
        if (!schema.contains("properties") || !schema["properties"].contains(name))
          issues.push_back(
            {pointer + "/required", "names \"" + name + "\", which is not a property"});
      const bool choice = schema.value("maxProperties", 0) == 1;
      if (schema.contains("properties"))
        for (const auto &[name, property] : schema["properties"].items())
          {
            const std::string place = pointer + "/properties" + pointer_part(name);
            if (!choice && std::find(required.begin(), required.end(), name) == required.end() &&
                !property.contains("default") &&
                property["description"].get<std::string>().find("when not given") ==
                  std::string::npos)
              issues.push_back({place,
                                "must be required, have a default, or say in its description what "
                                "holds \"when not given\""});
            check_component(root, property, place, issues);
          }
      if (schema.contains("items"))
        check_component(root, schema["items"], pointer + "/items", issues);
      if (schema.contains("additionalProperties") && schema["additionalProperties"].is_object() &&
          !schema.contains("slot"))
        check_component(root,
                        schema["additionalProperties"],
                        pointer + "/additionalProperties",
                        issues);
    }


    /// Type and range of a value in a few words.
    std::string
    summary(const Json &schema)
    {
      if (schema.contains("slot"))
        return "a " + schema["slot"].get<std::string>();
      if (schema.contains("enum"))
        return "one of " + list(schema["enum"]);
      if (schema.contains("const"))
        return schema["const"].dump();
      std::string text;
      for (const std::string &type : types(schema))
        text += (text.empty() ? "" : " or ") + type;
      std::string bounds;
      for (const auto &[keyword, words] : {std::pair<const char *, const char *>{"minimum", ">= "},
                                           {"exclusiveMinimum", "> "},
                                           {"maximum", "<= "},
                                           {"exclusiveMaximum", "< "},
                                           {"minItems", "at least "},
                                           {"maxItems", "at most "}})
        if (schema.contains(keyword))
          bounds += (bounds.empty() ? " " : " and ") + (words + schema[keyword].dump());
      if (schema.contains("items") && !types(schema["items"]).empty())
        return text + " of" + bounds + " " + summary(schema["items"]);
      return text + bounds;
    }


    void
    describe_properties(const Json &schema, const std::string &indent, std::string &text)
    {
      const auto required = schema.value("required", std::vector<std::string>());
      if (schema.contains("properties"))
        for (const auto &[name, property] : schema["properties"].items())
          {
            text += indent + name + " (" + summary(property) +
                    (property.contains("default") ? ", default " + property["default"].dump()
                     : std::find(required.begin(), required.end(), name) != required.end()
                       ? ", required"
                       : ", optional") +
                    ")\n" + indent + "    " + property.value("description", "") + "\n";
            describe_properties(property, indent + "    ", text);
          }
      if (schema.contains("items"))
        describe_properties(schema["items"], indent, text);
      if (schema.contains("additionalProperties") && schema["additionalProperties"].is_object())
        {
          const Json &rest = schema["additionalProperties"];
          text += indent + "any name (" + summary(rest) + ")\n" + indent + "    " +
                  rest.value("description", "") + "\n";
          describe_properties(rest, indent + "    ", text);
        }
    }


    /// valijson holds integers of 63 bits, and takes no 2.0 for one: what is whole becomes an
    /// integer where it fits, and a number else.
    void
    convert_integers(nlohmann::json &value)
    {
      constexpr double limit = 9223372036854775808.;
      if (value.is_structured())
        for (nlohmann::json &part : value)
          convert_integers(part);
      else if (value.is_number() && std::abs(value.get<double>()) >= limit)
        value = value.get<double>();
      else if (is_integer(value))
        value = value.get<std::int64_t>();
    }
  } // namespace


  struct Schema::Implementation
  {
    explicit Implementation(Json json)
      : document(std::move(json))
    {}

    Json document;

    /// The judge's form of the schema, made when it is first asked for.
    const valijson::Schema &
    judge() const
    {
      if (!compiled)
        {
          compiled = std::make_unique<valijson::Schema>();
          nlohmann::json plain(document);
          convert_integers(plain);
          valijson::SchemaParser().populateSchema(valijson::adapters::NlohmannJsonAdapter(plain),
                                                  *compiled);
        }
      return *compiled;
    }

  private:
    mutable std::unique_ptr<valijson::Schema> compiled;
  };


  Schema::Schema(const std::string &text)
    : implementation(std::make_unique<Implementation>(parse(text)))
  {}


  Schema::Schema(std::unique_ptr<Implementation> implementation)
    : implementation(std::move(implementation))
  {}


  Schema::Schema(Schema &&) = default;


  Schema::~Schema() = default;


  Schema
  Schema::expand(const std::string &skeleton, const Registry *registry)
  {
    return Schema(std::make_unique<Implementation>(Expansion(parse(skeleton), registry).document));
  }


  Schema
  Schema::compose(const Registry &registry)
  {
    Schema schema = expand(case_schema, &registry);
    Json document = {{"$schema", "http://json-schema.org/draft-07/schema#"}};
    document.update(schema.implementation->document);
    schema.implementation->document = std::move(document);
    return schema;
  }


  const Schema &
  Schema::component_rules()
  {
    static const Schema rules(component_schema);
    return rules;
  }


  Issues
  Schema::component_issues(const std::string &schema)
  {
    try
      {
        Issues issues = component_rules().explain(schema);
        if (issues.empty())
          {
            const Schema expanded = expand(schema, nullptr);
            const Json &document  = expanded.implementation->document;
            check_component(document, document, "", issues);
          }
        return issues;
      }
    catch (const Error &error)
      {
        return error.issues();
      }
  }


  bool
  Schema::accepts(const std::string &document) const
  {
    nlohmann::json json(parse(document));
    convert_integers(json);
    const valijson::adapters::NlohmannJsonAdapter target(json);
    valijson::Validator validator;
    return validator.validate(implementation->judge(), target, nullptr);
  }


  Issues
  Schema::explain(const std::string &document) const
  {
    Issues issues;
    const Json &schema = implementation->document;
    Walk(schema).explain(parse(document), schema, "", issues);
    return issues;
  }


  std::string
  Schema::with_defaults(const std::string &document) const
  {
    Json json = parse(document);
    Walk(implementation->document).fill(json, implementation->document);
    return json.dump(2);
  }


  std::string
  Schema::text() const
  {
    return implementation->document.dump(2);
  }


  std::string
  Schema::describe() const
  {
    const Json &schema = implementation->document;
    std::string text   = schema.value("description", "") + "\n";
    describe_properties(schema, "    ", text);
    if (schema.contains("examples"))
      for (const Json &example : schema["examples"])
        text += "Example: " + example.dump() + "\n";
    return text;
  }


  std::vector<std::string>
  Schema::examples() const
  {
    std::vector<std::string> result;
    for (const Json &example : implementation->document.value("examples", Json::array()))
      result.push_back(example.dump());
    return result;
  }
} // namespace feib
