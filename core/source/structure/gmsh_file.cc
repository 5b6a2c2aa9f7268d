// SPDX-License-Identifier: LGPL-2.1-or-later
#include "file_scanner.h"
#include "mesh_file.h"

#include <feib/message.h>
#include <feib/text_file.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <unordered_set>

namespace feib
{
  namespace
  {
    const char *const formats =
      "Feib reads files of the formats 2.2 and 4.1, ASCII and binary (Mesh.MshFileVersion)";

    /// A kind of elements.
    struct Kind
    {
      int type; // Gmsh's number
      const char *name;
      unsigned int dimension, n_nodes;
      bool simplex; // its corners come first
      unsigned int order;
    };

    const Kind kinds[] = {{15, "points", 0, 1, true, 1},
                          {1, "segments", 1, 2, true, 1},
                          {8, "segments of second order", 1, 3, true, 2},
                          {26, "segments of third order", 1, 4, true, 3},
                          {27, "segments of fourth order", 1, 5, true, 4},
                          {28, "segments of fifth order", 1, 6, true, 5},
                          {2, "triangles", 2, 3, true, 1},
                          {9, "triangles of second order", 2, 6, true, 2},
                          {20, "triangles of third order", 2, 9, true, 3},
                          {21, "triangles of third order", 2, 10, true, 3},
                          {22, "triangles of fourth order", 2, 12, true, 4},
                          {23, "triangles of fourth order", 2, 15, true, 4},
                          {24, "triangles of fifth order", 2, 15, true, 5},
                          {25, "triangles of fifth order", 2, 21, true, 5},
                          {4, "tetrahedra", 3, 4, true, 1},
                          {11, "tetrahedra of second order", 3, 10, true, 2},
                          {29, "tetrahedra of third order", 3, 20, true, 3},
                          {30, "tetrahedra of fourth order", 3, 35, true, 4},
                          {31, "tetrahedra of fifth order", 3, 56, true, 5},
                          {3, "quadrilaterals", 2, 4, false, 1},
                          {10, "quadrilaterals", 2, 9, false, 2},
                          {16, "quadrilaterals", 2, 8, false, 2},
                          {5, "hexahedra", 3, 8, false, 1},
                          {12, "hexahedra", 3, 27, false, 2},
                          {17, "hexahedra", 3, 20, false, 2},
                          {6, "prisms", 3, 6, false, 1},
                          {13, "prisms", 3, 18, false, 2},
                          {18, "prisms", 3, 15, false, 2},
                          {7, "pyramids", 3, 5, false, 1},
                          {14, "pyramids", 3, 14, false, 2},
                          {19, "pyramids", 3, 13, false, 2}};


    // Why not deal.II's GridIn: it refuses marked lines and faces inside a body, and cannot say
    // what a file of the wrong dimension holds instead.
    class Reader
    {
    public:
      Reader(const std::string &name, const std::string &text, MeshFile &result)
        : in(name, text)
        , result(result)
      {
        read();
        for (unsigned int m = 1; m < 4; ++m)
          join_groups(m);
      }

    private:
      /// A number of the parts of a file that are binary in a binary file.
      template <typename T>
      T
      get(const char *const what)
      {
        return in.binary ? in.item<T>() : in.number<T>(what);
      }

      template <typename T>
      void
      skip(const std::size_t n)
      {
        if (in.binary)
          in.take(n, sizeof(T));
        else
          in.skip_words(n);
      }

      /// In format 2.2 all counts are text.
      std::size_t
      count()
      {
        return in.binary && version == 4.1 ? in.item<std::uint64_t>()
                                           : in.number<std::size_t>("a count");
      }

      /// The number of a node or element.
      std::uint64_t
      tag(const char *const what)
      {
        if (!in.binary || version == 4.1)
          return get<std::uint64_t>(what);
        const int result = in.item<int>();
        if (result < 0)
          in.fail("found " + std::to_string(result) + " in " + in.section + " where " + what +
                  " is expected");
        return result;
      }

