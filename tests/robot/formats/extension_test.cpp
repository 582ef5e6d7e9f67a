// What a format cannot say is in prehend's block of its files, and comes back; hostile blocks are
// refused in words.

#include "prehend/robot/formats/extension.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "prehend/robot/formats/model_check.h"
#include "prehend/robot/formats/shape_mesh.h"
#include "prehend/robot/formats/srdf.h"
#include "prehend/robot/robot_model.h"
#include "tests/robot/formats/robot_files.h"

namespace prehend::robot::formats {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using Json = nlohmann::json;

/// All that a description can have, with names that XML has to escape.
const std::string kEverything = R"json({"prehend_robot": 1, "name": "all <of> \"it\" & 'more'",
"links": [
 {"name": "palm",
  "inertial": {"mass": 0.5, "pose": {"position": [0, 0, 0.02]}, "inertia": [[2e-4, 1e-5, 0], [1e-5, 2e-4, 0], [0, 0, 3e-4]]},
  "visuals": [{"name": "seen", "kind": "box", "size": [0.1, 0.1, 0.02], "material": "gr<e>y", "color": [0.5, 0.25, 0.5, 1]},
              {"kind": "sphere", "radius": 0.01}],
  "collisions": [{"kind": "box", "size": [0.1, 0.1, 0.02], "material": "rubber"}]},
 {"name": "finger", "inertial": {"mass": 0.1, "inertia": [[1e-5, 0, 0], [0, 1e-5, 0], [0, 0, 1e-5]]},
  "collisions": [{"name": "pad", "kind": "capsule", "radius": 0.01, "length": 0.03,
                  "pose": {"position": [0, 0, 0.02], "quaternion": [0.8, 0.6, 0, 0]}},
                 {"kind": "cylinder", "radius": 0.01, "length": 0.02}]},
 {"name": "tip", "inertial": {"mass": 0.1, "inertia": [[1e-5, 0, 0], [0, 1e-5, 0], [0, 0, 1e-5]]}},
 {"name": "thumb", "inertial": {"mass": 0.1, "inertia": [[1e-5, 0, 0], [0, 1e-5, 0], [0, 0, 1e-5]]}},
 {"name": "ball", "inertial": {"mass": 0.1, "inertia": [[1e-5, 0, 0], [0, 1e-5, 0], [0, 0, 1e-5]]}},
 {"name": "nail"}],
"joints": [
 {"name": "j", "kind": "revolute", "parent": "palm", "child": "finger", "pose": {"position": [0.05, 0, 0]}, "axis": [0, 1, 0],
  "lower": -0.2, "upper": 1.5, "velocity": 2, "effort": 1.5, "damping": 0.01, "friction": 0.02, "stiffness": 0.3, "rest": 0.1},
 {"name": "k", "kind": "revolute", "parent": "finger", "child": "tip", "pose": {"position": [0, 0, 0.05]},
  "child_pose": {"position": [0, 0.01, 0]}, "axis": [0, 1, 0], "lower": -0.2, "upper": 1.5,
  "follows": {"joint": "j", "coefficients": [0.1, 0.5, 0.4]}, "break_away": 0.4},
 {"name": "t", "kind": "revolute", "parent": "palm", "child": "thumb", "pose": {"position": [-0.05, 0, 0]}, "axis": [0, 1, 0],
  "upper": 1.5, "passive": true},
 {"name": "b", "kind": "ball", "parent": "thumb", "child": "ball", "pose": {"position": [-0.05, 0, 0.01]}},
 {"name": "mount", "kind": "fixed", "parent": "tip", "child": "nail", "pose": {"position": [0, 0, 0.01]}}],
"loops": [{"name": "four_bar", "kind": "point", "first": "tip", "second": "thumb", "pose": {"position": [0, 0, 0.05]}},
          {"name": "w", "kind": "weld", "first": "tip", "second": "ball", "pose": {"position": [0, 0, 0.05]}}],
"actuators": [{"name": "m", "joint": "j", "gear": 100, "effort": 1.2, "control": "velocity"}, {"name": "n", "joint": "t"}],
"sensors": [{"name": "pad", "kind": "tactile", "link": "finger", "pose": {"position": [0.01, 0, 0]}, "size": [0.01, 0.02, 0.001]},
            {"name": "ft", "kind": "force_torque", "link": "palm"},
            {"name": "cam", "kind": "camera", "link": "palm", "pose": {"position": [0, 0, 0.1]}},
            {"name": "touch", "kind": "touch", "link": "tip", "size": [0.01, 0.01, 0.01]}],
"manipulators": [{"name": "grip", "base": "palm", "tip": "palm", "tool": {"position": [0, 0, 0.12]}, "closing": [["j", 1], ["t", -1]]}],
"postures": [{"name": "open", "group": "fingers", "positions": {"j": 0.0, "t": -0.5}},
             {"name": "open", "group": "thumb", "positions": {"t": 0.5}}],
"disabled_collisions": [["palm", "finger"], ["tip", "thumb"]]})json";

