// SPDX-License-Identifier: LGPL-2.1-or-later
#include "study.h"

#include <feib/case.h>
#include <feib/schema.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <map>
#include <regex>
#include <set>

#include "study_schema.h"

namespace feib
{
  namespace
  {
    /// Plain JSON, validated, with all defaults.
    Json
    parse(const std::string &text)
    {
      const Schema schema(study_schema);
      const std::string written = Case::plain(text);
      Issues issues             = schema.explain(written);
      if (issues.empty() && !schema.accepts(written))
        issues.push_back({"", "breaks the schema of studies (schemas/study.schema.json)"});
      if (!issues.empty())
        throw Error(issues);
      return Json::parse(schema.with_defaults(written));
    }


    /// "a", "b" or "c"
    std::string
    quoted_list(const std::vector<std::string> &names)
    {
      std::string list;
      for (std::size_t i = 0; i < names.size(); ++i)
        list += (i == 0 ? "\"" : i + 1 < names.size() ? ", \"" : " or \"") + names[i] + "\"";
      return list;
    }


    /// Turns the document of a study into what it means, and collects what the schema cannot say.
    class Reader
    {
    public:
      Issues issues;

      void
      wrong(const std::string &pointer, const std::string &message)
      {
        issues.push_back({pointer, message});
      }

      /// A name that the table or a rate refers to.
      std::string
      name(const Json &owner, const std::string &pointer)
      {
        const std::string name = owner["name"].get<std::string>();
        if (name == "status")
          wrong(pointer + "/name", "\"status\" is the name of a column that every table has");
        else if (!names.insert(name).second)
          wrong(pointer + "/name", "the name \"" + name + "\" stands here a second time");
        return name;
      }

      void
      check_setting(const std::string &setting, const std::string &pointer)
      {
        if (setting.empty() || setting[0] != '/')
          wrong(pointer,
                "a JSON pointer starts with /, e.g. \"/time/step\", found \"" + setting + "\"");
      }

      Settings
      settings(const Json &object, const std::string &pointer)
      {
        Settings settings;
        for (const auto &[setting, value] : object.items())
          {
            check_setting(setting, pointer);
            settings.emplace_back(setting, value);
          }
        return settings;
      }

      /// One pointer or several.
      std::vector<std::string>
      pointers(const Json &value, const std::string &pointer)
      {
        const auto list = value.is_string() ? std::vector<std::string>{value.get<std::string>()}
                                            : value.get<std::vector<std::string>>();
        for (const std::string &setting : list)
          check_setting(setting, pointer);
        return list;
      }

      Axis
      axis(const Json &document, const std::string &pointer)
      {
        Axis axis;
        axis.name        = name(document, pointer);
        const auto fixed = document.contains("pointer")
                             ? pointers(document["pointer"], pointer + "/pointer")
                             : std::vector<std::string>();
        std::map<std::string, std::string> folders;
        for (std::size_t i = 0; i < document["values"].size(); ++i)
          {
            const std::string place = pointer + "/values/" + std::to_string(i);
            const Json &value       = document["values"][i];
            if (fixed.empty())
              axis.values.push_back({value["label"], settings(value["set"], place + "/set")});
            else
              {
                axis.values.push_back({value, {}});
                for (const std::string &setting : fixed)
                  axis.values.back().settings.emplace_back(setting, value);
              }
            const std::string label      = shown(axis.values.back().label);
            const auto [first, inserted] = folders.emplace(folder_name(label), label);
            if (!inserted)
              wrong(place,
                    first->second == label
                      ? "the value " + label + " stands here a second time"
                      : "\"" + first->second + "\" and \"" + label +
                          "\" would give their runs the same folder, \"" + first->first + "\"");
          }
        return axis;
      }

      Bisection
      bisection(const Json &document)
      {
        Bisection bisection{name(document, "/bisect"),
                            pointers(document["pointer"], "/bisect/pointer"),
                            document["lower"].get<double>(),
                            document["upper"].get<double>(),
                            document["ratio"].get<double>()};
        if (!(bisection.lower < bisection.upper))
          wrong("/bisect/upper",
                "must be greater than \"lower\", " + document["lower"].dump() + ", found " +
                  document["upper"].dump());
        return bisection;
      }

      Column
      column(const Json &document, const std::string &pointer)
      {
        Column column{name(document, pointer), Json::json_pointer(), ""};
        try
          {
            column.pointer = Json::json_pointer(document["pointer"].get<std::string>());
          }
        catch (const Json::exception &)
          {
            wrong(pointer + "/pointer",
                  "must be a JSON pointer, e.g. \"/energy/kinetic\", found " +
                    document["pointer"].dump());
          }
        if (document.contains("format"))
          {
            // What the user writes is handed to printf, with one double.
            static const std::regex one_number(
              "([^%]|%%)*%[-+ #0]*[0-9]{0,2}(\\.[0-9]{0,2})?[aAeEfFgG]([^%]|%%)*");
            column.format = document["format"].get<std::string>();
            if (!std::regex_match(column.format, one_number))
              wrong(pointer + "/format",
                    "must format one number with %e, %f or %g, e.g. \"%.3e\", found " +
                      document["format"].dump());
          }
        return column;
      }

