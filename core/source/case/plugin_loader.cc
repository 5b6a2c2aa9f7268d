// SPDX-License-Identifier: LGPL-2.1-or-later
#define BOOST_DLL_USE_STD_FS
#include <feib/message.h>
#include <feib/plugin.h>
#include <feib/plugin_loader.h>

#include <boost/dll/runtime_symbol_info.hpp>
#include <boost/dll/shared_library.hpp>
#include <dlfcn.h>
#include <elf.h>
#include <signal.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <sstream>

namespace feib
{
  namespace
  {
    /// What is not a file of bytes, or "". Opening a fifo waits for its writer, and a device acts.
    std::string
    check_kind(const std::string &name)
    {
      using std::filesystem::file_type;
      std::error_code problem;
      switch (std::filesystem::status(name, problem).type())
        {
          case file_type::regular:
            return "";
          case file_type::not_found:
            return std::filesystem::is_symlink(name, problem) ? "is a link to nothing"
                                                              : "does not exist";
          case file_type::directory:
            return "is a folder";
          case file_type::fifo:
            return "is a fifo, not a file";
          case file_type::socket:
            return "is a socket, not a file";
          case file_type::block:
          case file_type::character:
            return "is a device, not a file";
          default:
            return "cannot be read" + (problem ? ": " + problem.message() : "");
        }
    }


    /// Whether a file is a whole ELF library. The system's loader maps a truncated one without
    /// looking and dies on the first access beyond its end.
    std::string
    check_file(const std::string &name)
    {
      if (const std::string problem = check_kind(name); !problem.empty())
        return problem;
      std::ifstream file(name, std::ios::binary);
      if (!file)
        return "cannot be read";
      Elf64_Ehdr header;
      if (!file.read(reinterpret_cast<char *>(&header), sizeof header) ||
          std::memcmp(header.e_ident, ELFMAG, SELFMAG) != 0)
        return "is not a shared library";
      file.seekg(0, std::ios::end);
      const auto size = static_cast<std::uint64_t>(file.tellg());
      if (header.e_ident[EI_CLASS] != ELFCLASS64)
        return "is not a 64-bit library";
      if (header.e_shoff + std::uint64_t(header.e_shnum) * header.e_shentsize > size ||
          header.e_phoff + std::uint64_t(header.e_phnum) * header.e_phentsize > size)
        return "is truncated";
      for (unsigned int i = 0; i < header.e_phnum; ++i)
        {
          Elf64_Phdr segment;
          file.seekg(header.e_phoff + std::uint64_t(i) * header.e_phentsize);
          if (!file.read(reinterpret_cast<char *>(&segment), sizeof segment) ||
              (segment.p_type == PT_LOAD && segment.p_offset + segment.p_filesz > size))
            return "is truncated";
        }
      return "";
    }


    /// Names the plugin whose code runs when the program ends under it: by std::exit, which runs
    /// handlers, or by a signal such as abort's. Nothing can see _exit and _Exit.
    class Watch
    {
    public:
      explicit Watch(const std::string &file)
      {
        static const bool registered =
          std::atexit(at_exit) == 0 && std::at_quick_exit(at_exit) == 0;
        (void)registered;
        sentence =
          "error: the plugin " + readable(file) + " ended the program while it was loaded\n";
        struct sigaction action = {};
        action.sa_handler       = on_signal;
        action.sa_flags         = SA_RESETHAND;
        for (unsigned int i = 0; i < n_signals; ++i)
          sigaction(signals[i], &action, &before[i]);
        active = true;
      }

      ~Watch()
      {
        active = false;
        for (unsigned int i = 0; i < n_signals; ++i)
          sigaction(signals[i], &before[i], nullptr);
      }

      Watch(const Watch &)            = delete;
      Watch &operator=(const Watch &) = delete;

    private:
      static constexpr unsigned int n_signals    = 5;
      static constexpr int signals[n_signals]    = {SIGABRT, SIGSEGV, SIGBUS, SIGILL, SIGFPE};
      static inline volatile sig_atomic_t active = false;
      static inline std::string sentence;
      struct sigaction before[n_signals];

