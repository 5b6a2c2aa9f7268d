// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_message_h
#define feib_message_h

#include <string>

/// How values are shown in messages.
namespace feib
{
  /// A number, readable in any units: as it was written when 9 digits say all of it, otherwise
  /// rounded to 6 digits. 3e-07, 0.25, 1.5e+12.
  std::string readable(double number);

  /// A part of a whole in percent, to two digits: 0.35 %, 12 %, 140 %.
  std::string percent(double part);

  /// Text from outside (a key, a value, a file's name): control characters and what is not UTF-8
  /// become \u001b, \xff, ..., so that nothing of it acts on a terminal; longer text than
  /// @p length bytes is cut, with "..." at its end.
  std::string readable(const std::string &text, std::size_t length = std::string::npos);

  /// The same for text of several lines, which stay lines.
  std::string readable_lines(const std::string &text);
} // namespace feib

#endif
