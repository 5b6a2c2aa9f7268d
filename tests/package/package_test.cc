// SPDX-License-Identifier: LGPL-2.1-or-later
// Feib installed, moved to another place, and used there: runs, plugins built outside the tree, a
// Debian package.
#include "support/run_case.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>

using namespace feib::testing;
namespace fs = std::filesystem;

namespace
{
  /// A command without what this program's environment holds.
  RunResult
  run_alone(const std::string &command, const std::string &folder)
  {
    return run_command("env -i PATH=\"$PATH\" HOME=\"$HOME\" OMPI_ALLOW_RUN_AS_ROOT=1 "
                       "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 " +
                         command,
                       folder);
  }


  /// Runs one of the cases that were installed under a prefix, in short, from the root folder.
  void
  expect_run(const std::string &prefix, const std::string &output)
  {
    const RunResult run =
      run_alone(shell_quoted(prefix + "/bin/feib-host") + " " +
                  shell_quoted(prefix + "/share/feib/cases/stretched_disc/case.json") +
                  " --set /domain/cells=[8,8] --set /time/end=3e-3 --output " +
                  shell_quoted(output),
                "/");
    EXPECT_EQ(run.exit_code, 0) << run.output;
    EXPECT_EQ(read_json(output + "/summary.json")["steps"], 3);
  }


  class Package : public ::testing::Test
  {
  protected:
    static void
    SetUpTestSuite()
    {
      folder                  = std::make_unique<TemporaryFolder>();
      const std::string first = *folder / "first";
      const RunResult install =
        run_command(shell_quoted(FEIB_CMAKE) + " --install " + shell_quoted(FEIB_BUILD) +
                    " --prefix " + shell_quoted(first));
      ASSERT_EQ(install.exit_code, 0) << install.output;
      prefix = *folder / "some where";
      fs::rename(first, prefix);
    }

    static void
    TearDownTestSuite()
    {
      folder.reset();
    }

    /// What find_package(Feib) says against itself, "" for nothing, in a CMake that knows these
    /// things.
    static std::string
    refusal(const std::string &things)
    {
      const std::string script = folder->write(
        "script.cmake",
        things + "\nfind_package(Feib CONFIG QUIET)\nmessage(\"${Feib_NOT_FOUND_MESSAGE}\")\n");
      std::string text =
        run_alone(shell_quoted(FEIB_CMAKE) + " -DCMAKE_PREFIX_PATH=" + shell_quoted(prefix) +
                    " -P " + shell_quoted(script),
                  "/")
          .output;
      return text.substr(0, text.find('\n'));
    }

    static std::unique_ptr<TemporaryFolder> folder;
    static std::string prefix;
  };

  std::unique_ptr<TemporaryFolder> Package::folder;
  std::string Package::prefix;
} // namespace


TEST_F(Package, HoldsNothingOfTheTreesItCameFrom)
{
  unsigned int n = 0;
  for (const auto &file : fs::recursive_directory_iterator(prefix))
    {
      EXPECT_FALSE(file.is_symlink()) << file.path();
      if (!file.is_regular_file())
        continue;
      ++n;
      const std::string text = read_file(file.path().string());
      for (const std::string path : {FEIB_SOURCE, FEIB_BUILD})
        for (std::size_t at = text.find(path); at != std::string::npos;
             at             = text.find(path, at + 1))
          // A short path may be the end of another one.
          EXPECT_TRUE(at > 0 && (std::isalnum(static_cast<unsigned char>(text[at - 1])) ||
                                 std::string("_.-/}>)").find(text[at - 1]) != std::string::npos))
            << file.path() << ": " << text.substr(at > 40 ? at - 40 : 0, 120);
    }
  EXPECT_GT(n, 80u);
}


TEST_F(Package, CasesFindTheirSchema)
{
  for (const auto &entry : fs::directory_iterator(prefix + "/share/feib/cases"))
    {
      const auto description = nlohmann::json::parse(
        read_file((entry.path() / "case.json").string()), nullptr, true, true);
      EXPECT_TRUE(fs::exists(entry.path() / description["$schema"].get<std::string>()))
        << entry.path();
    }
}


TEST_F(Package, RunsFromAnywhere)
{
  expect_run(prefix, *folder / "out");
  const RunResult study = run_alone(shell_quoted(prefix + "/bin/feib-study") + " --help", "/");
  EXPECT_EQ(study.exit_code, 0) << study.output;
}


