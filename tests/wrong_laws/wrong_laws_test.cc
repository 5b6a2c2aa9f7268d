// SPDX-License-Identifier: LGPL-2.1-or-later
// A wrong law is found before the first step, by name, and nothing is written.
#include "support/complaint.h"
#include "support/run_host.h"

#include <gtest/gtest.h>

#include <algorithm>

using namespace feib::testing;

namespace
{
  const char *const body = R"({ "hyperelastic": { "name": "disc",
    "mesh": { "rectangle": { "lower": [0.3, 0.3], "upper": [0.7, 0.7], "cells": [3, 3] } },
    "law": LAW MORE } })";

  const char *const body_3d = R"({ "hyperelastic": { "name": "disc",
    "mesh": { "box": { "lower": [0.3, 0.3, 0.3], "upper": [0.7, 0.7, 0.7], "cells": [2, 2, 2] } },
    "law": LAW MORE } })";

  const char *const curve = R"x({ "membrane": { "name": "disc",
    "mesh": { "closed_curve": { "length": 1, "elements": 12 } },
    "initial_position": ["0.5 + 0.2*cos(2*pi*s1)", "0.5 + 0.1*sin(2*pi*s1)"],
    "law": LAW MORE } })x";

  std::string
  case_of(std::string structure, const std::string &law, const std::string &more = "")
  {
    const bool in_3d = structure == body_3d;
    structure.replace(structure.find("LAW"), 3, law);
    structure.replace(structure.find("MORE"), 4, more);
    return std::string(R"({ "dimension": )") + (in_3d ? "3" : "2") + R"(, "domain": { "cells": )" +
           (in_3d ? "[2, 2, 2]" : "[4, 4]") +
           R"( }, "fluid": { "navier_stokes": { "density": 1, "viscosity": 1 } },
              "structures": [)" +
           structure + R"(], "time": { "step": 0.001, "end": 0.001 } })";
  }

  std::string
  judged(const std::string &text)
  {
    return complaint(text, {}, FEIB_WRONG_LAWS);
  }

  std::string
  wrong(const std::string &fault)
  {
    return "{ \"wrong_law\": { \"fault\": \"" + fault + "\" } }";
  }

  struct Fault
  {
    const char *name, *sentence;
    bool everywhere = true; // for curves too
  };

  const Fault faults[] = {
    {"sign", "its stress is -1.000 times dW/dF"},
    {"twice", "its stress is 2.000 times dW/dF"},
    {"somewhere", "its stress is not dW/dF: along random displacements its work is"},
    {"both negative", "its energy falls, from -"},
    {"transposed", "its stress is not dW/dF", false},
    {"other order", "its stress is not dW/dF"},
    {"constant", "its stress is not dW/dF"},
    {"infinite", "fails in its stress: it is not finite in element 0, at the reference place ("},
    {"energy lacks a term", "its stress is not dW/dF"},
    {"no energy", "its stress is not dW/dF: its energy does not change where its stress does work"},
    {"not a number at rest",
     "fails in its energy: it is not finite in element 0, at the reference place (",
     false},
    {"derivative lacks a term", "the derivative of its stress is not what differences"},
    {"no derivative", "the derivative of its stress is zero, where its stress changes"},
    {"half the derivative", "the derivative of its stress is given as 0.500 times"},
    {"derivative not a number",
     "fails in its derivative of the stress: it is not finite in element 0"},
    {"not linear", "it says that its stress is linear in F"},
    {"state, another variable", "fails in its state: it gives 2 state variables, it has 1"},
    {"state, a value too many", "fails in its state: it gives "},
    {"state, not a number", "fails in its state: it is not finite in element 0"},
    {"state, energy grows", "when its state moves on"},
    {"viscous, sign", "its viscous stress drives the structure instead of damping it"},
    {"viscous, square", "its viscous stress is not linear in dF/dt"},
    {"viscous, no potential", "its viscous stress has no dissipation potential"},
    {"viscous, rotation", "its viscous stress resists when the structure is turned as a whole"},
    {"not objective", "when the structure is turned as a whole", false}};
} // namespace


TEST(WrongLaws, EachIsStoppedByName)
{
  for (const char *const structure : {body, body_3d, curve})
    for (const Fault &fault : faults)
      if (structure != curve || fault.everywhere)
        {
          SCOPED_TRACE(fault.name + std::string(structure == curve ? ", curve" : "") +
                       (structure == body_3d ? ", 3D" : ""));
          const std::string said = judged(case_of(structure, wrong(fault.name)));
          EXPECT_NE(said.find(std::string("/structures/0/") +
                              (structure == curve ? "membrane" : "hyperelastic") +
                              "/law: the law \"wrong_law\" of structure \"disc\" "),
                    std::string::npos)
            << said;
          EXPECT_NE(said.find(fault.sentence), std::string::npos) << said;
        }
}

