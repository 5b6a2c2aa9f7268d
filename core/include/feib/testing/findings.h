// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_testing_findings_h
#define feib_testing_findings_h

#include <exception>
#include <set>
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

    /// At each place a sentence is kept once: at other points it is the same one.
    void
    add(const std::string &sentence)
    {
      add(sentence, "");
    }

    void
    expect(const bool holds, const char *const sentence)
    {
      if (!holds)
        add(sentence);
    }

    /// Unless the value is below the limit; what is not a number is not.
    void
    below(const double value, const double limit, const std::string &sentence)
    {
      if (value < limit)
        return;
      std::ostringstream text;
      text << " (by " << value << ", where " << limit << " is allowed)";
      add(sentence, text.str());
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
    std::set<std::string> said;

    void
    add(const std::string &sentence, const std::string &amount)
    {
      if (said.insert(place + sentence).second)
        sentences.push_back(place + sentence + amount);
    }
  };
} // namespace feib::testing

#endif
