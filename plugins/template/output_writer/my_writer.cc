#include <feib/appended_file.h>
#include <feib/failure.h>
#include <feib/output_writer.h>
#include <feib/plugin.h>

#include <deal.II/base/mpi.h>

#include <iomanip>
#include <sstream>

#include "my_writer_schema.h"

namespace my_writer_plugin
{
  /// A line for each state written: the time, and the centroid of each structure's nodes.
  template <int dim>
  class MyWriter : public feib::OutputWriter<dim>
  {
  public:
    using Snapshot = typename feib::OutputWriter<dim>::Snapshot;

    explicit MyWriter(const feib::Parameters &parameters)
      : steps(parameters.integer("interval"))
    {}

    unsigned int
    interval() const override
    {
      return steps;
    }

    void
    write(const Snapshot &snapshot) override
    {
      std::ostringstream line;
      line << std::setprecision(17) << snapshot.time;
      for (const feib::ImmersedStructure<dim> &structure : snapshot.structures)
        {
          const dealii::Point<dim> X = structure.model->centroid(structure.model->positions);
          for (unsigned int a = 0; a < dim; ++a)
            line << ' ' << X[a];
        }
      // All ranks have the same structures; one writes, and all learn of a failure.
      feib::agree(snapshot.space.communicator(), [&] {
        if (dealii::Utilities::MPI::this_mpi_process(snapshot.space.communicator()) != 0)
          return;
        if (!file.is_open())
          file.open(snapshot.directory + "/" + name, "# time, centroids\n");
        file.append(line.str() + "\n");
      });
    }

    /// A run that is taken up at a checkpoint cuts the file to what it was there, and goes on.
    void
    archive(feib::Archive &archive) override
    {
      archive("file", file);
    }

    void
    reopen(const std::string &directory) override
    {
      feib::agree(MPI_COMM_WORLD, [&] {
        if (dealii::Utilities::MPI::this_mpi_process(MPI_COMM_WORLD) == 0)
          file.reopen(directory + "/" + name);
      });
    }

  private:
    static constexpr const char *name = "my_writer.txt";

    const unsigned int steps;
    feib::AppendedFile file;
  };
} // namespace my_writer_plugin

FEIB_PLUGIN("my_writer", "1.0", registry)
{
  registry.add<feib::OutputWriter, my_writer_plugin::MyWriter>("my_writer", my_writer_schema);
}
