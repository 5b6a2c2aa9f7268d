// SPDX-License-Identifier: LGPL-2.1-or-later
#include "vtk_piece.h"

#include <feib/text_file.h>

#include <feib/error.h>
#include <feib/message.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

namespace feib
{
  namespace
  {
    /// A kind of cells.
    struct Kind
    {
      int type; // VTK's number
      const char *name;
      unsigned int dimension;
      unsigned int n_nodes; // the least
      bool simplex, higher; // of the order; corners come first
    };

    const Kind kinds[] = {
      {1, "points", 0, 1, true, false},          {2, "points", 0, 1, true, false},
      {3, "segments", 1, 2, true, false},        {4, "lines of segments", 1, 2, true, false},
      {5, "triangles", 2, 3, true, false},       {6, "strips of triangles", 2, 3, false, false},
      {7, "polygons", 2, 3, false, false},       {8, "quadrilaterals", 2, 4, false, false},
      {9, "quadrilaterals", 2, 4, false, false}, {10, "tetrahedra", 3, 4, true, false},
      {11, "hexahedra", 3, 8, false, false},     {12, "hexahedra", 3, 8, false, false},
      {13, "prisms", 3, 6, false, false},        {14, "pyramids", 3, 5, false, false},
      {21, "segments", 1, 3, true, true},        {22, "triangles", 2, 6, true, true},
      {23, "quadrilaterals", 2, 8, false, true}, {24, "tetrahedra", 3, 10, true, true},
      {25, "hexahedra", 3, 20, false, true},     {28, "quadrilaterals", 2, 9, false, true},
      {34, "triangles", 2, 7, true, true},       {35, "segments", 1, 4, true, true},
      {68, "segments", 1, 2, true, true},        {69, "triangles", 2, 3, true, true},
      {70, "quadrilaterals", 2, 4, false, true}, {71, "tetrahedra", 3, 4, true, true},
      {75, "segments", 1, 2, true, true},        {76, "triangles", 2, 3, true, true},
      {77, "quadrilaterals", 2, 4, false, true}, {78, "tetrahedra", 3, 4, true, true}};


    std::size_t
    index_below(const double value, const std::size_t bound, const std::string &what)
    {
      if (!(value >= 0 && value < bound) || value != std::floor(value))
        throw Error(what + " " + readable(value) + "; there are " + std::to_string(bound) +
                    (bound > 0 ? ", 0 to " + std::to_string(bound - 1) : ""));
      return value;
    }


    /// The array of material ids, or null.
    const VtkArray *
    materials_of(const VtkPiece &piece)
    {
      for (const char *const name : {"material", "MaterialID", "gmsh:physical"})
        for (const VtkArray &array : piece.cell_data)
          if (array.name == name && array.integer && array.n_components == 1)
            return &array;
      return nullptr;
    }


    /// Of another piece.
    bool
    ghost(const VtkPiece &piece, const std::size_t cell)
    {
      return std::any_of(
        piece.cell_data.begin(), piece.cell_data.end(), [&](const VtkArray &array) {
          return (array.name == "vtkGhostType" || array.name == "vtkGhostLevels") &&
                 array.n_components == 1 && array.values[cell] != 0;
        });
    }


    int
    material_id(const VtkArray &array, const std::size_t cell)
    {
      const double id = array.values[cell];
      if (!(std::abs(id) < 2147483648.))
        throw Error("cell " + std::to_string(cell) + " has the material " + readable(id) +
                    " in the array \"" + array.name + "\"; ids are 0, 1, 2, ...");
      // Gmsh lists surfaces turned round by their negative number.
      return array.name == "gmsh:physical" ? std::abs(int(id)) : int(id);
    }


    void
    add_points(const VtkPiece &piece, MeshFile &file)
    {
      if (piece.points.size() % 3 != 0)
        throw Error("its points have " + std::to_string(piece.points.size()) +
                    " coordinates; each has three");
      for (std::size_t i = 0; i < piece.points.size(); i += 3)
        {
          MeshFile::Node node{{{piece.points[i], piece.points[i + 1], piece.points[i + 2]}},
                              file.nodes.size(),
                              0};
          for (const double coordinate : node.place)
            if (!std::isfinite(coordinate))
              throw Error("point " + std::to_string(node.number) + " has the coordinate " +
                          readable(coordinate) + "; it must be finite");
          file.nodes.push_back(node);
        }
    }


    void
    add_cell(const Kind &kind,
             const std::vector<unsigned int> &nodes,
             const int material_id,
             const std::uint64_t number,
             MeshFile &file)
    {
      if (!kind.simplex && kind.dimension > file.others_dimension)
        {
          file.others = kind.name ? kind.name : "cells of VTK's type " + std::to_string(kind.type);
          file.others_dimension = kind.dimension;
        }
      if (!kind.simplex || kind.dimension == 0)
        return;
      const bool line = kind.type == 4;
      for (std::size_t k = 0; k + 1 < (line ? nodes.size() : 2); ++k)
        {
          MeshFile::Simplex simplex{{}, material_id, 0, number};
          std::copy_n(nodes.begin() + k, kind.dimension + 1, simplex.nodes.begin());
          file.simplices[kind.dimension].push_back(simplex);
        }
      file.n_higher_order[kind.dimension] += kind.higher;
    }


