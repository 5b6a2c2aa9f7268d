// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gmsh_file.h"

#include <feib/error.h>

#include <fstream>
#include <map>
#include <sstream>
#include <unordered_map>
#include <unordered_set>

namespace feib
{
  namespace
  {
    // Why not deal.II's GridIn: it refuses marked lines and faces inside a body, and cannot say
    // what a file of the wrong dimension holds instead.
    class Reader
    {
    public:
      Reader(const std::string &name, GmshFile &result)
        : name(name)
        , input(name)
        , result(result)
      {
        if (!input)
          throw Error("file \"" + name + "\" cannot be opened");
        read();
      }

    private:
      [[noreturn]] void
      fail(const std::string &message) const
      {
        throw Error("file \"" + name + "\" " + message +
                    "; an ASCII Gmsh file of format 2.2 or 4.1 is needed");
      }

      template <typename T>
      T
      get()
      {
        T value;
        if (!(input >> value))
          fail("ends, or is not readable, inside " + section);
        return value;
      }

      void
      skip(const std::size_t n)
      {
        for (std::size_t i = 0; i < n; ++i)
          get<std::string>();
      }

      void
      read()
      {
        double version = 0;
        while (input >> section)
          {
            if (section[0] != '$')
              fail("has \"" + section.substr(0, 20) + "\" where a section was expected");
            if (section == "$MeshFormat")
              {
                version                 = get<double>();
                const unsigned int type = get<unsigned int>();
                if ((version != 2.2 && version != 4.1) || type != 0)
                  {
                    std::ostringstream found;
                    found << "is of format " << version << (type == 0 ? "" : " binary");
                    fail(found.str());
                  }
              }
            else if (version == 0)
              fail("does not begin with $MeshFormat");
            else if (section == "$Entities")
              read_entities();
            else if (section == "$PartitionedEntities")
              read_partitioned_entities();
            else if (section == "$Nodes")
              version == 2.2 ? read_nodes_2() : read_nodes_4();
            else if (section == "$Elements")
              version == 2.2 ? read_elements_2() : read_elements_4();

            const std::string end = "$End" + section.substr(1);
            std::string word      = get<std::string>();
            if ((section == "$Nodes" || section == "$Elements") && word != end)
              fail("holds more in " + section + " than its count says");
            while (word != end)
              word = get<std::string>();
          }
        if (version == 0)
          fail("is empty");
      }

      void
      read_entities()
      {
        read_entities_by_dimension(false);
      }

      /// Elements of a partitioned file belong to parts of entities, which have the groups.
      void
      read_partitioned_entities()
      {
        skip(1);
        const std::size_t n_ghosts = get<std::size_t>();
        for (std::size_t i = 0; i < n_ghosts; ++i)
          skip(2);
        read_entities_by_dimension(true);
      }

      void
      read_entities_by_dimension(const bool partitioned)
      {
        std::array<std::size_t, 4> n;
        for (std::size_t &n_of_dimension : n)
          n_of_dimension = get<std::size_t>();
        for (unsigned int dimension = 0; dimension < 4; ++dimension)
          for (std::size_t i = 0; i < n[dimension]; ++i)
            {
              const int tag = get<int>();
              if (partitioned)
                {
                  skip(2); // dimension and tag of the whole
                  skip(get<std::size_t>());
                }
              skip(dimension == 0 ? 3 : 6);
              const std::size_t n_groups = get<std::size_t>();
              for (std::size_t g = 0; g < n_groups; ++g)
                {
                  const int group = get<int>();
                  if (g == 0)
                    physical_group[{dimension, tag}] = std::abs(group);
                }
              if (dimension > 0)
                skip(get<std::size_t>());
            }
      }

      void
      add_node(const std::size_t tag)
      {
        std::array<double, 3> x;
        for (double &coordinate : x)
          coordinate = get<double>();
        if (!number.try_emplace(tag, result.nodes.size()).second)
          fail("has node " + std::to_string(tag) + " twice");
        result.nodes.push_back(x);
      }