      static void
      say()
      {
        if (active && write(STDERR_FILENO, sentence.data(), sentence.size()) < 0)
          return;
      }

      static void
      at_exit()
      {
        say();
        if (active)
          _exit(1);
      }

      static void
      on_signal(const int number)
      {
        say();
        raise(number);
      }
    };


    /// Takes what is printed meanwhile. A program that prints JSON must not print a plugin's words.
    class Printed
    {
    public:
      Printed()
        : before(dup(STDOUT_FILENO))
        , file(memfd_create("feib", MFD_CLOEXEC))
      {
        flush();
        active = before >= 0 && file >= 0 && dup2(file, STDOUT_FILENO) >= 0;
      }

      ~Printed()
      {
        flush();
        if (active)
          dup2(before, STDOUT_FILENO);
        for (const int descriptor : {before, file})
          if (descriptor >= 0)
            close(descriptor);
      }

      Printed(const Printed &)            = delete;
      Printed &operator=(const Printed &) = delete;

      /// Its beginning.
      std::string
      text() const
      {
        flush();
        char buffer[100];
        const ssize_t n = active ? pread(file, buffer, sizeof buffer, 0) : 0;
        return std::string(buffer, n > 0 ? n : 0);
      }

    private:
      const int before, file;
      bool active = false;

      static void
      flush()
      {
        std::cout << std::flush;
        std::fflush(stdout);
      }
    };


    /// The number of bytes of the data behind a symbol; 0 where it is no data.
    std::size_t
    size_of_data(const void *const symbol)
    {
      Dl_info info;
      const Elf64_Sym *entry = nullptr;
      void *extra            = nullptr;
      if (dladdr1(symbol, &info, &extra, RTLD_DL_SYMENT) == 0 || extra == nullptr)
        return 0;
      entry = static_cast<const Elf64_Sym *>(extra);
      return ELF64_ST_TYPE(entry->st_info) == STT_OBJECT ? entry->st_size : 0;
    }


    /// What is wrong with the plain data of a plugin, read before any of its code runs, or "".
    std::string
    check_handshake(const FeibPlugin &plugin)
    {
      const std::pair<const char *, const char *> texts[] = {{plugin.build_tag, "build tag"},
                                                             {plugin.name, "name"},
                                                             {plugin.version, "version"}};
      for (const auto &[text, what] : texts)
        {
          if (text == nullptr)
            return std::string("has no ") + what + ": it is not a Feib plugin";
          const std::size_t length = strnlen(text, 256);
          if (length == 0 || length == 256)
            return std::string("has a ") + what + (length == 0 ? " without text" : " without end") +
                   ": it is not a Feib plugin";
        }
      if (plugin.add_components == nullptr)
        return "has no function that adds components: it is not a Feib plugin";
      return "";
    }


    /// The loader's own words, without the path it repeats.
    std::string
    loader_message(const std::string &text, const std::string &file)
    {
      const std::size_t place = text.find(file + ": ");
      std::string message =
        place == std::string::npos ? text : text.substr(place + file.size() + 2);
      const std::size_t end = message.rfind("): Bad file descriptor");
      if (end != std::string::npos)
        message.erase(end);
      return message;
    }
  } // namespace


  PluginLoader::PluginLoader(Registry &registry)
    : registry(registry)
  {}


  void
  PluginLoader::load_directory(const std::string &directory)
  {
    std::error_code problem;
    std::filesystem::directory_iterator files(directory, problem);
    if (problem)
      throw Error("the plugin folder " + directory + " cannot be read: " + problem.message());
    std::vector<std::string> names;
    const std::string ending = ".feib.so";
    for (const auto &file : files)
      {
        const std::string name = file.path().filename().string();
        if (name.size() > ending.size() &&
            name.compare(name.size() - ending.size(), ending.size(), ending) == 0)
          names.push_back(file.path().string());
      }
    std::sort(names.begin(), names.end());
    for (const std::string &name : names)
      load(name);
  }


