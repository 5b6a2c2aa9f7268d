// SPDX-License-Identifier: LGPL-2.1-or-later
// A law and a writer that go wrong while a run is under way.
#include <feib/constitutive_law.h>
#include <feib/failure.h>
#include <feib/output_writer.h>
#include <feib/plugin.h>

#include <sys/resource.h>

#include <csignal>
#include <limits>
#include <sstream>

namespace
{
  using namespace feib;

  /// Throws what the name of a fault says, limits the size of files as a batch system may, or sends
  /// the signals whose numbers it lists.
  void
  commit(const std::string &fault)
  {
    if (fault == "throws_int")
      throw 7;
    if (fault == "throws_std")
      throw std::runtime_error("the table of stresses ends here");
    if (fault == "throws_failure")
      throw RunFailure("the table of stresses ends here");
    if (fault == "throws_incurable")
      throw Incurable("the table of stresses ends here");
    if (fault == "limits_files")
      {
        const rlimit limit{4096, RLIM_INFINITY};
        setrlimit(RLIMIT_FSIZE, &limit);
      }
    std::istringstream words(fault);
    std::string word;
    if (words >> word && word == "signals")
      for (int number; words >> number;)
        raise(number);
  }


  /// W = |F|^2 / 2 until so many evaluations of the stress.
  template <int structure_dim, int dim>
  class Faulty : public ConstitutiveLaw<structure_dim, dim>
  {
  public:
    using Matrix = typename ConstitutiveLaw<structure_dim, dim>::Matrix;

    explicit Faulty(const Parameters &parameters)
      : fault(parameters.string("fault"))
      , start(parameters.integer("start"))
      , rank(parameters.integer("rank"))
    {}

    void
    energy(const std::vector<Matrix> &F, std::vector<double> &W) const override
    {
      W.assign(F.size(), 0.);
      for (std::size_t q = 0; q < F.size(); ++q)
        for (unsigned int i = 0; i < dim; ++i)
          W[q] += sign() / 2 * (F[q][i] * F[q][i]);
    }

    void
    stress(const std::vector<Matrix> &F, std::vector<Matrix> &P) const override
    {
      const bool faulty = ++n >= start;
      int this_rank;
      MPI_Comm_rank(MPI_COMM_WORLD, &this_rank);
      const bool signals = fault.rfind("signals", 0) == 0; // once
      if ((signals ? n == start : faulty) && (rank < 0 || rank == this_rank))
        commit(fault);
      P = F;
      for (Matrix &p : P)
        p *= sign() * (faulty && fault == "doubled" ? 2. : 1.);
      if (faulty && fault == "not_finite" && !P.empty())
        P.back()[0][0] = std::numeric_limits<double>::quiet_NaN();
    }

    void
    stress_derivative(const std::vector<Matrix> &,
                      const std::vector<Matrix> &dF,
                      std::vector<Matrix> &dP) const override
    {
      dP = dF;
      for (Matrix &p : dP)
        p *= sign();
    }

  private:
    double
    sign() const
    {
      return fault == "negative" ? -1 : 1;
    }

    const std::string fault;
    const int start, rank;
    mutable int n = 0;
  };


  template <int dim>
  class FaultyWriter : public OutputWriter<dim>
  {
  public:
    explicit FaultyWriter(const Parameters &parameters)
      : fault(parameters.string("fault"))
      , start(parameters.integer("start"))
      , rank(parameters.integer("rank"))
    {}

    unsigned int
    interval() const override
    {
      return 1;
    }

    void
    write(const typename OutputWriter<dim>::Snapshot &snapshot) override
    {
      int this_rank;
      MPI_Comm_rank(MPI_COMM_WORLD, &this_rank);
      if (int(snapshot.step) == start && (rank < 0 || rank == this_rank))
        commit(fault);
    }

  private:
    const std::string fault;
    const int start, rank;
  };


  const char *const schema = R"({
    "type": "object", "additionalProperties": false, "description": "Goes wrong.",
    "properties": {
      "fault": { "type": "string", "description": "What goes wrong [-].", "default": "none" },
      "start": { "type": "integer", "default": 0,
        "description": "From which evaluation of a law on, or at which step of a writer [-]." },
      "rank": { "type": "integer", "description": "On which rank; -1: all [-].", "default": -1 }
    },
    "examples": [ {} ] })";
} // namespace

FEIB_PLUGIN("faulty", "1.0", registry)
{
  registry.add<ConstitutiveLaw, Faulty>("faulty", schema);
  registry.add<OutputWriter, FaultyWriter>("faulty_writer", schema);
}
