// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/failure.h>

#include <unistd.h>

#include <chrono>
#include <map>
#include <new>

namespace feib
{
  namespace
  {
    /// Messages about failures do not meet those of the work that failed.
    MPI_Comm
    separate(const MPI_Comm communicator)
    {
      static std::map<MPI_Comm, MPI_Comm> copies;
      const auto known = copies.find(communicator);
      if (known != copies.end())
        return known->second;
      MPI_Comm copy;
      MPI_Comm_dup(communicator, &copy);
      return copies[communicator] = copy;
    }


    /// Whether the request is fulfilled in time.
    bool
    wait(MPI_Request &request, const double seconds)
    {
      const auto start = std::chrono::steady_clock::now();
      for (int done = 0;;)
        {
          MPI_Test(&request, &done, MPI_STATUS_IGNORE);
          if (done != 0)
            return true;
          if (std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() >
              seconds)
            return false;
          usleep(1000);
        }
    }
  } // namespace


  void
  agree(const MPI_Comm communicator, const std::function<void()> &action, const std::string &where)
  {
    enum Outcome
    {
      good,
      curable,
      incurable
    };
    int n_ranks, rank;
    MPI_Comm_size(communicator, &n_ranks);
    MPI_Comm_rank(communicator, &rank);
    const MPI_Comm channel = n_ranks > 1 ? separate(communicator) : communicator;

    Outcome outcome = good;
    std::string trouble;
    const auto failed = [&](const Outcome how, const std::string &what) {
      outcome = how;
      trouble = (where.empty() ? "" : where + ": ") + what;
    };
    try
      {
        action();
      }
    catch (const LoneFailure &)
      {
        throw;
      }
    catch (const Incurable &failure)
      {
        failed(incurable, failure.what());
      }
    catch (const std::bad_alloc &)
      {
        failed(incurable, "out of memory");
      }
    catch (const std::exception &failure)
      {
        failed(curable, failure.what());
      }
    catch (...)
      {
        failed(curable, "it throws something that is no std::exception");
      }

    if (n_ranks > 1)
      {
        struct
        {
          int outcome, rank;
        } worst{outcome, rank};
        MPI_Request request;
        MPI_Iallreduce(MPI_IN_PLACE, &worst, 1, MPI_2INT, MPI_MAXLOC, channel, &request);
        if (outcome == good)
          MPI_Wait(&request, MPI_STATUS_IGNORE);
        else if (!wait(request, 30))
          throw LoneFailure(trouble);
        if (worst.outcome == good)
          return;
        outcome    = Outcome(worst.outcome);
        int length = trouble.size();
        MPI_Bcast(&length, 1, MPI_INT, worst.rank, channel);
        trouble.resize(length);
        MPI_Bcast(trouble.data(), length, MPI_CHAR, worst.rank, channel);
      }
    if (outcome == incurable)
      throw Incurable(trouble);
    if (outcome == curable)
      throw RunFailure(trouble);
  }
} // namespace feib
