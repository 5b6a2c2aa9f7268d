// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/failure.h>

#include <unistd.h>

#include <chrono>
#include <new>

namespace feib
{
  namespace
  {
    /// Called when a communicator goes that has a copy.
    int
    forget(const MPI_Comm communicator, int, void *copy, void *)
    {
      if (communicator != MPI_COMM_WORLD) // which goes when MPI ends
        MPI_Comm_free(static_cast<MPI_Comm *>(copy));
      delete static_cast<MPI_Comm *>(copy);
      return MPI_SUCCESS;
    }


    /// A copy of the communicator, which lives as long: messages about failures do not meet those
    /// of the work that failed. Its handle alone would not do to find the copy again, as a later
    /// communicator may get it.
    MPI_Comm
    separate(const MPI_Comm communicator)
    {
      static const int key = [] {
        int result;
        MPI_Comm_create_keyval(MPI_COMM_NULL_COPY_FN, forget, &result, nullptr);
        return result;
      }();
      MPI_Comm *copy;
      int known;
      MPI_Comm_get_attr(communicator, key, &copy, &known);
      if (known == 0)
        {
          copy = new MPI_Comm;
          MPI_Comm_dup(communicator, copy);
          MPI_Comm_set_attr(communicator, key, copy);
        }
      return *copy;
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
