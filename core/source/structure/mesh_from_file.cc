// SPDX-License-Identifier: LGPL-2.1-or-later
#include "mesh_from_file.h"

#include "built_in_meshes.h"
#include "mesh_builder.h"

#include <feib/message.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace feib
{
  namespace
  {
    using dealii::Point;
    using dealii::Tensor;

    const char *const names[] = {"points", "segments", "triangles", "tetrahedra"};

    /// What a file must hold for a structure.
    void
    check_content(const MeshFile &file, const unsigned int structure_dim, const int dim)
    {
      std::string found;
      for (unsigned int m = 3; m > 0; --m)
        if (!file.simplices[m].empty())
          found += (found.empty() ? "" : " and ") + std::to_string(file.simplices[m].size()) + " " +
                   names[m];
      if (!file.others.empty())
        found += (found.empty() ? "" : " and ") + file.others;
      bool fits = !file.simplices[structure_dim].empty() && file.others_dimension < structure_dim;
      for (unsigned int m = structure_dim + 1; m < 4; ++m)
        fits = fits && file.simplices[m].empty();
      const bool lines = dim == 3 && !file.simplices[1].empty() && file.simplices[2].empty() &&
                         file.simplices[3].empty() && file.others.empty();
      if (!fits)
        throw Error("holds " + (found.empty() ? "no elements" : found) +
                    "; a structure of dimension " + std::to_string(structure_dim) +
                    " in dimension " + std::to_string(dim) + " needs " + names[structure_dim] +
                    ", and nothing of higher dimension or another shape" +
                    (file.others.empty() ? "" : " (in Gmsh, Mesh.RecombineAll = 0)") +
                    (lines ? "; " + no_curves_in_space() : ""));
    }

    /// For each place, the index of the first one that is the same but for round-off.
    template <int dim>
    std::vector<unsigned int>
    places_without_repeats(const std::vector<Point<dim>> &places)
    {
      // Along a direction that no mesh is aligned with, few others are near.
      Tensor<1, dim> direction;
      for (unsigned int a = 0; a < dim; ++a)
        direction[a] = std::pow(.7548776662466927, a);
      std::vector<std::pair<double, unsigned int>> order;
      double extent = 0;
      for (unsigned int i = 0; i < places.size(); ++i)
        {
          order.emplace_back(direction * (places[i] - places[0]), i);
          extent = std::max(extent, places[i].distance(places[0]));
        }
      std::sort(order.begin(), order.end());
      const double tolerance = 1e-8 * extent;
      std::vector<unsigned int> result(places.size());
      for (unsigned int k = 0; k < order.size(); ++k)
        {
          const unsigned int i = order[k].second;
          result[i]            = i;
          for (unsigned int l = k; l-- > 0 && order[k].first - order[l].first < 2 * tolerance;)
            if (const unsigned int j = order[l].second; places[i].distance(places[j]) <= tolerance)
              {
                result[i] = result[j];
                break;
              }
        }
      std::vector<unsigned int> smallest(places.size(), places.size());
      for (unsigned int i = 0; i < places.size(); ++i)
        {
          unsigned int &index = smallest[result[i]];
          index               = std::min(index, i);
          result[i]           = index;
        }
      return result;
    }

    /// The places of the nodes that elements of the structure use. @p used: their indices in the
    /// file.
    template <int dim>
    std::vector<Point<dim>>
    used_places(const MeshFile &file,
                const unsigned int structure_dim,
                std::vector<unsigned int> &used)
    {
      std::vector<bool> is_used(file.nodes.size(), false);
      for (const MeshFile::Simplex &simplex : file.simplices[structure_dim])
        for (unsigned int k = 0; k <= structure_dim; ++k)
          is_used[simplex.nodes[k]] = true;
      std::vector<Point<dim>> places;
      double largest = 0;
      for (unsigned int i = 0; i < file.nodes.size(); ++i)
        if (is_used[i])
          {
            used.push_back(i);
            places.emplace_back();
            for (unsigned int a = 0; a < dim; ++a)
              places.back()[a] = file.nodes[i].place[a];
            largest = std::max(largest, places.back().distance(places.front()));
          }
      for (const unsigned int i : used)
        if (dim == 2 && std::abs(file.nodes[i].place[2]) > 1e-8 * largest)
          throw Error(
            "has nodes outside the plane z = 0, where a structure in dimension 2 must "
            "lie, as node " +
            std::to_string(file.nodes[i].number) +
            (file.nodes[i].line > 0 ? " in line " + std::to_string(file.nodes[i].line) : "") +
            " with z = " + readable(file.nodes[i].place[2]));
      return places;
    }

    /// Says which elements have been turned against how the file lists them, where the file does
    /// not list all those of a part in one sense.
    template <int dim>
    void
    remark_on_orientation(LagrangianMesh<dim> &mesh,
                          const std::vector<typename LagrangianMesh<dim>::Simplex> &given)
    {
      const std::vector<unsigned int> part_of = mesh.parts();
      const auto turned                       = [&](const unsigned int e) {
        return mesh.elements()[e].nodes[0] != given[e].nodes[0];
      };
      std::vector<std::array<unsigned int, 2>> counts; // of each part, as they are and turned
      for (unsigned int e = 0; e < given.size(); ++e)
        {
          counts.resize(std::max<std::size_t>(counts.size(), part_of[e] + 1));
          ++counts[part_of[e]][turned(e)];
        }
      unsigned int n = 0;
      for (const auto &count : counts)
        n += std::min(count[0], count[1]);
      for (unsigned int e = 0; e < given.size() && n > 0; ++e)
        if (const auto &count = counts[part_of[e]];
            count[turned(e)] == std::min(count[0], count[1]))
          {
            mesh.add_remark({"orientation",
                             double(n),
                             "the file lists the nodes of " + std::to_string(n) + " of its " +
                               std::to_string(given.size()) +
                               " elements in the other sense than those of the others, as of "
                               "element " +
                               std::to_string(mesh.elements()[e].number) + ": they are turned"});
            return;
          }
    }

    /// Says what is doubtful about the mesh of a file. @p example: the numbers of two nodes at one
    /// place.
    template <int dim>
    void
    add_remarks(LagrangianMesh<dim> &mesh,
                const MeshFile &file,
                const unsigned int n_unmerged,
                const std::pair<std::uint64_t, std::uint64_t> &example)
    {
      const unsigned int m = mesh.structure_dim();
      if (const std::uint64_t n = file.n_higher_order[m]; n > 0)
        mesh.add_remark({"higher_order",
                         double(n),
                         std::to_string(n) + " of its " + names[m] +
                           " are of second order or higher, of which the corners alone are taken: "
                           "edges become straight, what was curved is as coarse as the elements"});
      if (const MeshFile::Several &several = file.several[m]; several.count > 0)
        mesh.add_remark({"groups",
                         double(several.count),
                         std::to_string(several.count) +
                           " of its elements are in several physical groups of the file, as "
                           "element " +
                           std::to_string(several.example) + " in " + std::to_string(several.kept) +
                           " and " + std::to_string(several.other) +
                           ": the first one is taken for the material"});
      if (n_unmerged == 0)
        return;
      const std::vector<unsigned int> parts = mesh.parts();
      const unsigned int n_parts            = *std::max_element(parts.begin(), parts.end()) + 1;
      mesh.add_remark({"unmerged_nodes",
                       double(n_unmerged),
                       std::to_string(n_unmerged) + " of its nodes lie where others do, as nodes " +
                         std::to_string(example.first) + " and " + std::to_string(example.second) +
                         ", and are not joined: they move apart. The mesh has " +
                         std::to_string(n_parts) + (n_parts == 1 ? " part" : " parts") +
                         "; \"merge\": true in its block makes one node of "
                         "those at one place"});
    }

    /// The data of the elements, not a number where the file does not say.
    template <int dim>
    void
    add_element_data(LagrangianMesh<dim> &mesh, const std::map<std::string, MeshFile::Data> &given)
    {
      typename LagrangianMesh<dim>::ElementData data;
      for (const auto &[name, values] : given)
        {
          bool any = false;
          std::vector<dealii::Tensor<1, 3>> of_elements;
          for (const auto &element : mesh.elements())
            {
              const auto found = values.find(element.number);
              any              = any || found != values.end();
              of_elements.emplace_back();
              for (unsigned int c = 0; c < 3; ++c)
                of_elements.back()[c] = found != values.end()
                                          ? found->second[c]
                                          : std::numeric_limits<double>::quiet_NaN();
            }
          if (any)
            data[name] = std::move(of_elements);
        }
      mesh.set_element_data(std::move(data));
    }

    /// The names of materials that there are.
    template <int dim>
    void
    add_material_names(LagrangianMesh<dim> &mesh, const std::map<std::string, int> &names)
    {
      typename LagrangianMesh<dim>::MaterialNames result;
      for (const auto &[name, id] : names)
        result[name] = std::abs(id);
      mesh.set_material_names(std::move(result));
    }

    template <int dim>
    LagrangianMesh<dim>
    build(const MeshFile &file,
          const unsigned int structure_dim,
          const bool merge,
          const MPI_Comm communicator)
    {
      check_content(file, structure_dim, dim);
      Builder<dim> builder(communicator);
      std::vector<std::uint64_t> numbers;
      unsigned int n_unmerged = 0;
      std::pair<std::uint64_t, std::uint64_t> example;
      std::vector<unsigned int> used;
      const std::vector<Point<dim>> places  = used_places<dim>(file, structure_dim, used);
      const std::vector<unsigned int> first = places_without_repeats(places);
      std::vector<unsigned int> node_of(file.nodes.size()); // of the structure
      for (unsigned int i = 0; i < places.size(); ++i)
        {
          const std::uint64_t number = file.nodes[used[i]].number;
          if (first[i] != i && n_unmerged++ == 0)
            example = {file.nodes[used[first[i]]].number, number};
          if (merge && first[i] != i)
            node_of[used[i]] = node_of[used[first[i]]];
          else
            {
              node_of[used[i]] = builder.node(places[i]);
              numbers.push_back(number);
            }
        }
      for (const MeshFile::Simplex &simplex : file.simplices[structure_dim])
        {
          if (simplex.material_id < 0)
            throw Error("element " + std::to_string(simplex.number) + " has the material " +
                        std::to_string(simplex.material_id) + "; ids are 0, 1, 2, ...");
          std::vector<unsigned int> nodes;
          for (unsigned int k = 0; k <= structure_dim; ++k)
            nodes.push_back(node_of[simplex.nodes[k]]);
          builder.simplex(nodes, simplex.material_id);
          builder.simplices.back().number = simplex.number;
        }
      LagrangianMesh<dim> mesh = builder.build(structure_dim, std::move(numbers));
      add_material_names(mesh, file.names_of_materials[structure_dim]);
      add_element_data(mesh, file.element_data);
      add_remarks(mesh, file, merge ? 0 : n_unmerged, example);
      remark_on_orientation(mesh, builder.simplices);
      return mesh;
    }
  } // namespace


  template <int dim>
  LagrangianMesh<dim>
  mesh_from_file(const MeshFile &file,
                 const std::string &path,
                 const unsigned int structure_dim,
                 const bool merge,
                 const MPI_Comm communicator)
  {
    try
      {
        return build<dim>(file, structure_dim, merge, communicator);
      }
    catch (const Error &error)
      {
        throw Error("file \"" + readable(path) + "\": " + error.issues().front().message);
      }
  }

  template LagrangianMesh<2>
  mesh_from_file(const MeshFile &, const std::string &, unsigned int, bool, MPI_Comm);
  template LagrangianMesh<3>
  mesh_from_file(const MeshFile &, const std::string &, unsigned int, bool, MPI_Comm);
} // namespace feib
