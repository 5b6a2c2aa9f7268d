// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_nodal_field_h
#define feib_nodal_field_h

#include <feib/archive.h>

#include <deal.II/base/mpi.h>
#include <deal.II/base/point.h>
#include <deal.II/base/std_cxx20/iota_view.h>
#include <deal.II/base/tensor.h>

#include <algorithm>
#include <limits>
#include <type_traits>
#include <utility>
#include <vector>

namespace feib
{
  template <int dim>
  class LagrangianMesh;

  struct LagrangianPoints;

  /// A value for each node of a structure, or each of the points that ride on it: one for each that
  /// this rank holds, 0 to size() - 1, the numbers that elements of the mesh and LagrangianPoints
  /// use.
  ///
  /// A rank owns some values; of others it has copies, the ghosts. For now every rank holds and
  /// owns all of them, with the same values. It will not stay so: structures are to be divided
  /// between ranks underneath. What follows these rules will not notice:
  /// - A field is made from a mesh, from points or from another field of them.
  /// - What concerns each node by itself, such as X += dt U, is done for all of size(), so that
  ///   ghosts stay right.
  /// - Of nodes, elements, faces or points each is worked on by one rank (a node by its owner, an
  ///   element where LagrangianMesh::local_elements() has it, a point where its cell of the fluid
  ///   is), which adds to whatever value it must; compress() then sums up, and update_ghosts()
  ///   comes before what was summed up is read.
  /// - Sums and maxima over all nodes are made by sum(), largest() and the product of two fields.
  ///
  /// Nobody may rely on holding the whole structure, on size() being its number of nodes, on a node
  /// with a given number being here, or on how values are stored.
  ///
  /// @p Value: a point, or a tensor of rank 1.
  template <typename Value>
  class NodalValues
  {
  public:
    using value_type     = Value;
    using iterator       = typename std::vector<Value>::iterator;
    using const_iterator = typename std::vector<Value>::const_iterator;

    NodalValues() = default;

    /// Zero at the nodes of a mesh.
    template <int dim>
    explicit NodalValues(const LagrangianMesh<dim> &mesh)
      : values(mesh.n_nodes())
    {}

    /// Zero at points. Of lagrangian_points.h.
    explicit NodalValues(const LagrangianPoints &points);

    /// Zero at @p n nodes, points or faces of which every rank holds all.
    explicit NodalValues(const unsigned int n)
      : values(n)
    {}

    /// What every rank gives the same.
    NodalValues(std::vector<Value> values)
      : values(std::move(values))
    {}

    /// The values of another field, as points or as tensors.
    template <typename Iterator>
    NodalValues(const Iterator begin, const Iterator end)
      : values(begin, end)
    {}

    /// The number of values that this rank holds.
    std::size_t
    size() const
    {
      return values.size();
    }

    bool
    empty() const
    {
      return values.empty();
    }

    Value &
    operator[](const std::size_t i)
    {
      AssertIndexRange(i, values.size());
      return values[i];
    }

    const Value &
    operator[](const std::size_t i) const
    {
      AssertIndexRange(i, values.size());
      return values[i];
    }

    iterator
    begin()
    {
      return values.begin();
    }

    iterator
    end()
    {
      return values.end();
    }

    const_iterator
    begin() const
    {
      return values.begin();
    }

    const_iterator
    end() const
    {
      return values.end();
    }

    /// Whether all values that this rank holds are the same.
    bool
    operator==(const NodalValues &other) const
    {
      return values == other.values;
    }

    bool
    operator!=(const NodalValues &other) const
    {
      return values != other.values;
    }

    /// Every value becomes the sum of what the ranks of @p communicator have added to it, at the
    /// rank that owns it. What at most two elements or points add to depends on the number of ranks
    /// in no bit. Collective.
    void
    compress(const MPI_Comm communicator)
    {
      static_assert(sizeof(Value) == Value::dimension * sizeof(double));
      if (values.empty())
        return;
      const dealii::ArrayView<double> numbers(&values[0][0], values.size() * Value::dimension);
      dealii::Utilities::MPI::sum(dealii::ArrayView<const double>(numbers), communicator, numbers);
    }

    /// Ghosts get the values of their owners. Collective.
    void
    update_ghosts()
    {}

    /// The numbers of the values that this rank owns.
    dealii::std_cxx20::ranges::iota_view<unsigned int, unsigned int>
    owned() const
    {
      return {0u, static_cast<unsigned int>(size())};
    }

    /// The sum of @p term(i), a number or tensor, over all nodes i of the structure; term is asked
    /// for those that this rank owns. The same on all ranks. Collective.
    template <typename Term>
    auto
    sum(const Term &term) const
    {
      std::decay_t<decltype(term(0u))> result{};
      for (const unsigned int i : owned())
        result += term(i);
      return result;
    }

    /// The largest of @p term(i), a number, over all nodes; -infinity when there are none. Not a
    /// number counts for nothing. The same on all ranks. Collective.
    template <typename Term>
    double
    largest(const Term &term) const
    {
      double result = -std::numeric_limits<double>::infinity();
      for (const unsigned int i : owned())
        result = std::max<double>(result, term(i));
      return result;
    }

    /// What of its state an object that has the field carries from step to step.
    void
    archive(Archive &archive)
    {
      archive("values", values);
    }

  private:
    std::vector<Value> values;
  };

  /// The sum over all nodes of the products of two fields' values. The same on all ranks.
  /// Collective.
  template <typename Value>
  double
  operator*(const NodalValues<Value> &a, const NodalValues<Value> &b)
  {
    AssertDimension(a.size(), b.size());
    return a.sum([&](const unsigned int i) -> double { return a[i] * b[i]; });
  }

  /// A vector for each node, or each point that rides on the structure.
  template <int dim>
  using NodalField = NodalValues<dealii::Tensor<1, dim>>;

  /// The current position of each node, or point.
  template <int dim>
  using Positions = NodalValues<dealii::Point<dim>>;
} // namespace feib

#endif
