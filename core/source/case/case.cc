// SPDX-License-Identifier: LGPL-2.1-or-later
#include "json.h"
#include "time_series.h"
#include <feib/text_file.h>

#include <feib/case.h>
#include <feib/expression.h>
#include <feib/message.h>
#include <feib/schema.h>

#include <deal.II/base/mpi.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <set>

namespace feib
{
  namespace
  {
    /// Finds where the values of a document stand in its text, and keys that stand twice. The text
    /// may hold comments and is known to be correct.
    class Places
    {
    public:
      explicit Places(const std::string &text)
        : text(text)
      {
        value("");
      }

      std::map<std::string, std::size_t> offsets; // by JSON pointer
      Issues duplicates;

    private:
      const std::string &text;
      std::size_t at = 0;

      /// The next character that is neither space nor comment.
      char
      next()
      {
        while (at < text.size())
          if (text.compare(at, 2, "//") == 0)
            at = std::min(text.find('\n', at), text.size());
          else if (text.compare(at, 2, "/*") == 0)
            at = std::min(text.find("*/", at + 2), text.size() - 2) + 2;
          else if (std::isspace(static_cast<unsigned char>(text[at])) ||
                   text.compare(at, 3, "\xEF\xBB\xBF") == 0)
            at += text[at] == '\xEF' ? 3 : 1;
          else
            return text[at];
        return '\0';
      }

      std::string
      string()
      {
        const std::size_t start = at++;
        while (text[at] != '"')
          at += text[at] == '\\' ? 2 : 1;
        ++at;
        return Json::parse(text.substr(start, at - start)).get<std::string>();
      }

      void
      value(const std::string &pointer)
      {
        const char first = next();
        offsets[pointer] = at;
        if (first == '{')
          object(pointer);
        else if (first == '[')
          array(pointer);
        else if (first == '"')
          string();
        else
          at = std::min(text.find_first_of(",]}/ \t\r\n", at), text.size());
      }

      void
      object(const std::string &pointer)
      {
        std::set<std::string> keys;
        ++at;
        while (next() != '}')
          {
            if (text[at] == ',')
              {
                ++at;
                next();
              }
            const std::size_t start = at;
            const std::string key   = string();
            if (!keys.insert(key).second)
              duplicates.push_back({pointer + pointer_part(key),
                                    "the key " + quoted(key) + " stands here a second time",
                                    start});
            next();
            ++at; // the colon
            value(pointer + pointer_part(key));
          }
        ++at;
      }

      void
      array(const std::string &pointer)
      {
        ++at;
        for (std::size_t i = 0; next() != ']'; ++i)
          {
            if (text[at] == ',')
              ++at;
            value(pointer + "/" + std::to_string(i));
          }
        ++at;
      }
    };


    const char *const too_deep_sentence =
      "objects and arrays are nested more than 100 deep; no case needs that";


    /// The first number of a text that is beyond all numbers of the computer: where, and its text.
    std::optional<std::pair<std::size_t, std::string>>
    number_out_of_range(const std::string &text)
    {
      struct Search : nlohmann::detail::json_sax_acceptor<Json>
      {
        std::optional<std::pair<std::size_t, std::string>> found;

        bool
        parse_error(const std::size_t position,
                    const std::string &token,
                    const nlohmann::detail::exception &failure)
        {
          if (failure.id == 406)
            found = std::make_pair(position - token.size(), token);
          return false;
        }
      } search;
      Json::sax_parse(text, &search, nlohmann::detail::input_format_t::json, true, true);
      return search.found;
    }


    std::string
    out_of_range_sentence(const std::string &number)
    {
      return "the number " + readable(number, 60) + " is too large; the largest is 1.8e308";
    }


