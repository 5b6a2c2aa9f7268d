// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_case_h
#define feib_case_h

#include <feib/parameters.h>
#include <feib/registry.h>

#include <string>
#include <utility>
#include <vector>

namespace feib
{
  /// The parsed, validated, default-filled document of one simulation.
  class Case
  {
  public:
    using Settings = std::vector<std::pair<std::string, std::string>>;

    /// Parses @p text, applies the settings (JSON pointer, value: JSON, or else taken as a string),
    /// validates against the schema composed from the registry and fills in the defaults.
    /// @p file is the name used in messages; relative file names in the case are meant from its
    /// folder, or from @p directory when that is given. Components are built by the ranks of
    /// @p communicator. Throws Error with all issues. The registry must outlive the case.
    Case(const std::string &text,
         const std::string &file,
         const Registry &registry,
         const Settings &settings     = {},
         const std::string &directory = "",
         MPI_Comm communicator        = MPI_COMM_WORLD);

    /// The text of a file, read on rank 0 and shared. Collective (a program without MPI just reads
    /// it). Throws Error when it cannot be read.
    static std::string read(const std::string &file);

    /// What a text with comments says, as plain JSON, the keys in their order. Throws Error, with
    /// places for format(), when it is not JSON or a key stands twice.
    static std::string plain(const std::string &text);

    /// The case in a file; see read().
    static Case
    from_file(const std::string &file, const Registry &registry, const Settings &settings = {});

    /// The whole case.
    const Parameters &parameters() const;

    /// The exact run, with all defaults, as text.
    std::string resolved() const;

    /// Turns issues into lines "file:line:col: error: /pointer: message", by their places in the
    /// text (the nearest enclosing value where the pointer names something absent; a value given by
    /// --set says so).
    std::string format(const Issues &issues) const;

    /// The same for a text that could not become a case.
    static std::string format(const Issues &issues,
                              const std::string &text,
                              const std::string &file,
                              const Settings &settings = {});

  private:
    std::string text, file, resolved_text;
    Settings settings;
    std::unique_ptr<Parameters> view;
  };
} // namespace feib

#endif
