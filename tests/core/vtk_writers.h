// SPDX-License-Identifier: LGPL-2.1-or-later
// Files of VTK's formats that hold a mesh.
#ifndef feib_tests_vtk_writers_h
#define feib_tests_vtk_writers_h

#include "mesh_writers.h"

#include <zlib.h>

namespace feib::testing
{
  /// Legacy files are big endian.
  inline std::string
  legacy_vtk(const Mesh &mesh, const bool binary, const bool version_5 = false)
  {
    Numbers out{binary ? Encoding::swapped : Encoding::ascii};
    const std::string n = std::to_string(mesh.elements.size());
    out.line(std::string("# vtk DataFile Version ") + (version_5 ? "5.1" : "3.0"))
      .line("a title")
      .line(binary ? "BINARY" : "ASCII")
      .line("DATASET UNSTRUCTURED_GRID")
      .line("FIELD FieldData 1")
      .line("TIME 1 1 double")
      .put(.5)
      .line("")
      .line("POINTS " + std::to_string(mesh.nodes.size()) + " double");
    for (const auto &node : mesh.nodes)
      out.put(node[0]).put(node[1]).put(node[2]).end();
    const std::size_t n_points = mesh.elements.size() * mesh.elements[0].size();
    if (version_5)
      {
        out.line("").line("CELLS " + std::to_string(mesh.elements.size() + 1) + " " +
                          std::to_string(n_points));
        out.line("OFFSETS vtktypeint64");
        for (std::size_t e = 0; e <= mesh.elements.size(); ++e)
          out.put(std::int64_t(e * mesh.elements[0].size()));
        out.line("").line("CONNECTIVITY vtktypeint64");
        for (const auto &element : mesh.elements)
          for (const unsigned int node : element)
            out.put(std::int64_t(node));
      }
    else
      {
        out.line("").line("CELLS " + n + " " + std::to_string(n_points + mesh.elements.size()));
        for (const auto &element : mesh.elements)
          {
            out.put(int(element.size()));
            for (const unsigned int node : element)
              out.put(int(node));
            out.end();
          }
      }
    out.line("").line("CELL_TYPES " + n);
    for (std::size_t e = 0; e < mesh.elements.size(); ++e)
      out.put(mesh.vtk_type());
    out.line("").line("POINT_DATA " + std::to_string(mesh.nodes.size()));
    out.line("SCALARS height float 1").line("LOOKUP_TABLE default");
    for (const auto &node : mesh.nodes)
      out.put(float(node[1]));
    out.line("").line("CELL_DATA " + n);
    if (!mesh.groups.empty())
      {
        out.line("SCALARS MaterialID int").line("LOOKUP_TABLE default");
        for (const auto &groups : mesh.groups)
          out.put(groups[0]);
        out.line("");
      }
    if (!mesh.fibre.empty())
      {
        out.line("FIELD FieldData 1").line("the%20fibre 3 " + n + " double");
        for (const auto &fibre : mesh.fibre)
          out.put(fibre[0]).put(fibre[1]).put(fibre[2]);
        out.line("").line("METADATA").line("INFORMATION 0").line("");
      }
    return out.text;
  }

