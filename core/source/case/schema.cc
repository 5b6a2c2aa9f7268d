// SPDX-License-Identifier: LGPL-2.1-or-later
#include "schema_walk.h"

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


    /// Replaces the slots and fragments of a schema.
    class Expansion
    {
    public:
      Expansion(Json skeleton, const Registry *registry)
        : document(std::move(skeleton))
      {
        take_fragments(document);
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
      unsigned int depth = 0; // of fragments in fragments

      void
      take_fragments(Json &schema)
      {
        fragments = schema.value("fragments", Json::object());
        schema.erase("fragments");
      }

      void
      expand(Json &schema)
      {
        if (schema.contains("fragment"))
          {
            const auto name = schema["fragment"].get<std::string>();
            if (!fragments.contains(name))
              throw Error("names the fragment \"" + name + "\", which is not among its fragments");
            Json filled = fragments[name];
            schema.erase("fragment");
            filled.update(schema); // what stands beside it wins
            schema = std::move(filled);
            if (++depth > 100)
              throw Error("the fragment \"" + name + "\" holds itself");
            expand(schema);
            --depth;
            return;
          }
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
                  const Json outer = fragments;
                  take_fragments(component);
                  expand(component);
                  fragments        = outer;
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
      const SchemaWalk walk(root);
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
        return "one of " + SchemaWalk::list(schema["enum"]);
      if (schema.contains("const"))
        return schema["const"].dump();
      std::string text;
      for (const std::string &type : SchemaWalk::types(schema))
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
      if (schema.contains("items") && !SchemaWalk::types(schema["items"]).empty())
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
    SchemaWalk(schema).explain(parse(document), schema, "", issues);
    return issues;
  }


  std::string
  Schema::with_defaults(const std::string &document) const
  {
    Json json = parse(document);
    SchemaWalk(implementation->document).fill(json, implementation->document);
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
