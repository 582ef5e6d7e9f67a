// prehend's own text of robots: nothing is lost, and hostile files are refused in words.

#include <gmock/gmock.h>

#include <filesystem>
#include <limits>
#include <random>

#include "prehend/geometry/errors.h"
#include "prehend/robot/formats/json_record.h"
#include "prehend/robot/formats/model_check.h"
#include "tests/robot/formats/robot_files.h"

namespace prehend::robot::formats {
namespace {

namespace fs = std::filesystem;
using geometry::InputError;
using geometry::RigidTransform;
using testing::HasSubstr;

class JsonFormat : public RobotFiles {
 protected:
  RobotDescription read(const std::string& text) { return RobotFiles::read("a.robot.json", text); }
  RobotDescription again(const RobotDescription& robot) {
    LossReport loss;
    return read(format_for("a.robot.json").write(robot, loss));
  }
  std::string error_of(const std::string& text) {
    return RobotFiles::error_of("a.robot.json", text);
  }
};

/// Rotations come back within rounding, all else exactly.
bool same(const RigidTransform& a, const RigidTransform& b) {
  return a.translation() == b.translation() &&
         (a.linear() - b.linear()).cwiseAbs().maxCoeff() < 3e-15;
}

bool same(const Shape& a, const Shape& b) {
  return a.name == b.name && a.kind == b.kind && same(a.X_LS, b.X_LS) && a.size == b.size &&
         a.radius == b.radius && a.length == b.length && a.mesh == b.mesh && a.scale == b.scale &&
         a.material == b.material && a.color == b.color;
}

bool same(const LinkDescription& a, const LinkDescription& b) {
  const auto of_shape = [](const Shape& one, const Shape& other) { return same(one, other); };
  return a.name == b.name && a.inertial.has_value() == b.inertial.has_value() &&
         (!a.inertial ||
          (a.inertial->mass == b.inertial->mass && a.inertial->inertia == b.inertial->inertia &&
           same(a.inertial->X_LI, b.inertial->X_LI))) &&
         std::ranges::equal(a.visuals, b.visuals, of_shape) &&
         std::ranges::equal(a.collisions, b.collisions, of_shape);
}

bool same(const JointDescription& a, const JointDescription& b) {
  return a.name == b.name && a.kind == b.kind && a.parent == b.parent && a.child == b.child &&
         same(a.X_PJ, b.X_PJ) && same(a.X_JC, b.X_JC) && a.axis_J == b.axis_J &&
         a.lower == b.lower && a.upper == b.upper && a.velocity == b.velocity &&
         a.effort == b.effort && a.damping == b.damping && a.friction == b.friction &&
         a.stiffness == b.stiffness && a.rest == b.rest &&
         a.follows.has_value() == b.follows.has_value() &&
         (!a.follows || (a.follows->joint == b.follows->joint &&
                         a.follows->coefficients == b.follows->coefficients)) &&
         a.break_away == b.break_away && a.passive == b.passive;
}

bool same(const Loop& a, const Loop& b) {
  return a.name == b.name && a.kind == b.kind && a.first == b.first && a.second == b.second &&
         same(a.X_FirstLoop, b.X_FirstLoop);
}

bool same(const Actuator& a, const Actuator& b) {
  return a.name == b.name && a.joint == b.joint && a.gear == b.gear && a.effort == b.effort &&
         a.control == b.control;
}

bool same(const Sensor& a, const Sensor& b) {
  return a.name == b.name && a.kind == b.kind && a.link == b.link && same(a.X_LS, b.X_LS) &&
         a.size == b.size;
}

bool same(const Manipulator& a, const Manipulator& b) {
  return a.name == b.name && a.base == b.base && a.tip == b.tip && same(a.X_TipTool, b.X_TipTool) &&
         a.closing == b.closing;
}

bool same(const Posture& a, const Posture& b) {
  return a.name == b.name && a.group == b.group && a.positions == b.positions;
}

void expect_same(const RobotDescription& a, const RobotDescription& b, const std::string& of) {
  const auto all = [&](const auto& ones, const auto& others, const char* what) {
    ASSERT_EQ(ones.size(), others.size()) << of << ": " << what;
    for (std::size_t i = 0; i < ones.size(); ++i) {
      EXPECT_TRUE(same(ones[i], others[i])) << of << ": " << what << ' ' << ones[i].name;
    }
  };
  EXPECT_EQ(a.name, b.name) << of;
  all(a.links, b.links, "link");
  all(a.joints, b.joints, "joint");
  all(a.loops, b.loops, "loop");
  all(a.actuators, b.actuators, "actuator");
  all(a.sensors, b.sensors, "sensor");
  all(a.manipulators, b.manipulators, "manipulator");
  all(a.postures, b.postures, "posture");
  EXPECT_EQ(a.disabled_collisions, b.disabled_collisions) << of;
}

/// Every field is some number or word of its own.
RobotDescription full_robot() {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> number(-3, 3);
  const auto vector = [&] {
    return Eigen::Vector3d(number(random), number(random), number(random));
  };
  const auto pose = [&] {
    RigidTransform X = RigidTransform::Identity();
    X.translation() = vector();
    X.rotate(Eigen::AngleAxisd(number(random), vector().normalized()));
    return X;
  };
  RobotDescription robot;
  robot.name = "a \"robot\" \\ of \xc3\xbc, and: more";
  for (const char* name : {"base", "middle link", "tip"}) {
    LinkDescription link;
    link.name = name;
    link.inertial = Inertial{std::abs(number(random)), pose(), Eigen::Matrix3d::Random()};
    for (const auto kind : {Shape::Kind::kBox, Shape::Kind::kSphere, Shape::Kind::kCylinder,
                            Shape::Kind::kCapsule, Shape::Kind::kPlane, Shape::Kind::kMesh}) {
      Shape shape;
      shape.name = "shape";
      shape.kind = kind;
      shape.X_LS = pose();
      shape.size = vector();
      shape.radius = number(random);
      shape.length = number(random);
      shape.mesh = "meshes/a file.stl";
      shape.scale = vector();
      shape.material = "steel";
      shape.color = {0.1, 1.0 / 3, 0.3, 1};
      link.visuals.push_back(shape);
      shape.color.reset();
      link.collisions.push_back(shape);
    }
    robot.links.push_back(link);
  }
  for (int i = 0; i < 2; ++i) {
    JointDescription joint;
    joint.name = "joint " + std::to_string(i);
    joint.kind = i == 0 ? JointDescription::Kind::kRevolute : JointDescription::Kind::kPrismatic;
    joint.parent = robot.links[static_cast<std::size_t>(i)].name;
    joint.child = robot.links[static_cast<std::size_t>(i) + 1].name;
    joint.X_PJ = pose();
    joint.X_JC = pose();
    joint.axis_J = vector().normalized();
    joint.lower = -0.1;
    joint.upper = std::nextafter(0.1, 1);
    joint.velocity = 1e-300;
    joint.effort = 1e300;
    joint.damping = number(random);
    joint.friction = number(random);
    joint.stiffness = number(random);
    joint.rest = number(random);
    if (i == 1) joint.follows = Follows{"joint 0", number(random), number(random)};
    // Lines and polynomials.
    if (i == 1 && number(random) > 0) joint.follows->coefficients.push_back(number(random));
    if (i == 1) joint.break_away = number(random);
    joint.passive = i == 0;
    robot.joints.push_back(joint);
  }
  robot.loops = {{"loop", Loop::Kind::kPoint, "base", "tip", pose()},
                 {"weld", Loop::Kind::kWeld, "base", "tip", pose()}};
  robot.actuators = {{"motor", "joint 0", number(random), number(random), "effort"},
                     {"other", "joint 1", 1, std::nullopt, ""}};
  robot.sensors = {{"cell", "touch", "tip", pose(), vector()}};
  robot.manipulators = {{"arm", "base", "tip", pose(), {{"joint 0", -1}, {"joint 1", 0}}}};
  robot.postures = {{"open", "arm", {{"joint 0", number(random)}, {"joint 1", 0}}}};
  robot.disabled_collisions = {{"base", "tip"}};
  return robot;
}

TEST_F(JsonFormat, EveryFieldComesBack) {
  const RobotDescription robot = full_robot();
  expect_same(robot, again(robot), "all fields");
  EXPECT_TRUE(loss_.lossless()) << loss_.text();
  RobotDescription least;
  least.name = "least";
  least.links.push_back({"one", {}, {}, {}});
  expect_same(least, again(least), "least");
}

// Absent is not 0.
TEST_F(JsonFormat, WhatIsNotSaidIsAbsent) {
  RobotDescription robot = full_robot();
  robot.joints[0].lower.reset();
  robot.joints[0].effort = 0;
  const RobotDescription read_again = again(robot);
  EXPECT_FALSE(read_again.joints[0].lower);
  EXPECT_EQ(read_again.joints[0].effort, 0.0);
}

/// A record of kinds of fields that no format's has yet.
struct PairsAndMaps {
  std::vector<std::pair<std::string, double>> pairs;
  std::map<std::string, double> map;
  bool flag = false;
};

template <class Visitor>
void fields(Visitor& v, Part<Visitor, PairsAndMaps>& record) {
  v.list("pairs", record.pairs);
  v.field("map", record.map);
  v.field("flag", record.flag, false);
}

TEST(JsonRecord, PairsMapsAndFlagsComeBack) {
  const PairsAndMaps one{{{"a", 0.1}, {"b", -1}}, {{"x", 1.0 / 3}}, true};
  LossReport loss;
  JsonWriter writer("", loss);
  fields(writer, one);
  const JsonValue value = parse_json(json_text(writer.object(), loss), "file");
  JsonReader reader(value, "", "file", loss);
  PairsAndMaps other;
  fields(reader, other);
  reader.finish();
  EXPECT_EQ(one.pairs, other.pairs);
  EXPECT_EQ(one.map, other.map);
  EXPECT_TRUE(other.flag);
}

TEST_F(JsonFormat, IsToldByItsBeginningAndItsEnding) {
  EXPECT_EQ(format_of(file("any.name", " \n\t{\"prehend_robot\": 1}")).name(), "json");
  EXPECT_EQ(format_for("x.robot.json").name(), "json");
  EXPECT_EQ(format_of(file("arm.json", "<robot name='a'><link name='b'/></robot>")).name(), "urdf");
}

TEST_F(JsonFormat, MeshesWithinAreSaidToBeLost) {
  RobotDescription robot = full_robot();
  robot.links[0].visuals[5].surface = std::make_shared<geometry::TriangleMesh>();
  LossReport loss;
  format_named("json").write(robot, loss);
  ASSERT_EQ(loss.entries().size(), 1U);
  EXPECT_THAT(loss.entries()[0].what, HasSubstr("a file.stl"));
}

TEST_F(JsonFormat, NumbersThatAreNotFiniteAreNotWritten) {
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    RobotDescription robot = full_robot();
    robot.joints[0].X_PJ.translation().y() = bad;
    LossReport loss;
    EXPECT_THROW(format_named("json").write(robot, loss), InputError);
  }
}

TEST_F(JsonFormat, NamesThatAreNoUtf8AreSaid) {
  RobotDescription robot = full_robot();
  robot.name = "\xff";
  LossReport loss;
  EXPECT_EQ(read(format_named("json").write(robot, loss)).name, "\xef\xbf\xbd");
  EXPECT_FALSE(loss.lossless());
}

const std::string kHead = R"({"prehend_robot": 1, "name": "r", "links": [{"name": "a"}, )"
                          R"({"name": "b"}], "joints": [{"name": "j", "kind": "revolute", )"
                          R"("parent": "a", "child": "b")";

TEST_F(JsonFormat, FaultsAreNamedWithTheirPath) {
  EXPECT_EQ(error_of(kHead + "}]}"), "");
  const auto error_with = [&](const std::string& more) { return error_of(kHead + more + "}]}"); };
  EXPECT_THAT(error_with(R"(, "lowerr": 1)"), HasSubstr("a.robot.json: joints[0].lowerr: there is "
                                                        "no such key. The nearest is 'lower'"));
  EXPECT_THAT(error_with(R"(, "lower": "1")"), HasSubstr("joints[0].lower: is no number"));
  EXPECT_THAT(error_with(R"(, "lower": NaN)"), HasSubstr("is no JSON"));
  EXPECT_THAT(error_with(R"(, "lower": 1e999)"), HasSubstr("is no JSON"));
  EXPECT_THAT(error_with(R"(, "lower": null)"), HasSubstr("joints[0].lower: is no number"));
  EXPECT_THAT(error_with(R"(, "lower": 1, "lower": 2)"), HasSubstr("'lower' is there twice"));
  EXPECT_THAT(error_with(R"(, "axis": [0, 0])"), HasSubstr("joints[0].axis: is no list of 3"));
  EXPECT_THAT(error_with(R"(, "axis": [0, 0, 0])"), HasSubstr("joints[0].axis: has no length"));
  EXPECT_THAT(error_with(R"(, "axis": [0, 0, []])"), HasSubstr("joints[0].axis[2]: is no number"));
  EXPECT_THAT(error_with(R"(, "pose": {"quaternion": [2, 0, 0, 0]})"),
              HasSubstr("joints[0].pose.quaternion: has not the length 1"));
  EXPECT_THAT(error_with(R"(, "pose": [1, 2, 3])"), HasSubstr("joints[0].pose: is no object"));
  EXPECT_THAT(error_with(R"(, "follows": {})"), HasSubstr("joints[0].follows: has no 'joint'"));
  EXPECT_THAT(error_with(R"(, "follows": {"joint": "a", "coefficients": [1]})"),
              HasSubstr("joints[0].follows.coefficients: is no list of 2 to 16 numbers"));
  EXPECT_THAT(error_with(R"(, "follows": {"joint": "a", "offset": 1, "coefficients": [1, 2, 3]})"),
              HasSubstr("has coefficients beside multiplier or offset"));
  EXPECT_THAT(error_of(R"({"prehend_robot": 1, "name": "r", "links": {}})"),
              HasSubstr("links: is no list"));
  EXPECT_THAT(error_of(R"({"prehend_robot": 2, "name": "r"})"), HasSubstr("no version"));
  EXPECT_THAT(error_of(R"({"prehend_robot": 1e300, "name": "r"})"), HasSubstr("no whole number"));
  EXPECT_THAT(error_of(R"({"name": "r"})"), HasSubstr("has no 'prehend_robot'"));
  EXPECT_THAT(error_of(R"({"prehend_robot": 1, "name": "r"})"), HasSubstr("has no link"));
  EXPECT_THAT(error_of("{"), HasSubstr("is no JSON"));
  std::string hinged = kHead;
  hinged.replace(hinged.find("revolute"), 8, "revolut");
  EXPECT_THAT(error_of(hinged + "}]}"), HasSubstr("'revolut' is none of its words. The nearest is "
                                                  "'revolute'"));
}

TEST_F(JsonFormat, HostileFilesEndInWords) {
  std::string deep = R"({"prehend_robot": )";
  for (int i = 0; i < 1000000; ++i) deep += "[";
  EXPECT_THAT(error_of(deep), HasSubstr("deeper"));
  // Every byte of a good file in turn is another, or the last.
  LossReport unused;
  const std::string good = format_named("json").write(full_robot(), unused);
  std::mt19937 random(5);
  std::uniform_int_distribution<std::size_t> at(0, good.size() - 1);
  std::uniform_int_distribution<int> byte(0, 255);
  int refused = 0;
  for (int i = 0; i < 600; ++i) {
    std::string bad = good;
    if (i % 4 == 0) {
      bad.resize(at(random));
    } else {
      for (int k = 0; k < i % 4; ++k) bad[at(random)] = static_cast<char>(byte(random));
    }
    try {
      read(bad);
    } catch (const InputError&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 300);
}

TEST_F(JsonFormat, FilesOfOthersComeBackInAllFields) {
  if (shared_model("").empty()) GTEST_SKIP() << "no shared models";
  const int count = for_each_shared_robot([&](const fs::path& path, const RobotDescription& robot) {
    const RobotDescription read_again = again(robot);
    expect_same(robot, read_again, path.string());
    const ModelDifference found = difference(robot, read_again, 20);
    EXPECT_LT(std::max(found.place, found.turn), 1e-12) << path;
  });
  EXPECT_GE(count, 50);
}

}  // namespace
}  // namespace prehend::robot::formats