/// Without a compiler too, in words that say what is wrong with which law; nothing is written.
TEST(WrongLaws, CheckPluginNamesEach)
{
  const TemporaryFolder folder;
  const RunResult checked =
    run_host("--check-plugin " FEIB_WRONG_LAWS "/examples/wrong_examples.feib.so",
             1,
             folder.path.string());
  EXPECT_EQ(checked.exit_code, 2) << checked.output;
  EXPECT_TRUE(std::filesystem::is_empty(folder.path));
  const auto said_of = [&](std::string name) {
    std::replace(name.begin(), name.end(), ' ', '_');
    std::replace(name.begin(), name.end(), ',', '_');
    const std::size_t begin = checked.output.find("\nconstitutive_law/" + name + "\n");
    if (begin == std::string::npos)
      return "nothing is said of " + name + ": " + checked.output;
    return checked.output.substr(begin, checked.output.find("\nconst", begin + 1) - begin);
  };
  EXPECT_EQ(said_of("wrong_law").find("FAILED"), std::string::npos) << said_of("wrong_law");
  for (const Fault &fault : faults)
    EXPECT_NE(said_of(fault.name).find("FAILED\n"), std::string::npos) << said_of(fault.name);
  for (const auto &[fault, sentence] :
       {std::pair<const char *, const char *>{"twice", "P : dF is 2 times the change of W"},
        {"sign", "P : dF is -1 times the change of W"},
        {"both negative", "are energy and stress negative?"},
        {"viscous, sign", "the viscous stress drives instead of damping"},
        {"not linear", "linear() is true, but dP depends on F"},
        {"not objective", "W(Q F) is not W(F)"},
        {"not a number at rest", "W is not finite at F = I"},
        {"half the derivative", "dP is not the derivative of P"},
        {"declared, stress free", "the schema declares \"stress_free\": \"always\", but |P| = "},
        {"declared, resists collapse",
         "the schema declares \"resists_collapse\": \"always\", but W = "},
        {"declared, not convex",
         "the schema declares \"rank_one_convex\": \"never\", but here it is"},
        {"declared, both found",
         "the schema declares \"rank_one_convex\": \"sometimes\", but it is for every example"},
        {"declared, unknown", "the schema, /declares/polyconvex: "},
        {"declared, but loses convexity",
         "the schema declares \"rank_one_convex\": \"always\", but d2W/dF2 [a x n, a x n] is -"},
        {"declared, but loses convexity",
         "the schema declares \"stress_free\": \"never\", but here it is"},
        {"refused", "is refused in every dimension: "}})
    EXPECT_NE(said_of(fault).find(sentence), std::string::npos) << said_of(fault);
}

TEST(WrongLaws, RunsEndBeforeAnythingIsWrittenOnAnyNumberOfRanks)
{
  for (const unsigned int ranks : {1, 2})
    for (const std::string options : {"", "--validate"})
      {
        const TemporaryFolder folder;
        const std::string file = folder.write("case.json", case_of(body, wrong("twice")));
        const RunResult end =
          run_host(options + " --plugin-path " + shell_quoted(FEIB_WRONG_LAWS) + " " +
                     shell_quoted(file) + " --output " + shell_quoted(folder / "results"),
                   ranks);
        EXPECT_EQ(end.exit_code, 2);
        EXPECT_NE(end.output.find("2.000 times dW/dF"), std::string::npos) << end.output;
        EXPECT_FALSE(std::filesystem::exists(folder / "results"));
      }
}

/// What is wrong inside a split, without the load of the boundary, or with Gauss points.
TEST(WrongLaws, OptionsHideNothing)
{
  for (const std::string more : {", \"deviatoric\": true, \"volumetric_modulus\": 10",
                                 ", \"boundary_faces\": false",
                                 ", \"face_quadrature\": { \"gauss\": { \"points\": 2 } }"})
    for (const std::string fault : {"sign", "twice", "both negative", "no derivative"})
      EXPECT_NE(judged(case_of(body, wrong(fault), more)), "") << more << ", " << fault;
}

TEST(WrongLaws, RightLawsPass)
{
  const std::string stretched = ", \"initial_position\": [\"0.5 + 1.4*(s1-0.5)\", "
                                "\"0.5 + 0.7*(s2-0.5) + 0.2*s1*s2\"]";
  const std::string squeezed  = ", \"initial_position\": [\"0.5 + 0.3*(s1-0.5)\", "
                                "\"0.5 + 0.4*(s2-0.5)\"]";
  const std::string fibres    = "\"fibres\": [[1, 0]]";
  for (const std::string &law :
       {std::string("{ \"wrong_law\": { \"fault\": \"none\" } }"),
        std::string("{ \"wrong_law\": { \"fault\": \"viscous\" } }"),
        std::string("{ \"wrong_law\": { \"fault\": \"state\" } }"),
        std::string("{ \"neo_hookean\": { \"shear_modulus\": 1 } }"),
        std::string("{ \"neo_hookean\": { \"shear_modulus\": 1e-9, \"stress_free\": true } }"),
        "{ \"anisotropic_linear\": { \"stiffness\": 1e9, " + fibres + " } }",
        std::string("{ \"mooney_rivlin_fibres\": { \"c1\": 0, \"c2\": 1 } }"),
        std::string("{ \"mooney_rivlin_fibres\": { \"c1\": 1, \"c2\": 1 } }"),
        "{ \"mooney_rivlin_fibres\": { \"c1\": 0, \"fibre_modulus\": 2, \"tension_only\": true, " +
          fibres + " } }",
        "{ \"mooney_rivlin_fibres\": { \"c1\": 0, \"fibre_modulus\": 2, " + fibres + " } }"})
    for (const std::string &more : {std::string(), stretched, squeezed})
      for (const std::string options : {"",
                                        ", \"deviatoric\": true",
                                        ", \"volumetric_modulus\": 100",
                                        ", \"face_quadrature\": { \"gauss\": { \"points\": 2 } }",
                                        ", \"boundary_faces\": false"})
        EXPECT_EQ(judged(case_of(body, law, more + options)), "");
  for (const std::string law : {"{ \"neo_hookean\": { \"shear_modulus\": 1 } }",
                                "{ \"mooney_rivlin_fibres\": { \"c1\": 1, \"c2\": 0 } }",
                                "{ \"anisotropic_linear\": { \"stiffness\": 1 } }"})
    EXPECT_EQ(judged(case_of(curve, law)), "");
}
