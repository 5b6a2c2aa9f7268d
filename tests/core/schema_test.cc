// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components.h"

#include <feib/schema.h>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <random>

using namespace feib;
using namespace feib::testing;
using Json = nlohmann::json;

namespace
{
  const Schema &
  cases()
  {
    static const Registry registry = small_registry();
    static const Schema schema     = Schema::compose(registry);
    return schema;
  }

  /// The issues of the small case after a change, as "pointer: message" lines.
  std::string
  explained(const std::string &pointer, const Json &value)
  {
    Json document                         = Json::parse(small_case);
    document[Json::json_pointer(pointer)] = value;
    std::string lines;
    for (const Issue &issue : cases().explain(document.dump()))
      lines += issue.pointer + ": " + issue.message + "\n";
    return lines;
  }

  /// Documents that follow a schema, with something odd now and then.
  class Generator
  {
  public:
    Generator(const Json &root, const unsigned int seed)
      : root(root)
      , engine(seed)
    {}

    Json
    value(const Json &reference, const unsigned int depth = 0)
    {
      const Json &schema =
        reference.contains("$ref")
          ? root.at(Json::json_pointer(reference["$ref"].get<std::string>().substr(1)))
          : reference;
      if (one_in(100))
        return junk();
      if (schema.contains("enum"))
        return schema["enum"][below(schema["enum"].size())];
      if (!schema.contains("type"))
        return junk();
      Json type = schema["type"];
      if (type.is_array())
        type = Json(type[below(type.size())]);
      if (type == "object")
        return object(schema, depth);
      if (type == "array")
        {
          Json result             = Json::array();
          const unsigned int size = one_in(20) ? below(5) : schema.value("minItems", 0u) + below(2);
          for (unsigned int i = 0; i < size; ++i)
            result.push_back(value(schema["items"], depth + 1));
          return result;
        }
      if (type == "number")
        return one_in(20)   ? Json(0.5 * below(300) - 2)
               : one_in(50) ? Json(std::uint64_t(1) << 63) // beyond integers with a sign
                            : Json(schema.value("minimum", 0.) + 1 + below(3));
      if (type == "integer")
        return one_in(20) ? Json(2.0) : one_in(20) ? Json(-1) : Json(1 + below(4));
      if (type == "string")
        return one_in(2) ? "sin(x)" : "";
      return one_in(2);
    }

  private:
    const Json &root;
    std::mt19937 engine;

    unsigned int
    below(const std::size_t n)
    {
      return std::uniform_int_distribution<unsigned int>(0, n - 1)(engine);
    }

    bool
    one_in(const unsigned int n)
    {
      return below(n) == 0;
    }

    Json
    junk()
    {
      static const std::vector<Json> things = {nullptr,
                                               true,
                                               -1,
                                               0.0,
                                               1e300,
                                               "text",
                                               Json::array(),
                                               Json::array({1}),
                                               Json::object(),
                                               {{"key", 1}}};
      return things[below(things.size())];
    }

    Json
    object(const Json &schema, const unsigned int depth)
    {
      Json result           = Json::object();
      const Json properties = schema.value("properties", Json::object());
      if (schema.contains("maxProperties") && !properties.empty())
        {
          auto chosen = properties.begin();
          std::advance(chosen, below(properties.size()));
          result[chosen.key()] = value(chosen.value(), depth + 1);
        }
      else
        for (const auto &[key, property] : properties.items())
          if (schema.value("required", Json::array()).dump().find("\"" + key + "\"") !=
                  std::string::npos
                ? !one_in(50)
                : depth < 8 && one_in(2))
            result[key] = value(property, depth + 1);
      if (schema.contains("additionalProperties") && schema["additionalProperties"].is_object())
        result["name"] = value(schema["additionalProperties"], depth + 1);
      if (one_in(50))
        result["odd"] = junk();
      return result;
    }
  };
} // namespace

