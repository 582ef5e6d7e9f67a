// COLLADA as it is written: prehend's reader, Assimp and ROS's collada_urdf read the same robot.

#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <gmock/gmock.h>

#include <assimp/Importer.hpp>
#include <cstdlib>
#include <functional>
#include <numbers>
#include <random>

#include "prehend/geometry/mesh_files.h"
#include "prehend/robot/formats/collada_elements.h"
#include "prehend/robot/formats/collada_text.h"
#include "prehend/robot/formats/model_check.h"
#include "prehend/robot/formats/shape_mesh.h"
#include "prehend/robot/formats/xml_text.h"
#include "tests/robot/formats/robot_files.h"

namespace prehend::robot::formats {
namespace {

namespace fs = std::filesystem;
using geometry::InputError;
using geometry::RigidTransform;
using Kind = JointDescription::Kind;
using testing::HasSubstr;

TEST(ColladaDegrees, AreThereOfEveryNumberOfRadians) {
  EXPECT_EQ(radians_of_degrees("180"), std::numbers::pi);
  EXPECT_EQ(radians_of_degrees("+90"), std::numbers::pi / 2);
  EXPECT_EQ(degrees_text(std::numbers::pi / 4), "45");
  EXPECT_EQ(degrees_text(0), "0");
  std::mt19937 random(11);
  std::uniform_real_distribution<double> mantissa(-1, 1), exponent(-30, 10);
  int longer = 0;
  for (int i = 0; i < 100000; ++i) {
    const double angle = std::exp2(exponent(random)) * mantissa(random);
    const std::string text = degrees_text(angle);
    ASSERT_EQ(radians_of_degrees(text), angle) << text;
    const double others = std::stod(text);  // what is read by doubles
    ASSERT_NEAR(others, angle * 180 / std::numbers::pi, 1e-15 * std::abs(others)) << text;
    if (number_text(others) != text) ++longer;
  }
  EXPECT_GT(longer, 0);  // else this would test nothing
}

class ColladaWritten : public RobotFiles {
 protected:
  /// What `model convert` writes. @param from the robot's file's folder
  fs::path write(RobotDescription robot, const fs::path& from, const std::string& name) {
    const RobotFormat& format = format_for(name);
    written_ = {};
    EXPECT_TRUE(take_out_meshes(robot, from, "x", written_, format.taken_meshes()).empty());
    return file(name, format.write(robot, written_));
  }
  RobotDescription again(const RobotDescription& robot, const fs::path& from = "/nowhere") {
    loss_ = {};
    return read_robot(write(robot, from, "again.dae"), loss_);
  }
  LossReport written_;
};

void expect_same_motion(const RobotDescription& given, const RobotDescription& again) {
  const ModelDifference found = difference(given, again, 100);
  EXPECT_LT(found.place, 1e-9) << found.where;
  EXPECT_LT(found.turn, 1e-9) << found.where;
  EXPECT_THAT(found.only_first, testing::IsEmpty());
  EXPECT_THAT(found.only_second, testing::IsEmpty());
  for (const JointDescription& joint : given.joints) {
    const JointDescription* other = again.joint(joint.name);
    ASSERT_NE(other, nullptr) << joint.name;
    EXPECT_EQ(joint.kind, other->kind) << joint.name;
    EXPECT_EQ(joint.lower, other->lower) << joint.name;
    EXPECT_EQ(joint.upper, other->upper) << joint.name;
    EXPECT_EQ(joint.velocity, other->velocity) << joint.name;
    EXPECT_EQ(joint.effort, other->effort) << joint.name;
    EXPECT_EQ(joint.damping, other->damping);
    EXPECT_EQ(joint.friction, other->friction);
    EXPECT_EQ(joint.break_away, other->break_away);
    ASSERT_EQ(joint.follows.has_value(), other->follows.has_value()) << joint.name;
    if (!joint.follows) continue;
    EXPECT_EQ(joint.follows->joint, other->follows->joint);
    EXPECT_EQ(joint.follows->coefficients, other->follows->coefficients);
  }
}

void expect_same_masses(const RobotDescription& given, const RobotDescription& again) {
  for (const LinkDescription& link : given.links) {
    const LinkDescription* other = again.link(link.name);
    ASSERT_NE(other, nullptr) << link.name;
    ASSERT_EQ(link.inertial.has_value(), other->inertial.has_value()) << link.name;
    if (!link.inertial) continue;
    const auto in_link = [](const Inertial& one) -> Eigen::Matrix3d {
      return one.X_LI.linear() * one.inertia * one.X_LI.linear().transpose();
    };
    EXPECT_EQ(link.inertial->mass, other->inertial->mass) << link.name;
    EXPECT_LT((link.inertial->X_LI.translation() - other->inertial->X_LI.translation()).norm(),
              1e-12)
        << link.name;
    const Eigen::Matrix3d I = in_link(*link.inertial);
    EXPECT_LE((I - in_link(*other->inertial)).norm(), 1e-12 * I.norm()) << link.name;
  }
}

Eigen::AlignedBox3d box_in_link(const Shape& shape) {
  return geometry::bounds(geometry::transformed(ShapeMeshes(".").of(shape), shape.X_LS));
}

void expect_same_shapes(const std::vector<Shape>& given, const std::vector<Shape>& again,
                        const std::string& of) {
  ASSERT_EQ(given.size(), again.size()) << of;
  for (std::size_t i = 0; i < given.size(); ++i) {
    EXPECT_EQ(given[i].kind, again[i].kind) << of;
    EXPECT_EQ(given[i].name, again[i].name) << of;
    EXPECT_TRUE(given[i].X_LS.isApprox(again[i].X_LS, 1e-12)) << of;
    if (given[i].kind == Shape::Kind::kPlane) continue;
    const auto first = box_in_link(given[i]), second = box_in_link(again[i]);
    // Meshes' points are written as floats are.
    EXPECT_LT((first.min() - second.min()).norm(), 1e-6) << of;
    EXPECT_LT((first.max() - second.max()).norm(), 1e-6) << of;
  }
}

TEST_F(ColladaWritten, OwnRobotsComeBackWhole) {
  for (const auto& entry : fs::directory_iterator("config/robots")) {
    if (entry.path().extension() != ".urdf") continue;
    SCOPED_TRACE(entry.path());
    LossReport unused;
    const RobotDescription given = read_robot(entry.path(), unused);
    const RobotDescription once = again(given, "config/robots");
    EXPECT_TRUE(loss_.lossless()) << loss_.text();
    expect_same_motion(given, once);
    expect_same_masses(given, once);
    const RobotDescription twice = again(once);
    EXPECT_TRUE(written_.lossless() && loss_.lossless()) << written_.text() << loss_.text();
    expect_same_motion(given, twice);
    for (const LinkDescription& link : once.links) {
      expect_same_shapes(link.visuals, twice.link(link.name)->visuals, link.name);
      expect_same_shapes(link.collisions, twice.link(link.name)->collisions, link.name);
    }
    RobotDescription loaded = given;
    take_out_meshes(loaded, "config/robots", "x", unused, TakenMeshes::kEmbedded);
    for (const LinkDescription& link : loaded.links) {
      expect_same_shapes(link.visuals, once.link(link.name)->visuals, link.name);
      expect_same_shapes(link.collisions, once.link(link.name)->collisions, link.name);
    }
  }
}

RigidTransform some_pose(double x, double angle) {
  return geometry::make_transform(
      Eigen::Quaterniond(Eigen::AngleAxisd(angle, Eigen::Vector3d(1, 2, -2).normalized())),
      {x, 0.2, -0.1});
}

Shape some_shape(Shape::Kind kind, const std::string& name) {
  Shape shape;
  shape.kind = kind;
  shape.name = name;
  shape.X_LS = some_pose(0.01, 0.7);
  if (kind == Shape::Kind::kBox) shape.size = {0.1, 0.2, 0.3};
  if (kind != Shape::Kind::kBox && kind != Shape::Kind::kPlane) shape.radius = 0.05;
  if (kind == Shape::Kind::kCylinder || kind == Shape::Kind::kCapsule) shape.length = 0.2;
  return shape;
}

/// With all that COLLADA and OpenRAVE's extras can say, and names that XML would have otherwise.
RobotDescription all_of_it() {
  RobotDescription robot;
  robot.name = "<all> & \"it\"";
  for (const char* name : {"base", "a <&> \"b\" 'c'", "the ball", "the_ball", "rail", "slider"}) {
    robot.links.push_back({name, {}, {}, {}});
  }
  LinkDescription& base = robot.links[0];
  Eigen::Matrix3d inertia;
  inertia << 3, 0.1, 0.2, 0.1, 4, -0.3, 0.2, -0.3, 5;
  base.inertial = Inertial{1.25, some_pose(0.3, 1), 1e-3 * inertia};
  for (const auto kind :
       {Shape::Kind::kBox, Shape::Kind::kSphere, Shape::Kind::kCylinder, Shape::Kind::kCapsule}) {
    base.visuals.push_back(some_shape(kind, "seen & shown"));
    base.visuals.back().color = {{0.1, 0.2, 0.3, 0.5}};
    base.visuals.back().material = "a \"glass\"";
    base.collisions.push_back(some_shape(kind, "<touched>"));
  }
  base.collisions.push_back(some_shape(Shape::Kind::kPlane, "floor"));
  Shape mesh = some_shape(Shape::Kind::kMesh, "");
  mesh.mesh = "wedge";
  mesh.surface =
      std::make_shared<const geometry::TriangleMesh>(geometry::make_box({0.1, 0.2, 0.4}));
  mesh.scale = {0.5, 1, 2};
  robot.links[1].visuals = {mesh, mesh};
  robot.links[1].visuals[1].X_LS = some_pose(-0.2, 0.1);
  robot.links[1].collisions = {robot.links[1].visuals[1]};  // one of the two
  robot.links[2].visuals = {mesh};                          // nothing to touch
  robot.links[3].collisions = {mesh};                       // nothing to see
  const auto join = [&](const std::string& name, Kind kind, int parent, int child) {
    JointDescription joint;
    joint.name = name;
    joint.kind = kind;
    joint.parent = robot.links[static_cast<std::size_t>(parent)].name;
    joint.child = robot.links[static_cast<std::size_t>(child)].name;
    joint.X_PJ = some_pose(0.3, 0.4 * child);
    joint.X_JC = some_pose(-0.1, 0.9);
    joint.axis_J = Eigen::Vector3d(1, -2, 3).normalized();
    robot.joints.push_back(joint);
    return &robot.joints.back();
  };
  robot.joints.reserve(8);
  JointDescription* turning = join("turning & <so on>", Kind::kRevolute, 0, 1);
  turning->lower = -1.1;
  turning->upper = 2.2;
  turning->velocity = 0.7;
  turning->effort = 12.3;
  turning->damping = 0.4;
  turning->friction = 0.03;
  turning->stiffness = 5;
  turning->rest = 0.2;
  join("the ball", Kind::kBall, 1, 2);
  JointDescription* passive = join("the_ball", Kind::kRevolute, 1, 3);
  passive->passive = true;
  passive->lower = -0.3;  // on one side
  join("rail", Kind::kFixed, 0, 4)->axis_J = Eigen::Vector3d::UnitX();
  JointDescription* slide = join("slide", Kind::kPrismatic, 4, 5);
  slide->lower = 0;
  slide->upper = 0.1;
  slide->velocity = 0.02;
  slide->follows = Follows{turning->name, -0.03, 0.05};
  slide->break_away = 0.9;
  robot.actuators = {{"motor & gear", turning->name, 50, 11, "position"},
                     {"the other", slide->name, 1, {}, ""}};
  Sensor camera{"eye", "camera", "base", some_pose(1, 2), Eigen::Vector3d::Zero()};
  Sensor cell{"a cell", "tactile", "slider", some_pose(0, 1), {0.01, 0.02, 0.001}};
  robot.sensors = {camera, cell};
  robot.manipulators = {
      {"grip", "base", "the ball", some_pose(0, 0.3), {{"slide", -1}, {turning->name, 1}}}};
  robot.disabled_collisions = {{"base", "the ball"}, {"rail", "slider"}};
  return robot;
}

TEST_F(ColladaWritten, AllFieldsComeBack) {
  const RobotDescription given = all_of_it();
  const RobotDescription once = again(given);
  EXPECT_TRUE(written_.lossless()) << written_.text();
  EXPECT_TRUE(loss_.lossless()) << loss_.text();
  EXPECT_EQ(once.name, given.name);
  expect_same_motion(given, once);
  expect_same_masses(given, once);
  for (const LinkDescription& link : given.links) {
    expect_same_shapes(link.visuals, once.link(link.name)->visuals, link.name + " seen");
    expect_same_shapes(link.collisions, once.link(link.name)->collisions, link.name + " touched");
  }
  EXPECT_EQ(once.links[0].visuals[3].color, given.links[0].visuals[3].color);
  EXPECT_EQ(once.links[0].visuals[3].material, given.links[0].visuals[3].material);
  EXPECT_EQ(once.joints[0].stiffness, 5);
  EXPECT_EQ(once.joints[0].rest, 0.2);
  EXPECT_TRUE(once.joint("the_ball")->passive);
  EXPECT_FALSE(once.joints[0].passive);
  ASSERT_EQ(once.actuators.size(), 2U);
  EXPECT_EQ(once.actuators[0].name, "motor & gear");
  EXPECT_EQ(once.actuators[0].joint, given.joints[0].name);
  EXPECT_EQ(once.actuators[0].gear, 50);
  EXPECT_DOUBLE_EQ(*once.actuators[0].effort, 11);
  EXPECT_EQ(once.actuators[0].control, "position");
  EXPECT_FALSE(once.actuators[1].effort);
  ASSERT_EQ(once.sensors.size(), 2U);
  EXPECT_EQ(once.sensors[0].kind, "camera");
  EXPECT_TRUE(once.sensors[0].X_LS.isApprox(given.sensors[0].X_LS, 1e-12));
  EXPECT_EQ(once.sensors[1].kind, "tactile");
  EXPECT_EQ(once.sensors[1].size, given.sensors[1].size);
  ASSERT_EQ(once.manipulators.size(), 1U);
  EXPECT_EQ(once.manipulators[0].tip, "the ball");
  EXPECT_EQ(once.manipulators[0].closing, given.manipulators[0].closing);
  EXPECT_TRUE(once.manipulators[0].X_TipTool.isApprox(given.manipulators[0].X_TipTool, 1e-12));
  EXPECT_EQ(once.disabled_collisions, given.disabled_collisions);
}

/// The same document as other programs read it.
std::string without_block(std::string text) {
  const std::size_t begin = text.find(" <extra type=\"prehend\">");
  const std::size_t end = text.find("</COLLADA>");
  if (begin != std::string::npos) text.erase(begin, end - begin);
  return text;
}

TEST_F(ColladaWritten, WhatItCannotSayIsInItsBlock) {
  RobotDescription robot = all_of_it();
  robot.joints[1].kind = Kind::kFloating;
  robot.joints[0].lower = robot.joints[0].upper = 0;
  robot.loops = {{"ring", Loop::Kind::kPoint, "base", "slider", RigidTransform::Identity()}};
  robot.postures = {{"open", "grip", {{"slide", 0.1}}}};
  robot.links[0].visuals.push_back(some_shape(Shape::Kind::kPlane, "endless"));
  robot.links[5].inertial = Inertial{};
  robot.links[5].visuals = {Shape{}};  // a box without size
  const RobotDescription once = again(robot);
  EXPECT_TRUE(written_.lossless() && loss_.lossless()) << written_.text() << loss_.text();
  EXPECT_THAT(written_.text(), HasSubstr("kept in prehend's extension, which other programs do not "
                                         "read: 1 closed loop, 1 posture, "));
  EXPECT_THAT(written_.text(), HasSubstr("for others approximated limits of 0: fixed"));
  EXPECT_EQ(once.joint("the ball")->kind, Kind::kFloating);
  EXPECT_EQ(once.joints[0].kind, Kind::kRevolute);
  EXPECT_EQ(once.joints[0].upper, 0);
  ASSERT_EQ(once.loops.size(), 1U);
  EXPECT_EQ(once.postures.at(0).positions.at("slide"), 0.1);
  ASSERT_EQ(once.links[0].visuals.size(), 5U);
  EXPECT_EQ(once.links[0].visuals[4].kind, Shape::Kind::kPlane);
  EXPECT_EQ(once.link("slider")->visuals.size(), 1U);
  // What others read of it is whole, too, and each thing of it what is told.
  const RobotDescription others =
      read("others.dae", without_block(format_named("collada").write(robot, written_)));
  EXPECT_EQ(others.joint("the ball")->kind, Kind::kFixed);
  EXPECT_EQ(others.joints[0].kind, Kind::kFixed);
  EXPECT_TRUE(others.loops.empty());
  EXPECT_EQ(others.links[0].visuals.size(), 4U);
}

TEST_F(ColladaWritten, WithoutABlockTheReportSaysWhatIsLost) {
  RobotDescription robot = all_of_it();
  robot.joints[1].kind = Kind::kPlanar;
  robot.loops = {{"ring", Loop::Kind::kPoint, "base", "slider", RigidTransform::Identity()}};
  robot.postures = {{"\xff", "grip", {{"slide", 0.1}}}};
  const RobotDescription once = again(robot);
  EXPECT_TRUE(once.loops.empty() && once.postures.empty());
  for (const char* words : {"planar joint", "closed loop", "posture", "UTF-8"}) {
    EXPECT_THAT(written_.text(), HasSubstr(words));
  }
}

/// A mesh that nothing but the robot in memory has, and that no document can have.
TEST_F(ColladaWritten, ASurfaceWithoutTrianglesIsToldAndNotKept) {
  RobotDescription robot = all_of_it();
  Shape empty;
  empty.kind = Shape::Kind::kMesh;
  empty.mesh = "nothing";
  empty.surface = std::make_shared<const geometry::TriangleMesh>();
  robot.links[0].visuals.insert(robot.links[0].visuals.begin(), empty);
  const RobotDescription once = again(robot);
  EXPECT_THAT(written_.text(), HasSubstr("dropped visual (mesh 'nothing')"));
  EXPECT_EQ(once.links[0].visuals.size(), 4U);
}

/// As one whose corners are one point, so that it is read as none: no block may name its file.
TEST_F(ColladaWritten, ASurfaceThatIsAPointIsToldAndHasNoBlock) {
  RobotDescription robot = all_of_it();
  Shape point;
  point.kind = Shape::Kind::kMesh;
  point.mesh = "point";
  auto surface = std::make_shared<geometry::TriangleMesh>();
  surface->vertices.assign(3, Eigen::Vector3d::Ones());
  surface->triangles = {{0, 1, 2}};
  point.surface = surface;
  robot.links[0].visuals.push_back(point);
  robot.postures = {{"open", "grip", {{"slide", 0.1}}}};
  const RobotDescription once = again(robot);
  EXPECT_THAT(written_.text(), HasSubstr("dropped prehend's extension: link 'base' has shapes"));
  EXPECT_THAT(written_.text(), HasSubstr("dropped posture"));
  EXPECT_EQ(once.links[0].visuals.size(), 4U);
}

TEST_F(ColladaWritten, ABadMeshIsToldAndAllElseWritten) {
  const RobotDescription given = read("bad.urdf", R"(<robot name="r"><link name="l">
    <visual><geometry><mesh filename="gone.stl"/></geometry></visual>
    <visual><geometry><mesh filename="torn.stl"/></geometry></visual>
    <visual><geometry><box size="1 2 3"/></geometry></visual></link></robot>)");
  file("torn.stl", "solid no\n facet");
  const RobotDescription once = again(given, folder_);
  EXPECT_THAT(written_.text(), testing::AllOf(HasSubstr("gone.stl"), HasSubstr("torn.stl")));
  // As every format has them that names meshes: they may be there again.
  ASSERT_EQ(once.links.at(0).visuals.size(), 3U);
  EXPECT_EQ(once.links[0].visuals[0].mesh, "gone.stl");
  EXPECT_EQ(once.links[0].visuals[1].mesh, "torn.stl");
  EXPECT_EQ(once.links[0].visuals[2].size, Eigen::Vector3d(1, 2, 3));
  EXPECT_TRUE(once.links[0].collisions.empty());
}

// The visual scene by another's reader: every corner that is seen is where it is, all joints at 0.
std::vector<Eigen::Vector3d> corners_by_assimp(const fs::path& path) {
  Assimp::Importer importer;
  importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, true);
  const aiScene* scene = importer.ReadFile(path.string(), aiProcess_JoinIdenticalVertices);
  std::vector<Eigen::Vector3d> seen;
  EXPECT_NE(scene, nullptr) << importer.GetErrorString();
  if (!scene) return seen;
  const std::function<void(const aiNode&, const aiMatrix4x4&)> visit = [&](const aiNode& node,
                                                                           const aiMatrix4x4& up) {
    const aiMatrix4x4 X = up * node.mTransformation;
    for (unsigned i = 0; i < node.mNumMeshes; ++i) {
      const aiMesh& mesh = *scene->mMeshes[node.mMeshes[i]];
      for (unsigned k = 0; k < mesh.mNumVertices; ++k) {
        const aiVector3D p = X * mesh.mVertices[k];
        seen.emplace_back(p.x, p.y, p.z);
      }
    }
    for (unsigned i = 0; i < node.mNumChildren; ++i) visit(*node.mChildren[i], X);
  };
  visit(*scene->mRootNode, aiMatrix4x4());
  return seen;
}

TEST_F(ColladaWritten, AssimpSeesTheSameCorners) {
  RobotDescription robot = all_of_it();
  robot.links[3].collisions.clear();
  const auto seen = corners_by_assimp(write(robot, folder_, "seen.dae"));
  const auto packed = corners_by_assimp(write(robot, folder_, "seen.zae"));
  std::vector<Eigen::Vector3d> expected;
  for (JointDescription& joint : robot.joints) joint.follows.reset();
  const auto X_RL = link_poses(robot, {});
  for (const LinkDescription& link : robot.links) {
    for (const Shape& shape : link.visuals) {
      const auto mesh =
          geometry::transformed(ShapeMeshes(".").of(shape), X_RL.at(link.name) * shape.X_LS);
      expected.insert(expected.end(), mesh.vertices.begin(), mesh.vertices.end());
    }
  }
  const auto farthest = [](const auto& points, const auto& others) {
    double most = 0;
    for (const Eigen::Vector3d& p : points) {
      double nearest = 1e9;
      for (const Eigen::Vector3d& q : others) nearest = std::min(nearest, (p - q).norm());
      most = std::max(most, nearest);
    }
    return most;
  };
  ASSERT_FALSE(seen.empty());
  EXPECT_LT(farthest(expected, seen), 1e-6);
  EXPECT_LT(farthest(seen, expected), 1e-6);
  EXPECT_EQ(seen, packed);
}

// By collada-dom and ROS's parser on it. It reads no couplings, nor efforts from motors, takes
// speeds as radians, and a link's own place after its joint as before it: these are left out.
TEST_F(ColladaWritten, ColladaUrdfReadsTheSameKinematics) {
  const char* tool = "/usr/lib/collada_urdf/collada_to_urdf";
  if (!fs::exists(tool)) GTEST_SKIP() << "collada-urdf-tools of Debian is not installed";
  for (const char* name : {"ur5e.urdf", "schunk_sdh2.urdf", "pa10_7c.urdf", "stage_pg70.urdf"}) {
    SCOPED_TRACE(name);
    LossReport unused;
    RobotDescription given = read_robot(fs::path("config/robots") / name, unused);
    for (JointDescription& joint : given.joints) joint.follows.reset();
    given.postures = {{"rest", "all", {{given.joints[0].name, 0}}}};  // in a block
    const fs::path path = write(given, "config/robots", "given.dae"), back = folder_ / "back.urdf";
    const std::string command = std::string(tool) + " '" + path.string() + "' --mesh_output_dir '" +
                                folder_.string() + "' -O '" + back.string() + "' > '" +
                                (folder_ / "log").string() + "' 2>&1";
    ASSERT_EQ(std::system(command.c_str()), 0);
    const RobotDescription other = read_robot(back, unused);
    const ModelDifference found = difference(given, other, 100);
    EXPECT_LT(found.place, 1e-5) << found.where;  // it writes six digits of each
    EXPECT_LT(found.turn, 5e-5) << found.where;
    EXPECT_THAT(found.only_first, testing::IsEmpty());
    for (const LinkDescription& link : given.links) {
      if (!link.inertial) continue;
      ASSERT_TRUE(other.link(link.name) && other.link(link.name)->inertial) << link.name;
      const Inertial& its = *other.link(link.name)->inertial;
      EXPECT_NEAR(its.mass, link.inertial->mass, 1e-5 * link.inertial->mass);
      EXPECT_LT((its.X_LI.translation() - link.inertial->X_LI.translation()).norm(), 1e-5)
          << link.name;
    }
    std::ifstream log(folder_ / "log");
    const std::string words{std::istreambuf_iterator<char>(log), {}};
    EXPECT_THAT(words,
                testing::Not(HasSubstr("nable to create")));  // what its schema has not there
  }
}

TEST_F(ColladaWritten, RobotsOfOthersComeBack) {
  if (shared_model("urdf").empty()) GTEST_SKIP() << "no shared models";
  for (const char* name :
       {"sdf/gazebo_models/simple_gripper/model.sdf", "simox/Schunk_SAH/SAH_RightHand.xml",
        "graspit/HumanHand/HumanHand20DOF.xml", "openrave/kuka-youbot.zae",
        "openrave/barrett-wam-sensors.zae", "openhrp/nextage_description/models/main.dae",
        "urdf/robotiq_arg85_description/robots/robotiq_arg85_description.URDF"}) {
    SCOPED_TRACE(name);
    const fs::path path = shared_model(name);
    ASSERT_FALSE(path.empty());
    LossReport unused;
    const RobotDescription given = read_robot(path, unused);
    const RobotDescription once = again(given, path.parent_path());
    expect_same_motion(given, once);
    expect_same_masses(given, once);
    EXPECT_EQ(given.disabled_collisions, once.disabled_collisions);
    EXPECT_EQ(given.manipulators.size(), once.manipulators.size());
    EXPECT_EQ(given.sensors.size(), once.sensors.size());
  }
}

}  // namespace
}  // namespace prehend::robot::formats
