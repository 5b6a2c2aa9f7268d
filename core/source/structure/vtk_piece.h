// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_vtk_piece_h
#define feib_vtk_piece_h

#include "mesh_file.h"

#include <string>
#include <string_view>
#include <vector>

// What both kinds of files of VTK share, and each of them.
namespace feib
{
  /// A type of numbers.
  struct VtkNumber
  {
    std::size_t size; // bytes
    bool integer, negative;

    /// @p swapped: its bytes, against those of this machine.
    double value(const char *bytes, bool swapped) const;
  };

  /// An array of numbers. A double holds all integers that are of use.
  struct VtkArray
  {
    std::string name;
    std::size_t n_components = 1;
    bool integer             = false;
    std::vector<double> values;
  };

  /// Points and cells as they stand in a file. Those of a cell are in `connectivity`, up to the
  /// entry ends[cell].
  struct VtkPiece
  {
    std::vector<double> points; // three numbers each
    std::vector<double> connectivity, ends, types;
    std::vector<VtkArray> cell_data;

    /// Adds it to what is known of a file; points and cells go on with their numbers. Throws Error,
    /// without the file's name, where the piece contradicts itself.
    void add_to(MeshFile &file, std::uint64_t &n_cells_before) const;

  private:
    void add_cells(MeshFile &file, std::size_t first_node, std::uint64_t before) const;
  };

  /// A file of VTK's legacy format, of which @p text begins with a line "# vtk DataFile ...".
  MeshFile read_legacy_vtk(const std::string &name, std::string_view text);

  /// A file of VTK's XML format for unstructured grids.
  MeshFile read_vtu(const std::string &name, std::string_view text);
} // namespace feib

#endif