      int
      group(const char *const what)
      {
        const int found = get<int>(what);
        if (found == std::numeric_limits<int>::min())
          in.fail("found " + std::to_string(found) + " in " + in.section + " where " + what +
                  " is expected");
        return std::abs(found);
      }

      double
      real()
      {
        const double value = in.binary ? in.item<double>() : in.real();
        if (!std::isfinite(value))
          in.fail("found \"" + readable(value) + "\" in " + in.section +
                  " where a finite number is expected");
        return value;
      }

      void
      read()
      {
        if (!in.find_word())
          in.fail("the file is empty; " + std::string(formats));
        while (in.find_word())
          {
            in.section = "the file";
            const std::string header(in.word());
            if (header[0] != '$')
              in.fail("found " + in.quoted(header) + " where a section ($...) is expected; " +
                      formats);
            in.section = readable(header, 30);
            if (header != "$MeshFormat" && version == 0)
              in.fail("found " + in.quoted(header) + " where $MeshFormat is expected; " + formats);
            const std::string end = "$End" + header.substr(1);
            if (!read_section(header))
              {
                // Binary numbers are no words.
                if (in.binary)
                  in.skip_to(end);
                else
                  while (in.word() != end)
                    ;
              }
            else if (const auto found = in.word(); found != end)
              in.fail("found " + in.quoted(found) + " where " + end +
                      " is expected: " + in.section + " holds more than its counts say");
          }
      }

      /// Whether it is one of those that say something about structures.
      bool
      read_section(const std::string &header)
      {
        if (header == "$MeshFormat")
          read_format();
        else if (header == "$PhysicalNames")
          read_names();
        else if (header == "$Entities" || header == "$PartitionedEntities")
          read_entities(header == "$PartitionedEntities");
        else if (header == "$Nodes")
          version == 2.2 ? read_nodes_2() : read_nodes_4();
        else if (header == "$Elements")
          version == 2.2 ? read_elements_2() : read_elements_4();
        else if (header == "$ElementData")
          read_element_data();
        else
          return false;
        return true;
      }

      void
      read_format()
      {
        const double found       = in.real();
        const auto type          = in.number<int>("0 for ASCII or 1 for binary");
        const std::size_t n_size = in.number<std::size_t>("the size of a number");
        if ((found != 2.2 && found != 4.1) || type < 0 || type > 1)
          in.fail("the file is of format " + readable(found) +
                  (type == 0   ? ""
                   : type == 1 ? ", binary"
                               : ", type " + std::to_string(type)) +
                  "; " + formats);
        version = found;
        if (type == 0)
          return;
        if (n_size != 8)
          in.fail("the numbers of the binary file have " + std::to_string(n_size) +
                  " bytes; Feib reads those of 8");
        in.end_line();
        in.binary      = true;
        const auto one = in.item<std::uint32_t>();
        in.swapped     = one == 0x01000000;
        if (one != 1 && !in.swapped)
          in.fail("the file is binary, and its first number should be 1, of either endianness; "
                  "found " +
                  std::to_string(one));
      }

      /// The text between quotes that a line ends with.
      std::string
      text_in_line()
      {
        in.find_word();
        std::string text(in.rest_of_line());
        text.erase(text.find_last_not_of(" \t\r") + 1);
        return text.size() > 1 && text.front() == '"' && text.back() == '"'
                 ? text.substr(1, text.size() - 2)
                 : text;
      }

      /// Text in binary files too.
      void
      read_names()
      {
        for (auto n = in.number<std::size_t>("a count"); n > 0; --n)
          {
            const auto dimension   = in.number<unsigned int>("the dimension of a physical group");
            const int group        = in.number<int>("a physical group");
            const std::string name = text_in_line();
            if (dimension > 3)
              in.fail("found a physical group of dimension " + std::to_string(dimension));
            const auto known = result.names_of_materials[dimension].try_emplace(name, group).first;
            if (known->second != group)
              in.fail("two physical groups of dimension " + std::to_string(dimension) +
                      " have the name " + in.quoted(name) + ", " + std::to_string(known->second) +
                      " and " + std::to_string(group));
          }
      }

