#include <feib/plugin.h>
#include <feib/table_writer.h>

#include "my_writer_schema.h"

namespace my_writer_plugin
{
  /// A row for each state written: the time, and the centroid of each structure.
  template <int dim>
  class MyWriter : public feib::TableWriter<dim>
  {
  public:
    using Snapshot = typename feib::TableWriter<dim>::Snapshot;

    explicit MyWriter(const feib::Parameters &parameters)
      : feib::TableWriter<dim>("my_writer.csv", parameters.integer("interval"))
    {}

    /// All ranks have the same structures, and all call append(), which writes on one.
    void
    write(const Snapshot &snapshot) override
    {
      std::vector<std::string> columns = {"time"};
      std::vector<double> row          = {snapshot.time};
      for (const feib::ImmersedStructure<dim> &structure : snapshot.structures)
        {
          const dealii::Point<dim> X = structure.model->centroid(structure.model->positions);
          for (unsigned int a = 0; a < dim; ++a)
            {
              columns.push_back(std::string(1, "xyz"[a]) + "_" + structure.model->name());
              row.push_back(X[a]);
            }
        }
      this->append(snapshot, columns, {row});
    }
  };
} // namespace my_writer_plugin

FEIB_PLUGIN("my_writer", "1.0", registry)
{
  registry.add<feib::OutputWriter, my_writer_plugin::MyWriter>("my_writer", my_writer_schema);
}