    Json
    parse(const std::string &text)
    {
      if (const auto place = too_deep(text))
        throw Error(Issues{{"", too_deep_sentence, *place}});
      Json document;
      try
        {
          document = Json::parse(text, nullptr, true, true);
        }
      catch (const Json::parse_error &failure)
        {
          std::string message = failure.what();
          // Behind the place, which is said as that of the file.
          const std::size_t column = message.find("column ");
          const std::size_t start  = message.find(": ", column);
          if (column != std::string::npos && start != std::string::npos)
            message.erase(0, start + 2);
          if (message.rfind("syntax error", 0) != 0)
            message = "syntax error: " + message;
          throw Error(Issues{{"", message, std::max<std::size_t>(failure.byte, 1) - 1}});
        }
      catch (const Json::out_of_range &failure)
        {
          if (const auto number = number_out_of_range(text))
            throw Error(Issues{{"", out_of_range_sentence(number->second), number->first}});
          throw Error(Issues{{"", failure.what(), 0}});
        }
      Places places(text);
      if (!places.duplicates.empty())
        throw Error(places.duplicates);
      return document;
    }


    /// Puts the value of one --set into the document; returns what is wrong with it, or "".
    std::string
    apply(Json &document, const std::string &pointer, const std::string &text)
    {
      if (pointer.empty() || pointer[0] != '/')
        return "a JSON pointer starts with /, e.g. --set /time/step=0.1";
      if (too_deep(text))
        return too_deep_sentence;
      Json value = Json::parse(text, nullptr, false);
      if (value.is_discarded())
        if (const auto number = number_out_of_range(text))
          return out_of_range_sentence(number->second);
      if (value.is_discarded())
        value = text;
      try
        {
          value.dump();
          Json(pointer).dump();
        }
      catch (const Json::exception &)
        {
          return "pointer and value must be UTF-8 text";
        }

      Json *place = &document;
      std::string where;
      const std::vector<std::string> parts = pointer_parts(pointer);
      for (std::size_t i = 0; i < parts.size(); ++i)
        {
          const std::string &part = parts[i];
          const bool last         = i + 1 == parts.size();
          if (place->is_object())
            {
              if (!last && !place->contains(part))
                return "the case has no " + where + pointer_part(part) +
                       "; set that, with all it holds as JSON";
              place = &(*place)[part];
            }
          else if (place->is_array())
            {
              const bool is_index = !part.empty() && part.size() < 9 &&
                                    part.find_first_not_of("0123456789") == std::string::npos;
              if (!is_index || std::stoul(part) >= place->size())
                return where + " has " + std::to_string(place->size()) + " entries, no " +
                       quoted(part);
              place = &(*place)[std::stoul(part)];
            }
          else
            return where + " is neither an object nor an array";
          where += pointer_part(part);
        }
      *place = std::move(value);
      return "";
    }


    bool
    is_identifier(const std::string &name)
    {
      return !name.empty() && !std::isdigit(static_cast<unsigned char>(name[0])) &&
             std::all_of(name.begin(), name.end(), [](const unsigned char c) {
               return std::isalnum(c) || c == '_';
             });
    }


    /// The constants of the case, with pi and e.
    std::map<std::string, double>
    constants(const Json &document, Issues &issues)
    {
      std::map<std::string, double> result = mathematical_constants();
      for (const auto &[name, value] : document["constants"].items())
        {
          const std::string pointer = "/constants" + pointer_part(name);
          if (!is_identifier(name))
            issues.push_back({pointer,
                              quoted(name) +
                                " cannot name a constant: letters, digits and underscores are "
                                "allowed, a digit not first"});
          else if (is_expression_word(name))
            issues.push_back({pointer,
                              "\"" + name +
                                "\" cannot name a constant: it is a function, a variable or a "
                                "constant of every expression"});
          result[name] = value.get<double>();
        }
      return result;
    }


    /// The series of the case.
    std::map<std::string, std::shared_ptr<const TimeSeries>>
    series(const Json &document,
           const std::map<std::string, double> &constants,
           const std::string &folder,
           const MPI_Comm communicator,
           Issues &issues)
    {
      std::map<std::string, std::shared_ptr<const TimeSeries>> result;
      for (const auto &[name, value] : document["series"].items())
        {
          const std::string pointer = "/series" + pointer_part(name);
          if (!is_identifier(name) || is_expression_word(name) || constants.count(name) != 0)
            {
              issues.push_back({pointer,
                                quoted(name) +
                                  " cannot name a series: letters, digits and underscores are "
                                  "allowed, a digit not first, and no word of expressions and no "
                                  "constant"});
              continue;
            }
          try
            {
              result[name] = std::make_shared<const TimeSeries>(
                (std::filesystem::path(folder) / value["file"].get<std::string>()).string(),
                value.value("column", ""),
                value["repeat"].get<bool>(),
                communicator);
            }
          catch (const Error &error)
            {
              issues.push_back({pointer + "/file", error.what()});
            }
        }
      return result;
    }