      /// A section holds one view of Gmsh: of several times the last one counts, of more than three
      /// components (tensors) none. What precedes the values is text in binary files too.
      void
      read_element_data()
      {
        const auto text_count = [&] { return in.number<std::size_t>("a count"); };
        std::string view;
        for (std::size_t n = text_count(), i = 0; i < n; ++i)
          {
            const std::string text = text_in_line();
            if (i == 0)
              view = text;
            else if (text.empty() && !in.find_word())
              in.fail("the file ends inside " + in.section);
          }
        in.skip_words(text_count());
        const std::size_t n_integers = text_count();
        if (n_integers < 3)
          in.fail("$ElementData has three integers or more, the third is the number of its "
                  "elements; found " +
                  std::to_string(n_integers));
        in.skip_words(1);
        const std::size_t n_components = text_count(), n_elements = text_count();
        in.skip_words(n_integers - 3);
        if (in.binary)
          in.end_line();
        MeshFile::Data data;
        for (std::size_t e = 0; e < n_elements; ++e)
          {
            const auto number             = in.binary ? std::uint64_t(in.item<std::uint32_t>())
                                                      : in.number<std::uint64_t>("the number of an element");
            std::array<double, 3> &values = data[number];
            for (std::size_t c = 0; c < n_components; ++c)
              {
                const double value = real();
                if (c < 3)
                  values[c] = value;
              }
          }
        if (n_components <= 3)
          result.element_data[view] = std::move(data);
      }

      /// Elements of a partitioned file belong to parts of entities, which have the groups.
      void
      read_entities(const bool partitioned)
      {
        entities_listed = true;
        if (in.binary)
          in.end_line();
        if (partitioned)
          {
            skip<std::uint64_t>(1);
            const std::size_t n_ghosts = count();
            for (std::size_t i = 0; i < n_ghosts; ++i)
              skip<int>(2);
          }
        std::array<std::size_t, 4> n;
        for (std::size_t &n_of_dimension : n)
          n_of_dimension = count();
        for (unsigned int dimension = 0; dimension < 4; ++dimension)
          for (std::size_t i = 0; i < n[dimension]; ++i)
            {
              const auto tag = get<int>("the number of an entity");
              if (partitioned)
                {
                  skip<int>(2); // dimension and tag of the whole
                  skip<int>(count());
                }
              skip<double>(dimension == 0 ? 3 : 6); // place
              std::vector<int> &groups = groups_of[{dimension, tag}];
              groups.clear();
              const std::size_t n_groups = count();
              for (std::size_t g = 0; g < n_groups; ++g)
                groups.push_back(group("a physical group"));
              if (dimension > 0)
                skip<int>(count());
            }
      }

      void
      add_node(const std::uint64_t tag)
      {
        MeshFile::Node node;
        node.number = tag;
        for (double &coordinate : node.place)
          coordinate = real();
        ++n_nodes;
        // Some programs write a node once for each entity that it belongs to.
        const auto [known, is_new] = index.try_emplace(tag, result.nodes.size());
        if (!is_new && result.nodes[known->second].place != node.place)
          in.fail("node " + std::to_string(tag) + " stands here a second time, at another place");
        if (!is_new)
          return;
        node.line = in.binary ? 0 : in.line;
        result.nodes.push_back(node);
      }

      void
      read_nodes_2()
      {
        std::size_t n = count();
        if (in.binary)
          in.end_line();
        for (; n > 0; --n)
          add_node(tag("the number of a node"));
      }

      void
      read_nodes_4()
      {
        if (in.binary)
          in.end_line();
        const std::size_t n_blocks = count(), n_all = count();
        skip<std::uint64_t>(2);
        for (std::size_t b = 0; b < n_blocks; ++b)
          {
            const auto dimension = get<unsigned int>("the dimension of an entity");
            skip<int>(1);
            const bool parametric = get<int>("0 or 1") != 0;
            // The count is not believed: memory grows with what is read.
            std::vector<std::uint64_t> tags;
            for (std::size_t n = count(); n > 0; --n)
              tags.push_back(tag("the number of a node"));
            for (const std::uint64_t tag : tags)
              {
                add_node(tag);
                if (parametric)
                  skip<double>(dimension);
              }
          }
        check_total(n_all, n_nodes);
      }