/// A value with numbers rounded to 1e-9, a rotation of two quaternions as one of them, and no pose
/// that says nothing.
Json rounded(const Json& value) {
  if (value.is_number()) return std::round(value.get<double>() * 1e9) / 1e9 + 0.0;
  if (!value.is_structured()) return value;
  Json result = value;
  for (auto& item : result.items()) item.value() = rounded(item.value());
  if (value.is_object() && value.contains("quaternion")) {
    Json& q = result["quaternion"];
    for (const Json& one : q) {
      if (one.get<double>() == 0) continue;
      if (one.get<double>() < 0) {
        for (Json& number : q) number = -number.get<double>() + 0.0;
      }
      break;
    }
  }
  if (value.is_object()) {
    const Json nothing = {{"position", {0.0, 0.0, 0.0}}, {"quaternion", {1.0, 0.0, 0.0, 0.0}}};
    for (const char* key : {"pose", "child_pose"}) {
      if (result.contains(key) && result[key] == nothing) result.erase(key);
    }
  }
  return result;
}

/// The first lines in which two texts differ; empty: none.
std::string first_difference(const std::string& one, const std::string& other) {
  std::istringstream ones(one), others(other);
  std::string a, b;
  for (int line = 1; std::getline(ones, a) && std::getline(others, b); ++line) {
    if (a != b) return std::to_string(line) + ": " + a + " is not " + b;
  }
  return one == other ? "" : "one is longer";
}

/// Meshes without the names and scales of their files.
RobotDescription without_names(RobotDescription robot) {
  for (LinkDescription& link : robot.links) {
    for (auto* shapes : {&link.visuals, &link.collisions}) {
      for (Shape& shape : *shapes) {
        if (shape.kind != Shape::Kind::kMesh) continue;
        EXPECT_TRUE(shape.surface && !shape.surface->triangles.empty()) << shape.mesh;
        shape.mesh = "mesh";
        shape.scale = Eigen::Vector3d::Ones();
      }
    }
  }
  return robot;
}

class Extension : public RobotFiles {
 protected:
  /// The JSON's text, in one order, rounded; inertia in the link's axes, as formats differ there.
  static std::string text_of(RobotDescription robot) {
    for (LinkDescription& link : robot.links) {
      if (!link.inertial) continue;
      const Eigen::Matrix3d R = link.inertial->X_LI.linear();
      link.inertial->inertia = R * link.inertial->inertia * R.transpose();
      link.inertial->X_LI.linear().setIdentity();
    }
    for (JointDescription& joint : robot.joints) {
      if (joint.kind == JointDescription::Kind::kBall) joint.axis_J = Eigen::Vector3d::UnitX();
    }
    for (auto& pair : robot.disabled_collisions) {
      if (pair.second < pair.first) std::swap(pair.first, pair.second);
    }
    LossReport unused;
    Json json = rounded(Json::parse(format_named("json").write(robot, unused)));
    for (auto& item : json.items()) {
      if (item.value().is_array()) std::sort(item.value().begin(), item.value().end());
    }
    return json.dump(1);
  }
  RobotDescription everything() { return read("all.robot.json", kEverything); }
  RobotDescription through(const RobotDescription& robot, const std::string& format) {
    LossReport loss;
    const std::string text = format_named(format).write(robot, loss);
    EXPECT_TRUE(loss.lossless()) << loss.text();
    report_ = loss.text();
    return read("again." + format, text);
  }
  static bool has_mjcf() {
    return std::any_of(robot_formats().begin(), robot_formats().end(),
                       [](const auto& format) { return format->name() == "mjcf"; });
  }
  std::string report_;
};

