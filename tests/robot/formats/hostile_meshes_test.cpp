// Files of strangers who mean harm, by the meshes that they name: where those are, and how large.

#include <gmock/gmock.h>

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <numbers>

#include "prehend/geometry/errors.h"
#include "prehend/geometry/mesh_files.h"
#include "prehend/robot/formats/model_check.h"
#include "prehend/robot/formats/shape_mesh.h"
#include "prehend/robot/mesh_shape.h"
#include "tests/robot/formats/hostile_files.h"

namespace prehend::robot::formats {
namespace {

namespace fs = std::filesystem;
using geometry::InputError;
using testing::HasSubstr;
using testing::Not;

TEST_F(HostileFiles, PathsAreNeverCommandsAndPackagesAreNotLeft) {
  const std::string paths[] = {"$(touch touched)",
                               "`touch touched`",
                               "; touch touched",
                               "| touch touched",
                               "a\nb",
                               "../../../../etc/passwd",
                               "/etc/passwd",
                               "file:///etc/passwd",
                               "%2e%2e/etc/passwd",
                               "\\\\host\\share",
                               "http://host/a.stl",
                               "a.stl?<script>",
                               "file://",
                               "package://",
                               "package://p",
                               std::string(5000, 'a')};
  for (const std::string& path : paths) {
    RobotDescription robot;
    robot.name = "<script>alert(1)</script>";
    Shape mesh;
    mesh.kind = Shape::Kind::kMesh;
    mesh.mesh = path;
    robot.links = {{"\" onload=\"alert(1)", {}, {mesh}, {mesh}}};
    EXPECT_FALSE(findings_of(robot).empty()) << path;
    LossReport loss;
    EXPECT_TRUE(take_out_meshes(robot, folder_, "out", loss, TakenMeshes::kAll).empty()) << path;
    EXPECT_THAT(loss.text(), HasSubstr("mesh")) << path;
    for (const char* format : {"urdf", "sdf", "json"}) {
      const RobotDescription again = written_and_read(robot, format);
      EXPECT_EQ(again.links[0].visuals[0].mesh, path) << format;
      EXPECT_EQ(again.links[0].name, robot.links[0].name) << format;
      EXPECT_EQ(again.name, robot.name) << format;
    }
  }
  EXPECT_FALSE(fs::exists("touched") || fs::exists(folder_ / "touched"));
  file("p/a.stl", "");
  file("b.stl", "");
  for (const char* name :
       {"package://p/../b.stl", "package://p/../../b.stl", "package://p/x/../../b.stl",
        "package://../b.stl", "package://./b.stl", "package:////etc/passwd", "model://p/../b.stl",
        "package://p//etc/passwd"}) {
    EXPECT_THROW(find_mesh_file(name, folder_), InputError) << name;
    const RobotDescription robot =
        read("r.urdf", std::string("<robot name='r'><link name='a'><collision><geometry><mesh "
                                   "filename='") +
                           name + "'/></geometry></collision></link></robot>");
    EXPECT_THAT(findings_of(robot), HasSubstr("leaves its package")) << name;
  }
  EXPECT_EQ(find_mesh_file("package://p/x/../a.stl", folder_), folder_ / "p/x/../a.stl");
  // What is written beside the robot's file stays there, whatever it is called.
  RobotDescription robot;
  Shape shape;
  shape.kind = Shape::Kind::kMesh;
  shape.mesh = "../../../tmp/$(x)/..";
  shape.surface = std::make_shared<const geometry::TriangleMesh>(geometry::make_box({1, 1, 1}));
  robot.links = {{"a", {}, {shape}, {}}};
  LossReport loss;
  const auto meshes = take_out_meshes(robot, folder_, "../out", loss);
  ASSERT_EQ(meshes.size(), 1U);
  EXPECT_THAT(meshes[0].file.string(), Not(HasSubstr("..")));
}

/// A ball of about `count` triangles, as binary STL; rough by `noise` of its radius.
void write_ball(const fs::path& file, int count, double radius, double noise) {
  const int rows = static_cast<int>(std::sqrt(count / 2.0));
  const auto at = [&](int i, int j) {
    const double polar = std::numbers::pi * i / rows,
                 round = 2 * std::numbers::pi * (j % rows) / rows;
    const auto hash = static_cast<std::uint32_t>(i * 7919 + (j % rows) * 104729) * 2654435761U;
    const double r = radius * (1 + noise * (hash / 4294967296.0 - 0.5));
    return Eigen::Vector3f(static_cast<float>(r * std::sin(polar) * std::cos(round)),
                           static_cast<float>(r * std::sin(polar) * std::sin(round)),
                           static_cast<float>(r * std::cos(polar)));
  };
  std::string bytes(80, 'x');
  const auto add = [&](const void* data, std::size_t size) {
    bytes.append(static_cast<const char*>(data), size);
  };
  const std::uint32_t triangles = static_cast<std::uint32_t>(2 * rows * rows);
  add(&triangles, 4);
  const auto triangle = [&](const Eigen::Vector3f& a, const Eigen::Vector3f& b,
                            const Eigen::Vector3f& c) {
    const Eigen::Vector3f none = Eigen::Vector3f::Zero();
    for (const Eigen::Vector3f* p : {&none, &a, &b, &c}) add(p->data(), 12);
    bytes.append(2, '\0');
  };
  for (int i = 0; i < rows; ++i) {
    for (int j = 0; j < rows; ++j) {
      triangle(at(i, j), at(i + 1, j), at(i + 1, j + 1));
      triangle(at(i, j), at(i + 1, j + 1), at(i, j + 1));
    }
  }
  std::ofstream(file, std::ios::binary) << bytes;
}

/// Two links of that mesh, which are not joined to one another, 1.5 radii apart.
std::string two_of(const std::string& mesh) {
  const std::string shape =
      "<collision><geometry><mesh filename='" + mesh + "'/></geometry></collision></link>";
  return "<robot name='r'><link name='a'>" + shape + "<link name='m'/><link name='b'>" +
         "<inertial><mass value='1'/><inertia ixx='0' ixy='0' ixz='0' iyy='0' iyz='0' izz='0'/>"
         "</inertial>" +
         shape +
         "<joint name='j' type='continuous'><parent link='a'/><child link='m'/></joint>"
         "<joint name='k' type='continuous'><parent link='m'/><child link='b'/><origin xyz='0.15 0 "
         "0'/></joint></robot>";
}

TEST_F(HostileFiles, MeshesOfTwoMillionTrianglesAreThinnedWithAWord) {
  write_ball(folder_ / "ball.stl", 2000000, 0.1, 0);
  RobotDescription robot = read("two.urdf", two_of("ball.stl"));
  const std::string found = findings_of(robot);
  EXPECT_THAT(found, HasSubstr("link 'a' and link 'b': overlap by 49."));  // of 50 mm
  EXPECT_THAT(found, HasSubstr("triangles, was thinned to"));
  // Small ones are compared as they are.
  write_ball(folder_ / "small.stl", 20000, 0.1, 0);
  robot = read("two.urdf", two_of("small.stl"));
  EXPECT_THAT(findings_of(robot), Not(HasSubstr("thinned")));
  EXPECT_THAT(findings_of(robot), HasSubstr("link 'a' and link 'b': overlap by 49."));
  const auto mended = mend_model(robot, folder_);
  ASSERT_EQ(mended.size(), 1U);
  EXPECT_NEAR(robot.link("b")->inertial->inertia(0, 0), 0.4 * 0.1 * 0.1, 4e-5);
}

// All of a thousand balls at one place: half a million pairs of hulls of 500 corners.
TEST_F(HostileFiles, ShapesAtOnePlaceAreLookedAtInPart) {
  std::string text = "<robot name='r'><link name='root'/>";
  for (int i = 0; i < 1000; ++i) {
    const std::string n = std::to_string(i);
    text +=
        "<link name='m" + n + "'/><link name='l" + n +
        "'><collision><geometry><sphere radius='1'/></geometry></collision></link><joint name='i" +
        n + "' type='continuous'><parent link='root'/><child link='m" + n +
        "'/></joint><joint name='j" + n + "' type='continuous'><parent link='m" + n +
        "'/><child link='l" + n + "'/></joint>";
  }
  const RobotDescription robot = read("balls.urdf", text + "</robot>");
  EXPECT_THAT(findings_of(robot), HasSubstr("more pairs near one another than are looked at"));
}

}  // namespace
}  // namespace prehend::robot::formats
