// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/testing/constitutive_law_kit.h>
#include <feib/testing/stretched.h>

#include <functional>

FEIB_TEST_CONSTITUTIVE_LAW("by_material");

using namespace feib::testing;

namespace
{
  using Law = feib::ConstitutiveLaw<2, 2>;

  std::unique_ptr<Law>
  create(const std::string &laws)
  {
    return registry().create<Law>("by_material", "{\"laws\": [" + laws + "]}");
  }

  const std::string soft = R"({"materials": [0, 3], "law": {"neo_hookean": {"shear_modulus": 1}}})";
  const std::string stiff = R"({"materials": [1], "law": {"neo_hookean": {"shear_modulus": 5}}})";

  std::vector<Law::MaterialPoint>
  points_of(const std::vector<unsigned int> &materials)
  {
    std::vector<Law::MaterialPoint> points(materials.size());
    for (unsigned int q = 0; q < materials.size(); ++q)
      {
        points[q].material_id = materials[q];
        points[q].frame[0][0] = points[q].frame[1][1] = 1;
      }
    return points;
  }

  std::string
  refusal(const std::function<void()> &action)
  {
    try
      {
        action();
      }
    catch (const feib::Error &error)
      {
        return error.issues().front().message;
      }
    return "";
  }
} // namespace

TEST(ByMaterial, EachPointHasTheLawOfItsMaterial)
{
  const auto law = create(soft + ", " + stiff);
  law->set_points(points_of({3, 1, 0, 1}));
  Law::Matrix F;
  F[0][0] = F[1][1] = 1.1;
  std::vector<Law::Matrix> P;
  law->stress({F, F, F, F}, P);
  for (unsigned int q = 0; q < 4; ++q)
    EXPECT_NEAR(P[q][0][0], q % 2 == 0 ? 1.1 : 5.5, 1e-14);
}

TEST(ByMaterial, MaterialsWithoutALawAreRefused)
{
  const auto law           = create(soft + ", " + stiff);
  const std::string nobody = refusal([&] { law->set_points(points_of({0, 2})); });
  EXPECT_NE(nobody.find("no law for the material 2 of the mesh; there are laws for 0, 3, 1"),
            std::string::npos)
    << nobody;
  const std::string twice = refusal([] { create(soft + ", " + soft); });
  EXPECT_NE(twice.find("lists the material 0 a second time"), std::string::npos) << twice;
}

TEST(ByMaterial, MaterialsHaveNames)
{
  const std::string named =
    R"({"materials": ["soft tissue", 3], "law": {"neo_hookean": {"shear_modulus": 1}}}, )" + stiff;
  auto points        = points_of({7, 1, 3, 1});
  points[0].material = "soft tissue";
  points[1].material = "bone";
  const auto law     = create(named);
  law->set_points(points);
  Law::Matrix F;
  F[0][0] = F[1][1] = 1.1;
  std::vector<Law::Matrix> P;
  law->stress({F, F, F, F}, P);
  for (unsigned int q = 0; q < 4; ++q)
    EXPECT_NEAR(P[q][0][0], q % 2 == 0 ? 1.1 : 5.5, 1e-14);

  points[2].material_id = 2;
  points[2].material    = "skin";
  std::string message   = refusal([&] { law->set_points(points); });
  EXPECT_NE(message.find(
              "no law for the material 2 (\"skin\") of the mesh; there are laws for soft "
              "tissue, 3, 1"),
            std::string::npos)
    << message;
  points[2].material_id = 1;
  points[2].material    = "soft tissue";
  message               = refusal([&] { law->set_points(points); });
  EXPECT_NE(message.find(
              "has two laws for the material 1 (\"soft tissue\") of the mesh, one by its "
              "id and one by its name"),
            std::string::npos)
    << message;
}

TEST(ByMaterial, StateIsThatOfTheLaws)
{
  const auto law = create(
    R"({"materials": [0], "law": {"neo_hookean": {"shear_modulus": 1}}},
       {"materials": [1], "law": {"mullins_damage": {"r": 2, "m": 1, "law": {"neo_hookean": {"shear_modulus": 1}}}}})");
  law->set_points(points_of({0, 1}));
  ASSERT_EQ(law->state_variables().size(), 1u);
  EXPECT_EQ(law->state_variables()[0].name, "largest_energy_1");
  Law::Moment moment;
  moment.state = {{0, 0}};
  law->set_moment(moment);
  Law::Matrix F;
  F[0][0]    = 2;
  F[1][1]    = 1;
  auto state = moment.state;
  law->update_state({F, F}, state);
  EXPECT_EQ(state[0][0], 0);
  EXPECT_NEAR(state[0][1], 1.5, 1e-15);
}
