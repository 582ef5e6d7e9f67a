// prehend explain.

#include <gmock/gmock.h>
#include <google/protobuf/struct.pb.h>
#include <google/protobuf/util/json_util.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "prehend/geometry/cloud_files.h"
#include "prehend/geometry/rigid_transform.h"
#include "tests/launch/child_program.h"

namespace prehend::testing {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

class Explain : public ::testing::Test {
 protected:
  // The command's output and errors; its exit code in exit_code_.
  std::string run(std::vector<std::string> words) {
    words.insert(words.begin(), "explain");
    ChildProgram program("prehend", words, folder_.path("output"));
    exit_code_ = program.wait(std::chrono::seconds(30)).value_or(-1);
    return program.output();
  }
  std::string scene(const std::string& text) { return folder_.write("scene.yaml", text); }

  ScratchDirectory folder_;
  int exit_code_ = -1;
};

TEST_F(Explain, SaysWhatOfAShippedSceneIsModelledAndWhatIsNot) {
  const std::string output = run({"config/scenes/table_objects.yaml"});
  EXPECT_EQ(exit_code_, 0);
  EXPECT_THAT(output,
              AllOf(HasSubstr("2 x 14 x 6 texels"), HasSubstr("first order"), HasSubstr("30 N/A"),
                    HasSubstr("feel a cylinder"), HasSubstr("feel its mesh")));
  EXPECT_THAT(output, AllOf(HasSubstr("gate_texels"), HasSubstr("none: bitwise the same"),
                            HasSubstr("mesh of can"), HasSubstr("remember_triangles"),
                            HasSubstr("Rules that are off: rigid_pads")));
}

TEST_F(Explain, FollowsTheScenesRules) {
  const std::string far = scene(
      "physics: {integration: second_order, rules: {primitives: false}}\n"
      "objects: [{name: near}, {name: far, x: 0.9, mass: 2}]\n");
  std::string output = run({far});
  EXPECT_THAT(output, AllOf(HasSubstr("second order"), HasSubstr("motion of far"),
                            Not(HasSubstr("motion of near")), Not(HasSubstr("mesh of near ")),
                            HasSubstr("off: primitives, rigid_pads")));
  // m g / (4 points of 1e5 N/m)
  EXPECT_THAT(output, HasSubstr("at most 49 um of sinking"));
  output = run({scene("physics: {pads: rigid}\n")});
  EXPECT_THAT(output, AllOf(HasSubstr("168 texels of both pads"), HasSubstr("0.714 mm"),
                            Not(HasSubstr("gate_texels"))));
}

TEST_F(Explain, PrintsJsonForPrograms) {
  const std::string output = run({"config/scenes/demo.yaml", "--json"});
  google::protobuf::Struct parsed;
  ASSERT_TRUE(google::protobuf::util::JsonStringToMessage(output, &parsed).ok()) << output;
  EXPECT_EQ(parsed.fields().at("scene").string_value(), "config/scenes/demo.yaml");
  EXPECT_GT(parsed.fields().at("modelled").list_value().values_size(), 5);
  for (const auto& part : parsed.fields().at("left_out").list_value().values()) {
    const auto& fields = part.struct_value().fields();
    for (const char* name : {"what", "rule", "error", "unit", "error_text", "why"}) {
      EXPECT_EQ(fields.count(name), 1u) << name;
    }
    const bool known = !fields.at("rule").string_value().empty();
    EXPECT_EQ(fields.at("error").has_number_value(), known) << fields.at("what").string_value();
  }
}

// What a launch file's touch_tolerance and touch_budget choose can be seen before.
TEST_F(Explain, SaysWhichStepsABudgetOrToleranceChooses) {
  std::string output = run({"config/scenes/demo.yaml", "--tolerance", "0.5"});
  EXPECT_EQ(exit_code_, 0);
  EXPECT_THAT(output, AllOf(HasSubstr("steps chosen"), HasSubstr("ms of processor for a simulated"),
                            HasSubstr("pads' images"), HasSubstr("fidelity/touch.yaml")));
  output = run({"config/scenes/demo.yaml", "--platform", "kr5_sdh", "--budget", "1s", "--json"});
  EXPECT_EQ(exit_code_, 0);
  EXPECT_THAT(output, HasSubstr("fidelity/touch_hand.yaml"));
  const auto refused = [&](std::vector<std::string> words, const std::string& part) {
    words.insert(words.begin(), "config/scenes/demo.yaml");
    EXPECT_THAT(run(words), HasSubstr(part));
    EXPECT_EQ(exit_code_, 1);
  };
  refused({"--tolerance", "1e-9"}, "Allow as much as the most accurate one");
  refused({"--budget", "1us"}, "Allow as much as the fastest one");
  refused({"--budget", "1s", "--tolerance", "0.5"}, "budget and tolerance are both given");
  refused({"--front", "config/fidelity/touch.yaml"}, "without --budget or --tolerance");
  refused({"--tolerance", "0.5", "--front", "config/fidelity/shape.yaml"}, "is of 'shape'");
}

TEST_F(Explain, ABadSceneIsOneClearError) {
  const auto refused = [&](const std::string& file, const std::string& part) {
    const std::string output = run({file});
    EXPECT_EQ(exit_code_, 1) << output;
    EXPECT_EQ(std::count(output.begin(), output.end(), '\n'), 1) << output;
    EXPECT_THAT(output, AllOf(HasSubstr("prehend explain: "), HasSubstr(part)));
  };
  refused("nothing.yaml", "nothing.yaml does not exist");
  refused("config/robots/pg70_dsa.yaml", "pg70_dsa.yaml:3: unknown key 'name'");
  refused(scene("physics: {rules: {slep: true}}\n"), "The nearest is 'sleep'");
  refused(scene("objects: [{name: a, mass: -1}]\n"), "mass");
  run({});
  EXPECT_EQ(exit_code_, 2);
  run({"config/scenes/demo.yaml", "--loud"});
  EXPECT_EQ(exit_code_, 2);
  for (const char* none : {"nan", "0", "-1", "fast"}) {
    EXPECT_THAT(run({"config/scenes/demo.yaml", "--tolerance", none}),
                HasSubstr(std::string("'") + none + "' is no number above 0"));
    EXPECT_EQ(exit_code_, 2);
  }
}

constexpr int kTablePoints = 101 * 101;

// A box of 60 x 80 x 120 mm on a table of 1 m by 1 m, from 1.1 m; with one point high over it.
geometry::PointCloud box_on_table() {
  const geometry::RigidTransform X_WC = geometry::look_at({0.5, 0.4, 0.9}, {0, 0, 0.05});
  geometry::PointCloud cloud;
  const auto add = [&](double x, double y, double z) {
    cloud.points.push_back((X_WC.inverse() * Eigen::Vector3d(x, y, z)).cast<float>());
  };
  for (int i = -50; i <= 50; ++i) {
    for (int k = -50; k <= 50; ++k) add(0.01 * i, 0.01 * k, 0);
  }
  for (int i = 0; i <= 30; ++i) {
    for (int k = 0; k <= 40; ++k) add(-0.03 + 0.002 * i, -0.04 + 0.002 * k, 0.12);
    for (int k = 5; k <= 60; ++k) add(-0.03 + 0.002 * i, 0.04, 0.002 * k);
  }
  for (int i = 0; i <= 40; ++i) {
    for (int k = 5; k <= 60; ++k) add(0.03, -0.04 + 0.002 * i, 0.002 * k);
  }
  add(0, 0, 0.6);
  cloud.width = static_cast<int>(cloud.size());
  cloud.height = 1;
  return cloud;
}

TEST_F(Explain, SaysWhatBecomesOfARecordedCloud) {
  const std::string cloud = folder_.path("box.pcd");
  geometry::write_cloud_file(cloud, box_on_table());
  std::string output = run({cloud});
  EXPECT_EQ(exit_code_, 0) << output;
  EXPECT_THAT(output, AllOf(HasSubstr("points without an order"), HasSubstr("object 0"),
                            HasSubstr("predicted by"), HasSubstr("convex pieces")));
  EXPECT_THAT(output,
              AllOf(HasSubstr(std::to_string(kTablePoints) + " points of the table or under it"),
                    HasSubstr("1 points high over the table"), HasSubstr("max_height")));
  EXPECT_THAT(output, Not(HasSubstr("chosen of measured chains")));
  output = run({cloud, "--tolerance", "0.5", "--json"});
  google::protobuf::Struct parsed;
  ASSERT_TRUE(google::protobuf::util::JsonStringToMessage(output, &parsed).ok()) << output;
  EXPECT_EQ(parsed.fields().at("cloud").string_value(), cloud);
  EXPECT_THAT(output, AllOf(HasSubstr("chosen of measured chains"), HasSubstr("shape.thinning")));
  EXPECT_THAT(run({cloud, "--budget", "1us"}), HasSubstr("Allow as much as the fastest one"));
  EXPECT_THAT(run({cloud, "--front", "config/fidelity/touch.yaml"}), HasSubstr("is for scenes"));
  EXPECT_THAT(run({cloud, "--split", "top"}), HasSubstr("split is 'top'"));
  EXPECT_THAT(run({cloud, "--platform", "stage_pg7O", "--tolerance", "0.5"}),
              HasSubstr("nearest is 'stage_pg70'"));
  EXPECT_THAT(run({cloud, "--split", "wide"}), HasSubstr("Name the platform or hand"));
  EXPECT_THAT(run({cloud, "--split", "wide", "--platform", "stage_pg70"}),
              HasSubstr("needs an organized cloud"));
  EXPECT_THAT(run({cloud, "--split", "touching"}), HasSubstr("needs an organized cloud"));
  EXPECT_THAT(run({cloud, "--table", "1 2"}), HasSubstr("table"));
  EXPECT_THAT(run({folder_.write("empty.pcd", "")}), HasSubstr("empty.pcd"));
  EXPECT_EQ(exit_code_, 1);
}

TEST_F(Explain, SaysWhatAPlatformIsPlannedWith) {
  std::string output = run({"--platform", "kr5_sdh"});
  EXPECT_EQ(exit_code_, 0) << output;
  EXPECT_THAT(output, AllOf(HasSubstr("sdh2: 7 motors, 6 pads"),
                            HasSubstr("arm_axis_1 -170 to 170 deg"), HasSubstr("pairs of balls"),
                            HasSubstr("links that cannot collide"), HasSubstr("fcl")));
  output = run({"--platform", "kr5_sdh", "--json"});
  google::protobuf::Struct parsed;
  ASSERT_TRUE(google::protobuf::util::JsonStringToMessage(output, &parsed).ok()) << output;
  EXPECT_EQ(parsed.fields().at("platform").string_value(), "kr5_sdh");
  EXPECT_THAT(run({"--platform", "kr5_sdhh"}), HasSubstr("nearest is 'kr5_sdh'"));
  EXPECT_THAT(run({"--platform", "kr5_sdh", "--budget", "1s"}), HasSubstr("scenes and clouds"));
  EXPECT_THAT(run({"config/scenes/demo.yaml", "--up", "0 0 1"}), HasSubstr("recorded clouds"));
  EXPECT_EQ(exit_code_, 1);
}

TEST_F(Explain, SaysHowARobotOfArmAndHandIsModelled) {
  std::string output = run({"config/scenes/demo.yaml", "--platform", "kr5_sdh"});
  EXPECT_EQ(exit_code_, 0) << output;
  EXPECT_THAT(output, AllOf(HasSubstr("native (multibody)"), HasSubstr("6 joints on prescribed"),
                            HasSubstr("3 fingers, 7 motors"), HasSubstr("motor hand_thumb_distal"),
                            HasSubstr("pad thumb_distal"), HasSubstr("13 x 6 texels"),
                            HasSubstr("the arm's yielding"), HasSubstr("motors' currents"),
                            HasSubstr("mesh of wide_can"), HasSubstr("sleep")));
  EXPECT_THAT(output, HasSubstr("demo.yaml:3: gripper has no effect"));
  output = run({"config/scenes/demo.yaml", "--platform", "pa10_barrett"});
  EXPECT_THAT(output,
              AllOf(HasSubstr("7 joints on prescribed"), HasSubstr("fingertip_3"),
                    HasSubstr("24 texels (7 x 4 without 4) of 8.64 cm2"), HasSubstr("clutch of ")));
  const std::string own =
      scene("robot: " + std::filesystem::absolute("config/robots/kr5_pg70.yaml").string() +
            "\nphysics: {rules: {sleep: false, primitives: false}}\nobjects: [{name: carton}]\n");
  output = run({own});
  EXPECT_THAT(output,
              AllOf(HasSubstr("6 joints on prescribed"), HasSubstr("2 fingers, 1 motor,"),
                    HasSubstr("14 x 6 texels"), HasSubstr("meet its mesh"),
                    HasSubstr("off: sleep, primitives"), Not(HasSubstr("mesh of carton "))));
  output = run({"config/scenes/demo.yaml", "--platform", "stage_pg70"});
  EXPECT_THAT(output, HasSubstr("2 x 14 x 6 texels"));

  output = run({"config/scenes/demo.yaml", "--platform", "kr5_sdh", "--json"});
  google::protobuf::Struct parsed;
  ASSERT_TRUE(google::protobuf::util::JsonStringToMessage(output, &parsed).ok()) << output;
  EXPECT_EQ(parsed.fields().at("remarks").list_value().values_size(), 1) << output;

  output = run({"config/scenes/demo.yaml", "--platform", "kr5_shd"});
  EXPECT_EQ(exit_code_, 1);
  EXPECT_THAT(output, HasSubstr("kr5_sdh"));
  output = run({scene("physics: {integration: second_order}\n"), "--platform", "kr5_sdh"});
  EXPECT_EQ(exit_code_, 1);
  EXPECT_THAT(output, HasSubstr("scene.yaml:1: physics.integration does not apply to a robot"));
}

TEST_F(Explain, HelpIsComplete) {
  const std::string output = run({"--help"});
  EXPECT_EQ(exit_code_, 0);
  EXPECT_THAT(output, AllOf(HasSubstr("--json"), HasSubstr("scene"), HasSubstr("Examples"),
                            HasSubstr("config/scenes/demo.yaml"), HasSubstr("pads: rigid"),
                            HasSubstr("--platform")));
}

}  // namespace
}  // namespace prehend::testing