  const PluginLoader::Result &
  PluginLoader::load(const std::string &file)
  {
    // Never destroyed, so that no library is ever closed.
    static auto *const libraries = new std::vector<boost::dll::shared_library>;

    result_list.push_back({file, "", "", false, check_file(file), {}});
    Result &result = result_list.back();
    if (!result.reason.empty())
      return result;
    try
      {
        const Watch watch(file);
        const Printed printed;
        libraries->emplace_back(std::filesystem::absolute(file),
                                boost::dll::load_mode::rtld_now |
                                  boost::dll::load_mode::rtld_local);
        if (!libraries->back().has("feib_plugin"))
          {
            result.reason = "has no symbol feib_plugin: it is not a Feib plugin";
            return result;
          }
        const auto &plugin     = libraries->back().get<const FeibPlugin>("feib_plugin");
        const std::size_t size = size_of_data(&plugin);
        if (size < sizeof plugin.abi)
          {
            result.reason = "has a symbol feib_plugin that is not data: it is not a Feib plugin";
            return result;
          }
        if (plugin.abi != FEIB_ABI)
          {
            result.reason = "was built for interface version " + std::to_string(plugin.abi) +
                            "; this is version " + std::to_string(FEIB_ABI) + ": rebuild it";
            return result;
          }
        if (size != sizeof plugin)
          {
            result.reason = "has a description of " + std::to_string(size) + " bytes, and not of " +
                            std::to_string(sizeof plugin) + ": it is not a Feib plugin";
            return result;
          }
        if ((result.reason = check_handshake(plugin)) != "")
          return result;
        result.plugin  = readable(plugin.name);
        result.version = readable(plugin.version);
        if (std::strcmp(plugin.build_tag, FEIB_BUILD_TAG) != 0)
          {
            result.reason = "was built with \"" + readable(plugin.build_tag) + "\"; this is \"" +
                            FEIB_BUILD_TAG + "\": rebuild it";
            return result;
          }
        registry.transaction(result.plugin, file, [&](Registry &all) {
          plugin.add_components(all);
          if (const std::string text = printed.text(); !text.empty())
            throw Error("prints while it is loaded, \"" + readable(text, 60) + "\"");
        });
        result.accepted = true;
        for (const Registry::Entry &entry : registry.entries())
          if (entry.origin == file)
            result.components.push_back(entry.kind + "/" + entry.name);
      }
    catch (const std::system_error &failure)
      {
        result.reason = "cannot be loaded: " +
                        loader_message(failure.what(), std::filesystem::absolute(file).string());
      }
    catch (const std::exception &failure)
      {
        result.reason = failure.what();
        std::replace(result.reason.begin(), result.reason.end(), '\n', ';');
        result.reason = readable(result.reason);
      }
    catch (...)
      {
        result.reason = "throws something that is no std::exception while it adds its components";
      }
    return result;
  }


  const std::vector<PluginLoader::Result> &
  PluginLoader::results() const
  {
    return result_list;
  }


  std::vector<std::string>
  PluginLoader::search_path(const std::vector<std::string> &from_command_line)
  {
    std::vector<std::string> path;
    const auto add = [&](const std::string &directory) {
      std::error_code ignored;
      if (std::none_of(path.begin(), path.end(), [&](const std::string &known) {
            return known == directory || std::filesystem::equivalent(known, directory, ignored);
          }))
        path.push_back(directory);
    };
    for (const std::string &directory : from_command_line)
      add(directory);
    if (const char *const variable = std::getenv("FEIB_PLUGIN_PATH"))
      {
        std::istringstream directories(variable);
        for (std::string directory; std::getline(directories, directory, ':');)
          if (!directory.empty())
            add(directory);
      }
    // Beside the core's library, as installed as in a build tree.
    std::error_code ignored;
    const std::filesystem::path own =
      std::filesystem::weakly_canonical(boost::dll::this_line_location(), ignored).parent_path() /
      "feib" / "plugins";
    if (std::filesystem::is_directory(own, ignored))
      add(own.string());
    return path;
  }
} // namespace feib
