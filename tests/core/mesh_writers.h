// SPDX-License-Identifier: LGPL-2.1-or-later
// Small meshes, and files of other people's kinds that hold them.
#ifndef feib_tests_mesh_writers_h
#define feib_tests_mesh_writers_h

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace feib::testing
{
  enum class Encoding
  {
    ascii,
    native,
    swapped // the bytes of binary numbers
  };

  /// Numbers as text or as bytes.
  struct Numbers
  {
    const Encoding encoding;
    std::string text = "";

    template <typename T>
    Numbers &
    put(const T value)
    {
      if (encoding == Encoding::ascii)
        {
          std::ostringstream number;
          number.precision(17);
          number << +value;
          text += (text.empty() || text.back() == '\n' ? "" : " ") + number.str();
          return *this;
        }
      std::string bytes(sizeof(T), '\0');
      std::memcpy(bytes.data(), &value, sizeof(T));
      if (encoding == Encoding::swapped)
        std::reverse(bytes.begin(), bytes.end());
      text += bytes;
      return *this;
    }

    /// The end of a line, where there are lines.
    Numbers &
    end()
    {
      text += encoding == Encoding::ascii ? "\n" : "";
      return *this;
    }

    Numbers &
    line(const std::string &words)
    {
      text += words + "\n";
      return *this;
    }
  };

  /// A mesh of simplices, to be written. In files of Gmsh nodes are numbered 10, 20, 30, ... and
  /// elements 101, 102, ...
  struct Mesh
  {
    unsigned int m; // dimension of its elements
    std::vector<std::array<double, 3>> nodes;
    std::vector<std::vector<unsigned int>> elements; // indices of nodes
    std::vector<std::vector<int>> groups;            // of each element; empty: none
    std::vector<std::array<double, 3>> fibre = {};   // of each element; empty: no such data
    std::map<int, std::string> names         = {};   // of groups

    Mesh &
    operator+=(const Mesh &other)
    {
      const unsigned int n = nodes.size();
      nodes.insert(nodes.end(), other.nodes.begin(), other.nodes.end());
      for (std::vector<unsigned int> element : other.elements)
        {
          for (unsigned int &node : element)
            node += n;
          elements.push_back(element);
        }
      groups.insert(groups.end(), other.groups.begin(), other.groups.end());
      return *this;
    }

    Mesh
    operator+(const Mesh &other) const
    {
      return Mesh(*this) += other;
    }

    Mesh
    shifted(const std::array<double, 3> &by) const
    {
      Mesh result = *this;
      for (auto &node : result.nodes)
        for (unsigned int a = 0; a < 3; ++a)
          node[a] += by[a];
      return result;
    }

    Mesh
    in_groups(const std::vector<int> &all) const
    {
      Mesh result   = *this;
      result.groups = std::vector<std::vector<int>>(elements.size(), all);
      return result;
    }

    /// With a node in the middle of each edge.
    Mesh
    second_order() const
    {
      Mesh result = *this;
      std::map<std::pair<unsigned int, unsigned int>, unsigned int> middles;
      for (auto &element : result.elements)
        for (unsigned int k = 0; k <= m; ++k)
          for (unsigned int l = 0; l < k; ++l)
            {
              const auto [middle, is_new] =
                middles.try_emplace(std::minmax(element[k], element[l]), result.nodes.size());
              if (is_new)
                {
                  auto place = result.nodes[element[k]];
                  for (unsigned int a = 0; a < 3; ++a)
                    place[a] = (place[a] + result.nodes[element[l]][a]) / 2;
                  result.nodes.push_back(place);
                }
              element.push_back(middle->second);
            }
      return result;
    }

    bool
    of_second_order() const
    {
      return elements[0].size() > m + 1;
    }

    int
    gmsh_type() const
    {
      return of_second_order() ? (m == 3 ? 11 : 7 + int(m)) : (m == 3 ? 4 : int(m));
    }

    int
    vtk_type() const
    {
      return of_second_order() ? (m == 3 ? 24 : 20 + int(m)) : (m == 3 ? 10 : 1 + 2 * int(m));
    }

    std::string
    gmsh_header(const std::string &version, const Encoding encoding) const
    {
      Numbers out{encoding};
      out.line("$MeshFormat").line(version + (encoding == Encoding::ascii ? " 0 8" : " 1 8"));
      if (encoding != Encoding::ascii)
        out.put(1).line("");
      out.line("$EndMeshFormat");
      if (!names.empty())
        {
          out.line("$PhysicalNames").line(std::to_string(names.size()));
          for (const auto &[group, name] : names)
            out.line(std::to_string(m) + " " + std::to_string(group) + " \"" + name + "\"");
          out.line("$EndPhysicalNames");
        }
      return out.text;
    }

    std::string
    gmsh_data(const Encoding encoding) const
    {
      Numbers out{encoding};
      if (!fibre.empty())
        {
          out.line("$ElementData").line("1\n\"the fibre\"\n1\n0.0\n3\n0\n3");
          out.line(std::to_string(elements.size()));
          for (unsigned int e = 0; e < elements.size(); ++e)
            out.put(int(101 + e)).put(fibre[e][0]).put(fibre[e][1]).put(fibre[e][2]).end();
          out.line("$EndElementData");
        }
      return out.text;
    }

    /// Format 2.2 writes an element once for each of its groups.
    std::string
    format_2(const Encoding encoding = Encoding::ascii) const
    {
      const bool ascii = encoding == Encoding::ascii;
      Numbers out{encoding, gmsh_header("2.2", encoding)}, list{encoding};
      out.line("$Nodes").line(std::to_string(nodes.size()));
      for (unsigned int i = 0; i < nodes.size(); ++i)
        out.put(int(10 * (i + 1))).put(nodes[i][0]).put(nodes[i][1]).put(nodes[i][2]).end();
      out.line(ascii ? "$EndNodes" : "\n$EndNodes");
      int n = 0;
      for (unsigned int e = 0; e < elements.size(); ++e)
        for (const int group :
             groups.empty() || groups[e].empty() ? std::vector<int>{0} : groups[e])
          {
            if (ascii)
              list.put(101 + n).put(gmsh_type()).put(2);
            else // blocks of one
              list.put(gmsh_type()).put(1).put(2).put(101 + n);
            list.put(group).put(1);
            for (const unsigned int node : elements[e])
              list.put(int(10 * (node + 1)));
            list.end();
            ++n;
          }
      out.line("$Elements").line(std::to_string(n));
      out.text += list.text;
      out.line(ascii ? "$EndElements" : "\n$EndElements");
      return out.text + gmsh_data(encoding);
    }

    /// One entity for each list of groups.
    std::string
    format_4(const Encoding encoding = Encoding::ascii) const
    {
      using Size       = std::uint64_t;
      const bool ascii = encoding == Encoding::ascii;
      std::map<std::vector<int>, std::vector<unsigned int>> entities;
      for (unsigned int e = 0; e < elements.size(); ++e)
        entities[groups.empty() ? std::vector<int>() : groups[e]].push_back(e);
      Numbers out{encoding, gmsh_header("4.1", encoding)}, list{encoding};
      out.line("$Entities");
      for (unsigned int d = 0; d < 4; ++d)
        out.put(Size(d == m ? entities.size() : 0));
      out.end();
      int tag = 0;
      for (const auto &[in_groups, members] : entities)
        {
          out.put(++tag);
          for (const double coordinate : {0., 0., 0., 1., 1., 1.})
            out.put(coordinate);
          out.put(Size(in_groups.size()));
          for (const int group : in_groups)
            out.put(group);
          out.put(Size(0)).end();
          list.put(int(m)).put(tag).put(gmsh_type()).put(Size(members.size())).end();
          for (const unsigned int e : members)
            {
              list.put(Size(101 + e));
              for (const unsigned int node : elements[e])
                list.put(Size(10 * (node + 1)));
              list.end();
            }
        }
      out.line(ascii ? "$EndEntities" : "\n$EndEntities").line("$Nodes");
      const Size n = nodes.size();
      out.put(Size(1)).put(n).put(Size(10)).put(10 * n).end();
      out.put(int(m)).put(1).put(0).put(n).end();
      for (unsigned int i = 0; i < nodes.size(); ++i)
        out.put(Size(10 * (i + 1))).end();
      for (const auto &node : nodes)
        out.put(node[0]).put(node[1]).put(node[2]).end();
      out.line(ascii ? "$EndNodes" : "\n$EndNodes").line("$Elements");
      out.put(Size(entities.size())).put(Size(elements.size())).put(Size(101));
      out.put(Size(100 + elements.size())).end();
      out.text += list.text;
      out.line(ascii ? "$EndElements" : "\n$EndElements");
      return out.text + gmsh_data(encoding);
    }

    std::vector<std::string>
    texts() const
    {
      return {format_2(), format_4()};
    }
  };

  /// The unit square of n x n cells, two triangles each.
  inline Mesh
  square(const unsigned int n)
  {
    Mesh mesh{2, {}, {}, {}};
    for (unsigned int j = 0; j <= n; ++j)
      for (unsigned int i = 0; i <= n; ++i)
        mesh.nodes.push_back({double(i) / n, double(j) / n, 0});
    for (unsigned int j = 0; j < n; ++j)
      for (unsigned int i = 0; i < n; ++i)
        {
          const unsigned int a = j * (n + 1) + i, b = a + n + 1;
          mesh.elements.push_back({a, a + 1, b + 1});
          mesh.elements.push_back({a, b + 1, b});
        }
    return mesh;
  }

  /// The unit cube: six tetrahedra.
  inline Mesh
  cube()
  {
    Mesh mesh{3, {}, {}, {}};
    for (unsigned int i = 0; i < 8; ++i)
      mesh.nodes.push_back({double(i % 2), double(i / 2 % 2), double(i / 4)});
    for (const auto &[a, b] : std::vector<std::pair<unsigned int, unsigned int>>{
           {1, 3}, {5, 1}, {3, 2}, {2, 6}, {4, 5}, {6, 4}})
      mesh.elements.push_back({0, a, b, 7});
    return mesh;
  }

  /// A regular polygon.
  inline Mesh
  loop(const double radius, const unsigned int n, const bool turned = false)
  {
    Mesh mesh{1, {}, {}, {}};
    for (unsigned int i = 0; i < n; ++i)
      {
        const double angle = 2 * M_PI * i / n;
        mesh.nodes.push_back({radius * std::cos(angle), radius * std::sin(angle), 0});
        if (turned)
          mesh.elements.push_back({(i + 1) % n, i});
        else
          mesh.elements.push_back({i, (i + 1) % n});
      }
    return mesh;
  }

  inline double
  area(const double radius, const unsigned int n)
  {
    return n / 2. * radius * radius * std::sin(2 * M_PI / n);
  }

  /// The surface of a regular tetrahedron of volume 8/3 size^3 about the origin.
  inline Mesh
  surface(const double size, const bool turned = false)
  {
    const double s = size;
    Mesh mesh{2, {{s, s, s}, {s, -s, -s}, {-s, s, -s}, {-s, -s, s}}, {}, {}};
    mesh.elements = {{0, 1, 2}, {0, 3, 1}, {0, 2, 3}, {1, 3, 2}};
    if (turned)
      for (auto &element : mesh.elements)
        std::swap(element[0], element[1]);
    return mesh;
  }

  inline std::string
  replace(std::string text, const std::string &from, const std::string &to)
  {
    const std::size_t place = text.find(from);
    if (place == std::string::npos)
      throw std::logic_error("nothing to replace: " + from);
    return text.replace(place, from.size(), to);
  }
} // namespace feib::testing

#endif