      void
      read_nodes_2()
      {
        const std::size_t n = get<std::size_t>();
        for (std::size_t i = 0; i < n; ++i)
          add_node(get<std::size_t>());
      }

      void
      read_nodes_4()
      {
        const std::size_t n_blocks = get<std::size_t>();
        skip(3);
        for (std::size_t b = 0; b < n_blocks; ++b)
          {
            const unsigned int dimension = get<unsigned int>();
            skip(1);
            const bool parametric = get<int>() != 0;
            // The count is not believed: memory grows with what is read.
            std::vector<std::size_t> tags;
            for (std::size_t n = get<std::size_t>(); n > 0; --n)
              tags.push_back(get<std::size_t>());
            for (const std::size_t tag : tags)
              {
                add_node(tag);
                if (parametric)
                  skip(dimension);
              }
          }
      }

      void
      add_element_number()
      {
        const std::size_t tag = get<std::size_t>();
        if (!elements.insert(tag).second)
          fail("has element " + std::to_string(tag) + " twice");
      }

      /// Takes the rest of the line: the nodes of an element.
      void
      add_element(const int type, const unsigned int material_id)
      {
        std::string line;
        std::getline(input, line);
        const unsigned int dimension = type == 1 ? 1 : type == 2 ? 2 : type == 4 ? 3 : 0;
        if (dimension > 0)
          {
            std::istringstream words(line);
            GmshFile::Simplex simplex{{}, material_id};
            for (unsigned int k = 0; k <= dimension; ++k)
              {
                std::size_t tag;
                if (!(words >> tag) || number.count(tag) == 0)
                  fail("has an element with a node that does not exist");
                simplex.nodes[k] = number[tag];
              }
            result.simplices[dimension].push_back(simplex);
          }
        else if (type != 15)
          {
            static const std::map<int, std::pair<const char *, unsigned int>> names = {
              {3, {"quadrilaterals", 2}},
              {5, {"hexahedra", 3}},
              {6, {"prisms", 3}},
              {7, {"pyramids", 3}},
              {8, {"segments of second order", 1}},
              {9, {"triangles of second order", 2}},
              {11, {"tetrahedra of second order", 3}}};
            const auto found = names.find(type);
            const auto [words, others_dimension] =
              found == names.end()
                ? std::make_pair("elements of Gmsh type " + std::to_string(type), 3u)
                : std::make_pair(std::string(found->second.first), found->second.second);
            if (others_dimension > result.others_dimension)
              {
                result.others           = words;
                result.others_dimension = others_dimension;
              }
          }
      }

      void
      read_elements_2()
      {
        const std::size_t n = get<std::size_t>();
        for (std::size_t i = 0; i < n; ++i)
          {
            add_element_number();
            const int type            = get<int>();
            const unsigned int n_tags = get<unsigned int>();
            unsigned int material_id  = 0;
            for (unsigned int t = 0; t < n_tags; ++t)
              {
                const int tag = get<int>();
                if (t == 0)
                  material_id = std::abs(tag);
              }
            add_element(type, material_id);
          }
      }

      void
      read_elements_4()
      {
        const std::size_t n_blocks = get<std::size_t>();
        skip(3);
        for (std::size_t b = 0; b < n_blocks; ++b)
          {
            const unsigned int dimension   = get<unsigned int>();
            const int tag                  = get<int>();
            const int type                 = get<int>();
            const std::size_t n            = get<std::size_t>();
            const auto group               = physical_group.find({dimension, tag});
            const unsigned int material_id = group == physical_group.end() ? 0 : group->second;
            for (std::size_t i = 0; i < n; ++i)
              {
                add_element_number();
                add_element(type, material_id);
              }
          }
      }

      const std::string name;
      std::ifstream input;
      GmshFile &result;
      std::string section;
      std::map<std::pair<unsigned int, int>, int> physical_group; // of an entity (4.1)
      std::unordered_map<std::size_t, unsigned int> number;       // of a node by its tag
      std::unordered_set<std::size_t> elements;                   // their numbers
    };
  } // namespace

  GmshFile::GmshFile(const std::string &file)
  {
    Reader(file, *this);
  }
} // namespace feib
