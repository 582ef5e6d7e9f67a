// COLLADA 1.5: kinematics, formulas, archives.

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <tuple>

#include "prehend/geometry/errors.h"
#include "tests/robot/formats/robot_files.h"
#include "tests/robot/formats/zip_files.h"

namespace prehend::robot::formats {
namespace {

namespace fs = std::filesystem;
using geometry::InputError;
using geometry::RigidTransform;
using testing::HasSubstr;
using Kind = JointDescription::Kind;
using ColladaFiles = RobotFiles;

/// In centimetres; a finger that follows, and a body that is tied to its link's node.
std::string collada(const std::string& formula) {
  return R"(<COLLADA xmlns="http://www.collada.org/2008/03/COLLADASchema" version="1.5.0">
  <asset><contributor><authoring_tool>by hand</authoring_tool></contributor><unit meter="0.01" name="cm"/></asset>
  <library_joints><joint id="j0" name="turn"><revolute sid="axis0"><axis>0 0 2</axis>
    <limits><min>-90</min><max>45</max></limits></revolute></joint></library_joints>
  <library_visual_scenes><visual_scene id="v"><node id="n1" name="arm"/></visual_scene></library_visual_scenes>
  <library_kinematics_models><kinematics_model id="k" name="lift"><technique_common>
    <instance_joint url="#j0" sid="first"/>
    <joint sid="second" name="slide"><prismatic sid="axis0"><axis>1 0 0</axis></prismatic></joint>
    <link sid="l0" name="base"><attachment_full joint="k/first"><rotate>0 1 0 90</rotate><translate>10 0 0</translate>
      <link sid="l1" name="arm"><attachment_full joint="k/second"><translate>0 20 0</translate>
        <link sid="l2" name="tip"><translate>0 0 5</translate></link></attachment_full></link></attachment_full></link>
    <formula><target><param>k/second/axis0</param></target><technique_common>)" +
         formula + R"(</technique_common></formula>
  </technique_common></kinematics_model></library_kinematics_models>
  <library_articulated_systems>
    <articulated_system id="a"><kinematics><technique_common>
      <axis_info sid="i0" axis="k/first/axis0"><limits><min><float>-60</float></min></limits></axis_info></technique_common></kinematics>
      <extra type="manipulator" name="arm"/></articulated_system>
    <articulated_system id="m"><motion><technique_common>
      <axis_info axis="a/i0"><speed><float>90</float></speed></axis_info></technique_common></motion></articulated_system>
  </library_articulated_systems>
  <library_physics_models><physics_model id="p"><rigid_body sid="b1"><technique_common><mass>3</mass>
    <mass_frame><translate>0 7 0</translate></mass_frame><inertia>0.1 0.2 0.15</inertia></technique_common></rigid_body></physics_model></library_physics_models>
  <library_physics_scenes><physics_scene id="s"><instance_physics_model url="#p">
    <instance_rigid_body body="b1" target="#n1"/></instance_physics_model></physics_scene></library_physics_scenes>
</COLLADA>)";
}

const std::string kHalfAndAThousandth =
    "<math><apply><plus/><apply><times/><cn>0.5</cn><csymbol>k/first</csymbol></apply>"
    "<cn>0.001</cn></apply></math>";

TEST_F(ColladaFiles, ColladaLinksHangInOneAnother) {
  const RobotDescription lift = read("lift.dae", collada(kHalfAndAThousandth));
  ASSERT_EQ(lift.links.size(), 3U);
  const JointDescription& turn = *lift.joint("turn");
  constexpr double kDegree = std::numbers::pi / 180;
  EXPECT_NEAR(*turn.lower, -60 * kDegree, 1e-12);  // the soft one
  EXPECT_NEAR(*turn.upper, 45 * kDegree, 1e-12);
  EXPECT_NEAR(turn.velocity.value_or(0), 90 * kDegree, 1e-12);
  EXPECT_EQ(lift.joint("slide")->follows->joint, "turn");
  const double q = 0.4;
  RigidTransform X = RigidTransform::Identity();
  X.rotate(Eigen::AngleAxisd(90 * kDegree, Eigen::Vector3d::UnitY()));
  X.translate(Eigen::Vector3d(0.1, 0, 0));
  X.rotate(Eigen::AngleAxisd(q, Eigen::Vector3d::UnitZ()));
  EXPECT_TRUE(link_poses(lift, {{"turn", q}}).at("arm").isApprox(X, 1e-12));
  X.translate(Eigen::Vector3d(0.5 * q + 0.001, 0.2, 0.05));
  EXPECT_TRUE(link_poses(lift, {{"turn", q}}).at("tip").isApprox(X, 1e-12));
  // The frame of a mass is the model's, not the link's.
  const auto& inertial = lift.link("arm")->inertial;
  ASSERT_TRUE(inertial);
  EXPECT_EQ(inertial->mass, 3);
  EXPECT_TRUE((link_poses(lift, {}).at("arm") * inertial->X_LI)
                  .isApprox(RigidTransform(Eigen::Translation3d(0, 0.07, 0)), 1e-12));
  EXPECT_THAT(loss_.text(), HasSubstr("extra: it is of its writer's own"));
}