TEST(Schema, ExplainAgreesWithTheJudge)
{
  const Json root      = Json::parse(cases().text());
  unsigned int valid   = 0;
  const unsigned int n = 3000;
  Generator generator(root, 1);
  for (unsigned int i = 0; i < n; ++i)
    {
      const std::string document = generator.value(root).dump();
      const Issues issues        = cases().explain(document);
      const bool explained       = issues.empty();
      ASSERT_EQ(explained, cases().accepts(document))
        << document << '\n'
        << (explained ? "" : issues[0].pointer + ": " + issues[0].message);
      valid += explained;
    }
  // Both answers must have been tried.
  EXPECT_GT(valid, n / 50);
  EXPECT_LT(valid, n - n / 10);
}

TEST(Schema, ExplainAgreesWithTheJudgeOnTheRules)
{
  const Json root  = Json::parse(Schema::component_rules().text());
  const Json model = Json::parse(stokes_schema);
  std::mt19937 engine(2);
  unsigned int valid   = 0;
  const unsigned int n = 500;
  for (unsigned int i = 0; i < n; ++i)
    {
      // Change one place of a good schema.
      Json changed    = model;
      const Json flat = model.flatten();
      auto place      = flat.begin();
      std::advance(place, engine() % flat.size());
      const Json::json_pointer pointer(place.key());
      const Json things[] = {
        "text", 1, true, false, Json::array({"a"}), Json::object(), "object", 2.5};
      Json &parent = changed[pointer.parent_pointer()];
      if (parent.is_object() && engine() % 3 == 0)
        parent[engine() % 2 ? "additionalProperties" : "pattern"] = false;
      else if (parent.is_object() && engine() % 3 == 0)
        parent.erase(pointer.back());
      else
        changed[pointer] = things[engine() % 8];
      const std::string document = changed.dump();
      const Issues issues        = Schema::component_rules().explain(document);
      const bool explained       = issues.empty();
      ASSERT_EQ(explained, Schema::component_rules().accepts(document))
        << document << '\n'
        << (explained ? "" : issues[0].pointer + ": " + issues[0].message);
      valid += explained;
    }
  EXPECT_GT(valid, n / 20);
  EXPECT_LT(valid, n - n / 20);
}

TEST(Schema, SpeaksPlainly)
{
  EXPECT_EQ(explained("/fluid/stokes/viscosty", 1),
            "/fluid/stokes/viscosty: unknown key \"viscosty\"; did you mean \"viscosity\"?\n");
  EXPECT_EQ(explained("/time/qqq", 1),
            "/time/qqq: unknown key \"qqq\"; allowed are \"step\", \"end\", \"control\", "
            "\"energy_growth\", \"measure_tolerance\", \"integrator\"\n");
  EXPECT_EQ(
    explained("/domain/boundary", {{"x_min", {{"no_slip", {{"speed", 1}}}}}}),
    "/domain/boundary/x_min/no_slip/speed: unknown key \"speed\"; nothing is allowed here\n");
}

TEST(Schema, NamesTypesAndRanges)
{
  EXPECT_EQ(explained("/fluid/stokes/viscosity", "abc"),
            "/fluid/stokes/viscosity: must be a number, found the string \"abc\"\n");
  EXPECT_EQ(explained("/fluid/stokes/viscosity", 0),
            "/fluid/stokes/viscosity: must be greater than 0, found 0\n");
  EXPECT_EQ(explained("/fluid/stokes/density", -1),
            "/fluid/stokes/density: must be at least 0, found -1\n");
  EXPECT_EQ(explained("/fluid/stokes/density", 101),
            "/fluid/stokes/density: must be at most 100, found 101\n");
  EXPECT_EQ(explained("/fluid/stokes/sweeps", 1.5),
            "/fluid/stokes/sweeps: must be an integer, found the number 1.5\n");
  EXPECT_EQ(explained("/fluid/stokes/steady", nullptr),
            "/fluid/stokes/steady: must be true or false, found null\n");
  EXPECT_EQ(explained("/fluid/stokes/force", {true, 1}),
            "/fluid/stokes/force/0: must be a string or a number, found true\n");
  EXPECT_EQ(explained("/fluid/stokes/convection", "upwind"),
            "/fluid/stokes/convection: must be one of \"none\", \"explicit\", found \"upwind\"\n");
  EXPECT_EQ(explained("/domain/cells", {4}),
            "/domain/cells: must have at least 2 entries, found 1\n");
  EXPECT_EQ(explained("/time", {{"step", 1}}), "/time: the required key \"end\" is missing\n");
}

