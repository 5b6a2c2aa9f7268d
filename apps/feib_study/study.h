// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_study_study_h
#define feib_study_study_h

#include <nlohmann/json.hpp>

#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace feib
{
  /// The order of keys is the user's order.
  using Json = nlohmann::ordered_json;

  /// Changes of a case: JSON pointer and value.
  using Settings = std::vector<std::pair<std::string, Json>>;

  /// A number or text for people: a text without its quotes, anything else as JSON.
  std::string shown(const Json &value);

  /// A text as a part of the name of a folder, without what needs care in a shell.
  std::string folder_name(std::string text);

  /// One direction in which a study varies its case.
  struct Axis
  {
    struct Value
    {
      Json label;
      Settings settings;
    };

    std::string name;
    std::vector<Value> values;

    /// Whether all labels are numbers.
    bool is_numeric() const;
  };


  /// The search for the largest value with which a run completes.
  struct Bisection
  {
    /// What is known after some runs: the value to try next, or the end of the search.
    struct State
    {
      std::optional<double> next;
      std::optional<double> completed; // the largest value that completed
      Json result;                     // that value, or "< lower" or "> upper"
    };

    std::string name;
    std::vector<std::string> pointers;
    double lower, upper, ratio;

    Settings settings(double value) const;

    /// Follows the search as far as the runs are known. @p completes says whether the run with a
    /// value completes, or nothing when that is not known yet.
    State follow(const std::function<std::optional<bool>(double)> &completes) const;
  };


  /// A column of the table: an entry of summary.json.
  struct Column
  {
    std::string name;
    Json::json_pointer pointer;
    std::string format; // of printf; may be empty
  };


  /// The rate of a column along an axis.
  struct Rate
  {
    unsigned int axis;
    std::string column; // or the name of the bisection
    bool of_differences;
  };


  /// The parsed, validated, default-filled description of a study.
  struct Study
  {
    /// @p file is the name of the study, which the name of the case is relative to. Throws Error
    /// with all issues, their places being in @p text.
    Study(const std::string &text, const std::string &file);

    std::string title;
    std::string case_file, case_text;
    unsigned int ranks;
    Settings settings;
    std::vector<Axis> axes;
    std::optional<Bisection> bisection;
    std::vector<Column> columns;
    std::vector<Rate> rates;
  };
} // namespace feib

#endif
