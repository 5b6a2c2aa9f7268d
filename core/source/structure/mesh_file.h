// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_mesh_file_h
#define feib_mesh_file_h

#include <mpi.h>

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <unordered_map>
#include <vector>

namespace feib
{
  /// What a file holds of simplices. Those of higher order are known by their corners alone.
  struct MeshFile
  {
    struct Node
    {
      std::array<double, 3> place;
      std::uint64_t number;
      std::size_t line; // of the file; 0 where it has none
    };

    /// A segment, triangle or tetrahedron (dimension 1, 2, 3).
    struct Simplex
    {
      std::array<unsigned int, 4> nodes; // indices; dimension + 1 used
      int material_id;                   // 0 where there is none
      int entity;                        // that of the geometry, in a file of Gmsh
      std::uint64_t number;
    };

    /// Elements in several physical groups: the first group is kept.
    struct Several
    {
      std::uint64_t count = 0, example = 0; // the number of one of them
      int kept = 0, other = 0;              // its groups
    };

    /// Of the elements: their numbers, and up to three values.
    using Data = std::unordered_map<std::uint64_t, std::array<double, 3>>;

    std::vector<Node> nodes;
    std::array<std::vector<Simplex>, 4> simplices;                // by dimension; [0] stays empty
    std::array<std::uint64_t, 4> n_higher_order{};                // of the simplices, by dimension
    std::array<Several, 4> several;                               // by dimension
    std::array<std::map<std::string, int>, 4> names_of_materials; // by dimension
    std::map<std::string, Data> element_data;                     // by name
    /// What else it holds, of the highest dimension, e.g. "quadrilaterals"; empty when nothing.
    std::string others;
    unsigned int others_dimension = 0;
  };

  /// A file of Gmsh, format 2.2 or 4.1, ASCII or binary of either endianness. Throws Error with the
  /// line (the byte of a binary file), what was found and what is allowed, when the file is
  /// missing, cannot be read, or contradicts itself. Collective: the first rank reads.
  MeshFile read_gmsh_file(const std::string &file, MPI_Comm communicator);

  /// A file of VTK that holds an unstructured grid, of the legacy format, ASCII or binary, or of
  /// the XML format (vtu), ASCII, in base64 or appended, compressed by zlib or not. Points and
  /// cells are numbered from 0. Material ids are the first integer cell data named material,
  /// MaterialID or gmsh:physical. Throws Error and is collective as read_gmsh_file().
  MeshFile read_vtk_file(const std::string &file, MPI_Comm communicator);
} // namespace feib

#endif