// The law of docs/writing_a_law.md, from the very text.
TEST_F(Package, ALawIsBuiltTestedAndRunOutsideTheTree)
{
  const std::string page = read_file(FEIB_SOURCE "/docs/writing_a_law.md");
  const auto block       = [&](const std::string &language, const std::string &name) {
    const std::string opening = "```" + language + "\n";
    const std::size_t begin   = page.find(opening) + opening.size();
    folder->write("my_gent/" + name, page.substr(begin, page.find("```", begin) - begin));
  };
  const std::string host  = shell_quoted(prefix + "/bin/feib-host"),
                    cmake = shell_quoted(FEIB_CMAKE);
  // Not optimised, to be short.
  for (const std::string &command :
       {host + " --new-plugin constitutive_law my_gent --energy-only",
        cmake +
          " -S my_gent -B my_gent/build -DCMAKE_CXX_FLAGS_RELEASE=-DNDEBUG "
          "-DCMAKE_CXX_FLAGS_DEBUG= -DCMAKE_CXX_COMPILER=" +
          shell_quoted(FEIB_COMPILER) + " -DCMAKE_PREFIX_PATH=" + shell_quoted(prefix),
        cmake + " --build my_gent/build -j2",
        shell_quoted(FEIB_CTEST) + " --test-dir my_gent/build --output-on-failure",
        host + " --check-plugin my_gent/build/plugins/my_gent.feib.so",
        host + " my_gent/case.json --plugin-path my_gent/build/plugins --set /domain/cells=[8,8] "
               "--set /time/end=0.02 --set '/structures/0/hyperelastic/law={\"my_gent\": "
               "{\"shear_modulus\": 1, \"limit\": 2}}'"})
    {
      const RunResult result = run_alone(command, folder->path.string());
      ASSERT_EQ(result.exit_code, 0) << command << "\n" << result.output;
      if (holds(command, "--new-plugin"))
        {
          const std::string said = "Build it, test it and run its case:\n";
          EXPECT_TRUE(
            holds(page,
                  "```text\n" + result.output.substr(0, result.output.find(said)) + said + "```"))
            << result.output;
          block("cpp", "my_gent.cc");
          block("json", "my_gent.schema.json");
        }
      if (holds(command, "--test-dir"))
        EXPECT_TRUE(holds(result.output, "100% tests passed, 0 tests failed out of 1"))
          << result.output;
    }
  EXPECT_EQ(read_json(*folder / "output/my_gent/summary.json")["status"], "completed");
}


TEST_F(Package, WhatPluginsMustShareWithItIsRefusedWhenItDiffers)
{
  const std::string first = read_file(prefix + "/lib/cmake/Feib/FeibConfig.cmake");
  // What this build was made by, as the package says it.
  const auto recorded = [&](const std::string &before) {
    const std::size_t begin = first.find(before) + before.size();
    return first.substr(begin, first.find_first_of(",\"", begin) - begin);
  };
  const std::string compiler = recorded("this Feib was built by "),
                    id       = compiler.substr(0, compiler.find(' ')),
                    major    = compiler.substr(compiler.find(' ') + 1),
                    dealii   = recorded("this Feib was built on deal.II "),
                    other    = std::string(FEIB_CONFIGURATION) == "Debug" ? "Release" : "Debug";
  const auto with = [](const std::string &id, const std::string &version, const std::string &type) {
    return "set(CMAKE_CXX_COMPILER_ID " + id + ")\nset(CMAKE_CXX_COMPILER_VERSION " + version +
           ")\nset(CMAKE_BUILD_TYPE " + type + ")\n";
  };
  EXPECT_EQ(refusal(""),
            "Feib needs the language CXX: write project(... LANGUAGES CXX) before "
            "find_package(Feib)");
  EXPECT_EQ(refusal(with("Clang", "15.0.6", FEIB_CONFIGURATION)),
            "this Feib was built by " + compiler +
              ", and its plugins must be too; the compiler found is Clang 15.0.6: choose another "
              "with -DCMAKE_CXX_COMPILER=");
  EXPECT_EQ(refusal(with(id, "99.1.0", FEIB_CONFIGURATION)),
            "this Feib was built by " + compiler +
              ", and its plugins must be too; the compiler found is " + id +
              " 99.1.0: choose another with -DCMAKE_CXX_COMPILER=");
  EXPECT_EQ(refusal(with(id, major + ".9.0", other)),
            "this Feib was built as " FEIB_CONFIGURATION
            ", and its plugins must be too; the build type found is \"" +
              other + "\": configure with -DCMAKE_BUILD_TYPE=" FEIB_CONFIGURATION);
  const std::string fake = *folder / "other_dealii";
  fs::create_directory(fake);
  folder->write("other_dealii/deal.IIConfig.cmake", "set(DEAL_II_VERSION 9.5.0)\n");
  EXPECT_EQ(refusal(with(id, major + ".9.0", FEIB_CONFIGURATION) + "set(deal.II_DIR \"" + fake +
                    "\")\n"),
            "this Feib was built on deal.II " + dealii +
              ", and its plugins must be too; deal.II 9.5.0 was found in " + fake +
              ": choose another with -Ddeal.II_DIR=");
}


TEST_F(Package, TheDebianPackageRuns)
{
  if (run_command("command -v dpkg-deb dpkg-shlibdeps").exit_code != 0)
    GTEST_SKIP() << "no Debian";
  const std::string packages = *folder / "packages";
  const RunResult cpack =
    run_alone(shell_quoted(FEIB_CPACK) + " -G DEB --config " +
                shell_quoted(FEIB_BUILD "/CPackConfig.cmake") + " -B " + shell_quoted(packages),
              folder->path.string());
  ASSERT_EQ(cpack.exit_code, 0) << cpack.output;
  std::string package;
  for (const auto &file : fs::directory_iterator(packages))
    if (file.path().extension() == ".deb")
      package = shell_quoted(file.path().string());
  const std::string root = *folder / "root", about = run_command("dpkg-deb -f " + package).output;
  for (const char *const part : {"Package: feib\n", "libdeal.ii", "Recommends: ", "libdeal.ii-dev"})
    EXPECT_TRUE(holds(about, part)) << about;
  const RunResult unpacked = run_command("dpkg-deb -x " + package + " " + shell_quoted(root));
  ASSERT_EQ(unpacked.exit_code, 0) << unpacked.output;
  expect_run(root + "/usr", *folder / "out_of_package");
}
