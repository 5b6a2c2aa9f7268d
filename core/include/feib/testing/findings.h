// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_testing_findings_h
#define feib_testing_findings_h

#include <exception>
#include <sstream>
#include <string>
#include <vector>

namespace feib::testing
{
  /// What is found wrong with a component, a sentence for each place: for a test, where each is a
  /// failure, as for feib-host --check-plugin.
  class Findings
  {
  public:
    /// What the next sentence begins with: where it is true.
    std::string place;

    std::vector<std::string> sentences;

    /// The first sentence of a place is kept: the others are mostly the same one, at other points.
    void
    add(const std::string &sentence)
    {
      if (sentences.empty() || last != place)
        sentences.push_back(place + sentence);
      last = place;
    }

    /// Unless the value is below the limit; what is not a number is not.
    void
    below(const double value, const double limit, const std::string &sentence)
    {
      if (value < limit)
        return;
      std::ostringstream text;
      text << sentence << " (by " << value << ", where " << limit << " is allowed)";
      add(text.str());
    }

    /// What an action throws is a finding.
    template <typename Action>
    void
    run(const Action &action)
    {
      try
        {
          action();
        }
      catch (const std::exception &failure)
        {
          add("it throws: " + std::string(failure.what()));
        }
      catch (...)
        {
          add("it throws something that is no std::exception");
        }
    }

    void
    append(const Findings &other)
    {
      sentences.insert(sentences.end(), other.sentences.begin(), other.sentences.end());
    }

  private:
    std::string last;
  };
} // namespace feib::testing

#endif