TEST_F(Extension, UrdfKeepsAllThatADescriptionHas) {
  const RobotDescription robot = everything();
  EXPECT_EQ(first_difference(text_of(through(robot, "urdf")), text_of(robot)), "");
  EXPECT_TRUE(loss_.lossless()) << loss_.text();
  EXPECT_THAT(report_, AllOf(HasSubstr("kept in prehend's extension, which other programs do not "
                                       "read: 4 sensors, 2 actuators, 2 closed loops"),
                             HasSubstr("for others approximated break-away clutch"),
                             // 0.4 (1.7 / 2)^2, half way between the leader's limits
                             HasSubstr("the line through its ends, at most 0.289 rad beside it"),
                             HasSubstr("0 approximated, 0 dropped")));
}

TEST_F(Extension, SdfKeepsAllThatADescriptionHas) {
  const RobotDescription robot = everything();
  EXPECT_EQ(first_difference(text_of(through(robot, "sdf")), text_of(robot)), "");
  EXPECT_TRUE(loss_.lossless()) << loss_.text();
}

TEST_F(Extension, MjcfKeepsAllThatADescriptionHas) {
  if (!has_mjcf()) GTEST_SKIP() << "built without MuJoCo";
  const RobotDescription robot = everything();
  EXPECT_EQ(first_difference(text_of(through(robot, "mjcf")), text_of(robot)), "");
  EXPECT_TRUE(loss_.lossless()) << loss_.text();
}

TEST_F(Extension, ColladaKeepsAllThatADescriptionHas) {
  const RobotDescription robot = everything();
  for (const char* format : {"collada", "zae"}) {
    EXPECT_EQ(first_difference(text_of(through(robot, format)), text_of(robot)), "") << format;
    EXPECT_TRUE(loss_.lossless()) << loss_.text();
    EXPECT_THAT(report_, HasSubstr("kept in prehend's extension, which other programs do not read: "
                                   "2 closed loops, 2 postures"));
  }
}

TEST_F(Extension, EveryPairOfWrittenFormatsKeepsIt) {
  const RobotDescription robot = everything();
  for (const std::string& first : written_formats()) {
    for (const std::string& second : written_formats()) {
      EXPECT_EQ(first_difference(text_of(through(through(robot, first), second)), text_of(robot)),
                "")
          << first << " to " << second;
    }
  }
}

/// Other programs read a line that is right at the ends of the leader's range.
TEST_F(Extension, PolynomialCouplingsAreLinesForOthers) {
  const RobotDescription robot = everything();
  const std::vector<std::pair<std::string, std::string>> blocks{
      {"urdf", "prehend"}, {"sdf", "prehend:robot"}, {"collada", "robot"}};
  for (const auto& [format, element] : blocks) {
    LossReport loss;
    std::string text = format_named(format).write(robot, loss);
    const std::size_t begin = text.find("<" + element), end = text.find("</" + element + ">");
    ASSERT_NE(end, std::string::npos);
    text.erase(begin, end + element.size() + 3 - begin);
    const RobotDescription others = read("others." + format, text);
    const Follows& line = *others.joint("k")->follows;
    EXPECT_TRUE(line.is_linear());
    for (const double q : {-0.2, 1.5}) {
      EXPECT_NEAR(line.at(q), 0.1 + 0.5 * q + 0.4 * q * q, 1e-12) << format << ", " << q;
    }
  }
}

