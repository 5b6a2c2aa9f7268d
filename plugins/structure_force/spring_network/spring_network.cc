// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/message.h>
#include <feib/plugin.h>
#include <feib/registry.h>
#include <feib/structure_force/stencil_force.h>
#include <feib/text_file.h>

#include "spring_network_schema.h"

#include <cmath>
#include <map>
#include <set>
#include <sstream>

namespace feib
{
  /// Springs and dampers between pairs of nodes, E = sum k/2 (|X_j - X_i| - l)^2 and the force c (e
  /// . (U_j - U_i)) e, e the unit vector along the spring.
  template <int dim>
  class SpringNetwork : public StencilForce<SpringNetwork<dim>, 2, dim>
  {
  public:
    using Body      = typename StructureForce<dim>::Body;
    using Stiffness = typename StructureForce<dim>::Stiffness;

    explicit SpringNetwork(const Parameters &parameters)
      : parameters(parameters)
      , damping(parameters.number("damping"))
    {}

    void
    attach(const Body &body) override
    {
      this->communicator = body.mesh.communicator();
      if (parameters.has("file"))
        read(body);
      else
        take_edges(body);
      if (this->stencils.empty())
        parameters.fail("file", "has no springs");
      intact.assign(this->stencils.size(), 1.);
      const std::vector<double> measures = body.mesh.node_measures();
      std::vector<double> sums(measures.size(), 0.);
      // Twice the sum of a row's entries bounds the eigenvalues of its matrix.
      for (unsigned int s = 0; s < this->stencils.size(); ++s)
        for (const unsigned int i : this->stencils[s])
          sums[i] += 2 * constants[s];
      for (unsigned int i = 0; i < sums.size(); ++i)
        largest = std::max(largest, sums[i] / measures[i]);
    }

    template <typename Number>
    Number
    stencil_energy(const std::array<std::array<Number, dim>, 2> &X, const PointBatch &springs) const
    {
      Number square(Lanes(0.));
      for (unsigned int a = 0; a < dim; ++a)
        {
          const Number d = X[1][a] - X[0][a];
          square += d * d;
        }
      const Number extension = sqrt(square) - springs(lengths);
      return extension * extension * (.5 * springs(constants) * springs(intact));
    }

    void
    update_state(const Positions<dim> &X) override
    {
      if (!parameters.has("breaking_stretch"))
        return;
      const double limit = parameters.number("breaking_stretch");
      for (unsigned int s = 0; s < intact.size(); ++s)
        if (along(s, X).norm() > limit * lengths[s])
          intact[s] = 0;
    }

    bool
    viscous() const override
    {
      return damping > 0;
    }

    void
    viscous_load(const Positions<dim> &X,
                 const NodalField<dim> &U,
                 NodalField<dim> &load) const override
    {
      for (unsigned int s = 0; s < intact.size(); ++s)
        {
          const auto &[i, j]             = this->stencils[s];
          const dealii::Tensor<1, dim> e = direction(s, X);
          const dealii::Tensor<1, dim> f = damping * intact[s] * (e * (U[j] - U[i])) * e;
          load[i] += f;
          load[j] -= f;
        }
    }

    void
    viscous_tangent(const Positions<dim> &X, MatrixEntries &entries) const override
    {
      if (dealii::Utilities::MPI::this_mpi_process(this->communicator) != 0)
        return;
      for (unsigned int s = 0; s < intact.size(); ++s)
        {
          const dealii::Tensor<1, dim> e = direction(s, X);
          for (unsigned int k = 0; k < 2; ++k)
            for (unsigned int l = 0; l < 2; ++l)
              for (unsigned int a = 0; a < dim; ++a)
                for (unsigned int b = 0; b < dim; ++b)
                  entries.push_back({std::uint64_t(this->stencils[s][k]) * dim + a,
                                     std::uint64_t(this->stencils[s][l]) * dim + b,
                                     (k == l ? 1 : -1) * damping * intact[s] * e[a] * e[b]});
        }
    }

    Stiffness
    stiffness(const Positions<dim> &) const override
    {
      return {largest, 0.};
    }

