#include "prehend/robot/mesh_shape.h"

#include <cstdlib>
#include <fstream>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "prehend/geometry/errors.h"
#include "prehend/geometry/mesh_files.h"
#include "prehend/robot/robot_model.h"
#include "tests/robot/as_meshes.h"

namespace prehend::robot {
namespace {

using Eigen::Vector3d;
using geometry::InputError;
using ::testing::HasSubstr;

class MeshShape : public testing::Test {
 protected:
  MeshShape()
      : folder_(std::filesystem::temp_directory_path() /
                ("prehend_meshes_" + std::to_string(getpid()))) {
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
    geometry::write_mesh_file(folder_ / "box.stl", geometry::make_box({0.1, 0.2, 0.3}));
  }
  ~MeshShape() override {
    std::filesystem::remove_all(folder_);
    unsetenv("ROS_PACKAGE_PATH");
  }

  RobotModel read(const std::string& mesh) const {
    const std::filesystem::path file = folder_ / "robot.urdf";
    std::ofstream(file) << "<robot name='r'><link name='forearm'><collision><origin xyz='0 0 1'/>"
                           "<geometry><mesh "
                        << mesh << "/></geometry></collision></link></robot>";
    return read_urdf(file);
  }

  std::string error(const std::string& mesh) const {
    try {
      read(mesh);
    } catch (const InputError& e) {
      return e.what();
    }
    return "no error";
  }

  static double volume(const RobotModel& model) {
    return geometry::mass_properties(*model.links[0].shapes[0].solid).volume;
  }

