// SPDX-License-Identifier: LGPL-2.1-or-later
#include "file_scanner.h"
#include "vtk_piece.h"

#include <feib/error.h>
#include <feib/message.h>

#include <cctype>
#include <cmath>
#include <cstdlib>
#include <limits>

namespace feib
{
  namespace
  {
    bool
    big_endian()
    {
      const std::uint16_t one = 1;
      char first;
      std::memcpy(&first, &one, 1);
      return first == 0;
    }


    std::string
    capital(const std::string_view word)
    {
      std::string result(word);
      for (char &c : result)
        c = std::toupper(static_cast<unsigned char>(c));
      return result;
    }


    /// Spaces in names are written as %20.
    std::string
    decoded(const std::string_view word)
    {
      std::string result;
      for (std::size_t i = 0; i < word.size(); ++i)
        if (word[i] == '%' && i + 2 < word.size() && std::isxdigit(word[i + 1]) &&
            std::isxdigit(word[i + 2]))
          {
            result += char(std::strtol(std::string(word.substr(i + 1, 2)).c_str(), nullptr, 16));
            i += 2;
          }
        else
          result += word[i];
      return result;
    }


    class Reader
    {
    public:
      Reader(const std::string &name, const std::string_view text)
        : in(name, text)
      {
        read_header();
        while (in.find_word())
          {
            in.section             = "the file";
            const std::string word = capital(in.word());
            in.section             = readable(word, 30);
            if (!read_cells(word) && !read_attribute(word))
              in.fail(
                "found " + in.quoted(word) +
                " where a part of an unstructured grid (POINTS, CELLS, CELL_TYPES, "
                "CELL_DATA, ...) is expected: what precedes it holds more than its counts say, "
                "or less");
          }
      }

      VtkPiece piece;

    private:
      struct Type
      {
        const char *name;
        VtkNumber number;
      };

      VtkNumber
      number_of(const std::string &type) const
      {
        static const Type types[] = {{"unsigned_char", {1, true, false}},
                                     {"char", {1, true, true}},
                                     {"signed_char", {1, true, true}},
                                     {"unsigned_short", {2, true, false}},
                                     {"short", {2, true, true}},
                                     {"unsigned_int", {4, true, false}},
                                     {"int", {4, true, true}},
                                     {"vtkidtype", {4, true, true}}, // so it is written
                                     {"unsigned_long", {8, true, false}},
                                     {"long", {8, true, true}},
                                     {"vtktypeint64", {8, true, true}},
                                     {"vtktypeuint64", {8, true, false}},
                                     {"bit", {1, true, false}},
                                     {"float", {4, false, true}},
                                     {"double", {8, false, true}}};
        for (const Type &known : types)
          if (capital(type) == capital(known.name))
            return known.number;
        in.fail("found numbers of the type " + in.quoted(type) + " in " + in.section +
                "; Feib reads int, float, double and the like");
      }

      std::size_t
      count()
      {
        return in.number<std::size_t>("a count");
      }

      void
      read_header()
      {
        const std::string first(in.next_line());
        major = std::atoi(first.substr(std::min(first.size(), first.find("Version") + 8)).c_str());
        in.next_line(); // title
        in.section                 = "the file";
        const std::string encoding = capital(in.word());
        if (encoding != "ASCII" && encoding != "BINARY")
          in.fail("found " + in.quoted(encoding) + " where ASCII or BINARY is expected");
        const std::string dataset = capital(in.word()), kind = capital(in.word());
        if (dataset != "DATASET" || kind != "UNSTRUCTURED_GRID")
          in.fail("found " + in.quoted(dataset + " " + kind) +
                  "; Feib reads DATASET UNSTRUCTURED_GRID");
        in.binary  = encoding == "BINARY";
        in.swapped = !big_endian();
      }

      /// The numbers that follow the line.
      VtkArray
      array(const std::string_view type, const std::size_t n_tuples, const std::size_t n)
      {
        VtkArray result;
        result.n_components = n;
        if (n > 0 && n_tuples > std::numeric_limits<std::size_t>::max() / n)
          in.fail("the file ends inside " + in.section);
        const std::size_t size = n_tuples * n;
        if (in.binary && capital(type) == "BIT")
          {
            // Eight of them in a byte; nobody needs them here.
            in.end_line();
            in.take(size / 8 + (size % 8 > 0), 1);
            result.n_components = 0;
            return result;
          }
        const VtkNumber number = number_of(std::string(type));
        result.integer         = number.integer;
        if (!in.binary)
          {
            for (std::size_t i = 0; i < size; ++i)
              result.values.push_back(in.real(false));
            return result;
          }
        in.end_line();
        const std::string_view bytes = in.take(size, number.size);
        result.values.reserve(size);
        for (std::size_t i = 0; i < size; ++i)
          result.values.push_back(number.value(bytes.data() + i * number.size, in.swapped));
        return result;
      }

