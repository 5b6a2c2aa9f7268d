// SPDX-License-Identifier: LGPL-2.1-or-later
#include "new_plugin.h"

#include <feib/error.h>
#include <feib/message.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <vector>

namespace feib
{
  namespace
  {
    namespace fs = std::filesystem;

    fs::path
    program()
    {
      return fs::read_symlink("/proc/self/exe");
    }


    /// The folder that holds bin, lib and share, installed or of a build.
    fs::path
    prefix()
    {
      return program().parent_path().parent_path();
    }


    fs::path
    template_folder(const NewPlugin &plugin)
    {
      const fs::path all = prefix() / "share" / "feib" / "templates";
      std::string kinds;
      std::error_code problem;
      std::set<std::string> folders;
      for (const auto &entry : fs::directory_iterator(all, problem))
        folders.insert(entry.path().filename().string());
      if (problem)
        throw Error("the templates of plugins, " + all.string() +
                    ", cannot be read: " + problem.message());
      for (const std::string &folder : folders)
        if (folder.find('.') == std::string::npos)
          kinds += (kinds.empty() ? "" : ", ") + folder;
      if (folders.count(plugin.kind) == 0 || plugin.kind.find('.') != std::string::npos)
        throw Error("there is no template of a plugin of the kind \"" + plugin.kind +
                    "\"; the kinds are " + kinds);
      return all / (plugin.style.empty() ? plugin.kind : plugin.kind + "." + plugin.style);
    }


    void
    check_name(const NewPlugin &plugin, const Registry &registry)
    {
      const std::string &name = plugin.name;
      if (name.empty() || !std::isalpha(static_cast<unsigned char>(name[0])) ||
          !std::all_of(name.begin(), name.end(), [](const unsigned char c) {
            return c < 128 && (std::isalnum(c) || c == '_');
          }))
        throw Error("the name \"" + name +
                    "\" will not do: a name begins with a letter and holds letters, digits and _");
      for (const char *const kept : {"all",
                                     "clean",
                                     "depend",
                                     "edit_cache",
                                     "help",
                                     "install",
                                     "list_install_components",
                                     "package",
                                     "package_source",
                                     "preinstall",
                                     "rebuild_cache",
                                     "test"})
        if (name == kept)
          throw Error("the name \"" + name + "\" will not do: CMake has a target of this name");
      for (const Registry::Entry &entry : registry.entries())
        if (entry.name == name || entry.plugin == name)
          throw Error("the " + entry.kind + " \"" + entry.name + "\" exists already, from " +
                      entry.origin + "; choose another name");
    }


    /// "MyLaw" for "my_law".
    std::string
    class_name(const std::string &name)
    {
      std::string result;
      bool begins = true;
      for (const char c : name)
        {
          if (c != '_')
            result += begins ? char(std::toupper(static_cast<unsigned char>(c))) : c;
          begins = c == '_';
        }
      return result;
    }


    std::string
    replaced(std::string text, const std::string &from, const std::string &to)
    {
      for (std::size_t at = text.find(from); at != std::string::npos;
           at             = text.find(from, at + to.size()))
        text.replace(at, from.size(), to);
      return text;
    }


    std::string
    for_shell(const std::string &word)
    {
      const bool plain = std::all_of(word.begin(), word.end(), [](const unsigned char c) {
        return std::isalnum(c) || std::string("_./-+").find(char(c)) != std::string::npos;
      });
      return plain ? word : "'" + replaced(word, "'", "'\\''") + "'";
    }


    std::string
    how_to_go_on(const std::string &directory)
    {
      // cmake and the shell look there by themselves.
      const bool known         = prefix() == "/usr" || prefix() == "/usr/local";
      const std::string folder = for_shell(directory), build = for_shell(directory + "/build");
      std::ostringstream text;
      text << "Build it, test it and run its case:\n  cmake -S " << folder << " -B " << build
           << (known ? "" : " -DCMAKE_PREFIX_PATH=" + for_shell(prefix().string()))
           << "\n  cmake --build " << build << " -j\n  ctest --test-dir " << build
           << " --output-on-failure\n  " << (known ? "feib-host" : for_shell(program().string()))
           << ' ' << for_shell(directory + "/case.json") << " --plugin-path "
           << for_shell(directory + "/build/plugins") << '\n';
      return text.str();
    }
  } // namespace


  std::string
  write(const NewPlugin &plugin, const Registry &registry)
  {
    const fs::path source = template_folder(plugin), target = plugin.directory;
    check_name(plugin, registry);
    std::error_code problem;
    if (fs::symlink_status(target, problem).type() != fs::file_type::not_found)
      throw Error("the folder " + target.string() +
                  " exists already; choose another with --dir, or another name");

    // A template is a plugin itself, of the name that its schema has.
    std::string old;
    std::vector<fs::path> files;
    const std::string ending = ".schema.json";
    for (const auto &entry : fs::directory_iterator(source))
      {
        files.push_back(entry.path());
        const std::string name = entry.path().filename().string();
        if (const std::size_t end = name.find(ending); end != std::string::npos)
          old = name.substr(0, end);
      }
    std::sort(files.begin(), files.end());

    if (!fs::create_directories(target, problem))
      throw Error("cannot make the folder " + target.string() + ": " + problem.message());
    std::string written;
    for (const fs::path &file : files)
      {
        std::ostringstream text;
        text << std::ifstream(file).rdbuf();
        const std::string name = replaced(file.filename().string(), old, plugin.name);
        std::ofstream stream(target / name);
        stream << replaced(replaced(text.str(), class_name(old), class_name(plugin.name)),
                           old,
                           plugin.name)
               << std::flush;
        if (!stream)
          throw Error("cannot write " + (target / name).string());
        written += "  " + (target / name).string() + "\n";
      }
    return "Wrote the " + plugin.kind + " " + plugin.name + ":\n" + written +
           how_to_go_on(plugin.directory);
  }
} // namespace feib
