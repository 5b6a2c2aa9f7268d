// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/failure.h>

#include <deal.II/base/mpi.h>

#include <gtest/gtest.h>

using namespace feib;

/// A communicator that is freed gives its handle to the next, of other ranks or in another order.
TEST(Agree, KnowsCommunicatorsFromThoseBefore)
{
  const int rank = dealii::Utilities::MPI::this_mpi_process(MPI_COMM_WORLD);
  for (unsigned int i = 0; i < 3; ++i)
    for (const int sign : {1, -1})
      {
        MPI_Comm group;
        MPI_Comm_split(MPI_COMM_WORLD, 0, sign * rank, &group);
        const bool first = dealii::Utilities::MPI::this_mpi_process(group) == 0;
        std::string found;
        try
          {
            agree(
              group,
              [&] {
                if (first)
                  throw RunFailure("the first one fails");
              },
              "here");
          }
        catch (const RunFailure &failure)
          {
            found = failure.what();
          }
        EXPECT_EQ(found, "here: the first one fails") << sign;
        MPI_Comm_free(&group);
      }
}