      Rate
      rate(const Json &document, const Study &study, const std::string &pointer)
      {
        Rate rate{0, document["column"].get<std::string>(), document["of"] == "differences"};
        const auto axis_name = document["axis"].get<std::string>();
        std::vector<std::string> axis_names, column_names;
        for (const Axis &axis : study.axes)
          axis_names.push_back(axis.name);
        if (study.bisection)
          column_names.push_back(study.bisection->name);
        for (const Column &column : study.columns)
          column_names.push_back(column.name);

        rate.axis = std::find(axis_names.begin(), axis_names.end(), axis_name) - axis_names.begin();
        if (rate.axis == axis_names.size())
          wrong(pointer + "/axis",
                axis_names.empty()
                  ? "the study has no axes"
                  : "must be " + quoted_list(axis_names) + ", found \"" + axis_name + "\"");
        else if (!study.axes[rate.axis].is_numeric())
          wrong(pointer + "/axis",
                "rates need an axis whose values are all numbers; those of \"" + axis_name +
                  "\" are not");
        if (std::find(column_names.begin(), column_names.end(), rate.column) == column_names.end())
          wrong(pointer + "/column",
                column_names.empty()
                  ? "the study has no columns"
                  : "must be " + quoted_list(column_names) + ", found \"" + rate.column + "\"");
        if (!rate_pairs.emplace(rate.axis, rate.column).second)
          wrong(pointer, "the rate of this column along this axis stands here a second time");
        return rate;
      }

    private:
      std::set<std::string> names;
      std::set<std::pair<unsigned int, std::string>> rate_pairs;
    };


    /// A value that can be read and typed: six digits.
    double
    rounded(const double value)
    {
      char text[32];
      std::snprintf(text, sizeof text, "%.6g", value);
      return std::strtod(text, nullptr);
    }
  } // namespace


  std::string
  shown(const Json &value)
  {
    if (value.is_string())
      return value.get<std::string>();
    std::string text = value.dump();
    if (value.is_number_float() && text.size() > 2 && text.compare(text.size() - 2, 2, ".0") == 0)
      text.erase(text.size() - 2);
    return text;
  }


  std::string
  folder_name(std::string text)
  {
    for (char &c : text)
      if (static_cast<unsigned char>(c) <= ' ' || std::strchr("/\\:*?\"'<>|&;,$`(){}[]!#~", c))
        c = '_';
    return text;
  }


  bool
  Axis::is_numeric() const
  {
    return std::all_of(values.begin(), values.end(), [](const Value &value) {
      return value.label.is_number();
    });
  }


  Settings
  Bisection::settings(const double value) const
  {
    Settings settings;
    for (const std::string &pointer : pointers)
      settings.emplace_back(pointer, value);
    return settings;
  }


  Bisection::State
  Bisection::follow(const std::function<std::optional<bool>(double)> &completes) const
  {
    // Runs beyond the limit tend to be the short ones, and many searches need no other.
    const std::optional<bool> at_upper = completes(upper);
    if (!at_upper)
      return {upper, {}, {}};
    if (*at_upper)
      return {{}, upper, "> " + shown(upper)};
    const std::optional<bool> at_lower = completes(lower);
    if (!at_lower)
      return {lower, {}, {}};
    if (!*at_lower)
      return {{}, {}, "< " + shown(lower)};

    double good = lower, bad = upper;
    while (bad / good > ratio)
      {
        const double middle                 = rounded(std::sqrt(good) * std::sqrt(bad));
        const std::optional<bool> at_middle = completes(middle);
        if (!at_middle)
          return {middle, {}, {}};
        (*at_middle ? good : bad) = middle;
      }
    return {{}, good, good};
  }


  Study::Study(const std::string &text, const std::string &file)
  {
    const Json document = parse(text);
    Reader reader;

    title     = document["title"].get<std::string>();
    ranks     = document["ranks"].get<unsigned int>();
    case_file = (std::filesystem::path(file).parent_path() / document["case"].get<std::string>())
                  .lexically_normal()
                  .string();
    try
      {
        case_text = Case::read(case_file);
      }
    catch (const Error &error)
      {
        reader.wrong("/case", error.what());
      }

    const auto each = [&](const char *const key, const auto &read) {
      for (std::size_t i = 0; i < document[key].size(); ++i)
        read(document[key][i], "/" + std::string(key) + "/" + std::to_string(i));
    };
    settings = reader.settings(document["set"], "/set");
    each("axes", [&](const Json &axis, const std::string &pointer) {
      axes.push_back(reader.axis(axis, pointer));
    });
    if (document.contains("bisect"))
      bisection = reader.bisection(document["bisect"]);
    if (axes.empty() && !bisection)
      reader.wrong("", "must have at least one entry in \"axes\", or a \"bisect\"");
    each("columns", [&](const Json &column, const std::string &pointer) {
      columns.push_back(reader.column(column, pointer));
    });
    each("rates", [&](const Json &rate, const std::string &pointer) {
      rates.push_back(reader.rate(rate, *this, pointer));
    });
    if (!reader.issues.empty())
      throw Error(reader.issues);
  }
} // namespace feib