    void
    archive(Archive &archive) override
    {
      archive("intact", intact);
    }

  private:
    dealii::Tensor<1, dim>
    along(const unsigned int s, const Positions<dim> &X) const
    {
      return X[this->stencils[s][1]] - X[this->stencils[s][0]];
    }

    /// Zero where both nodes are at one place.
    dealii::Tensor<1, dim>
    direction(const unsigned int s, const Positions<dim> &X) const
    {
      const dealii::Tensor<1, dim> d = along(s, X);
      return d.norm() > 0 ? d / d.norm() : d;
    }

    void
    add(const Body &body, const unsigned int i, const unsigned int j)
    {
      this->stencils.push_back({i, j});
      constants.push_back(parameters.number("stiffness"));
      lengths.push_back(parameters.has("rest_length")
                          ? parameters.number("rest_length")
                          : body.positions[i].distance(body.positions[j]));
    }

    void
    take_edges(const Body &body)
    {
      std::set<std::pair<unsigned int, unsigned int>> edges;
      for (const auto &element : body.mesh.elements())
        for (unsigned int k = 0; k <= body.mesh.structure_dim(); ++k)
          for (unsigned int l = 0; l < k; ++l)
            edges.insert(std::minmax(element.nodes[k], element.nodes[l]));
      for (const auto &[i, j] : edges)
        add(body, i, j);
    }

    void
    read(const Body &body)
    {
      const std::string file = parameters.string("file");
      std::string content;
      try
        {
          content = read_text_file(parameters.path("file"), file, true, parameters.communicator());
        }
      catch (const Error &error)
        {
          parameters.fail("file", error.issues().front().message);
        }
      std::map<std::uint64_t, unsigned int> index;
      for (unsigned int i = 0; i < body.mesh.n_nodes(); ++i)
        index[body.mesh.node_number(i)] = i;
      std::istringstream lines(content);
      unsigned int number = 0;
      for (std::string line; std::getline(lines, line);)
        {
          ++number;
          line = line.substr(0, line.find('#'));
          if (line.find_first_not_of(" \t\r") != std::string::npos)
            read_line(body, index, line, file + ":" + std::to_string(number));
        }
    }

    void
    read_line(const Body &body,
              const std::map<std::uint64_t, unsigned int> &index,
              const std::string &line,
              const std::string &where)
    {
      std::istringstream words(line);
      std::string word;
      std::uint64_t nodes[2];
      for (std::uint64_t &node : nodes)
        {
          if (!(words >> word))
            parameters.fail("file", where + ": lacks the numbers of two nodes");
          if (word.size() > 18 || word.find_first_not_of("0123456789") != std::string::npos)
            parameters.fail("file",
                            where + ": found \"" + readable(word, 40) +
                              "\" where the number of a node must stand");
          node = std::stoull(word);
          if (index.count(node) == 0)
            parameters.fail("file", where + ": the structure has no node " + std::to_string(node));
        }
      if (nodes[0] == nodes[1])
        parameters.fail("file", where + ": a spring needs two nodes");
      add(body, index.at(nodes[0]), index.at(nodes[1]));
      for (double *value : {&lengths.back(), &constants.back()})
        if (words >> word)
          {
            std::istringstream text(word);
            if (!(text >> *value) || !text.eof() || !(*value >= 0) || !std::isfinite(*value))
              parameters.fail("file",
                              where + ": found \"" + word + "\" where a " +
                                (value == &lengths.back() ? "rest length" : "stiffness") +
                                ", a number not less than 0, may stand");
          }
      if (words >> word)
        parameters.fail("file", where + ": found \"" + word + "\" after all a spring may have");
    }

    const Parameters parameters;
    const double damping;
    std::vector<double> constants, lengths; // k and l of the springs
    std::vector<double> intact;             // 1, or 0 when broken
    double largest = 0;                     // twice what acts at a node, per its measure
  };
} // namespace feib

FEIB_PLUGIN("spring_network", "1.0", registry)
{
  registry.add<feib::StructureForce, feib::SpringNetwork>("spring_network", spring_network_schema);
}