TEST(Schema, NamesComponentsOfASlot)
{
  EXPECT_EQ(explained("/coupling", {{"divergence_fre", Json::object()}}),
            "/coupling/divergence_fre: no plugin provides the coupling_operator "
            "\"divergence_fre\"; did you mean "
            "\"divergence_free\"?\n");
  EXPECT_EQ(explained("/coupling", {{"magic", Json::object()}}),
            "/coupling/magic: no plugin provides the coupling_operator \"magic\"; available are "
            "\"divergence_free\"\n");
  EXPECT_EQ(
    explained("/coupling", "divergence_free"),
    "/coupling: must name a coupling_operator as its key, {\"name\": {...}}, found the string "
    "\"divergence_free\"; available are \"divergence_free\"\n");
  EXPECT_EQ(explained("/output",
                      Json::array({{{"vtu", Json::object()}, {"ledger_csv", Json::object()}}})),
            "/output/0: must name exactly one output_writer, found 2: \"ledger_csv\", \"vtu\"; "
            "available are "
            "\"ledger_csv\", \"vtu\"\n");
  EXPECT_EQ(explained("/domain/boundary", {{"x_min", Json::object()}}),
            "/domain/boundary/x_min: must have exactly 1 key, found 0; allowed are \"no_slip\", "
            "\"velocity\", \"free_slip\", \"outflow\", \"pressure\", \"traction\", \"flux\", "
            "\"windkessel\", \"parts\"\n");

  const Registry nothing;
  const Issues issues = Schema::compose(nothing).explain(small_case);
  ASSERT_EQ(issues.size(), 1u);
  EXPECT_EQ(issues[0].pointer, "/fluid/stokes");
  EXPECT_EQ(issues[0].message,
            "no plugin provides the fluid_solver \"stokes\"; no plugin provides any fluid_solver");
}

TEST(Schema, ReportsEverythingAtOnce)
{
  Json document               = Json::parse(small_case);
  document["dimension"]       = 4;
  document["time"]["step"]    = -1;
  document["tme"]             = 1;
  document["fluid"]["stokes"] = {{"viscosity", "x"}, {"density", -1}};
  EXPECT_EQ(cases().explain(document.dump()).size(), 5u);
}

TEST(Schema, FillsDefaultsEverywhere)
{
  Json document                             = Json::parse(small_case);
  document["fluid"]["stokes"]["probes"]     = {{{"at", 1}}, {{"at", 2}, {"weight", 9}}};
  document["fluid"]["stokes"]["marks"]["a"] = Json::object();
  document["structures"]                    = {{{"body", {{"law", {{"scaled", Json::object()}}}}}}};
  const Json filled                         = Json::parse(cases().with_defaults(document.dump()));

  EXPECT_EQ(filled["title"], "");
  EXPECT_EQ(filled["coupling"], Json::parse(R"({"divergence_free": {}})"));
  EXPECT_EQ(filled["time"]["integrator"], Json::parse(R"({"midpoint": {}})"));
  EXPECT_EQ(filled["domain"]["boundary"], Json::object());
  EXPECT_FALSE(filled["domain"].contains("lower"));
  EXPECT_EQ(filled["fluid"]["stokes"]["density"], 1);
  EXPECT_EQ(filled["fluid"]["stokes"]["solver"], Json::parse(R"({"tolerance": 1e-10})"));
  EXPECT_EQ(filled["fluid"]["stokes"]["probes"],
            Json::parse(R"([{"at": 1, "weight": 0.5}, {"at": 2, "weight": 9}])"));
  EXPECT_EQ(filled["fluid"]["stokes"]["marks"], Json::parse(R"({"a": {"size": 7}})"));
  EXPECT_EQ(filled["structures"][0]["body"]["law"]["scaled"],
            Json::parse(R"({"factor": 1, "law": {"spring": {"c": 3}}})"));
  EXPECT_TRUE(cases().explain(filled.dump()).empty());

  const Schema open(R"({"properties": {"known": {"default": 1}}})");
  EXPECT_EQ(Json::parse(open.with_defaults(R"({"other": {"deep": 2}})")),
            Json::parse(R"({"other": {"deep": 2}, "known": 1})"));
}