/// MJCF has five coefficients.
TEST_F(Extension, PolynomialsOfAHighDegreeComeBackFromMjcf) {
  if (!has_mjcf()) GTEST_SKIP() << "built without MuJoCo";
  RobotDescription robot = everything();
  robot.joints[1].follows->coefficients = {0, 0.5, 0, 0, 0.1, -0.02};
  const RobotDescription again = through(robot, "mjcf");
  EXPECT_THAT(report_, HasSubstr("coupling of a degree above 4"));
  EXPECT_EQ(again.joint("k")->follows->coefficients, robot.joints[1].follows->coefficients);
}

TEST_F(Extension, IsNotThereWhereNothingIsMissing) {
  const RobotDescription plain = read("a.sdf", R"(<sdf version="1.7"><model name="m">
    <link name="a"/><link name="b"/><joint name="j" type="revolute"><parent>a</parent><child>b</child>
    <axis><xyz>0 0 1</xyz><limit><lower>-1</lower><upper>1</upper><effort>3</effort><velocity>1</velocity></limit>
    </axis></joint></model></sdf>)");
  for (const char* format : {"urdf", "sdf"}) {
    LossReport loss;
    EXPECT_THAT(format_named(format).write(plain, loss), Not(HasSubstr("prehend"))) << format;
    EXPECT_TRUE(loss.entries().empty()) << loss.text();
  }
  LossReport loss;  // COLLADA's says who wrote it
  EXPECT_THAT(format_named("collada").write(plain, loss), Not(HasSubstr("\"prehend\"")));
  EXPECT_TRUE(loss.entries().empty()) << loss.text();
}

TEST_F(Extension, ARobotThatNamesWhatIsNotThereIsReadAgain) {
  RobotDescription robot = everything();
  robot.sensors[0].link = "gone";
  for (const std::string& format : written_formats()) {
    if (format == "json") continue;  // has no block
    LossReport loss;
    const std::string text = format_named(format).write(robot, loss);
    EXPECT_FALSE(loss.lossless()) << format;
    EXPECT_THAT(loss.text(), AllOf(HasSubstr("dropped prehend's extension"),
                                   HasSubstr("there is no link 'gone'")))
        << format;
    EXPECT_EQ(error_of("gone." + format, text), "") << format;
  }
}

TEST_F(Extension, EditsOfTheRestOfTheFileCount) {
  LossReport loss;
  std::string text = format_named("urdf").write(everything(), loss);
  const std::string before = "lower=\"-0.2\" upper=\"1.5\" effort=\"1.5\"";
  ASSERT_NE(text.find(before), std::string::npos);
  text.replace(text.find(before), before.size(), "lower=\"-0.7\" upper=\"1.5\" effort=\"9\"");
  const RobotDescription again = read("edited.urdf", text);
  EXPECT_EQ(again.joint("j")->lower, -0.7);
  EXPECT_EQ(again.joint("j")->effort, 9);
  EXPECT_EQ(again.joint("j")->stiffness, 0.3);
}

TEST_F(Extension, EditsOfTheRestOfColladaCount) {
  RobotDescription robot = everything();
  robot.joints[0].upper = std::numbers::pi / 2;
  LossReport loss;
  std::string text = format_named("collada").write(robot, loss);
  const std::string before = "<max>90</max>";
  ASSERT_NE(text.find(before), std::string::npos);
  text.replace(text.find(before), before.size(), "<max>45</max>");
  EXPECT_DOUBLE_EQ(*read("edited.dae", text).joint("j")->upper, std::numbers::pi / 4);
}

/// A shape's surface, which no text says, stays when the block names the shape.
TEST_F(Extension, MeshesWithinAFileStay) {
  if (!has_mjcf()) GTEST_SKIP() << "built without MuJoCo";
  file("t.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
  const RobotDescription robot = read("m.robot.json", R"({"prehend_robot": 1, "name": "m",
    "links": [{"name": "a", "collisions": [{"kind": "mesh", "mesh": "t.obj", "material": "steel",
    "scale": [0.1, 0.1, 0.1], "color": [1, 0, 0, 1]}]}]})");
  const RobotDescription again = through(robot, "mjcf");
  const Shape& shape = again.link("a")->collisions.at(0);
  EXPECT_EQ(shape.material, "steel");
  EXPECT_EQ(shape.kind, Shape::Kind::kMesh);
  ASSERT_NE(shape.surface, nullptr);
  EXPECT_EQ(shape.surface->triangles.size(), 4U);
}

