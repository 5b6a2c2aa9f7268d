// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gmsh_file.h"
#include <feib/text_file.h>

#include <feib/error.h>
#include <feib/message.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <map>
#include <string_view>
#include <unordered_map>
#include <unordered_set>

namespace feib
{
  namespace
  {
    const char *const formats = "Feib reads ASCII files of the formats 2.2 and 4.1 "
                                "(Mesh.MshFileVersion, with Mesh.Binary = 0)";

    /// A kind of elements by Gmsh's number.
    struct Kind
    {
      std::string name;
      unsigned int dimension;
      bool simplex;
    };

    Kind
    kind_of(const int type)
    {
      switch (type)
        {
          case 15:
            return {"points", 0, true};
          case 1:
            return {"segments", 1, true};
          case 2:
            return {"triangles", 2, true};
          case 4:
            return {"tetrahedra", 3, true};
          case 3:
            return {"quadrilaterals", 2, false};
          case 5:
            return {"hexahedra", 3, false};
          case 6:
            return {"prisms", 3, false};
          case 7:
            return {"pyramids", 3, false};
          case 8:
            return {"segments of second order", 1, false};
          case 9:
            return {"triangles of second order", 2, false};
          case 11:
            return {"tetrahedra of second order", 3, false};
          default:
            return {"elements of Gmsh type " + std::to_string(type), 3, false};
        }
    }


    // Why not deal.II's GridIn: it refuses marked lines and faces inside a body, and cannot say
    // what a file of the wrong dimension holds instead.
    class Reader
    {
    public:
      Reader(const std::string &name, const std::string &text, GmshFile &result)
        : name(name)
        , text(text)
        , result(result)
      {
        read();
        for (unsigned int m = 1; m < 4; ++m)
          join_groups(m);
      }

    private:
      [[noreturn]] void
      fail(const std::string &message) const
      {
        throw Error("file \"" + name + "\", line " + std::to_string(line) + ": " + message);
      }

      /// Goes to the next word; whether there is one.
      bool
      find_word()
      {
        for (; at < text.size() && std::isspace(static_cast<unsigned char>(text[at])); ++at)
          line += text[at] == '\n';
        return at < text.size();
      }

      std::string_view
      word()
      {
        if (!find_word())
          fail("the file ends inside " + section);
        const std::size_t begin = at;
        while (at < text.size() && !std::isspace(static_cast<unsigned char>(text[at])))
          ++at;
        return text.substr(begin, at - begin);
      }

      /// The rest of the line.
      std::string_view
      rest()
      {
        const std::size_t begin = at;
        at                      = std::min(text.find('\n', at), text.size());
        return text.substr(begin, at - begin);
      }

      std::string
      quoted(const std::string_view found) const
      {
        return '"' + readable(std::string(found), 30) + '"';
      }

      template <typename T>
      T
      number(const char *const what)
      {
        const std::string_view found = word();
        T value{};
        const auto [end, problem] =
          std::from_chars(found.data(), found.data() + found.size(), value);
        if (problem != std::errc() || end != found.data() + found.size())
          fail("found " + quoted(found) + " in " + section + " where " + what + " is expected");
        return value;
      }

      std::size_t
      count()
      {
        return number<std::size_t>("a count");
      }

      double
      real()
      {
        const std::string copy(word());
        char *end          = nullptr;
        const double value = std::strtod(copy.c_str(), &end);
        if (end != copy.c_str() + copy.size() || !std::isfinite(value))
          fail("found " + quoted(copy) + " in " + section + " where a finite number is expected");
        return value;
      }

      void
      skip(const std::size_t n)
      {
        for (std::size_t i = 0; i < n; ++i)
          word();
      }