namespace
{
  /// The spring's schema after a change.
  Issues
  rule_issues(const std::string &pointer, const Json &value)
  {
    Json schema                         = Json::parse(spring_schema);
    schema[Json::json_pointer(pointer)] = value;
    return Schema::component_issues(schema.dump());
  }
} // namespace

TEST(Schema, RulesForComponents)
{
  EXPECT_TRUE(Schema::component_issues(spring_schema).empty());
  EXPECT_TRUE(Schema::component_issues(scaled_schema).empty());
  EXPECT_TRUE(Schema::component_issues(stokes_schema).empty());

  EXPECT_FALSE(Schema::component_issues("{").empty());
  EXPECT_FALSE(Schema::component_issues("{}").empty());
  EXPECT_FALSE(rule_issues("/type", "array").empty());
  EXPECT_FALSE(rule_issues("/additionalProperties", true).empty());
  EXPECT_FALSE(rule_issues("/oneOf", Json::array()).empty());
  EXPECT_FALSE(rule_issues("/examples", Json::array()).empty());
  EXPECT_FALSE(rule_issues("/examples/0/c", -2).empty()) << "an example must be valid";
  EXPECT_FALSE(rule_issues("/required/0", "d").empty()) << "required names no property";
  EXPECT_FALSE(rule_issues("/required", Json::array()).empty()) << "c has no default";
  EXPECT_FALSE(rule_issues("/properties/c/default", -1).empty()) << "a default must be valid";
  EXPECT_FALSE(rule_issues("/properties/c/pattern", "a").empty());
  EXPECT_FALSE(rule_issues("/properties/c/type", "float").empty());
  EXPECT_FALSE(rule_issues("/properties/d", {{"type", "number"}, {"default", 1}}).empty())
    << "a property needs a description";
  EXPECT_FALSE(
    rule_issues("/properties/d", {{"type", "object"}, {"description", "D; none when not given."}})
      .empty())
    << "objects must say what else they hold";
  EXPECT_FALSE(
    rule_issues("/properties/d",
                {{"slot", "a"}, {"type", "object"}, {"description", "D when not given."}})
      .empty())
    << "a slot is nothing else";
  EXPECT_TRUE(
    rule_issues("/properties/d", {{"type", "number"}, {"description", "D; 0 when not given."}})
      .empty());
  EXPECT_TRUE(rule_issues("/properties/d",
                          {{"type", {"number", "string"}}, {"description", "D."}, {"default", 1}})
                .empty());
}

TEST(Schema, FragmentsOfComponents)
{
  const Json number = {{"type", "number"}, {"description", "A number."}, {"default", 1}};
  const Json one    = {{"fragment", "number"}};
  Json schema       = Json::parse(stokes_schema);
  schema["fragments"]["number"] = number;
  schema["properties"]["d"]     = one;
  schema["properties"]["e"]     = one;
  EXPECT_TRUE(Schema::component_issues(schema.dump()).empty());
  Registry registry;
  registry.add<fluid_solver_interface, fluid_solver_component>("stokes", schema.dump());
  const Json composed =
    Json::parse(Schema::compose(registry).text())["definitions"]["fluid_solver.stokes"];
  EXPECT_EQ(composed["properties"]["d"], number);
  EXPECT_EQ(composed["properties"]["e"], number);
  EXPECT_FALSE(composed.contains("fragments"));

  const auto said = [&](const std::string &pointer, const Json &value) {
    Json changed                         = schema;
    changed[Json::json_pointer(pointer)] = value;
    const Issues issues                  = Schema::component_issues(changed.dump());
    return issues.empty() ? "" : issues[0].message;
  };
  EXPECT_EQ(said("/properties/d/fragment", "digit"),
            "names the fragment \"digit\", which is not among its fragments");
  EXPECT_EQ(said("/fragments/number/items", one), "the fragment \"number\" holds itself");
  EXPECT_NE(said("/properties/d/default", 1), "") << "a fragment is nothing else";
  EXPECT_NE(said("/fragments/number/default", "a"), "") << "its default must be valid";
}

TEST(Schema, RefusesWhatIsNotJson)
{
  EXPECT_THROW(Schema("{"), Error);
}