  inline std::string
  in_base64(const std::string &bytes)
  {
    const char *const letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string result;
    for (std::size_t i = 0; i < bytes.size(); i += 3)
      {
        std::uint32_t group = 0;
        for (std::size_t k = 0; k < 3; ++k)
          group =
            group << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0);
        for (std::size_t k = 0; k < 4; ++k)
          result += i + k > bytes.size() ? '=' : letters[group >> (18 - 6 * k) & 63];
      }
    return result;
  }

  /// How a file of VTK's XML format may be written.
  struct Vtu
  {
    enum Where
    {
      ascii,
      inline_base64,
      appended_base64,
      appended_raw
    };
    Where where       = ascii;
    bool compressed   = false;
    bool swapped      = false;
    bool long_headers = false;
    bool one_stream   = false; // of base64, for header and numbers

    std::string appended = ""; // while it is written

    std::string
    text(const Mesh &mesh)
    {
      appended.clear();
      std::string result = std::string("<?xml version=\"1.0\"?>\n<!-- <VTKFile> -->\n") +
                           "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order='" +
                           (swapped ? "BigEndian" : "LittleEndian") + "'" +
                           (long_headers ? " header_type=\"UInt64\"" : "") +
                           (compressed ? " compressor=\"vtkZLibDataCompressor\"" : "") +
                           ">\n<UnstructuredGrid>\n" + piece(mesh) + "</UnstructuredGrid>\n";
      if (where == appended_base64)
        result += "<AppendedData encoding=\"base64\">\n _" + appended + "\n</AppendedData>\n";
      if (where == appended_raw)
        result += "<AppendedData encoding=\"raw\">\n _" + appended + "\n</AppendedData>\n";
      return result + "</VTKFile>\n";
    }

  private:
    Encoding
    encoding() const
    {
      return where == ascii ? Encoding::ascii : swapped ? Encoding::swapped : Encoding::native;
    }

    std::string
    header(const std::vector<std::size_t> &sizes) const
    {
      Numbers out{encoding()};
      for (const std::size_t size : sizes)
        long_headers ? out.put(std::uint64_t(size)) : out.put(std::uint32_t(size));
      return out.text;
    }

    /// Blocks of 40 bytes where they are compressed.
    std::string
    packed(const std::string &bytes) const
    {
      std::string head = header({bytes.size()}), body = bytes;
      if (compressed)
        {
          const std::size_t n_blocks = (bytes.size() + 39) / 40;
          std::vector<std::size_t> sizes{n_blocks, 40, bytes.size() % 40};
          body.clear();
          for (std::size_t b = 0; b < n_blocks; ++b)
            {
              const std::string block = bytes.substr(40 * b, 40);
              std::vector<Bytef> to(compressBound(block.size()));
              uLongf n = to.size();
              compress(to.data(), &n, reinterpret_cast<const Bytef *>(block.data()), block.size());
              sizes.push_back(n);
              body.append(to.begin(), to.begin() + n);
            }
          head = header(sizes);
        }
      if (where == appended_raw)
        return head + body;
      return one_stream ? in_base64(head + body) : in_base64(head) + in_base64(body);
    }

    template <typename T>
    std::string
    array(const std::string &name, const std::vector<T> &values, const unsigned int components = 1)
    {
      const std::string kind = std::is_floating_point_v<T> ? "Float"
                               : std::is_signed_v<T>       ? "Int"
                                                           : "UInt";
      std::string result     = "<DataArray type=\"" + kind + std::to_string(8 * sizeof(T)) +
                           "\" Name=\"" + name + "\" NumberOfComponents=\"" +
                           std::to_string(components) + "\" format=\"" +
                           (where == ascii           ? "ascii"
                            : where == inline_base64 ? "binary"
                                                     : "appended") +
                           "\"";
      Numbers out{encoding()};
      for (const T value : values)
        out.put(value).end();
      if (where == ascii || where == inline_base64)
        return result + ">\n" + (where == ascii ? out.text : packed(out.text)) + "\n</DataArray>\n";
      result += " offset=\"" + std::to_string(appended.size()) + "\"/>\n";
      appended += packed(out.text);
      return result;
    }

    std::string
    piece(const Mesh &mesh)
    {
      std::vector<double> points, fibre;
      for (const auto &node : mesh.nodes)
        points.insert(points.end(), node.begin(), node.end());
      for (const auto &direction : mesh.fibre)
        fibre.insert(fibre.end(), direction.begin(), direction.end());
      std::vector<std::int32_t> ids, nodes;
      std::vector<std::int64_t> ends;
      for (const auto &element : mesh.elements)
        {
          nodes.insert(nodes.end(), element.begin(), element.end());
          ends.push_back(nodes.size());
        }
      for (const auto &groups : mesh.groups)
        ids.push_back(groups[0]);
      std::string result = "<Piece NumberOfPoints=\"" + std::to_string(mesh.nodes.size()) +
                           "\" NumberOfCells=\"" + std::to_string(mesh.elements.size()) + "\">\n";
      result += "<CellData>\n";
      if (!ids.empty())
        result += array("material", ids);
      if (!fibre.empty())
        result += array("the fibre", fibre, 3);
      result += "</CellData>\n<Points>\n" + array("Points", points, 3) + "</Points>\n<Cells>\n";
      result += array("connectivity", nodes) + array("offsets", ends);
      result += array("types", std::vector<std::uint8_t>(ends.size(), mesh.vtk_type()));
      result += "</Cells>\n<PointData>\n" + array("height", points, 3) + "</PointData>\n";
      return result + "</Piece>\n";
    }
  };
} // namespace feib::testing

#endif