TEST_F(Extension, TextThatIsNoUtf8HasNoBlockAndTheReportSaysSo) {
  RobotDescription robot = everything();
  robot.sensors[0].name = "\xff\xfe";
  LossReport loss;
  const std::string text = format_named("urdf").write(robot, loss);
  EXPECT_THAT(text, Not(HasSubstr("<prehend>")));
  EXPECT_FALSE(loss.lossless());
  EXPECT_THAT(loss.text(), AllOf(HasSubstr("dropped prehend's extension"),
                                 HasSubstr("dropped loop"), HasSubstr("UTF-8")));
}

class HostileBlock : public Extension {
 protected:
  std::string error_of_block(const std::string& block) {
    return error_of("arm.urdf",
                    "<robot name='arm'><link name='base'/><link name='upper'>\n"
                    "<collision><geometry><box size='1 1 1'/></geometry></collision>"
                    "</link>\n<joint name='turn' type='continuous'>"
                    "<parent link='base'/><child link='upper'/></joint>\n" +
                        block + "</robot>");
  }
  std::string error_with(const std::string& keys) {
    return error_of_block("<prehend>{\"version\": 1, " + keys + "}</prehend>");
  }
};

TEST_F(HostileBlock, IsRefusedWithItsPlaceAndMend) {
  EXPECT_THAT(error_of_block("<prehend>{\"version\": 1, oh}</prehend>"),
              AllOf(HasSubstr("arm.urdf:4"), HasSubstr("prehend's extension is no JSON")));
  EXPECT_THAT(error_of_block("<prehend/>"), HasSubstr("is no JSON"));
  EXPECT_THAT(error_of_block("<prehend>[]</prehend>"), HasSubstr("is no object"));
  EXPECT_THAT(error_of_block("<prehend>{}</prehend>"), HasSubstr("has no 'version'"));
  EXPECT_THAT(error_of_block("<prehend>{\"version\": 2}</prehend>"),
              AllOf(HasSubstr("2 is none that is known"), HasSubstr("This reads version 1")));
  EXPECT_THAT(error_of_block("<prehend>{\"version\": 1}</prehend>\n"
                             "<prehend>{\"version\": 1}</prehend>"),
              AllOf(HasSubstr("arm.urdf:5"), HasSubstr("is there twice")));
  EXPECT_THAT(error_with("\"version\": 1"), HasSubstr("twice in one object"));
  EXPECT_THAT(error_with("\"sensor\": []"), HasSubstr("'sensors'"));
  EXPECT_EQ(error_with("\"links\": []"), "");
}

TEST_F(HostileBlock, NamesNothingThatIsNotThere) {
  const std::vector<std::pair<std::string, std::string>> cases{
      {R"("links": [{"name": "uper"}])", "'upper'"},
      {R"("joints": [{"name": "turm", "passive": true}])", "'turn'"},
      {R"("joints": [{"name": "x", "was": "gone"}])", "there is no joint 'gone'"},
      {R"("joints": [{"name": "turn", "follows": {"joint": "gone"}}])", "there is no joint 'gone'"},
      {R"("joints": [{"name": "turn", "child": "gone"}])", "there is no link 'gone'"},
      {R"("sensors": [{"name": "s", "kind": "touch", "link": "gone"}])", "there is no link 'gone'"},
      {R"("actuators": [{"name": "m", "joint": "gone"}])", "there is no joint 'gone'"},
      {R"("loops": [{"name": "l", "kind": "weld", "first": "base", "second": "gone"}])",
       "loops[0].second"},
      {R"("manipulators": [{"name": "g", "base": "base", "tip": "gone"}])", "manipulators[0].tip"},
      {R"("manipulators": [{"name": "g", "base": "base", "tip": "upper", "closing": [["gone", 1]]}])",
       "manipulators[0].closing"},
      {R"("postures": [{"name": "p", "positions": {"gone": 1}}])", "postures[0].positions"},
      {R"("disabled_collisions": [["base", "gone"]])", "disabled_collisions[0]"},
      {R"("without": {"links": ["gone"]})", "without.links[0]"},
      {R"("merged": ["gone"])", "is no fixed joint"},
  };
  for (const auto& [keys, words] : cases) {
    EXPECT_THAT(error_with(keys), AllOf(HasSubstr("arm.urdf:4"), HasSubstr(words))) << keys;
  }
}