      void
      read()
      {
        if (!find_word())
          fail("the file is empty; " + std::string(formats));
        while (find_word())
          {
            section           = "the file";
            const auto header = word();
            if (header[0] != '$')
              fail("found " + quoted(header) + " where a section ($...) is expected; " + formats);
            section = readable(std::string(header), 30);
            if (header == "$MeshFormat")
              read_format();
            else if (version == 0)
              fail("found " + quoted(header) + " where $MeshFormat is expected; " + formats);
            else if (header == "$Entities")
              read_entities(false);
            else if (header == "$PartitionedEntities")
              read_entities(true);
            else if (header == "$Nodes")
              version == 2.2 ? read_nodes_2() : read_nodes_4();
            else if (header == "$Elements")
              version == 2.2 ? read_elements_2() : read_elements_4();
            else if (header == "$ElementData")
              read_element_data();
            else
              {
                const std::string end = "$End" + std::string(header.substr(1));
                while (word() != end)
                  ;
                continue;
              }
            if (const auto end = word(); end != "$End" + section.substr(1))
              fail("found " + quoted(end) + " where $End" + section.substr(1) +
                   " is expected: " + section + " holds more than its counts say");
          }
      }

      void
      read_format()
      {
        version         = real();
        const auto type = number<int>("0 for ASCII or 1 for binary");
        count(); // bytes of a number
        if (type != 0 || (version != 2.2 && version != 4.1))
          fail("the file is of format " + readable(version) + (type == 0 ? "" : ", binary") + "; " +
               formats);
      }

