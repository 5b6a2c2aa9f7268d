// SPDX-License-Identifier: LGPL-2.1-or-later
#include "table.h"

#include <algorithm>
#include <cmath>

namespace feib
{
  namespace
  {
    std::string
    print(const std::string &format, const double value)
    {
      std::vector<char> text(1 + std::snprintf(nullptr, 0, format.c_str(), value));
      std::snprintf(text.data(), text.size(), format.c_str(), value);
      return text.data();
    }


    /// A cell for people.
    std::string
    rendered(const Json &cell, const std::string &format)
    {
      if (cell.is_null())
        return "";
      if (cell.is_number() && !format.empty())
        return print(format, cell.get<double>());
      if (cell.is_number_float())
        return print("%.4g", cell.get<double>());
      std::string text;
      for (const char c : shown(cell))
        if (c == '|')
          text += "\\|";
        else
          text += c == '\n' ? ' ' : c;
      return text;
    }


    /// The number of characters of a text in UTF-8.
    std::size_t
    width(const std::string &text)
    {
      return std::count_if(text.begin(), text.end(), [](const unsigned char c) {
        return (c & 0xC0) != 0x80;
      });
    }


    std::string
    csv_field(const std::string &text)
    {
      if (text.find_first_of(",\"\r\n") == std::string::npos)
        return text;
      std::string quoted = "\"";
      for (const char c : text)
        quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
      return quoted + "\"";
    }


    /// The entry of a summary, or null.
    Json
    entry(const Json &summary, const Json::json_pointer &pointer)
    {
      try
        {
          return summary.contains(pointer) ? summary.at(pointer) : Json();
        }
      catch (const Json::exception &) // an index no array can have
        {
          return Json();
        }
    }


    /// log(e / e_before) / log(x / x_before), or null where that is no number.
    Json
    order(const double e_before, const double e, const double x_before, const double x)
    {
      const double result = std::log(std::abs(e / e_before)) / std::log(x / x_before);
      return std::isfinite(result) ? Json(result) : Json();
    }


    /// The rates of a column, row by row.
    std::vector<Json>
    rates(const Rate &rate,
          const Study &study,
          const std::vector<Combination> &combinations,
          const std::vector<Json> &cells)
    {
      // Rows that are neighbours along the axis are so many rows apart.
      std::size_t stride = 1;
      for (std::size_t a = rate.axis + 1; a < study.axes.size(); ++a)
        stride *= study.axes[a].values.size();
      const std::size_t needed = rate.of_differences ? 2 : 1; // rows before this one

      std::vector<Json> result(cells.size());
      for (std::size_t i = 0; i < cells.size(); ++i)
        {
          bool known = combinations[i].values[rate.axis] >= needed;
          for (std::size_t k = 0; known && k <= needed; ++k)
            known =
              cells[i - k * stride].is_number() && combinations[i - k * stride].outcome.completed();
          if (!known)
            continue;
          const auto e = [&](const std::size_t k) { return cells[i - k * stride].get<double>(); };
          const auto x = [&](const std::size_t k) {
            return study.axes[rate.axis]
              .values[combinations[i - k * stride].values[rate.axis]]
              .label.get<double>();
          };
          result[i] = rate.of_differences ? order(e(1) - e(2), e(0) - e(1), x(1), x(0))
                                          : order(e(1), e(0), x(1), x(0));
        }
      return result;
    }
  } // namespace


  Table::Table(const Study &study, const std::vector<Combination> &combinations)
    : title(study.title)
  {
    const auto add =
      [&](const std::string &name, const std::string &format, const auto &cell) -> void {
      columns.push_back({name, format, {}});
      for (const Combination &combination : combinations)
        columns.back().cells.push_back(cell(combination));
    };
    const auto add_rates = [&](const std::string &column) {
      const std::vector<Json> cells = columns.back().cells;
      const auto n = std::count_if(study.rates.begin(), study.rates.end(), [&](const Rate &rate) {
        return rate.column == column;
      });
      for (const Rate &rate : study.rates)
        if (rate.column == column)
          columns.push_back(
            {"rate(" + column + (n > 1 ? ", " + study.axes[rate.axis].name : "") + ")",
             "%.2f",
             rates(rate, study, combinations, cells)});
    };

    for (std::size_t a = 0; a < study.axes.size(); ++a)
      add(study.axes[a].name, "%.10g", [&](const Combination &combination) {
        return study.axes[a].values[combination.values[a]].label;
      });
    if (study.bisection)
      {
        add(study.bisection->name, "", [](const Combination &combination) {
          return combination.limit;
        });
        add_rates(study.bisection->name);
      }
    add("status", "", [](const Combination &combination) { return combination.outcome.status; });
    for (const Column &column : study.columns)
      {
        add(column.name, column.format, [&](const Combination &combination) {
          return entry(combination.outcome.summary, column.pointer);
        });
        add_rates(column.name);
      }
  }


  std::string
  Table::markdown() const
  {
    const std::size_t n_rows = columns[0].cells.size();
    std::vector<std::string> lines(n_rows + 2, "|");
    for (const TableColumn &column : columns)
      {
        std::vector<std::string> texts = {rendered(column.name, "")};
        for (const Json &cell : column.cells)
          texts.push_back(rendered(cell, column.format));
        std::size_t widest = 3;
        for (const std::string &text : texts)
          widest = std::max(widest, width(text));
        // Numbers stand to the right.
        const bool right =
          std::all_of(column.cells.begin(), column.cells.end(), [](const Json &cell) {
            return cell.is_number() || cell.is_null();
          });
        const auto add = [&](std::string &line, const std::string &text) {
          const std::string space(widest - width(text), ' ');
          line += " " + (right ? space + text : text + space) + " |";
        };
        add(lines[0], texts[0]);
        lines[1] += (right ? " " : " :") + std::string(widest - 1, '-') + (right ? ": |" : " |");
        for (std::size_t i = 0; i < n_rows; ++i)
          add(lines[i + 2], texts[i + 1]);
      }
    std::string text = title.empty() ? "" : title + "\n\n";
    for (const std::string &line : lines)
      text += line + "\n";
    return text;
  }


  std::string
  Table::csv() const
  {
    std::string text;
    const auto line = [&](const auto &field) {
      for (std::size_t c = 0; c < columns.size(); ++c)
        text += (c == 0 ? "" : ",") + csv_field(field(columns[c]));
      text += "\r\n";
    };
    line([](const TableColumn &column) { return column.name; });
    for (std::size_t i = 0; i < columns[0].cells.size(); ++i)
      line([i](const TableColumn &column) {
        const Json &cell = column.cells[i];
        return cell.is_number_float() ? print("%.17g", cell.get<double>())
               : cell.is_null()       ? std::string()
                                      : shown(cell);
      });
    return text;
  }
} // namespace feib
