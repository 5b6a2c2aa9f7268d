// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_gmsh_file_h
#define feib_gmsh_file_h

#include <array>
#include <string>
#include <vector>

namespace feib
{
  /// What a Gmsh file (format 2.2 or 4.1, ASCII) holds of linear simplices.
  struct GmshFile
  {
    /// A segment, triangle or tetrahedron (dimension 1, 2, 3).
    struct Simplex
    {
      std::array<unsigned int, 4> nodes; // dimension + 1 used
      unsigned int material_id;          // the physical group, 0 where there is none
    };

    /// Throws Error, saying what was found, when the file is missing or cannot be read.
    explicit GmshFile(const std::string &file);

    std::vector<std::array<double, 3>> nodes;
    std::array<std::vector<Simplex>, 4> simplices; // by dimension; [0] stays empty
    /// What else it holds, of the highest dimension, e.g. "quadrilaterals"; empty when nothing.
    std::string others;
    unsigned int others_dimension = 0;
  };
} // namespace feib

#endif