    void
    add_data(const VtkArray &array, const std::uint64_t before, MeshFile &file)
    {
      const std::size_t n = array.n_components;
      if (n > 3)
        return;
      MeshFile::Data &data = file.element_data[array.name];
      for (std::size_t cell = 0; cell * n < array.values.size(); ++cell)
        std::copy_n(array.values.begin() + cell * n, n, data[before + cell].begin());
    }
  } // namespace


  double
  VtkNumber::value(const char *const bytes, const bool swapped) const
  {
    std::array<char, 8> b;
    for (std::size_t i = 0; i < size; ++i)
      b[swapped ? size - 1 - i : i] = bytes[i];
    const auto as = [&](auto number) {
      std::memcpy(&number, b.data(), sizeof(number));
      return double(number);
    };
    if (!integer)
      return size == 4 ? as(float()) : as(double());
    switch (size)
      {
        case 1:
          return negative ? as(std::int8_t()) : as(std::uint8_t());
        case 2:
          return negative ? as(std::int16_t()) : as(std::uint16_t());
        case 4:
          return negative ? as(std::int32_t()) : as(std::uint32_t());
        default:
          return negative ? as(std::int64_t()) : as(std::uint64_t());
      }
  }


  void
  VtkPiece::add_to(MeshFile &file, std::uint64_t &n_cells_before) const
  {
    const std::size_t n_cells = ends.size(), first_node = file.nodes.size();
    add_points(*this, file);
    if (types.size() != n_cells)
      throw Error("it has " + std::to_string(n_cells) + " cells and the types of " +
                  std::to_string(types.size()));
    for (const VtkArray &array : cell_data)
      if (array.n_components == 0 || array.values.size() % array.n_components != 0 ||
          array.values.size() / array.n_components != n_cells)
        throw Error("the array \"" + readable(array.name, 30) + "\" has " +
                    std::to_string(array.values.size()) + " numbers for " +
                    std::to_string(n_cells) + " cells of " + std::to_string(array.n_components) +
                    " numbers each");
    add_cells(file, first_node, n_cells_before);
    for (const VtkArray &array : cell_data)
      add_data(array, n_cells_before, file);
    n_cells_before += n_cells;
  }


  void
  VtkPiece::add_cells(MeshFile &file,
                      const std::size_t first_node,
                      const std::uint64_t before) const
  {
    const VtkArray *const materials = materials_of(*this);
    std::size_t begin               = 0;
    for (std::size_t cell = 0; cell < ends.size(); ++cell)
      {
        const std::string the_cell = "cell " + std::to_string(before + cell);
        const std::size_t end      = index_below(ends[cell],
                                            connectivity.size() + 1,
                                            the_cell + " ends in the list of points at");
        if (end < begin)
          throw Error(the_cell + " ends before it begins in the list of points");
        const int type   = index_below(types[cell], 256, the_cell + " is of the type");
        const auto *kind = std::find_if(std::begin(kinds), std::end(kinds), [&](const Kind &k) {
          return k.type == type;
        });
        const bool known = kind != std::end(kinds);
        std::vector<unsigned int> nodes;
        for (; begin < end; ++begin)
          nodes.push_back(first_node + index_below(connectivity[begin],
                                                   points.size() / 3,
                                                   the_cell + " has the point"));
        if (known && nodes.size() < kind->n_nodes)
          throw Error(the_cell + " of the " + kind->name + " has " + std::to_string(nodes.size()) +
                      " points, " + std::to_string(kind->n_nodes) + " are needed");
        if (type > 0 && !ghost(*this, cell))
          add_cell(known ? *kind : Kind{type, nullptr, 3, 0, false, false},
                   nodes,
                   materials ? material_id(*materials, cell) : 0,
                   before + cell,
                   file);
      }
  }


  MeshFile
  read_vtk_file(const std::string &file, const MPI_Comm communicator)
  {
    const std::string name = readable(file), named = "file \"" + name + "\"";
    const std::string text = read_text_file(file, named, true, communicator);
    const std::string mark = "# vtk DataFile";
    if (text.compare(0, mark.size(), mark) == 0)
      return read_legacy_vtk(name, text);
    // After a byte order mark, maybe.
    const std::size_t first = text.find_first_not_of(" \t\r\n\xEF\xBB\xBF");
    if (first != text.npos && text[first] == '<')
      return read_vtu(name, text);
    throw Error(
      named + ", line 1: " +
      (first == text.npos
         ? "the file is empty"
         : "found \"" + readable(text.substr(first, text.find('\n', first) - first), 30) + "\"") +
      "; Feib reads VTK's legacy format, whose first line is \"# vtk DataFile Version "
      "...\", and its XML format for unstructured grids, which begins with <VTKFile");
  }
} // namespace feib
