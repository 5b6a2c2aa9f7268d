// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/error.h>
#include <feib/log.h>
#include <feib/message.h>

#include <deal.II/base/mpi.h>

#include <spdlog/sinks/base_sink.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iostream>

namespace feib::log
{
  namespace
  {
    /// Standard error: information as it is, trouble with its level in front; and on a terminal the
    /// status line, which the next line replaces.
    class Console : public spdlog::sinks::base_sink<std::mutex>
    {
    public:
      void
      status(const std::string &line)
      {
        const std::lock_guard<std::mutex> lock(mutex_);
        std::cerr << "\r\033[K" << line << std::flush;
        pending = !line.empty();
      }

    protected:
      void
      sink_it_(const spdlog::details::log_msg &message) override
      {
        if (pending)
          std::cerr << "\r\033[K";
        pending = false;
        if (message.level != spdlog::level::info)
          std::cerr << spdlog::level::to_string_view(message.level).data() << ": ";
        std::cerr.write(message.payload.data(), message.payload.size());
        std::cerr << std::endl;
      }

      void
      flush_() override
      {
        std::cerr.flush();
      }

    private:
      bool pending = false;
    };


    /// The file: whole lines, or none any more once one could not be written, which is said.
    class File : public spdlog::sinks::base_sink<std::mutex>
    {
    public:
      File(const std::string &name, const bool append)
        : name(name)
        , stream(name, append ? std::ios::app : std::ios::trunc)
      {}

      bool
      good() const
      {
        return bool(stream);
      }

    protected:
      void
      sink_it_(const spdlog::details::log_msg &message) override
      {
        if (!stream)
          return;
        const auto whole = stream.tellp();
        spdlog::memory_buf_t line;
        formatter_->format(message, line);
        stream.write(line.data(), line.size());
        stream.flush();
        if (stream)
          return;
        // Without the head of a line that did not fit, now or when the stream is closed.
        stream.close();
        stream.setstate(std::ios::badbit);
        std::error_code ignored;
        if (whole >= 0 && std::filesystem::is_regular_file(name, ignored))
          std::filesystem::resize_file(name, whole, ignored);
        std::cerr << "warning: " << name << " cannot be written; it ends here" << std::endl;
      }

      void
      flush_() override
      {}

    private:
      std::string name;
      std::ofstream stream;
    };


    struct Output
    {
      Output()
      {
        console->set_level(spdlog::level::info);
        logger.set_level(spdlog::level::trace);
        logger.flush_on(spdlog::level::info);
      }

      std::shared_ptr<Console> console = std::make_shared<Console>();
      spdlog::logger logger{"feib", console};
    };


    /// Never destroyed: a library may log while the program ends.
    Output &
    output()
    {
      static auto *const output = new Output;
      return *output;
    }


    bool
    speaks()
    {
      return dealii::Utilities::MPI::this_mpi_process(MPI_COMM_WORLD) == 0;
    }


    void
    write(const spdlog::level::level_enum level, const std::string &message)
    {
      if (speaks())
        output().logger.log(level, spdlog::string_view_t(readable_lines(message)));
    }
  } // namespace


  void
  set_level(const std::string &level)
  {
    static const std::vector<std::pair<std::string, spdlog::level::level_enum>> levels = {
      {"trace", spdlog::level::trace},
      {"debug", spdlog::level::debug},
      {"info", spdlog::level::info},
      {"warning", spdlog::level::warn},
      {"error", spdlog::level::err},
      {"off", spdlog::level::off}};
    const auto place = std::find_if(levels.begin(), levels.end(), [&](const auto &entry) {
      return entry.first == level;
    });
    if (place == levels.end())
      throw Error("there is no log level \"" + level +
                  "\"; the levels are trace, debug, info, warning, error and off");
    output().console->set_level(place->second);
  }


  void
  open_file(const std::string &file, const bool append)
  {
    std::string problem;
    if (speaks())
      {
        const auto sink = std::make_shared<File>(file, append);
        if (!sink->good())
          problem = file + ": " + std::strerror(errno);
        sink->set_level(std::min(spdlog::level::info, output().console->level()));
        sink->set_pattern("%Y-%m-%d %H:%M:%S %l: %v");
        output().logger.sinks().push_back(sink);
      }
    problem = dealii::Utilities::MPI::broadcast(MPI_COMM_WORLD, problem);
    if (!problem.empty())
      throw RunFailure("cannot write the log file: " + problem);
  }


  void
  status(const std::string &line)
  {
    static const bool terminal = isatty(STDERR_FILENO) != 0;
    if (terminal && speaks() && output().console->should_log(spdlog::level::info))
      output().console->status(line);
  }


  void
  debug(const std::string &message)
  {
    write(spdlog::level::debug, message);
  }


  void
  info(const std::string &message)
  {
    write(spdlog::level::info, message);
  }


  void
  warning(const std::string &message)
  {
    write(spdlog::level::warn, message);
  }


  void
  error(const std::string &message)
  {
    write(spdlog::level::err, message);
  }
} // namespace feib::log