      bool
      read_cells(const std::string &word)
      {
        if (word == "POINTS")
          {
            const std::size_t n = count();
            piece.points        = array(in.word(), n, 3).values;
          }
        else if (word == "CELLS")
          major >= 5 ? read_offsets() : read_lists();
        else if (word == "CELL_TYPES")
          piece.types = array("int", count(), 1).values;
        else
          return false;
        return true;
      }

      /// Version 5: ends, with a zero before, and points.
      void
      read_offsets()
      {
        const std::size_t n = count(), n_points = count();
        const auto list = [&](const std::string &name, const std::size_t size) {
          if (const std::string found = capital(in.word()); found != name)
            in.fail("found " + in.quoted(found) + " where " + name + " is expected");
          return array(in.word(), size, 1).values;
        };
        piece.ends = list("OFFSETS", n);
        if (!piece.ends.empty())
          piece.ends.erase(piece.ends.begin());
        piece.connectivity = list("CONNECTIVITY", n_points);
      }

      /// Before: for each cell, how many points it has, and these.
      void
      read_lists()
      {
        const std::size_t n = count(), size = count();
        const std::vector<double> list = array("int", size, 1).values;
        piece.connectivity.clear();
        piece.ends.clear();
        std::size_t at = 0;
        for (std::size_t cell = 0; cell < n; ++cell)
          {
            if (at == size || !(list[at] >= 0 && list[at] < size - at) ||
                list[at] != std::floor(list[at]))
              in.fail("CELLS holds fewer numbers than its " + std::to_string(n) +
                      " cells say: the list ends with cell " + std::to_string(cell));
            const std::size_t n_points = list[at++];
            piece.connectivity.insert(piece.connectivity.end(),
                                      list.begin() + at,
                                      list.begin() + at + n_points);
            piece.ends.push_back(piece.connectivity.size());
            at += n_points;
          }
        if (at != size)
          in.fail("CELLS holds more numbers than its " + std::to_string(n) + " cells say");
      }

      void
      keep(const std::string &name, VtkArray data)
      {
        data.name = name;
        if (of_cells && data.n_components > 0)
          piece.cell_data.push_back(std::move(data));
      }

      void
      read_scalars()
      {
        const std::string name = decoded(in.word()), type(in.word());
        const std::string more(in.rest_of_line());
        const std::size_t n = std::strtoul(more.c_str(), nullptr, 10);
        if (const std::string found = capital(in.word()); found != "LOOKUP_TABLE")
          in.fail("found " + in.quoted(found) + " where LOOKUP_TABLE is expected");
        in.word(); // its name
        keep(name, array(type, n_tuples, n > 0 ? n : 1));
      }

      void
      read_field()
      {
        in.word(); // its name
        for (std::size_t n = count(); n > 0; --n)
          {
            const std::string name         = decoded(in.word());
            const std::size_t n_components = count(), n_of_array = count();
            keep(name, array(in.word(), n_of_array, n_components));
            if (in.find("METADATA"))
              pass_lines();
          }
      }

      /// Up to an empty line.
      void
      pass_lines()
      {
        in.next_line();
        while (in.next_line().find_first_not_of(" \t\r") != std::string_view::npos)
          ;
      }

      bool
      read_attribute(const std::string &word)
      {
        if (word == "CELL_DATA" || word == "POINT_DATA")
          {
            of_cells = word == "CELL_DATA";
            n_tuples = count();
          }
        else if (word == "FIELD")
          read_field();
        else if (word == "SCALARS")
          read_scalars();
        else if (word == "VECTORS" || word == "NORMALS" || word == "TENSORS" ||
                 word == "TENSORS6" || word == "GLOBAL_IDS" || word == "PEDIGREE_IDS")
          {
            const std::string name = decoded(in.word()), type(in.word());
            const std::size_t n    = word == "TENSORS"                        ? 9
                                     : word == "TENSORS6"                     ? 6
                                     : word == "VECTORS" || word == "NORMALS" ? 3
                                                                              : 1;
            keep(name, array(type, n_tuples, n));
          }
        else if (word == "TEXTURE_COORDINATES")
          {
            const std::string name = decoded(in.word());
            const std::size_t n    = count();
            keep(name, array(in.word(), n_tuples, n));
          }
        else if (word == "COLOR_SCALARS" || word == "LOOKUP_TABLE")
          {
            in.word(); // its name
            const std::size_t n = count();
            array(in.binary ? "unsigned_char" : "float", word == "LOOKUP_TABLE" ? 4 : n_tuples, n);
          }
        else if (word == "METADATA")
          pass_lines();
        else
          return false;
        return true;
      }

      FileScanner in;
      int major            = 0; // of the version
      bool of_cells        = false;
      std::size_t n_tuples = 0;
    };
  } // namespace


  MeshFile
  read_legacy_vtk(const std::string &name, const std::string_view text)
  {
    const Reader reader(name, text);
    MeshFile result;
    std::uint64_t n_cells = 0;
    try
      {
        reader.piece.add_to(result, n_cells);
      }
    catch (const Error &error)
      {
        throw Error("file \"" + name + "\": " + error.issues().front().message);
      }
    return result;
  }
} // namespace feib
