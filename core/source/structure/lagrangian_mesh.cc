// SPDX-License-Identifier: LGPL-2.1-or-later
#include "closed_parts.h"

#include <feib/error.h>
#include <feib/message.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>

namespace feib
{
  namespace
  {
    using dealii::Point;
    using dealii::Tensor;

    template <int dim>
    using Simplex = typename LagrangianMesh<dim>::Simplex;
    template <int dim>
    using Face = typename LagrangianMesh<dim>::Face;
    template <int dim>
    using Element = typename LagrangianMesh<dim>::Element;

    template <int dim>
    std::string
    text(const Point<dim> &x)
    {
      std::string result = "(";
      for (unsigned int i = 0; i < dim; ++i)
        result += (i ? ", " : "") + readable(x[i]);
      return result + ")";
    }

    /// An orthonormal frame of the simplex's plane; m = dim: the axes. A degenerate simplex has
    /// none.
    template <int dim>
    bool
    make_frame(const Simplex<dim> &simplex, const unsigned int m, Element<dim> &element)
    {
      for (unsigned int k = 0; k < m; ++k)
        if (m == dim)
          element.frame[k][k] = 1;
        else
          {
            const Tensor<1, dim> edge = simplex.corners[k + 1] - simplex.corners[0];
            Tensor<1, dim> v          = edge;
            for (unsigned int l = 0; l < k; ++l)
              v -= (v * element.frame[l]) * element.frame[l];
            if (!(v.norm() > 1e-12 * edge.norm()))
              return false;
            element.frame[k] = v / v.norm();
          }
      return true;
    }

    /// The edge matrix in the frame, filled up with ones: its inverse holds the gradients.
    template <int dim>
    Tensor<2, dim>
    edge_matrix(const Simplex<dim> &simplex, const unsigned int m, const Element<dim> &element)
    {
      Tensor<2, dim> edges;
      for (unsigned int k = 0; k < dim; ++k)
        for (unsigned int j = 0; j < dim; ++j)
          if (k < m && j < m)
            edges[k][j] = (simplex.corners[j + 1] - simplex.corners[0]) * element.frame[k];
          else
            edges[k][j] = (k == j);
      return edges;
    }

    /// @p simplex may be turned to positive orientation.
    template <int dim>
    Element<dim>
    make_element(Simplex<dim> &simplex, const unsigned int m)
    {
      Element<dim> element;
      element.material_id = simplex.material_id;
      element.number      = simplex.number;
      element.diameter    = 0;
      for (unsigned int k = 0; k <= m; ++k)
        {
          element.centroid += simplex.corners[k] / (m + 1.);
          for (unsigned int l = 0; l < k; ++l)
            element.diameter =
              std::max(element.diameter, simplex.corners[k].distance(simplex.corners[l]));
        }

      const bool has_frame = make_frame<dim>(simplex, m, element);
      Tensor<2, dim> edges = edge_matrix<dim>(simplex, m, element);
      if (determinant(edges) < 0)
        {
          std::swap(simplex.nodes[0], simplex.nodes[1]);
          std::swap(simplex.corners[0], simplex.corners[1]);
          edges = edge_matrix<dim>(simplex, m, element);
        }
      element.measure = determinant(edges) / (m == 3 ? 6 : m);
      if (!has_frame || !(element.measure > 1e-12 * std::pow(element.diameter, m)))
        throw Error("element " + std::to_string(element.number) + " at " + text(element.centroid) +
                    " is degenerate: its corners lie " +
                    (m == 1   ? "in one point"
                     : m == 2 ? "on one line"
                              : "in one plane"));

      const Tensor<2, dim> inverse = invert(edges);
      for (unsigned int k = 0; k < m; ++k)
        for (unsigned int l = 0; l < m; ++l)
          {
            element.shape_gradients[k + 1][l] = inverse[k][l];
            element.shape_gradients[0][l] -= inverse[k][l];
          }
      element.nodes.fill(LagrangianMesh<dim>::invalid);
      std::copy_n(simplex.nodes.begin(), m + 1, element.nodes.begin());
      return element;
    }