    std::string
    position(const std::string &text, const std::size_t offset)
    {
      const auto end          = text.begin() + std::min(offset, text.size());
      const auto lines        = std::count(text.begin(), end, '\n');
      const std::size_t start = std::string(text.begin(), end).rfind('\n') + 1; // 0 without any
      const auto column       = std::count_if(text.begin() + start, end, [](const unsigned char c) {
        return (c & 0xC0) != 0x80;
      });
      return std::to_string(lines + 1) + ":" + std::to_string(column + 1);
    }
  } // namespace


  Case::Case(const std::string &text,
             const std::string &file,
             const Registry &registry,
             const Settings &settings,
             const std::string &directory,
             const MPI_Comm communicator)
    : text(text)
    , file(file)
    , settings(settings)
  {
    Json document = parse(text);
    Issues issues;
    for (const auto &[pointer, value] : settings)
      if (const std::string problem = apply(document, pointer, value); !problem.empty())
        issues.push_back({pointer, problem});
    if (!issues.empty())
      throw Error(issues);

    const Schema schema       = Schema::compose(registry);
    const std::string written = document.dump();
    issues                    = schema.explain(written);
    if (issues.empty())
      {
        resolved_text = schema.with_defaults(written);
        issues        = schema.explain(resolved_text); // a default may name an absent component
        if (issues.empty() && !schema.accepts(resolved_text))
          issues.push_back({"", "breaks the schema of cases (feib-host --schema)"});
      }
    if (!issues.empty())
      throw Error(issues);

    document          = Json::parse(resolved_text);
    const auto known  = constants(document, issues);
    const auto parent = std::filesystem::path(file).parent_path().string();
    const auto folder = !directory.empty() ? directory : parent.empty() ? "." : parent;
    const auto given  = series(document, known, folder, communicator, issues);
    const auto shared = std::make_shared<Document>(
      Document{std::move(document), &registry, known, given, folder, communicator});
    if (!issues.empty())
      throw Error(issues);
    view = std::make_unique<Parameters>(
      std::make_shared<Parameters::Node>(Parameters::Node{shared, &shared->root, ""}));
  }


  std::string
  Case::read(const std::string &file)
  {
    return read_text_file(file, file, false);
  }


  std::string
  Case::plain(const std::string &text)
  {
    return parse(text).dump();
  }


  Case
  Case::from_file(const std::string &file, const Registry &registry, const Settings &settings)
  {
    return Case(read(file), file, registry, settings);
  }


  const Parameters &
  Case::parameters() const
  {
    return *view;
  }


  std::string
  Case::resolved() const
  {
    return resolved_text;
  }


  std::string
  Case::format(const Issues &issues) const
  {
    return format(issues, text, file, settings);
  }


  std::string
  Case::format(const Issues &issues,
               const std::string &text,
               const std::string &file,
               const Settings &settings)
  {
    const bool is_syntax_error =
      too_deep(text) || Json::parse(text, nullptr, false, true).is_discarded();
    const Places places(is_syntax_error ? "null" : text);
    const auto place = [&](const Issue &issue) {
      if (issue.offset)
        return readable(file) + ":" + position(text, *issue.offset);
      for (auto setting = settings.rbegin(); setting != settings.rend(); ++setting)
        if (issue.pointer == setting->first || issue.pointer.rfind(setting->first + "/", 0) == 0)
          return "--set " + readable(setting->first, 200);
      std::string pointer = issue.pointer;
      while (places.offsets.count(pointer) == 0)
        pointer.erase(std::min(pointer.rfind('/'), pointer.size()));
      return readable(file) + ":" + position(text, places.offsets.at(pointer));
    };
    std::string lines;
    for (const Issue &issue : issues)
      lines += place(issue) +
               ": error: " + (issue.pointer.empty() ? "" : readable(issue.pointer, 200) + ": ") +
               readable(issue.message, 4000) + "\n";
    return lines;
  }
} // namespace feib
