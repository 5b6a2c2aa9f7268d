// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_lagrangian_mesh_h
#define feib_lagrangian_mesh_h

#include <feib/nodal_field.h>

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace feib
{
  /// Length, area or volume of a simplex of dimension @p m, whose edges from one corner to the
  /// others are the first m of @p edges.
  template <int dim>
  double simplex_measure(unsigned int m, const std::array<dealii::Tensor<1, dim>, dim> &edges);

  /// The reference mesh of a structure: P1 simplices of dimension m = dim or dim-1 on flat arrays.
  ///
  /// Reference coordinates have dim components whatever m is (a curve uses the first alone, a
  /// surface in space all three). Each element carries the constant gradients of its m+1 shape
  /// functions in an orthonormal frame of its own, so that a seam of a periodic reference body,
  /// where one node has two reference places, needs no special code. Work on elements is divided
  /// by local_elements(). For now every rank holds the whole mesh; who goes over all elements,
  /// faces or facets relies on that (NodalValues says what will last).
  template <int dim>
  class LagrangianMesh
  {
  public:
    static constexpr unsigned int invalid = static_cast<unsigned int>(-1);

    /// One element as it is built: the node numbers and the reference place of each corner (which
    /// differs from the node's own across a seam). The first m+1 of each are used.
    struct Simplex
    {
      std::array<unsigned int, dim + 1> nodes;
      std::array<dealii::Point<dim>, dim + 1> corners;
      unsigned int material_id = 0;
      std::uint64_t number     = unnumbered; // its number in the file it comes from
    };
    static constexpr std::uint64_t unnumbered = static_cast<std::uint64_t>(-1);

    /// A face between two elements, or on the boundary (elements[1] == invalid). The face lies
    /// opposite the local vertex opposite[k] of elements[k]; its m nodes come in nodes.
    struct Face
    {
      std::array<unsigned int, dim> nodes;
      std::array<unsigned int, 2> elements;
      std::array<unsigned int, 2> opposite;
      bool
      at_boundary() const
      {
        return elements[1] == invalid;
      }
    };

    struct Element
    {
      std::array<unsigned int, dim + 1> nodes;                     // m+1 used
      std::array<dealii::Tensor<1, dim>, dim + 1> shape_gradients; // m+1 used, m components each
      std::array<dealii::Tensor<1, dim>, dim> frame; // m orthonormal reference vectors
      dealii::Point<dim> centroid;                   // reference coordinates
      double measure;                                // reference length, area or volume
      double diameter;                               // longest reference edge
      unsigned int material_id;
      std::uint64_t number; // for messages: its number in the file, or its index
    };

    /// What is doubtful about the mesh, though it can be used: a warning of the run (Verdict).
    struct Remark
    {
      std::string kind; // one word
      double value;     // how much of it
      std::string text;
    };

    LagrangianMesh() = default;

    /// @p node_places: the reference coordinates of each node. @p node_numbers: for messages, the
    /// numbers of the nodes in the file they come from; empty: their indices. Elements of dimension
    /// m = dim are oriented to positive measure, those of a curve or surface like their neighbours.
    /// All ranks of @p communicator make the same mesh, and work on it together. Throws Error for a
    /// degenerate element, for two elements with the same nodes, for a node without element, for a
    /// face of more than two elements, for two elements on one side of a face of a body, and for a
    /// closed surface that has one side only.
    LagrangianMesh(unsigned int structure_dim,
                   std::vector<dealii::Point<dim>> node_places,
                   const std::vector<Simplex> &simplices,
                   std::vector<std::uint64_t> node_numbers = {},
                   MPI_Comm communicator                   = MPI_COMM_WORLD);

    /// m
    unsigned int structure_dim() const;
    unsigned int n_nodes() const;
    unsigned int n_elements() const;
    const std::vector<dealii::Point<dim>> &nodes() const;
    const std::vector<Element> &elements() const;
    const std::vector<Face> &faces() const;

    /// The reference measure that each node stands for: an equal part of that of each element
    /// around it. [length^m]
    std::vector<double> node_measures() const;

    /// The reference place of corner @p k of an element, which differs from the node's own across a
    /// seam.
    dealii::Point<dim> corner(const Element &element, unsigned int k) const;

    /// The measure of an element whose nodes are at @p X. [length^m]
    double measure(const Element &element, const Positions<dim> &X) const;

    /// The longest of its edges. [length]
    double longest_edge(const Element &element, const Positions<dim> &X) const;

    /// For messages: the number of node @p i in the file it comes from, or i.
    std::uint64_t node_number(unsigned int i) const;

    /// Nodes of a facet of dimension dim - 1. Its normal lies, in two dimensions, to the right of
    /// the direction from the first node to the second; in three the nodes turn to the left about
    /// it.
    using Facet = std::array<unsigned int, dim>;

    /// The elements of a curve or surface, or the boundary faces of a body with normals outward.
    const std::vector<Facet> &surface() const;

    /// The faces inside a body between elements of different materials, normals towards the larger
    /// id.
    const std::vector<Facet> &interfaces() const;

    /// Gives each element its material id, one per element. Remarks of the kind "groups" about
    /// those there were are void, and so are their names.
    void set_materials(const std::vector<unsigned int> &material_ids);

    /// What a file calls materials, each by the name of its physical group. Not every id has a
    /// name.
    using MaterialNames = std::map<std::string, unsigned int>;
    const MaterialNames &material_names() const;
    void set_material_names(MaterialNames names);

    /// What a file knows of the elements beside their nodes: by name, up to three numbers for each
    /// element.
    using ElementData = std::map<std::string, std::vector<dealii::Tensor<1, 3>>>;
    const ElementData &element_data() const;
    void set_element_data(ElementData data);

    /// The part that each element belongs to, 0, 1, ...: a part is connected through faces.
    std::vector<unsigned int> parts() const;

    /// Turns the parts of a closed curve or surface whose nodes are at @p X so that normals point
    /// out of what it encloses: what lies inside an odd number of its parts, as the space between
    /// two of them, one in the other. Nothing happens to other structures. Remarks on parts that
    /// cross each other (kind "overlap"), which enclose nothing that could be measured.
    void orient_closed_parts(const Positions<dim> &X);

    const std::vector<Remark> &remarks() const;
    void add_remark(Remark remark);

    /// Whether the structure has no boundary face.
    bool closed() const;

    /// The largest reference diameter of an element, h_s.
    double diameter() const;

    /// The elements [first, second) that this rank works on, each of them on one rank.
    std::pair<unsigned int, unsigned int> local_elements() const;

    /// The ranks that hold the mesh.
    MPI_Comm communicator() const;

  private:
    void find_facets();

    void find_opposite_vertices();

    void check_sides() const;

    void turn(Element &element);

    unsigned int m            = dim;
    MPI_Comm mpi_communicator = MPI_COMM_WORLD;
    std::vector<dealii::Point<dim>> node_places;
    std::vector<std::uint64_t> node_numbers; // empty: the indices
    std::vector<Element> element_list;
    std::vector<Face> face_list;
    std::vector<Facet> surface_facets, interface_facets;
    std::vector<Remark> remark_list;
    MaterialNames names_of_materials;
    ElementData data_of_elements;
    bool is_closed = false;
  };
} // namespace feib

#endif