    /// The faces, sorted by their nodes; `opposite` is not set yet.
    template <int dim>
    std::vector<Face<dim>>
    make_faces(const std::vector<Simplex<dim>> &simplices, const unsigned int m)
    {
      using Key                      = std::pair<std::array<unsigned int, dim>, unsigned int>;
      constexpr unsigned int invalid = LagrangianMesh<dim>::invalid;
      std::vector<Key> sides;
      sides.reserve(simplices.size() * (m + 1));
      for (unsigned int e = 0; e < simplices.size(); ++e)
        for (unsigned int k = 0; k <= m; ++k)
          {
            std::array<unsigned int, dim> nodes;
            nodes.fill(invalid);
            for (unsigned int l = 0, n = 0; l <= m; ++l)
              if (l != k)
                nodes[n++] = simplices[e].nodes[l];
            std::sort(nodes.begin(), nodes.end()); // the unused ones are last
            sides.emplace_back(nodes, e);
          }
      std::sort(sides.begin(), sides.end());

      std::vector<Face<dim>> faces;
      for (unsigned int i = 0; i < sides.size();)
        {
          unsigned int n = 1;
          while (i + n < sides.size() && sides[i + n].first == sides[i].first)
            ++n;
          if (n > 2)
            throw Error(std::to_string(n) + " elements share one face (elements " +
                        std::to_string(simplices[sides[i].second].number) + ", " +
                        std::to_string(simplices[sides[i + 1].second].number) + ", " +
                        std::to_string(simplices[sides[i + 2].second].number) + "); at most 2 may");
          faces.push_back({sides[i].first,
                           {{sides[i].second, n == 2 ? sides[i + 1].second : invalid}},
                           {{invalid, invalid}}});
          i += n;
        }
      return faces;
    }

    /// From which side an element of a body sees the face opposite its vertex @p k: the sign of the
    /// permutation that sorts the face's nodes, with that of the face in the element.
    template <int dim>
    bool
    side(const Element<dim> &element, const unsigned int k)
    {
      bool result = k % 2;
      for (unsigned int i = 0; i <= dim; ++i)
        for (unsigned int j = 0; j < i; ++j)
          if (i != k && j != k && element.nodes[j] > element.nodes[i])
            result = !result;
      return result;
    }

    /// Turns the elements of a curve or surface so that neighbours agree; false where that is not
    /// possible: it has one side only.
    template <int dim>
    bool
    orient(std::vector<Simplex<dim>> &simplices,
           const std::vector<Face<dim>> &faces,
           const unsigned int m)
    {
      // The direction in which an element runs along (m = 1: through) a face.
      const auto direction = [&](const unsigned int e, const Face<dim> &face) {
        const auto &nodes = simplices[e].nodes;
        const unsigned int k =
          std::find(nodes.begin(), nodes.begin() + m + 1, face.nodes[0]) - nodes.begin();
        return m == 1 ? k == 0 : nodes[(k + 1) % 3] == face.nodes[1];
      };

      std::vector<std::vector<unsigned int>> faces_of(simplices.size());
      for (unsigned int f = 0; f < faces.size(); ++f)
        if (!faces[f].at_boundary())
          for (const unsigned int e : faces[f].elements)
            faces_of[e].push_back(f);
      std::vector<bool> known(simplices.size(), false);
      std::vector<unsigned int> front;
      bool two_sides = true;
      for (unsigned int first = 0; first < simplices.size(); ++first)
        {
          if (known[first])
            continue;
          known[first] = true;
          front        = {first};
          while (!front.empty())
            {
              const unsigned int e = front.back();
              front.pop_back();
              for (const unsigned int f : faces_of[e])
                {
                  const auto &pair         = faces[f].elements;
                  const unsigned int other = pair[pair[0] == e];
                  const bool agree         = direction(e, faces[f]) != direction(other, faces[f]);
                  if (known[other])
                    {
                      two_sides = two_sides && agree;
                      continue;
                    }
                  if (!agree)
                    {
                      std::swap(simplices[other].nodes[0], simplices[other].nodes[1]);
                      std::swap(simplices[other].corners[0], simplices[other].corners[1]);
                    }
                  known[other] = true;
                  front.push_back(other);
                }
            }
        }
      return two_sides;
    }

    /// Gives numbers to elements without one. What is wrong with single elements is thrown.
    template <int dim>
    void
    check_nodes(std::vector<Simplex<dim>> &simplices,
                const LagrangianMesh<dim> &mesh,
                const unsigned int m)
    {
      std::vector<bool> used(mesh.n_nodes(), false);
      for (unsigned int e = 0; e < simplices.size(); ++e)
        {
          Simplex<dim> &simplex = simplices[e];
          if (simplex.number == LagrangianMesh<dim>::unnumbered)
            simplex.number = e;
          for (unsigned int k = 0; k <= m; ++k)
            {
              AssertIndexRange(simplex.nodes[k], mesh.n_nodes());
              used[simplex.nodes[k]] = true;
              for (unsigned int l = 0; l < k; ++l)
                if (simplex.nodes[k] == simplex.nodes[l])
                  throw Error("element " + std::to_string(simplex.number) +
                              " is degenerate: it has node " +
                              std::to_string(mesh.node_number(simplex.nodes[k])) + " at " +
                              text(mesh.nodes()[simplex.nodes[k]]) + " twice");
            }
        }
      for (unsigned int i = 0; i < used.size(); ++i)
        if (!used[i])
          throw Error("node " + std::to_string(mesh.node_number(i)) + " at " +
                      text(mesh.nodes()[i]) + " belongs to no element");
    }