      void
      check_total(const std::size_t said, const std::size_t there) const
      {
        if (said != there)
          in.fail(in.section + " says that it holds " + std::to_string(said) +
                  ", its blocks hold " + std::to_string(there));
      }

      std::uint64_t
      element_number()
      {
        const auto number = tag("the number of an element");
        if (!elements.insert(number).second)
          in.fail("element " + std::to_string(number) + " stands here a second time");
        return number;
      }

      /// Those whose kind is not known are to be left out, which a line can be.
      Kind
      kind_of(const int type) const
      {
        for (const Kind &kind : kinds)
          if (kind.type == type)
            return kind;
        if (in.binary)
          in.fail("found elements of Gmsh type " + std::to_string(type) +
                  ", which Feib does not know");
        return {type, nullptr, 3, 0, false, 1};
      }

      /// What is no simplex.
      void
      pass_over(const Kind &kind)
      {
        if (in.binary)
          version == 2.2 ? skip<int>(kind.n_nodes) : skip<std::uint64_t>(kind.n_nodes);
        else
          in.rest_of_line();
        if (kind.dimension <= result.others_dimension)
          return;
        result.others =
          kind.name ? kind.name : "elements of Gmsh type " + std::to_string(kind.type);
        result.others_dimension = kind.dimension;
      }

      /// Takes the rest of the line: the nodes of an element.
      void
      add_element(const Kind &kind, MeshFile::Simplex simplex)
      {
        if (!kind.simplex)
          {
            pass_over(kind);
            return;
          }
        const std::size_t first_line = in.line;
        const auto said              = [&] {
          return "element " + std::to_string(simplex.number) + " of the " + kind.name + " needs " +
                 std::to_string(kind.n_nodes) + " nodes, ";
        };
        for (unsigned int k = 0; k < kind.n_nodes; ++k)
          {
            if (!in.binary && in.find_word() && in.line != first_line)
              {
                in.line = first_line;
                in.fail(said() + "found " + std::to_string(k));
              }
            const auto number = tag("the number of a node");
            const auto found  = index.find(number);
            if (found == index.end())
              in.fail("element " + std::to_string(simplex.number) + " has node " +
                      std::to_string(number) + ", which does not exist");
            if (k <= kind.dimension)
              simplex.nodes[k] = found->second;
          }
        if (!in.binary)
          if (const auto more = in.rest_of_line(); more.find_first_not_of(" \t\r\v\f") != more.npos)
            in.fail(said() + "found more: " + in.quoted(more));
        if (kind.dimension > 0)
          result.simplices[kind.dimension].push_back(simplex);
        result.n_higher_order[kind.dimension] += kind.order > 1;
      }

      void
      add_tagged_element(const Kind &kind, const std::size_t n_tags, const std::uint64_t number)
      {
        MeshFile::Simplex simplex{{}, 0, 0, number};
        for (std::size_t t = 0; t < n_tags; ++t)
          {
            if (t == 0)
              simplex.material_id = group("a physical group");
            else if (const int tag = get<int>("a tag of an element"); t == 1)
              simplex.entity = tag;
          }
        add_element(kind, simplex);
      }

      /// In binary files, blocks of elements of one kind.
      void
      read_elements_2()
      {
        std::size_t n = count();
        if (in.binary)
          in.end_line();
        while (n > 0)
          {
            if (!in.binary)
              {
                --n;
                const std::uint64_t number = element_number();
                const Kind kind            = kind_of(in.number<int>("the type of an element"));
                add_tagged_element(kind, count(), number);
                continue;
              }
            const Kind kind          = kind_of(in.item<int>());
            const auto n_of_block    = in.item<std::uint32_t>();
            const std::size_t n_tags = in.item<std::uint32_t>();
            if (n_of_block == 0 || n_of_block > n)
              in.fail("found a block of " + std::to_string(n_of_block) +
                      " elements in $Elements where 1 to " + std::to_string(n) + " are left");
            n -= n_of_block;
            for (std::size_t e = 0; e < n_of_block; ++e)
              add_tagged_element(kind, n_tags, element_number());
          }
      }

