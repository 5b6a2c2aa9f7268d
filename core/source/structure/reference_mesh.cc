// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/reference_mesh.h>

#include "built_in_meshes.h"
#include "mesh_builder.h"
#include "mesh_from_file.h"
#include "refined_mesh.h"
#include "united_mesh.h"

#include <algorithm>
#include <cmath>
#include <set>

namespace feib
{
  namespace
  {
    /// What a mesh of this name would be for, as "2 for dimension 3"; "" where there is none.
    template <int dim>
    std::string
    dimensions(const std::string &name)
    {
      std::string result;
      for (const BuiltInMesh<dim> &mesh : built_in_meshes<dim>())
        if (mesh.name == name)
          result += (result.empty() ? "" : " or ") + std::to_string(mesh.structure_dim) +
                    " for dimension " + std::to_string(dim);
      return result;
    }


    template <int dim>
    [[noreturn]] void
    refuse(const Parameters &mesh, const std::string &name, const unsigned int structure_dim)
    {
      std::string allowed, found = dimensions<2>(name), other = dimensions<3>(name);
      found += (found.empty() || other.empty() ? "" : " or ") + other;
      for (const BuiltInMesh<dim> &known : built_in_meshes<dim>())
        if (known.structure_dim == structure_dim)
          allowed += known.name + ", ";
      const bool line = found.rfind("1 ", 0) == 0 && dim == 3;
      mesh.fail(name,
                name + " is a mesh of dimension " + found + "; a " +
                  (structure_dim == dim ? "thick body" : "membrane") + " in dimension " +
                  std::to_string(dim) + " needs a mesh of dimension " +
                  std::to_string(structure_dim) + ": " + allowed + "gmsh, vtk" +
                  (line ? "; " + no_curves_in_space() : ""));
    }


    template <int dim>
    LagrangianMesh<dim>
    read(const Parameters &block,
         const unsigned int structure_dim,
         MeshFile (*read_file)(const std::string &, MPI_Comm))
    {
      const std::string path = block.path("file");
      try
        {
          return mesh_from_file<dim>(read_file(path, block.communicator()),
                                     path,
                                     structure_dim,
                                     block.boolean("merge"),
                                     block.communicator());
        }
      catch (const Error &error)
        {
          block.fail("file", error.issues().front().message);
        }
    }


    template <int dim>
    LagrangianMesh<dim>
    unite(const Parameters &block, const unsigned int structure_dim)
    {
      std::vector<LagrangianMesh<dim>> meshes;
      std::vector<std::string> names;
      std::set<std::string> known;
      for (const Parameters &part : block.children("meshes"))
        {
          meshes.push_back(make_reference_mesh<dim>(part.child("mesh"), structure_dim));
          names.push_back(part.word("name"));
          if (!known.insert(names.back()).second)
            part.fail("name",
                      "found \"" + names.back() +
                        "\" a second time; each part needs a name of its own");
        }
      return united_mesh<dim>(meshes, names);
    }


    template <int dim>
    LagrangianMesh<dim>
    refine(const Parameters &block, const unsigned int structure_dim)
    {
      LagrangianMesh<dim> mesh = make_reference_mesh<dim>(block.child("mesh"), structure_dim);
      double longest           = block.number("longest_edge");
      if (block.string("unit") == "cells")
        longest *= block.cell_edge();
      if (longest == 0) // without a fluid, or with one whose faults are told
        return mesh;
      const auto halvings = [&] {
        double diameter = 0;
        for (const auto &element : mesh.elements())
          diameter = std::max(diameter, element.diameter);
        return std::ceil(std::log2(diameter / longest) - 1e-9);
      };
      // The octahedra in the middle of tetrahedra may want one more.
      for (double n = halvings(); n > 0; n = halvings())
        {
          check_number(block, "longest_edge", mesh.n_elements() * std::exp2(n * structure_dim));
          mesh = refined_mesh(mesh);
        }
      return mesh;
    }
  } // namespace


  template <int dim>
  LagrangianMesh<dim>
  make_reference_mesh(const Parameters &mesh, const unsigned int structure_dim)
  {
    const auto [name, block] = mesh.choice();
    if (name == "parts")
      return unite<dim>(block, structure_dim);
    if (name == "refined")
      return refine<dim>(block, structure_dim);
    if (name == "gmsh")
      return read<dim>(block, structure_dim, read_gmsh_file);
    if (name == "vtk")
      return read<dim>(block, structure_dim, read_vtk_file);
    for (const BuiltInMesh<dim> &known : built_in_meshes<dim>())
      if (known.name == name && known.structure_dim == structure_dim)
        return known.make(block);
    refuse<dim>(mesh, name, structure_dim);
  }

  template LagrangianMesh<2> make_reference_mesh<2>(const Parameters &, unsigned int);
  template LagrangianMesh<3> make_reference_mesh<3>(const Parameters &, unsigned int);
} // namespace feib