TEST_F(HostileBlock, SaysNothingThatARobotCannotHave) {
  const std::vector<std::pair<std::string, std::string>> cases{
      {R"("links": [5])", "is no object"},
      {R"("links": {})", "is no list"},
      {R"("links": [{}])", "has no 'name'"},
      {R"("joints": [{"name": "turn", "brake_away": 1}])", "'break_away'"},
      {R"("joints": [{"name": "turn", "kind": null}])", "has no 'kind'"},
      {R"("joints": [{"name": "turn", "damping": "much"}])", "is no number"},
      {R"("joints": [{"name": "turn", "was": 5}])", "is no text"},
      {R"("joints": [{"name": "turn", "child": "base"}])", "links are no tree"},
      {R"("without": {"joints": ["turn"]})", "links are no tree"},
      {R"("sensors": [{"name": "s"}])", "has no 'kind'"},
      {R"("links": [{"name": "upper", "collisions": []}])", "as many shapes"},
      {R"("links": [{"name": "upper", "collisions": [{}, {}]}])", "as many shapes"},
      {R"("links": [{"name": "upper", "collisions": [{"parts": 99999999999999999}]}])",
       "as many shapes"},
      {R"("links": [{"name": "upper", "collisions": [{"parts": -1}]}])", "no whole number"},
      {R"("links": [{"name": "upper", "collisions": [{"radios": 1}]}])", "'radius'"},
      {R"("links": [{"name": "upper", "visuals": 5}])", "is no list"},
      {R"("without": {"linkss": []})", "'links'"},
  };
  for (const auto& [keys, words] : cases) {
    EXPECT_THAT(error_with(keys), AllOf(HasSubstr("arm.urdf:4"), HasSubstr(words))) << keys;
  }
  std::string deep(64, '[');
  EXPECT_THAT(error_with("\"links\": " + deep), HasSubstr("nested deeper than 32"));
}

TEST_F(HostileBlock, OfSdfAndMjcfIsRefusedToo) {
  const auto sdf = [&](const std::string& block) {
    return error_of("a.sdf", "<sdf version='1.7'><model name='m'><link name='a'/>\n" + block +
                                 "</model></sdf>");
  };
  const std::string wrong =
      "<prehend:robot xmlns:prehend='urn:prehend:robot'>{\"version\": 1, \"sensors\": "
      "[{\"name\": \"s\", \"kind\": \"t\", \"link\": \"b\"}]}</prehend:robot>";
  EXPECT_THAT(sdf(wrong), AllOf(HasSubstr("a.sdf:2"), HasSubstr("there is no link 'b'")));
  EXPECT_THAT(sdf(wrong + "\n" + wrong), AllOf(HasSubstr("a.sdf:3"), HasSubstr("twice")));
}