    template <int dim>
    void
    check_repeats(const std::vector<Simplex<dim>> &simplices, const unsigned int m)
    {
      std::vector<std::pair<std::array<unsigned int, dim + 1>, unsigned int>> keys;
      keys.reserve(simplices.size());
      for (unsigned int e = 0; e < simplices.size(); ++e)
        {
          keys.emplace_back(simplices[e].nodes, e);
          auto &nodes = keys.back().first;
          std::fill(nodes.begin() + m + 1, nodes.end(), LagrangianMesh<dim>::invalid);
          std::sort(nodes.begin(), nodes.begin() + m + 1);
        }
      std::sort(keys.begin(), keys.end());
      for (unsigned int i = 1; i < keys.size(); ++i)
        if (keys[i].first == keys[i - 1].first)
          throw Error("element " + std::to_string(simplices[keys[i].second].number) +
                      " repeats element " + std::to_string(simplices[keys[i - 1].second].number) +
                      ": it has the same nodes");
    }
  } // namespace

  template <int dim>
  double
  simplex_measure(const unsigned int m, const std::array<dealii::Tensor<1, dim>, dim> &edges)
  {
    // Gram's determinant.
    dealii::Tensor<2, dim> products;
    for (unsigned int j = 0; j < dim; ++j)
      for (unsigned int k = 0; k < dim; ++k)
        products[j][k] = j < m && k < m ? edges[j] * edges[k] : double(j == k);
    return std::sqrt(std::max(0., determinant(products))) / (m == 3 ? 6 : m);
  }


  template <int dim>
  LagrangianMesh<dim>::LagrangianMesh(const unsigned int structure_dim,
                                      std::vector<Point<dim>> places,
                                      const std::vector<Simplex> &given,
                                      std::vector<std::uint64_t> numbers,
                                      const MPI_Comm communicator)
    : m(structure_dim)
    , mpi_communicator(communicator)
    , node_places(std::move(places))
    , node_numbers(std::move(numbers))
  {
    Assert(m == dim || m + 1 == dim, dealii::ExcInternalError());
    std::vector<Simplex> simplices = given;
    check_nodes<dim>(simplices, *this, m);
    check_repeats<dim>(simplices, m);
    face_list = make_faces<dim>(simplices, m);
    is_closed = std::none_of(face_list.begin(), face_list.end(), [](const Face &face) {
      return face.at_boundary();
    });
    if (m < dim && !orient<dim>(simplices, face_list, m) && is_closed)
      throw Error("the surface has one side only (like the bottle of Klein): it encloses nothing");
    element_list.reserve(simplices.size());
    for (Simplex &simplex : simplices)
      element_list.push_back(make_element<dim>(simplex, m));
    find_opposite_vertices();
    if (m == dim)
      check_sides();
    find_facets();
  }

  template <int dim>
  void
  LagrangianMesh<dim>::check_sides() const
  {
    for (const Face &face : face_list)
      if (!face.at_boundary())
        {
          const Element &first = element_list[face.elements[0]];
          const Element &other = element_list[face.elements[1]];
          if (side<dim>(first, face.opposite[0]) == side<dim>(other, face.opposite[1]))
            throw Error("elements " + std::to_string(first.number) + " and " +
                        std::to_string(other.number) + " at " + text(first.centroid) +
                        " lie on the same side of the face they share: they overlap, or the "
                        "mesh is folded there");
        }
  }

  template <int dim>
  void
  LagrangianMesh<dim>::find_opposite_vertices()
  {
    for (Face &face : face_list)
      for (unsigned int side = 0; side < 2; ++side)
        if (face.elements[side] != invalid)
          for (unsigned int k = 0; k <= m; ++k)
            if (std::find(face.nodes.begin(),
                          face.nodes.begin() + m,
                          element_list[face.elements[side]].nodes[k]) == face.nodes.begin() + m)
              face.opposite[side] = k;
  }

