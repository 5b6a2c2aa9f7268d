// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_parameters_h
#define feib_parameters_h

#include <feib/error.h>

#include <mpi.h>

#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace feib
{
  class Registry;
  class TimeSeries;

  /// A read-only view of one block of a validated, default-filled case: what a component is built
  /// from. Every key a schema lists is there, so a getter that meets a missing key or another type
  /// is a programmer's error (std::logic_error), unless the key is optional without default: ask
  /// has(). The key of a value or of has() may go deeper: "fibres/0".
  class Parameters
  {
  public:
    double number(const std::string &key) const;
    int integer(const std::string &key) const;
    bool boolean(const std::string &key) const;
    std::string string(const std::string &key) const;

    /// A text that names columns and files of results. Throws Error unless it is made of letters,
    /// digits and _.
    std::string word(const std::string &key) const;

    std::vector<double> numbers(const std::string &key) const;
    std::vector<int> integers(const std::string &key) const;

    /// The texts of one expression or an array of expressions; numbers come as their shortest text.
    std::vector<std::string> expressions(const std::string &key) const;

    bool has(const std::string &key) const;

    /// The object at @p key.
    Parameters child(const std::string &key) const;

    /// The objects of the array at @p key.
    std::vector<Parameters> children(const std::string &key) const;

    /// For an object with exactly one key, {"name": {...}}: that key and its block.
    std::pair<std::string, Parameters> choice() const;

    /// For a slot, {"name": {...}}: the component of that name, built from its block, e.g.
    /// child("law").create<ConstitutiveLaw<2, 2>>(). Include registry.h. Throws Error when the
    /// component is not offered for these dimensions.
    template <class Interface>
    std::unique_ptr<Interface> create() const;

    /// The JSON pointer of this block in the case, e.g. "/structures/0/hyperelastic".
    const std::string &pointer() const;

    /// The named constants that the case's expressions may use.
    const std::map<std::string, double> &constants() const;

    /// The named series of the case, functions of one variable in its expressions.
    const std::map<std::string, std::shared_ptr<const TimeSeries>> &series() const;

    /// The folder that relative file names in the case are meant from.
    const std::string &directory() const;

    /// The file or folder that @p key names, meant from directory().
    std::string path(const std::string &key) const;

    /// The ranks that build the component, all with the same parameters.
    MPI_Comm communicator() const;

    /// The shortest edge of the finest cells that the fluid may have where this is built beside
    /// it, 0 where it is not [length].
    double cell_edge() const;

    /// The same with that edge. For the core.
    Parameters beside_cells(double edge) const;

    /// Throws an Error at @p key of this block ("" for the block itself; "mesh/gmsh/file" goes
    /// deeper).
    [[noreturn]] void fail(const std::string &key, const std::string &message) const;

    /// For the core: a view is made by Case and by Registry.
    struct Node;
    explicit Parameters(std::shared_ptr<const Node> node);

  private:
    const Registry &registry() const;

    std::shared_ptr<const Node> node;
  };
} // namespace feib

#endif