      void
      read_elements_4()
      {
        if (in.binary)
          in.end_line();
        const std::size_t n_blocks = count(), n_all = count();
        skip<std::uint64_t>(2);
        for (std::size_t b = 0; b < n_blocks; ++b)
          {
            const auto dimension = get<unsigned int>("the dimension of an entity");
            const auto entity    = get<int>("the number of an entity");
            const Kind kind      = kind_of(get<int>("the type of elements"));
            if (kind.simplex && kind.dimension != dimension)
              in.fail(std::string(kind.name) + " belong to an entity of dimension " +
                      std::to_string(kind.dimension) + ", found one of dimension " +
                      std::to_string(dimension));
            const auto groups = groups_of.find({dimension, entity});
            if (entities_listed && groups == groups_of.end())
              in.fail((kind.name ? std::string(kind.name)
                                 : "elements of Gmsh type " + std::to_string(kind.type)) +
                      " belong to the entity " + std::to_string(entity) + " of dimension " +
                      std::to_string(dimension) + ", which $Entities does not list");
            const bool grouped = groups != groups_of.end() && !groups->second.empty();
            for (std::size_t n = count(); n > 0; --n)
              {
                const std::uint64_t tag = element_number();
                add_element(kind, {{}, grouped ? groups->second[0] : 0, entity, tag});
                if (grouped && groups->second.size() > 1 && kind.simplex)
                  add_several(dimension, tag, groups->second[0], groups->second[1]);
              }
          }
        check_total(n_all, elements.size());
      }

      void
      add_several(const unsigned int dimension,
                  const std::uint64_t element,
                  const int kept,
                  const int other)
      {
        MeshFile::Several &several = result.several[dimension];
        if (several.count++ == 0)
          several = {1, element, kept, other};
      }

      /// Format 2.2 writes an element once for each of its groups: one is kept, the first.
      void
      join_groups(const unsigned int dimension)
      {
        auto &simplices = result.simplices[dimension];
        const auto key  = [&](const unsigned int e) {
          std::array<unsigned int, 4> nodes = simplices[e].nodes;
          std::sort(nodes.begin(), nodes.begin() + dimension + 1);
          return nodes;
        };
        struct First
        {
          unsigned int element;
          bool repeated;
        };
        std::map<std::array<unsigned int, 4>, First> firsts;
        std::vector<MeshFile::Simplex> kept;
        for (unsigned int e = 0; e < simplices.size(); ++e)
          {
            const auto [place, is_new]     = firsts.try_emplace(key(e), First{e, false});
            First &first                   = place->second;
            const MeshFile::Simplex &known = simplices[first.element], &now = simplices[e];
            // An element repeated in one group, or by another entity, is not meant.
            if (is_new || now.material_id == known.material_id || now.entity != known.entity)
              kept.push_back(now);
            else if (!first.repeated)
              {
                first.repeated = true;
                add_several(dimension, known.number, known.material_id, now.material_id);
              }
          }
        simplices = std::move(kept);
      }

      FileScanner in;
      MeshFile &result;
      double version       = 0; // not read yet
      bool entities_listed = false;
      std::size_t n_nodes  = 0;
      std::map<std::pair<unsigned int, int>, std::vector<int>> groups_of; // of an entity (4.1)
      std::unordered_map<std::uint64_t, unsigned int> index;              // of a node by its number
      std::unordered_set<std::uint64_t> elements;                         // their numbers
    };
  } // namespace

  MeshFile
  read_gmsh_file(const std::string &file, const MPI_Comm communicator)
  {
    const std::string text =
      read_text_file(file, "file \"" + readable(file) + "\"", true, communicator);
    MeshFile result;
    Reader(readable(file), text, result);
    return result;
  }
} // namespace feib
