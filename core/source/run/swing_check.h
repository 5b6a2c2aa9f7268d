// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_swing_check_h
#define feib_swing_check_h

#include <feib/archive.h>
#include <feib/ledger.h>

#include <deque>
#include <string>
#include <vector>

namespace feib
{
  /// Watches the forces of the ledger, those of structures, of the forces on them and of the faces
  /// of the box, for one that swings faster than the steps can follow: what a scheme that damps
  /// nothing makes of a spring too stiff for its steps, or of a start that is not smooth. Means
  /// over several steps hold, single values do not.
  class SwingCheck
  {
  public:
    /// The forces of the last row. @p negligible: below that a force is round-off.
    void add(const Ledger &ledger, double negligible);

    /// Of the forces that have swung within less than about ten steps, and by more than a tenth of
    /// what they were lately, for 20 steps, that which swings the most: its amplitude in that. 0
    /// without.
    struct Worst
    {
      double part = 0;
      std::string name;
    };
    Worst worst() const;

    void
    archive(Archive &archive)
    {
      archive("forces", forces);
    }

  private:
    struct Force
    {
      std::string name;
      std::deque<dealii::Tensor<1, 3>> past; // the newest first
      std::deque<double> rough;              // the amplitudes of what is swung
      double amplitude   = 0;                // the largest of these
      double peak        = 0;                // of the force, lately
      unsigned int steps = 0;                // swinging

      void
      archive(Archive &archive)
      {
        archive("name", name);
        archive("past", past);
        archive("rough", rough);
        archive("amplitude", amplitude);
        archive("peak", peak);
        archive("steps", steps);
      }

      void add(const dealii::Tensor<1, 3> &value, double negligible);
    };

    std::vector<Force> forces;
  };
} // namespace feib

#endif
