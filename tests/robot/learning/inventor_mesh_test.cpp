// Meshes of Inventor and VRML, and meshes that are written beside a robot's new file.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "prehend/geometry/errors.h"
#include "prehend/geometry/mesh_files.h"
#include "prehend/robot/formats/inventor_mesh.h"
#include "prehend/robot/formats/shape_mesh.h"
#include "prehend/robot/formats/uniform_inertial.h"

namespace prehend::robot::formats {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;
using geometry::InputError;
using testing::HasSubstr;

class InventorMesh : public testing::Test {
 protected:
  InventorMesh() { fs::create_directories(folder_); }
  ~InventorMesh() override { fs::remove_all(folder_); }
  fs::path file(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
    return folder_ / name;
  }
  static std::string error_of(const fs::path& file) {
    try {
      read_inventor_mesh(file);
    } catch (const InputError& error) {
      return error.what();
    }
    return {};
  }
  const fs::path folder_ =
      fs::temp_directory_path() / ("prehend_inventor_" + std::to_string(::getpid()));
};

TEST_F(InventorMesh, ShapesWithTransformsUnitsAndIncludes) {
  file("part.iv", "#Inventor V2.1 ascii\nCube { width 20 height 40 depth 60 }\n");
  const auto mesh = read_inventor_mesh(file(
      "all.iv",
      "#Inventor V2.1 ascii\nSeparator { Units { units MILLIMETERS } Translation { translation "
      "10 0 0 } File { name part.iv } }\n"));
  const Eigen::AlignedBox3d box = geometry::bounds(mesh);
  EXPECT_LT((box.min() - Vector3d(0, -0.02, -0.03)).norm(), 1e-6);
  EXPECT_LT((box.max() - Vector3d(0.02, 0.02, 0.03)).norm(), 1e-6);
  EXPECT_TRUE(geometry::find_defects(mesh).watertight());
  EXPECT_NEAR(geometry::mass_properties(mesh).volume, 0.02 * 0.04 * 0.06, 1e-9);
}

TEST_F(InventorMesh, Vrml2WithAMirrorStaysOutward) {
  const auto mesh = read_inventor_mesh(file("a.wrl",
                                            "#VRML V2.0 utf8\nTransform { scale -1 1 1 children [ "
                                            "Shape { geometry Box { size 2 2 2 } } ] "
                                            "}\n"));
  EXPECT_NEAR(geometry::mass_properties(mesh).volume, 8, 1e-6);
}

TEST_F(InventorMesh, BadFilesAreRefusedInWords) {
  EXPECT_THAT(error_of(folder_ / "none.iv"), HasSubstr("none.iv"));
  EXPECT_THAT(error_of(file("empty.iv", "#Inventor V2.1 ascii\nSeparator { }\n")),
              HasSubstr("has no surface"));
  EXPECT_THAT(error_of(file("text.iv", "this is no scene\n")), HasSubstr("text.iv"));
  EXPECT_THAT(error_of(file("cut.iv", "#Inventor V2.1 ascii\nSeparator { Cube {")),
              HasSubstr("cut.iv"));
  file("b.iv", "#Inventor V2.1 ascii\nFile { name a.iv }\n");
  EXPECT_THAT(error_of(file("a.iv", "#Inventor V2.1 ascii\nFile { name b.iv }\n")),
              HasSubstr("includes itself"));
}

TEST_F(InventorMesh, IsWrittenAsStlBesideTheNewFile) {
  file("cube.iv", "#Inventor V2.1 ascii\nCube { width 20 height 20 depth 20 }\n");
  RobotDescription robot;
  robot.links.push_back({"palm", {}, {}, {}});
  Shape shape;
  shape.kind = Shape::Kind::kMesh;
  shape.mesh = "cube.iv";
  shape.scale = Vector3d::Constant(0.001);
  robot.links[0].collisions = {shape, shape};
  Shape within = shape;
  within.mesh = "palm <0>";
  within.surface = std::make_shared<const geometry::TriangleMesh>(geometry::make_box({1, 1, 1}));
  robot.links[0].visuals = {within};
  LossReport loss;
  write_meshes(take_out_meshes(robot, folder_, "new name", loss), folder_ / "there");
  EXPECT_EQ(robot.links[0].collisions[0].mesh, "new_name_meshes/cube.stl");
  EXPECT_EQ(robot.links[0].collisions[1].mesh, "new_name_meshes/cube.stl");
  EXPECT_EQ(robot.links[0].visuals[0].mesh, "new_name_meshes/palm__0_.stl");
  EXPECT_FALSE(loss.lossless());
  const auto mesh = geometry::read_mesh_file(folder_ / "there" / robot.links[0].collisions[0].mesh);
  EXPECT_LT((geometry::bounds(mesh).sizes() - Vector3d::Constant(20)).norm(), 1e-5);
}

TEST_F(InventorMesh, ACapsuleHasTheInertiaOfTheFormula) {
  LinkDescription link;
  Shape shape;
  shape.kind = Shape::Kind::kCapsule;
  shape.radius = 0.02;
  shape.length = 0.1;
  link.collisions = {shape};
  ShapeMeshes meshes(folder_);
  const auto inertial = uniform_inertial(link, meshes, 1000);
  ASSERT_TRUE(inertial);
  const double volume = M_PI * 0.02 * 0.02 * 0.1 + 4.0 / 3 * M_PI * std::pow(0.02, 3);
  EXPECT_NEAR(inertial->mass, 1000 * volume, 0.03 * 1000 * volume);  // flat facets within
  EXPECT_NEAR(inertial->X_LI.translation().norm(), 0, 1e-9);
  link.collisions.clear();
  EXPECT_FALSE(uniform_inertial(link, meshes));
}

}  // namespace
}  // namespace prehend::robot::formats