/// A slope is the number that is written, and no difference of values, which would round.
TEST_F(ColladaFiles, ColladaFormulasHaveTheirOwnNumbers) {
  const std::string q = "<csymbol>k/first</csymbol>";
  const auto apply = [](const std::string& operation, const std::string& parts) {
    return "<apply><" + operation + "/>" + parts + "</apply>";
  };
  const std::vector<std::tuple<std::string, double, double>> cases{
      {apply("plus", apply("times", "<cn>0.1</cn>" + q) + "<cn>1000</cn>"), 1000, 0.1},
      {apply("divide", q + "<cn>3</cn>"), 0, 1.0 / 3},
      {apply("minus", "<cn>1</cn>" + apply("divide", q + "<cn>4</cn>")), 1, -0.25},
      {apply("minus", apply("times", "<cn>3</cn>" + q + "<cn>0.1</cn>")), 0, -(3 * 0.1)},
      {apply("times", apply("sin", "<cn>0.5</cn>") + q), 0, std::sin(0.5)},
      {apply("plus", q + apply("cos", "<cn>0.5</cn>") + q), std::cos(0.5), 2}};
  for (const auto& [formula, offset, slope] : cases) {
    const RobotDescription lift = read("lift.dae", collada("<math>" + formula + "</math>"));
    ASSERT_TRUE(lift.joint("slide")->follows) << formula;
    EXPECT_EQ(lift.joint("slide")->follows->offset(), offset) << formula;
    EXPECT_EQ(lift.joint("slide")->follows->multiplier(), slope) << formula;
  }
}

TEST_F(ColladaFiles, ColladaFormulasThatAreNoLineAreSaid) {
  const auto follows = [&](const std::string& formula) {
    return read("lift.dae", collada(formula)).joint("slide")->follows.has_value();
  };
  EXPECT_FALSE(
      follows("<math><apply><times/><csymbol>k/first</csymbol><csymbol>k/first</csymbol>"
              "</apply></math>"));
  EXPECT_THAT(loss_.text(), HasSubstr("no linear formula"));
  EXPECT_FALSE(follows("<math><csymbol>k/nowhere</csymbol></math>"));
  EXPECT_THAT(loss_.text(), HasSubstr("'nowhere' in it is not there"));
  EXPECT_FALSE(
      follows("<math><apply><divide/><cn>1</cn><csymbol>k/first</csymbol></apply></math>"));
  EXPECT_FALSE(
      follows("<math><apply><divide/><csymbol>k/first</csymbol><csymbol>k/first"
              "</csymbol></apply></math>"));
  EXPECT_THAT(error_of("a.dae", collada("<math><apply><tan/><cn>1</cn></apply></math>")),
              HasSubstr("<tan> is not read"));
  EXPECT_THAT(error_of("b.dae", collada("<math/>")), HasSubstr("empty"));
  EXPECT_THAT(error_of("mesh.dae", "<COLLADA version='1.4.1'><library_geometries/></COLLADA>"),
              HasSubstr("no kinematics"));
}

TEST_F(ColladaFiles, ZippedColladaIsBoundedAndWhole) {
  const std::string text = collada(kHalfAndAThousandth);
  const std::string manifest = "<dae_root>./lift.dae#main</dae_root>";
  const auto error_of_zip = [&](const std::vector<std::pair<std::string, std::string>>& files) {
    pack(folder_ / "r.zae", files);
    try {
      read_robot(folder_ / "r.zae", loss_);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_EQ(error_of_zip({{"manifest.xml", manifest}, {"lift.dae", text}}), "");
  EXPECT_THAT(error_of_zip({{"lift.dae", text}}), HasSubstr("'manifest.xml' in it is not there"));
  EXPECT_THAT(error_of_zip({{"manifest.xml", manifest}}), HasSubstr("'lift.dae' in it"));
  EXPECT_THAT(error_of_zip({{"manifest.xml", "<dae_root>../../etc/passwd</dae_root>"}}),
              HasSubstr("is not there"));
  // 100 MB of blanks in 100 kB.
  EXPECT_THAT(error_of_zip({{"manifest.xml", manifest}, {"lift.dae", std::string(100 << 20, ' ')}}),
              HasSubstr("larger than 64 MiB"));
  // Cut, and with one byte changed.
  pack(folder_ / "r.zae", {{"manifest.xml", manifest}, {"lift.dae", text}});
  std::ifstream stream(folder_ / "r.zae", std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(stream), {}};
  EXPECT_THAT(error_of("cut.zae", bytes.substr(0, bytes.size() / 2)), HasSubstr("no whole zip"));
  std::string changed = bytes;
  changed[bytes.find("lift.dae") + 200] ^= 0x55;
  EXPECT_THAT(error_of("changed.zae", changed), HasSubstr("is damaged"));
}

// Joints by their makers' own words: the hand is Shadow's C6M, the arm Barrett's WAM with its hand.
TEST_F(ColladaFiles, ColladaRobotsOfOthersHaveTheirJoints) {
  const char* shared = std::getenv("PREHEND_SHARED_DATA");
  const fs::path folder = shared ? fs::path(shared) / "models" : fs::path();
  if (!shared || !fs::is_directory(folder)) GTEST_SKIP() << "no shared models";
  const auto moving = [&](const char* name) {
    LossReport loss;
    const RobotDescription robot = read_robot(folder / name, loss);
    return std::count_if(robot.joints.begin(), robot.joints.end(), [](const auto& joint) {
      return joint.kind != Kind::kFixed && !joint.follows;
    });
  };
  EXPECT_EQ(moving("openrave/pumaarm.zae"), 6);
  EXPECT_EQ(moving("openrave/barrett-wam-sensors.zae"), 7 + 4);
  EXPECT_EQ(moving("openhrp/nextage_description/models/main.dae"), 15);
}

}  // namespace
}  // namespace prehend::robot::formats