TEST_F(HostileBlock, OfColladaIsRefusedToo) {
  const std::string head =
      "<COLLADA version='1.5.0'><library_kinematics_models><kinematics_model name='r'>"
      "<technique_common><link sid='a' name='a'/></technique_common></kinematics_model>"
      "</library_kinematics_models>\n";
  const auto collada = [&](const std::string& extras) {
    return error_of("a.dae", head + extras + "</COLLADA>");
  };
  const auto extra = [](const std::string& type, const std::string& block) {
    return "<extra type='" + type + "'><technique profile='" + type + "'>" + block +
           "</technique></extra>\n";
  };
  const std::string wrong = "<robot>{\"version\": 1, \"links\": [{\"name\": \"b\"}]}</robot>";
  EXPECT_THAT(collada(extra("prehend", wrong)),
              AllOf(HasSubstr("a.dae:2"), HasSubstr("there is no link 'b'")));
  EXPECT_THAT(collada(extra("prehend", wrong) + extra("prehend", wrong)),
              AllOf(HasSubstr("a.dae:3"), HasSubstr("twice")));
  // What is of others is passed over, and told.
  EXPECT_EQ(collada(extra("theirs", wrong)), "");
  EXPECT_FALSE(loss_.lossless());
  EXPECT_EQ(collada(extra("prehend", "<other/>")), "");
  EXPECT_THAT(loss_.text(), HasSubstr("COLLADA/extra/technique/other"));
}

TEST_F(Extension, WhatIsWrongInMjcfIsRefusedToo) {
  if (!has_mjcf()) GTEST_SKIP() << "built without MuJoCo";
  const auto mjcf = [&](const std::string& texts) {
    return error_of("a.xml", "<mujoco><worldbody><body name='a'/></worldbody>\n<custom>\n" + texts +
                                 "</custom></mujoco>");
  };
  const std::string text =
      R"(<text name="prehend" data="{&quot;version&quot;: 1, &quot;links&quot;: [{&quot;name&quot;: &quot;b&quot;}]}"/>)";
  EXPECT_THAT(mjcf(text), AllOf(HasSubstr("a.xml:3"), HasSubstr("there is no link 'b'")));
  EXPECT_THAT(mjcf(text + text), HasSubstr("a.xml"));  // by MuJoCo itself
  EXPECT_THAT(mjcf("<text name='prehend' data='no'/>"), HasSubstr("is no JSON"));
}

TEST_F(Extension, UrdfdomAndThePlannerPassOverIt) {
  RobotDescription robot = read_robot("config/robots/barrett_bh8.urdf", loss_);
  robot.sensors.push_back({"pad", "tactile", robot.links.front().name,
                           geometry::RigidTransform::Identity(), Eigen::Vector3d::Zero()});
  for (LinkDescription& link : robot.links) link.visuals.clear();
  LossReport loss;
  move_meshes(robot, "config/robots", folder_);
  const std::string text = format_named("urdf").write(robot, loss);
  EXPECT_THAT(text, HasSubstr("<prehend>"));
  const RobotModel given = read_urdf("config/robots/barrett_bh8.urdf");
  const RobotModel again = read_urdf(file("bh8.urdf", text));
  EXPECT_EQ(given.links.size(), again.links.size());
  EXPECT_EQ(given.joints.size(), again.joints.size());
}

TEST_F(Extension, RobotsOfOthersComeBackInAllFields) {
  const std::vector<std::string> files{"graspit/BarrettBH8_280_Tactile/BarrettBH8_280_Tactile.xml",
                                       "graspit/HumanHand/HumanHand20DOF.xml",
                                       "simox/Schunk_SAH/SAH_RightHand.xml"};
  for (const std::string& name : files) {
    const std::filesystem::path path = shared_model(name);
    if (path.empty()) GTEST_SKIP() << "set PREHEND_SHARED_DATA to test robots of others";
    LossReport loss;
    RobotDescription robot = read_robot(path, loss);
    write_meshes(take_out_meshes(robot, path.parent_path(), "m", loss, TakenMeshes::kAll), folder_);
    for (const char* format : {"urdf", "sdf"}) {
      EXPECT_EQ(first_difference(text_of(through(robot, format)), text_of(robot)), "")
          << name << ", " << format;
    }
    // Of COLLADA meshes are within the file: the same surfaces, of other names.
    take_out_meshes(robot, folder_, "m", loss, TakenMeshes::kEmbedded);
    EXPECT_EQ(first_difference(text_of(without_names(through(robot, "collada"))),
                               text_of(without_names(robot))),
              "")
        << name;
  }
}

}  // namespace
}  // namespace prehend::robot::formats