  template <int dim>
  const typename LagrangianMesh<dim>::ElementData &
  LagrangianMesh<dim>::element_data() const
  {
    return data_of_elements;
  }


  template <int dim>
  void
  LagrangianMesh<dim>::set_element_data(ElementData data)
  {
    data_of_elements = std::move(data);
  }


  template <int dim>
  std::vector<unsigned int>
  LagrangianMesh<dim>::parts() const
  {
    // The smallest element of each part stands for it while parts are joined.
    std::vector<unsigned int> parent(element_list.size()), result(element_list.size());
    std::iota(parent.begin(), parent.end(), 0u);
    const auto root = [&](unsigned int e) {
      while (parent[e] != e)
        e = parent[e] = parent[parent[e]];
      return e;
    };
    for (const Face &face : face_list)
      if (!face.at_boundary())
        {
          const unsigned int a = root(face.elements[0]), b = root(face.elements[1]);
          parent[std::max(a, b)] = std::min(a, b);
        }
    for (unsigned int e = 0, n = 0; e < result.size(); ++e)
      result[e] = parent[e] == e ? n++ : result[root(e)];
    return result;
  }

  template <int dim>
  void
  LagrangianMesh<dim>::turn(Element &element)
  {
    std::swap(element.nodes[0], element.nodes[1]);
    std::swap(element.shape_gradients[0], element.shape_gradients[1]);
  }

  template <int dim>
  void
  LagrangianMesh<dim>::orient_closed_parts(const Positions<dim> &X)
  {
    if (m == dim || !is_closed)
      return;
    const std::vector<unsigned int> part_of = parts();
    const std::vector<bool> turned          = parts_to_turn(*this, part_of, X, remark_list);
    for (unsigned int e = 0; e < element_list.size(); ++e)
      if (turned[part_of[e]])
        turn(element_list[e]);
    find_opposite_vertices();
    find_facets();
  }

  template <int dim>
  void
  LagrangianMesh<dim>::find_facets()
  {
    surface_facets.clear();
    interface_facets.clear();
    if (m < dim)
      for (const Element &element : element_list)
        {
          surface_facets.emplace_back();
          std::copy_n(element.nodes.begin(), dim, surface_facets.back().begin());
        }
    else
      for (const Face &face : face_list)
        {
          // Seen from the element of the smaller material id.
          unsigned int side = 0;
          if (!face.at_boundary())
            {
              const unsigned int id       = element_list[face.elements[0]].material_id;
              const unsigned int other_id = element_list[face.elements[1]].material_id;
              if (id == other_id)
                continue;
              side = other_id < id;
            }
          // Without vertex k an element of positive orientation leaves an outward face when k is
          // even.
          Facet facet;
          const auto &nodes = element_list[face.elements[side]].nodes;
          for (unsigned int l = 0, j = 0; l <= dim; ++l)
            if (l != face.opposite[side])
              facet[j++] = nodes[l];
          if (face.opposite[side] % 2 == 1)
            std::swap(facet[0], facet[1]);
          (face.at_boundary() ? surface_facets : interface_facets).push_back(facet);
        }
  }

  template <int dim>
  const std::vector<typename LagrangianMesh<dim>::Facet> &
  LagrangianMesh<dim>::surface() const
  {
    return surface_facets;
  }

  template <int dim>
  const std::vector<typename LagrangianMesh<dim>::Facet> &
  LagrangianMesh<dim>::interfaces() const
  {
    return interface_facets;
  }

  template <int dim>
  void
  LagrangianMesh<dim>::set_materials(const std::vector<unsigned int> &material_ids)
  {
    AssertDimension(material_ids.size(), element_list.size());
    for (unsigned int e = 0; e < element_list.size(); ++e)
      element_list[e].material_id = material_ids[e];
    remark_list.erase(std::remove_if(remark_list.begin(),
                                     remark_list.end(),
                                     [](const Remark &remark) { return remark.kind == "groups"; }),
                      remark_list.end());
    names_of_materials.clear();
    find_facets();
  }

  template <int dim>
  const typename LagrangianMesh<dim>::MaterialNames &
  LagrangianMesh<dim>::material_names() const
  {
    return names_of_materials;
  }

  template <int dim>
  void
  LagrangianMesh<dim>::set_material_names(MaterialNames names)
  {
    names_of_materials = std::move(names);
  }

  template <int dim>
  unsigned int
  LagrangianMesh<dim>::structure_dim() const
  {
    return m;
  }

  template <int dim>
  unsigned int
  LagrangianMesh<dim>::n_nodes() const
  {
    return node_places.size();
  }

