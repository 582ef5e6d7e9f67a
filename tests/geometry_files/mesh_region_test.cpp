#include "prehend/geometry/mesh_region.h"

#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>
#include <unistd.h>

#include "prehend/geometry/errors.h"
#include "prehend/geometry/mesh_files.h"

namespace prehend::geometry {
namespace {

class MeshRegionTest : public ::testing::Test {
 protected:
  MeshRegionTest()
      : folder_(std::filesystem::temp_directory_path() /
                ("prehend_regions_" + std::to_string(getpid()))) {
    std::filesystem::create_directories(folder_);
  }
  ~MeshRegionTest() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path file(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
    return folder_ / name;
  }

  static std::string error_of(const std::filesystem::path& path, const MeshRegion& region) {
    try {
      read_mesh_region(path, region);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }

  static void expect_error(const std::filesystem::path& path, const MeshRegion& region,
                           const std::string& says) {
    EXPECT_NE(error_of(path, region).find(says), std::string::npos) << error_of(path, region);
  }

  // Two squares side by side that share an edge: the left one a quad, the right one two triangles.
  std::filesystem::path squares() const {
    return file("squares.obj",
                "# two squares\nmtllib none.mtl\n"
                "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 1 0\nv 1 1 0\nv 2 1 0\n"
                "o plate\ng left both\nusemtl rubber\nf 1/1/1 2/2/1 5//1 4\n"
                "g right both\nusemtl steel\nf 2 3 6\nf -5 -1 -2\n");
  }

  std::filesystem::path folder_;
};

TEST_F(MeshRegionTest, GroupsObjectsAndMaterialsOfAnObj) {
  const TriangleMesh left = read_mesh_region(squares(), {.group = "left"});
  EXPECT_EQ(left.triangles.size(), 2u) << "the quad as a fan";
  EXPECT_EQ(left.vertices.size(), 4u) << "those that it uses";
  EXPECT_NEAR(surface_area(left), 1, 1e-15);
  EXPECT_EQ(bounds(left).max().x(), 1);
  const TriangleMesh right = read_mesh_region(squares(), {.group = "right"});
  EXPECT_EQ(bounds(right).min().x(), 1);
  EXPECT_NEAR(surface_area(right), 1, 1e-15) << "also by indices from the end";
  for (const MeshRegion& all : {MeshRegion{.group = "both"}, MeshRegion{.group = "plate"}}) {
    const TriangleMesh both = read_mesh_region(squares(), all);
    EXPECT_NEAR(surface_area(both), 2, 1e-15);
    EXPECT_EQ(both.vertices.size(), 6u) << "the shared edge's stay shared";
  }
  EXPECT_EQ(bounds(read_mesh_region(squares(), {.material = "rubber"})).max().x(), 1);
  EXPECT_NEAR(surface_area(read_mesh_region(squares(), {})), 2, 1e-6);
}

TEST_F(MeshRegionTest, ColoursOfFacesAndOfVerticesOfAPly) {
  const auto faces = file("faces.ply",
                          "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\n"
                          "property float y\nproperty float z\nelement face 2\n"
                          "property list uchar int vertex_indices\nproperty uchar red\n"
                          "property uchar green\nproperty uchar blue\nend_header\n"
                          "0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2 255 0 0\n3 0 2 3 9 9 9\n");
  const TriangleMesh red = read_mesh_region(faces, {.color = {{254, 1, 0}}});
  ASSERT_EQ(red.triangles.size(), 1u);
  EXPECT_EQ(red.vertices.size(), 3u);
  EXPECT_EQ(red.vertices[1], Eigen::Vector3d(1, 0, 0));
  expect_error(faces, {.color = {{0, 0, 255}}}, "no face painted [0, 0, 255]");
  expect_error(faces, {.color = {{0, 0, 255}}}, "[255, 0, 0]");
  const auto vertices =
      file("vertices.ply",
           "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\n"
           "property float y\nproperty float z\nproperty float red\n"
           "property float green\nproperty float blue\nelement face 2\n"
           "property list uchar int vertex_indices\nend_header\n"
           "0 0 0 0 1 0\n1 0 0 0 0 0\n1 1 0 0 1 0\n0 1 0 0 1 0\n3 0 1 2\n3 0 2 3\n");
  const TriangleMesh green = read_mesh_region(vertices, {.color = {{0, 255, 0}}});
  ASSERT_EQ(green.triangles.size(), 1u) << "all three corners must have it";
  EXPECT_EQ(green.vertices[2], Eigen::Vector3d(0, 1, 0));
}

TEST_F(MeshRegionTest, RefusesWhatIsNotThereWithTheNearest) {
  expect_error(squares(), {.group = "lefd"}, "has no group or object 'lefd'");
  expect_error(squares(), {.group = "lefd"}, "The nearest is 'left'");
  expect_error(squares(), {.material = "steal"}, "The nearest is 'steel'");
  expect_error(squares(), {.color = {{1, 2, 3}}}, "no PLY");
  expect_error(folder_ / "none.obj", {.group = "a"}, "none.obj");
  const auto plain = folder_ / "plain.ply";
  write_mesh_file(plain, make_box({1, 1, 1}));
  expect_error(plain, {.group = "a"}, "no OBJ");
  expect_error(plain, {.color = {{1, 2, 3}}}, "neither faces nor vertices with colours");
  expect_error(file("empty.obj", "v 0 0 0\ng a\ng b\nf 1 1 1\n"), {.group = "a"}, "no face in");
  expect_error(file("broken.obj", "v 0 0 0\ng a\nf 1 2 3\n"), {.group = "a"}, "line 3");
  expect_error(file("nan.obj", "v 0 nan 0\ng a\nf 1 1 1\n"), {.group = "a"}, "line 1");
  expect_error(file("line.obj", "v 0 0 0\ng a\nf 1 1\n"), {.group = "a"}, "three corners");
}

}  // namespace
}  // namespace prehend::geometry
