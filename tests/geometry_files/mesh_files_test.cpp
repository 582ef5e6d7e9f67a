#include "prehend/geometry/mesh_files.h"

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "prehend/geometry/errors.h"
#include "tests/geometry_files/scratch_folder.h"

namespace prehend::geometry {
namespace {

using ::testing::HasSubstr;

class MeshFiles : public ::testing::Test {
 protected:
  std::string error_of(const std::string& name, const std::string& bytes) {
    const std::filesystem::path path = scratch_.write(name, bytes);
    try {
      read_mesh_file(path);
    } catch (const InputError& error) {
      return error.what();
    }
    return "no error";
  }
  testing::ScratchFolder scratch_;
};

TEST_F(MeshFiles, RoundTripKeepsTheSolid) {
  const TriangleMesh sphere = make_sphere(0.05, 24);
  const MassProperties before = mass_properties(sphere);
  for (const char* name : {"a.ply", "a.stl", "a.obj", "A.PLY"}) {
    write_mesh_file(scratch_.path() / name, sphere);
    const TriangleMesh mesh = read_mesh_file(scratch_.path() / name);
    EXPECT_EQ(mesh.triangles.size(), sphere.triangles.size()) << name;
    EXPECT_EQ(mesh.vertices.size(), sphere.vertices.size()) << name;
    EXPECT_TRUE(find_defects(mesh).watertight()) << name << ": " << find_defects(mesh).to_string();
    EXPECT_NEAR(mass_properties(mesh).volume, before.volume, 1e-5 * before.volume) << name;
  }
}

// Some programs begin the free text of binary files with the word of text files, and round the same
// corner differently in each triangle.
TEST_F(MeshFiles, BinaryStlIsClosedWhateverItsHeaderAndRounding) {
  const TriangleMesh sphere = make_sphere(50, 24);
  write_mesh_file(scratch_.path() / "a.stl", sphere);
  std::string bytes = testing::ScratchFolder::read(scratch_.path() / "a.stl");
  bytes.replace(0, 5, "solid");
  for (std::size_t at = 84 + 12; at + 4 <= bytes.size(); at += 50) {
    float x = 0;
    std::memcpy(&x, bytes.data() + at, sizeof x);
    x = std::nextafter(x, 1e9F);
    std::memcpy(bytes.data() + at, &x, sizeof x);
  }
  const TriangleMesh mesh = read_mesh_file(scratch_.write("solid.stl", bytes), 1e-3);
  EXPECT_EQ(mesh.vertices.size(), sphere.vertices.size());
  EXPECT_TRUE(find_defects(mesh).watertight()) << find_defects(mesh).to_string();
  EXPECT_NEAR(mass_properties(mesh).volume, 1e-9 * mass_properties(sphere).volume, 1e-9);
}

TEST_F(MeshFiles, ATextStlIsClosed) {
  const TriangleMesh box = make_box({1, 2, 3});
  std::string text = "solid box\n";
  for (const Eigen::Vector3i& t : box.triangles) {
    text += "facet normal 0 0 0\nouter loop\n";
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d& p = box.vertices[t[k]];
      text += "vertex " + std::to_string(p.x()) + ' ' + std::to_string(p.y()) + ' ' +
              std::to_string(p.z()) + '\n';
    }
    text += "endloop\nendfacet\n";
  }
  const TriangleMesh mesh = read_mesh_file(scratch_.write("a.stl", text + "endsolid box\n"));
  EXPECT_EQ(mesh.vertices.size(), 8U);
  EXPECT_TRUE(find_defects(mesh).watertight());
}

TEST_F(MeshFiles, ScaleAndOrientation) {
  const TriangleMesh box = make_box({1, 2, 3});
  write_mesh_file(scratch_.path() / "a.obj", box);
  const TriangleMesh mesh = read_mesh_file(scratch_.path() / "a.obj", 0.01);
  EXPECT_NEAR(mass_properties(mesh).volume, 6e-6, 1e-12);
  EXPECT_THROW(read_mesh_file(scratch_.path() / "a.obj", 0), std::invalid_argument);
}

TEST_F(MeshFiles, QuadsAndGroupsBecomeOneTriangleMesh) {
  const std::string obj =
      "o a\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\ng b\nv 0 0 1\nf 1 2 5\n";
  const TriangleMesh mesh = read_mesh_file(scratch_.write("a.obj", obj));
  EXPECT_EQ(mesh.triangles.size(), 3U);
}

TEST_F(MeshFiles, OffIsRead) {
  const TriangleMesh mesh = read_mesh_file(
      scratch_.write("a.off", "OFF\n4 2 0\n0 0 0\n2 0 0\n2 2 0\n0 2 0\n3 0 1 2\n3 0 2 3\n"));
  ASSERT_EQ(mesh.triangles.size(), 2U);
  EXPECT_NEAR(surface_area(mesh), 4, 1e-12);
}

/// A tetrahedron with legs of 1, 2 and 3 units along x, y and z, moved by its node by one along x.
std::string collada(const std::string& unit, const std::string& up) {
  return "<?xml version='1.0'?><COLLADA xmlns='http://www.collada.org/2005/11/COLLADASchema' "
         "version='1.4.1'><asset>" +
         unit + "<up_axis>" + up +
         "</up_axis></asset><library_geometries><geometry id='g'><mesh><source id='p'><float_array "
         "id='pa' count='12'>0 0 0 1 0 0 0 2 0 0 0 3</float_array><technique_common><accessor "
         "source='#pa' count='4' stride='3'><param name='X' type='float'/><param name='Y' "
         "type='float'/><param name='Z' type='float'/></accessor></technique_common></source>"
         "<vertices id='v'><input semantic='POSITION' source='#p'/></vertices><triangles count='4'>"
         "<input semantic='VERTEX' source='#v' offset='0'/><p>0 2 1 0 1 3 0 3 2 1 2 3</p>"
         "</triangles></mesh></geometry></library_geometries><library_visual_scenes><visual_scene "
         "id='s'><node id='n'><translate>1 0 0</translate><instance_geometry url='#g'/></node>"
         "</visual_scene></library_visual_scenes><scene><instance_visual_scene url='#s'/></scene>"
         "</COLLADA>";
}

TEST_F(MeshFiles, ColladasUnitIsAppliedAndItsUpAxisIsNot) {
  const struct {
    std::string unit;
    double metres;
  } kUnits[] = {{"<unit name='metre' meter='1'/>", 1},
                {"<unit name='millimetre' meter='0.001'/>", 0.001},
                {"<unit name='inch' meter='0.0254'/>", 0.0254},
                {"", 1}};
  for (const auto& [unit, metres] : kUnits) {
    for (const char* up : {"X_UP", "Y_UP", "Z_UP"}) {
      const TriangleMesh mesh = read_mesh_file(scratch_.write("a.dae", collada(unit, up)));
      EXPECT_NEAR(mass_properties(mesh).volume, std::pow(metres, 3), 1e-5 * std::pow(metres, 3))
          << unit << up;
      EXPECT_TRUE(bounds(mesh).sizes().isApprox(metres * Eigen::Vector3d(1, 2, 3), 1e-5))
          << unit << up;
      EXPECT_TRUE(bounds(mesh).min().isApprox(metres * Eigen::Vector3d(1, 0, 0), 1e-5))
          << unit << up;
    }
  }
  // The caller's scale comes on top.
  const TriangleMesh mesh =
      read_mesh_file(scratch_.write("a.dae", collada(kUnits[1].unit, "Z_UP")), 10);
  EXPECT_TRUE(bounds(mesh).sizes().isApprox(0.01 * Eigen::Vector3d(1, 2, 3), 1e-5));
}

TEST_F(MeshFiles, PlyOfEitherByteOrderWithPolygonsAndOtherElements) {
  const std::string header =
      "element vertex 4\nproperty double x\nproperty float y\nproperty float z\n"
      "property uchar red\nelement face 1\nproperty list uchar ushort vertex_index\n"
      "element edge 1\nproperty int vertex1\nend_header\n";
  const TriangleMesh ascii = read_mesh_file(scratch_.write(
      "a.ply",
      "ply\nformat ascii 1.0\n" + header + "0 0 0 9\n2 0 0 9\n2 2 0 9\n0 2 0 9\n4 0 1 2 3\n5\n"));
  std::string body;
  for (const auto& [x, y] : {std::pair{0, 0}, std::pair{2, 0}, std::pair{2, 2}, std::pair{0, 2}}) {
    body += x == 0 ? std::string(8, '\0') : std::string("\x40\0\0\0\0\0\0\0", 8);
    body += y == 0 ? std::string(4, '\0') : std::string("\x40\0\0\0", 4);
    body += std::string(4, '\0') + "\x09";
  }
  body += std::string("\x04\0\0\0\x01\0\x02\0\x03\0\0\0\x05", 13);
  const TriangleMesh binary = read_mesh_file(
      scratch_.write("b.ply", "ply\nformat binary_big_endian 1.0\n" + header + body));
  for (const TriangleMesh& mesh : {ascii, binary}) {
    ASSERT_EQ(mesh.triangles.size(), 2U);
    EXPECT_EQ(mesh.vertices[2], Eigen::Vector3d(2, 2, 0));
    EXPECT_NEAR(surface_area(mesh), 4, 1e-12);
  }
}

TEST_F(MeshFiles, MissingForeignAndEmpty) {
  EXPECT_THROW(read_mesh_file(scratch_.path() / "none.stl"), InputError);
  EXPECT_THROW(read_mesh_file(scratch_.path()), InputError);
  for (const char* name : {"a.obj", "a.ply", "a.stl"}) {
    EXPECT_THAT(error_of(name, ""), HasSubstr("empty")) << name;
    EXPECT_THAT(error_of(name, "\x89PNG\r\n\x1a\n0123456789"), HasSubstr(name)) << name;
  }
  EXPECT_THAT(error_of("a.wrl", "#VRML V2.0 utf8"), HasSubstr(".stl"));
  EXPECT_THAT(error_of("a.dae", "<xml/>"), HasSubstr("a.dae"));
  EXPECT_THAT(error_of("a.off", "FOO"), HasSubstr("a.off"));
  EXPECT_THAT(error_of("points.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n"), HasSubstr("points.obj"));
  EXPECT_THAT(error_of("points.ply",
                       "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\n"
                       "property float y\nproperty float z\nend_header\n1 2 3\n"),
              HasSubstr("no triangles"));
}

TEST_F(MeshFiles, HostileCountsAndIndices) {
  std::string stl(84, ' ');
  stl[80] = stl[81] = stl[82] = '\xff';
  stl[83] = '\x7f';
  EXPECT_THAT(error_of("a.stl", stl + "0123456789"), HasSubstr("truncated"));
  EXPECT_THAT(error_of("a.ply",
                       "ply\nformat binary_little_endian 1.0\nelement vertex 4000000000\n"
                       "property float x\nproperty float y\nproperty float z\n"
                       "element face 1\nproperty list uchar int vertex_indices\n"
                       "end_header\n0123456789"),
              HasSubstr("promises"));
  const std::string vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  EXPECT_NE(error_of("a.obj", vertices + "f 1 2 9\n"), "no error");
  EXPECT_THAT(error_of("b.ply",
                       "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n"
                       "property float y\nproperty float z\nelement face 1\n"
                       "property list uchar int vertex_indices\nend_header\n"
                       "0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n"),
              HasSubstr("does not exist"));
  EXPECT_NE(error_of("c.obj", "v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"), "no error");
}

// Assimp read beyond the end of such files.
TEST_F(MeshFiles, TruncationOfBinaryFilesIsAnError) {
  const TriangleMesh box = make_box({1, 2, 3});
  for (const char* name : {"a.stl", "a.ply"}) {
    write_mesh_file(scratch_.path() / name, box);
    const std::string bytes = testing::ScratchFolder::read(scratch_.path() / name);
    for (std::size_t size = 0; size < bytes.size(); ++size) {
      EXPECT_NE(error_of(std::string("cut") + (name + 1), bytes.substr(0, size)), "no error")
          << name << " " << size;
    }
  }
  EXPECT_THAT(error_of("text.stl",
                       "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\n"
                       "vertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"),
              HasSubstr("truncated"));
}

TEST_F(MeshFiles, WritingWhereItCannot) {
  const TriangleMesh box = make_box({1, 1, 1});
  EXPECT_THROW(write_mesh_file(scratch_.path() / "none" / "a.ply", box), InputError);
  EXPECT_THROW(write_mesh_file(scratch_.path() / "a.xyz", box), InputError);
  EXPECT_THROW(write_mesh_file(scratch_.path() / "a.ply", {}), InputError);
  TriangleMesh broken = box;
  broken.triangles[0][0] = 99;
  EXPECT_THROW(write_mesh_file(scratch_.path() / "a.ply", broken), InputError);
}

TEST(SharedMeshes, ScansAreReadWhole) {
  const char* folder = std::getenv("PREHEND_SHARED_DATA");
  if (folder == nullptr || *folder == '\0') {
    GTEST_SKIP() << "PREHEND_SHARED_DATA does not name a folder of meshes";
  }
  const std::filesystem::path meshes = std::filesystem::path(folder) / "meshes";
  const TriangleMesh sugar = read_mesh_file(meshes / "ycb" / "004_sugar_box.ply");
  EXPECT_EQ(sugar.triangles.size(), 16384U);
  EXPECT_EQ(sugar.vertices.size(), 8194U);
  EXPECT_TRUE(find_defects(sugar).watertight());
  const TriangleMesh duck = read_mesh_file(meshes / "other" / "duck.obj", 0.05);
  EXPECT_EQ(duck.triangles.size(), 4212U);
  EXPECT_NEAR(bounds(duck).sizes().maxCoeff(), 0.082, 0.001);
  const MeshDefects spray = find_defects(read_mesh_file(meshes / "other" / "dexnet_spray.obj"));
  EXPECT_EQ(spray.boundary_edges, 7);
}

}  // namespace
}  // namespace prehend::geometry