      /// A section holds one view of Gmsh: of several times the last one counts, of more than three
      /// components (tensors) none.
      void
      read_element_data()
      {
        std::string view;
        for (std::size_t n = count(), i = 0; i < n; ++i)
          {
            find_word();
            std::string text(rest());
            text.erase(text.find_last_not_of(" \t\r") + 1);
            if (text.size() > 1 && text.front() == '"' && text.back() == '"')
              text = text.substr(1, text.size() - 2);
            if (i == 0)
              view = text;
          }
        skip(count());
        const std::size_t n_integers = count();
        if (n_integers < 3)
          fail("$ElementData has three integers or more, the third is the number of its elements; "
               "found " +
               std::to_string(n_integers));
        skip(1);
        const std::size_t n_components = count(), n_elements = count();
        skip(n_integers - 3);
        GmshFile::Data data;
        for (std::size_t e = 0; e < n_elements; ++e)
          {
            std::array<double, 3> &values = data[number<std::uint64_t>("the number of an element")];
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
        if (partitioned)
          {
            skip(1);
            const std::size_t n_ghosts = count();
            for (std::size_t i = 0; i < n_ghosts; ++i)
              skip(2);
          }
        std::array<std::size_t, 4> n;
        for (std::size_t &n_of_dimension : n)
          n_of_dimension = count();
        for (unsigned int dimension = 0; dimension < 4; ++dimension)
          for (std::size_t i = 0; i < n[dimension]; ++i)
            {
              const auto tag = number<int>("the number of an entity");
              if (partitioned)
                {
                  skip(2); // dimension and tag of the whole
                  skip(count());
                }
              skip(dimension == 0 ? 3 : 6); // place
              std::vector<int> &groups = groups_of[{dimension, tag}];
              groups.clear();
              const std::size_t n_groups = count();
              for (std::size_t g = 0; g < n_groups; ++g)
                groups.push_back(std::abs(number<int>("a physical group")));
              if (dimension > 0)
                skip(count());
            }
      }

      void
      add_node(const std::uint64_t tag)
      {
        GmshFile::Node node;
        node.number = tag;
        for (double &coordinate : node.place)
          coordinate = real();
        if (!index.try_emplace(tag, result.nodes.size()).second)
          fail("node " + std::to_string(tag) + " stands here a second time");
        node.line = line;
        result.nodes.push_back(node);
      }

      void
      read_nodes_2()
      {
        for (std::size_t n = count(); n > 0; --n)
          add_node(number<std::uint64_t>("the number of a node"));
      }

      void
      read_nodes_4()
      {
        const std::size_t n_blocks = count(), n_all = count();
        skip(2);
        for (std::size_t b = 0; b < n_blocks; ++b)
          {
            const auto dimension = number<unsigned int>("the dimension of an entity");
            skip(1);
            const bool parametric = number<int>("0 or 1") != 0;
            // The count is not believed: memory grows with what is read.
            std::vector<std::uint64_t> tags;
            for (std::size_t n = count(); n > 0; --n)
              tags.push_back(number<std::uint64_t>("the number of a node"));
            for (const std::uint64_t tag : tags)
              {
                add_node(tag);
                if (parametric)
                  skip(dimension);
              }
          }
        check_total(n_all, result.nodes.size());
      }

      void
      check_total(const std::size_t said, const std::size_t there) const
      {
        if (said != there)
          fail(section + " says that it holds " + std::to_string(said) + ", its blocks hold " +
               std::to_string(there));
      }

      std::uint64_t
      element_number()
      {
        const auto tag = number<std::uint64_t>("the number of an element");
        if (!elements.insert(tag).second)
          fail("element " + std::to_string(tag) + " stands here a second time");
        return tag;
      }

      /// Takes the rest of the line: the nodes of an element.
      void
      add_element(const Kind &kind, GmshFile::Simplex simplex)
      {
        if (!kind.simplex)
          {
            rest();
            if (kind.dimension > result.others_dimension)
              {
                result.others           = kind.name;
                result.others_dimension = kind.dimension;
              }
            return;
          }
        const std::size_t first_line = line;
        const std::string said       = "element " + std::to_string(simplex.number) + " of the " +
                                 kind.name + " needs " + std::to_string(kind.dimension + 1) +
                                 " nodes, ";
        for (unsigned int k = 0; k <= kind.dimension; ++k)
          {
            if (find_word() && line != first_line)
              {
                line = first_line;
                fail(said + "found " + std::to_string(k));
              }
            const auto tag   = number<std::uint64_t>("the number of a node");
            const auto found = index.find(tag);
            if (found == index.end())
              fail("element " + std::to_string(simplex.number) + " has node " +
                   std::to_string(tag) + ", which does not exist");
            simplex.nodes[k] = found->second;
          }
        if (const auto more = rest(); more.find_first_not_of(" \t\r\v\f") != more.npos)
          fail(said + "found more: " + quoted(more));
        if (kind.dimension > 0)
          result.simplices[kind.dimension].push_back(simplex);
      }

      void
      read_elements_2()
      {
        for (std::size_t n = count(); n > 0; --n)
          {
            GmshFile::Simplex simplex{{}, 0, 0, element_number()};
            const Kind kind          = kind_of(number<int>("the type of an element"));
            const std::size_t n_tags = count();
            for (std::size_t t = 0; t < n_tags; ++t)
              {
                const int tag = number<int>("a tag of an element");
                if (t == 0)
                  simplex.material_id = std::abs(tag);
                else if (t == 1)
                  simplex.entity = tag;
              }
            add_element(kind, simplex);
          }
      }

      void
      read_elements_4()
      {
        const std::size_t n_blocks = count(), n_all = count();
        skip(2);
        for (std::size_t b = 0; b < n_blocks; ++b)
          {
            const auto dimension = number<unsigned int>("the dimension of an entity");
            const auto entity    = number<int>("the number of an entity");
            const Kind kind      = kind_of(number<int>("the type of elements"));
            if (kind.simplex && kind.dimension != dimension)
              fail(kind.name + " belong to an entity of dimension " +
                   std::to_string(kind.dimension) + ", found one of dimension " +
                   std::to_string(dimension));
            const auto groups = groups_of.find({dimension, entity});
            if (entities_listed && groups == groups_of.end())
              fail(kind.name + " belong to the entity " + std::to_string(entity) +
                   " of dimension " + std::to_string(dimension) +
                   ", which $Entities does not list");
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
        GmshFile::Several &several = result.several[dimension];
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
        std::vector<GmshFile::Simplex> kept;
        for (unsigned int e = 0; e < simplices.size(); ++e)
          {
            const auto [place, is_new]     = firsts.try_emplace(key(e), First{e, false});
            First &first                   = place->second;
            const GmshFile::Simplex &known = simplices[first.element], &now = simplices[e];
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

      const std::string name;
      const std::string_view text;
      GmshFile &result;
      std::size_t at = 0, line = 1;
      std::string section  = "the file";
      double version       = 0; // not read yet
      bool entities_listed = false;
      std::map<std::pair<unsigned int, int>, std::vector<int>> groups_of; // of an entity (4.1)
      std::unordered_map<std::uint64_t, unsigned int> index;              // of a node by its number
      std::unordered_set<std::uint64_t> elements;                         // their numbers
    };
  } // namespace

  GmshFile::GmshFile(const std::string &file, const MPI_Comm communicator)
  {
    const std::string text =
      read_text_file(file, "file \"" + readable(file) + "\"", true, communicator);
    Reader(readable(file), text, *this);
  }
} // namespace feib