  template <int dim>
  unsigned int
  LagrangianMesh<dim>::n_elements() const
  {
    return element_list.size();
  }

  template <int dim>
  const std::vector<Point<dim>> &
  LagrangianMesh<dim>::nodes() const
  {
    return node_places;
  }

  template <int dim>
  const std::vector<Element<dim>> &
  LagrangianMesh<dim>::elements() const
  {
    return element_list;
  }

  template <int dim>
  const std::vector<Face<dim>> &
  LagrangianMesh<dim>::faces() const
  {
    return face_list;
  }

  template <int dim>
  double
  LagrangianMesh<dim>::measure(const Element &element, const Positions<dim> &X) const
  {
    std::array<dealii::Tensor<1, dim>, dim> edges;
    for (unsigned int k = 0; k < m; ++k)
      edges[k] = X[element.nodes[k + 1]] - X[element.nodes[0]];
    return simplex_measure<dim>(m, edges);
  }


  template <int dim>
  double
  LagrangianMesh<dim>::longest_edge(const Element &element, const Positions<dim> &X) const
  {
    double result = 0;
    for (unsigned int j = 0; j <= m; ++j)
      for (unsigned int k = 0; k < j; ++k)
        result = std::max(result, X[element.nodes[j]].distance(X[element.nodes[k]]));
    return result;
  }


  template <int dim>
  std::vector<double>
  LagrangianMesh<dim>::node_measures() const
  {
    std::vector<double> result(n_nodes(), 0.);
    for (const Element &element : element_list)
      for (unsigned int k = 0; k <= m; ++k)
        result[element.nodes[k]] += element.measure / (m + 1);
    return result;
  }


  template <int dim>
  dealii::Point<dim>
  LagrangianMesh<dim>::corner(const Element &element, const unsigned int k) const
  {
    // By the shape functions, N_i = 1/(m+1) + g_i . y in the element's own frame about its
    // centroid.
    dealii::Tensor<2, dim> gradients;
    dealii::Tensor<1, dim> change; // of the shape functions, from the centroid to the corner
    for (unsigned int j = 0; j < dim; ++j)
      {
        gradients[j][j] = 1;
        if (j < m)
          {
            gradients[j] = element.shape_gradients[j + 1];
            change[j]    = (j + 1 == k ? 1. : 0.) - 1. / (m + 1);
            for (unsigned int l = m; l < dim; ++l)
              gradients[j][l] = 0;
          }
      }
    const dealii::Tensor<1, dim> way = invert(gradients) * change;
    dealii::Point<dim> result        = element.centroid;
    for (unsigned int l = 0; l < m; ++l)
      result += way[l] * element.frame[l];
    const dealii::Point<dim> &node = node_places[element.nodes[k]];
    return node.distance(result) < 1e-6 * element.diameter ? node : result;
  }


  template <int dim>
  std::uint64_t
  LagrangianMesh<dim>::node_number(const unsigned int i) const
  {
    return node_numbers.empty() ? i : node_numbers[i];
  }

  template <int dim>
  const std::vector<typename LagrangianMesh<dim>::Remark> &
  LagrangianMesh<dim>::remarks() const
  {
    return remark_list;
  }

  template <int dim>
  void
  LagrangianMesh<dim>::add_remark(Remark remark)
  {
    remark_list.push_back(std::move(remark));
  }

  template <int dim>
  bool
  LagrangianMesh<dim>::closed() const
  {
    return is_closed;
  }

  template <int dim>
  double
  LagrangianMesh<dim>::diameter() const
  {
    double result = 0;
    for (const Element &element : element_list)
      result = std::max(result, element.diameter);
    return result;
  }

  template <int dim>
  MPI_Comm
  LagrangianMesh<dim>::communicator() const
  {
    return mpi_communicator;
  }

  template <int dim>
  std::pair<unsigned int, unsigned int>
  LagrangianMesh<dim>::local_elements() const
  {
    const std::uint64_t n    = element_list.size();
    const std::uint64_t rank = dealii::Utilities::MPI::this_mpi_process(mpi_communicator);
    const std::uint64_t size = dealii::Utilities::MPI::n_mpi_processes(mpi_communicator);
    return {n * rank / size, n * (rank + 1) / size};
  }

  template double simplex_measure<2>(unsigned int, const std::array<dealii::Tensor<1, 2>, 2> &);
  template double simplex_measure<3>(unsigned int, const std::array<dealii::Tensor<1, 3>, 3> &);
  template class LagrangianMesh<2>;
  template class LagrangianMesh<3>;
} // namespace feib