  std::filesystem::path folder_;
};

TEST_F(MeshShape, IsASolidAtItsScale) {
  const RobotModel model = read("filename='box.stl'");
  EXPECT_TRUE(model.remarks.empty());
  const CollisionShape& shape = model.links[0].shapes[0];
  EXPECT_EQ(shape.kind, CollisionShape::Kind::kMesh);
  EXPECT_EQ(shape.mesh, "box.stl");
  EXPECT_EQ(shape.X_LS.translation().z(), 1);
  EXPECT_EQ(shape.solid->vertices.size(), 8u);
  EXPECT_NEAR(volume(model), 0.006, 1e-9);
  EXPECT_NEAR(volume(read("filename='box.stl' scale='2 1 0.5'")), 0.006, 1e-9);
  EXPECT_TRUE(geometry::bounds(*read("filename='box.stl' scale='2 1 0.5'").links[0].shapes[0].solid)
                  .sizes()
                  .isApprox(Vector3d(0.2, 0.2, 0.15), 1e-6));
  // A mirror image is not inside out.
  EXPECT_NEAR(volume(read("filename='box.stl' scale='1 -1 1'")), 0.006, 1e-9);
  geometry::TriangleMesh inside_out = geometry::make_box({0.1, 0.2, 0.3});
  for (Eigen::Vector3i& t : inside_out.triangles) std::swap(t[0], t[1]);
  geometry::write_mesh_file(folder_ / "inside_out.ply", inside_out);
  EXPECT_NEAR(volume(read("filename='inside_out.ply'")), 0.006, 1e-9);
}

TEST_F(MeshShape, ShellsThatTouchAreASolid) {
  // Two boxes that share an edge, as programs for drawing write assemblies: four triangles meet
  // there.
  geometry::TriangleMesh other = geometry::make_box({0.1, 0.1, 0.1});
  for (Vector3d& p : other.vertices) p += Vector3d(0.1, 0.1, 0);
  geometry::write_mesh_file(folder_ / "two.stl",
                            geometry::concatenated({geometry::make_box({0.1, 0.1, 0.1}), other}));
  const RobotModel model = read("filename='two.stl'");
  EXPECT_TRUE(model.remarks.empty());
  EXPECT_NEAR(volume(model), 0.002, 1e-9);
}

/// A bracket like an L, 2 x 2 x 1 units of 0.1 m without a corner of one: far from its hull.
geometry::TriangleMesh bracket() {
  const std::vector<Vector3d> corners{{0, 0, 0}, {2, 0, 0}, {2, 1, 0},
                                      {1, 1, 0}, {1, 2, 0}, {0, 2, 0}};
  geometry::TriangleMesh mesh;
  for (const double z : {0.0, 1.0}) {
    for (const Vector3d& p : corners) mesh.vertices.push_back(0.1 * Vector3d(p.x(), p.y(), z));
  }
  for (const auto& t : {Eigen::Vector3i(0, 1, 2), {0, 2, 3}, {0, 3, 4}, {0, 4, 5}}) {
    mesh.triangles.emplace_back(t[0], t[2], t[1]);
    mesh.triangles.emplace_back(t[0] + 6, t[1] + 6, t[2] + 6);
  }
  for (int i = 0; i < 6; ++i) {
    const int j = (i + 1) % 6;
    mesh.triangles.emplace_back(i, j, j + 6);
    mesh.triangles.emplace_back(i, j + 6, i + 6);
  }
  return mesh;
}

TEST_F(MeshShape, HolesAreClosedAndRemarkedOn) {
  geometry::TriangleMesh open = bracket();
  ASSERT_TRUE(geometry::find_defects(open).watertight());
  ASSERT_NEAR(geometry::mass_properties(open).volume, 0.003, 1e-12);
  open.triangles.erase(open.triangles.begin() + 10);
  open.triangles.pop_back();
  geometry::write_mesh_file(folder_ / "open.obj", open);
  const RobotModel model = read("filename='open.obj'");
  ASSERT_EQ(model.remarks.size(), 1u);
  EXPECT_THAT(model.remarks[0], HasSubstr("link 'forearm'"));
  EXPECT_THAT(model.remarks[0], HasSubstr("open.obj' has 2 holes"));
  EXPECT_NEAR(volume(model), 0.003, 1e-9) << "the missing triangles were flat";
  EXPECT_TRUE(geometry::find_defects(*model.links[0].shapes[0].solid).watertight());
}

TEST_F(MeshShape, WhatCannotBeClosedIsItsHullAndSaysSo) {
  geometry::TriangleMesh half = bracket(), mixed = bracket();
  std::erase_if(half.triangles, [&](const Eigen::Vector3i& t) {
    return half.vertices[t[0]].z() + half.vertices[t[1]].z() + half.vertices[t[2]].z() > 0.25;
  });
  half.triangles.resize(8);
  std::swap(mixed.triangles[10][0], mixed.triangles[10][1]);
  for (const auto& mesh : {half, mixed}) {
    geometry::write_mesh_file(folder_ / "open.obj", mesh);
    const RobotModel model = read("filename='open.obj'");
    ASSERT_EQ(model.remarks.size(), 1u);
    EXPECT_THAT(model.remarks[0], HasSubstr("open.obj' does not close: its convex hull"));
    EXPECT_GT(volume(model), 0.0024);
  }
}

TEST_F(MeshShape, PackagesAreFoundAboveAndOnTheRosPath) {
  // robots/my_arm/urdf/arm.urdf, robots/my_arm/meshes/a.stl and robots/my_hand/meshes/b.stl.
  const std::filesystem::path urdf = folder_ / "robots/my_arm/urdf";
  for (const char* place : {"robots/my_arm/urdf", "robots/my_arm/meshes", "robots/my_hand/meshes",
                            "elsewhere/far/meshes"}) {
    std::filesystem::create_directories(folder_ / place);
  }
  const auto put = [&](const std::string& place) {
    std::filesystem::copy_file(folder_ / "box.stl", folder_ / place);
    return folder_ / place;
  };
  const auto own = put("robots/my_arm/meshes/a.stl"), beside = put("robots/my_hand/meshes/b.stl"),
             far = put("elsewhere/far/meshes/c.stl");
  EXPECT_EQ(find_mesh_file("package://my_arm/meshes/a.stl", urdf), own);
  EXPECT_EQ(find_mesh_file("model://my_arm/meshes/a.stl", urdf.string() + "/"), own);
  EXPECT_EQ(find_mesh_file("package://my_hand/meshes/b.stl", urdf), beside);
  EXPECT_EQ(find_mesh_file("../meshes/a.stl", urdf), urdf / "../meshes/a.stl");
  EXPECT_EQ(find_mesh_file("file://" + own.string(), urdf), own);
  EXPECT_EQ(find_mesh_file(own.string(), urdf), own);
  EXPECT_FALSE(std::filesystem::exists(find_mesh_file("package://far/meshes/c.stl", urdf)));
  // Of a file that is named without a folder.
  EXPECT_FALSE(std::filesystem::exists(find_mesh_file("package://far/meshes/c.stl", "")));
  setenv("ROS_PACKAGE_PATH", ("/nowhere::" + (folder_ / "elsewhere").string()).c_str(), 1);
  EXPECT_EQ(find_mesh_file("package://far/meshes/c.stl", urdf), far);
  setenv("ROS_PACKAGE_PATH", (folder_ / "elsewhere/far").c_str(), 1);
  EXPECT_EQ(find_mesh_file("package://far/meshes/c.stl", urdf), far);
}

TEST_F(MeshShape, ErrorsNameLinkFileAndMend) {
  EXPECT_THAT(error("filename='none.stl'"),
              testing::AllOf(HasSubstr("robot.urdf': link 'forearm'"), HasSubstr("'none.stl'"),
                             HasSubstr("relative to the URDF's folder")));
  EXPECT_THAT(
      error("filename='package://my_arm/a.stl'"),
      testing::AllOf(HasSubstr("link 'forearm'"), HasSubstr((folder_ / "my_arm/a.stl").string()),
                     HasSubstr("ROS_PACKAGE_PATH")));
  for (const char* name : {"filename='package://'", "filename='package://p/../a.stl'",
                           "filename='package://../a.stl'"}) {
    EXPECT_THAT(error(name),
                testing::AllOf(HasSubstr("link 'forearm'"), HasSubstr("leaves its package")));
  }
  EXPECT_THAT(error("filename=''"), HasSubstr("robot.urdf"));
  EXPECT_THAT(error("filename='.'"), HasSubstr("link 'forearm'"));
  std::ofstream(folder_ / "noise.stl") << "no mesh at all";
  EXPECT_THAT(error("filename='noise.stl'"),
              testing::AllOf(HasSubstr("link 'forearm'"), HasSubstr("noise.stl")));
  std::ofstream(folder_ / "empty.obj") << "v 0 0 0\nv 0 0 1\nv 0 1 0\n";
  EXPECT_THAT(error("filename='empty.obj'"), HasSubstr("empty.obj"));
  std::ofstream(folder_ / "nan.obj") << "v 0 0 nan\nv 0 0 1\nv 0 1 0\nv 1 0 0\nf 1 2 3\nf 1 3 4\n";
  EXPECT_THAT(error("filename='nan.obj'"), HasSubstr("nan.obj"));
  std::ofstream(folder_ / "flat.obj") << "v 0 0 0\nv 0 0 1\nv 0 1 0\nf 1 2 3\n";
  EXPECT_THAT(error("filename='flat.obj'"), HasSubstr("flat.obj' is flat"));
  std::ofstream(folder_ / "there_and_back.obj") << "v 0 0 0\nv 0 0 1\nv 0 1 0\nf 1 2 3\nf 1 3 2\n";
  EXPECT_THAT(error("filename='there_and_back.obj'"), HasSubstr("encloses no volume"));
  std::ofstream(folder_ / "robot.wrl") << "#VRML V2.0 utf8\n";
  EXPECT_THAT(error("filename='robot.wrl'"), HasSubstr("Convert it"));
  for (const char* scale : {"0 1 1", "1 1 0"}) {
    EXPECT_THAT(
        error("filename='box.stl' scale='" + std::string(scale) + "'"),
        testing::AllOf(HasSubstr("link 'forearm'"), HasSubstr("box.stl"), HasSubstr("scale")));
  }
  for (const char* scale : {"nan 1 1", "1 1", "much"}) {
    EXPECT_THAT(error("filename='box.stl' scale='" + std::string(scale) + "'"),
                testing::AllOf(HasSubstr("robot.urdf"), HasSubstr("forearm")));
  }
  EXPECT_THROW(
      read_solid_mesh(folder_ / "box.stl", {1, 1, std::numeric_limits<double>::quiet_NaN()}),
      InputError);
  // Millimetres.
  EXPECT_THAT(error("filename='box.stl' scale='1000 1000 1000'"),
              testing::AllOf(HasSubstr("300 m long"), HasSubstr("0.001 0.001 0.001")));
}

TEST_F(MeshShape, OneFileOfSeveralLinksIsReadOnce) {
  std::ofstream(folder_ / "robot.urdf")
      << "<robot name='r'><link name='a'><collision><geometry><mesh filename='box.stl'/></geometry>"
         "</collision><collision><geometry><mesh filename='box.stl' scale='1 1 2'/></geometry>"
         "</collision><collision><geometry><mesh filename='./box.stl'/></geometry></collision>"
         "<collision><geometry><mesh filename='box.stl'/></geometry></collision></link></robot>";
  const RobotModel model = read_urdf(folder_ / "robot.urdf");
  const auto& shapes = model.links[0].shapes;
  ASSERT_EQ(shapes.size(), 4u);
  EXPECT_EQ(shapes[0].solid, shapes[3].solid);
  EXPECT_NE(shapes[0].solid, shapes[1].solid);
}

TEST_F(MeshShape, ALinkThatIsOnlySeenIsRemarkedOn) {
  const RobotModel model = parse_urdf(
      "<robot name='r'><link name='cover'><visual><geometry><sphere radius='1'/></geometry>"
      "</visual></link></robot>",
      "r.urdf");
  ASSERT_EQ(model.remarks.size(), 1u);
  EXPECT_THAT(model.remarks[0], HasSubstr("'cover'"));
}

TEST_F(MeshShape, MacrosOfXacroAreRefusedAndWhatXacroMadeIsNot) {
  const auto error_of = [](const std::string& text) -> std::string {
    try {
      parse_urdf(text, "arm.urdf.xacro");
    } catch (const InputError& e) {
      return e.what();
    }
    return "no error";
  };
  const std::string link = "<link name='a'/>";
  for (const std::string& macro :
       {std::string("<xacro:include filename='b.xacro'/>"),
        std::string("<link name='${prefix}a'/>"), std::string("<link name='$(arg prefix)'/>")}) {
    EXPECT_THAT(error_of("<robot name='r' xmlns:xacro='http://ros.org/wiki/xacro'>" + macro + link +
                         "</robot>"),
                HasSubstr("xacro arm.urdf.xacro > robot.urdf"))
        << macro;
  }
  EXPECT_EQ(error_of("<robot name='r' xmlns:xacro='http://ros.org/wiki/xacro'><!-- <xacro:b/> -->" +
                     link + "<!-- ${c} --></robot>"),
            "no error");
  EXPECT_NE(error_of("<robot name='r'><!-- " + link), "no error");
}

TEST_F(MeshShape, ForeignRobotsAreRead) {
  const char* data = std::getenv("PREHEND_SHARED_DATA");
  const std::filesystem::path robots = std::filesystem::path(data ? data : "") / "robots";
  if (!data || !std::filesystem::exists(robots / "kuka_iiwa/model.urdf")) {
    GTEST_SKIP() << "PREHEND_SHARED_DATA names no folder with robots/kuka_iiwa/model.urdf, a robot "
                    "that is not part of this project";
  }
  const RobotModel iiwa = read_urdf(robots / "kuka_iiwa/model.urdf");
  EXPECT_EQ(iiwa.links.size(), 8u);
  for (const Link& link : iiwa.links) {
    ASSERT_EQ(link.shapes.size(), 1u) << link.name;
    const double size = geometry::bounds(*link.shapes[0].solid).sizes().maxCoeff();
    EXPECT_GT(size, 0.09) << link.name;
    EXPECT_LT(size, 0.35) << link.name;
  }
  EXPECT_EQ(iiwa.remarks.size(), 8u) << "its files have cracks";
  for (const char* name : {"pg70/pg70.dae", "pg70/pg70.stl"}) {
    const SolidMesh pg70 =
        read_solid_mesh(robots / "schunk_description/meshes" / name, Vector3d::Ones());
    EXPECT_EQ(pg70.remark, "") << name;
    EXPECT_TRUE(geometry::bounds(*pg70.mesh).sizes().isApprox(Vector3d(0.08, 0.112, 0.078), 1e-3))
        << name;
  }
  EXPECT_THROW(read_urdf(robots / "schunk_description/urdf/pg70/pg70.urdf.xacro"), InputError);
}

}  // namespace
}  // namespace prehend::robot
