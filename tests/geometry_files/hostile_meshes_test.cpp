// Mesh files of strangers who mean harm, or of programs that err: with each of these Assimp ended
// the program, or took minutes or gigabytes. They are refused in words; their like that is sound is
// read.

#include "prehend/geometry/mesh_files.h"

#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "prehend/geometry/errors.h"
#include "tests/geometry_files/scratch_folder.h"

namespace prehend::geometry {
namespace {

using ::testing::AnyOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

class HostileMeshes : public ::testing::Test {
 protected:
  /// Empty: it was read.
  std::string error_of(const std::string& name, const std::string& bytes) {
    const std::filesystem::path path = scratch_.write(name, bytes);
    try {
      read_mesh_file(path);
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr(name));
      return error.what();
    }
    return "";
  }
  testing::ScratchFolder scratch_;
};

std::string times(const std::string& part, int count) {
  std::string all;
  for (int i = 0; i < count; ++i) all += part;
  return all;
}

const std::string kCorners = "0 0 0\n1 0 0\n0 1 0\n0 0 1\n";

TEST_F(HostileMeshes, OffIsReadWithItsVariantsAndNotBelieved) {
  const auto volume_of = [&](const std::string& text) {
    return mass_properties(read_mesh_file(scratch_.write("a.off", text))).volume;
  };
  const std::string faces = "3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";
  for (const std::string& text :
       {"OFF\n4 4 6\n" + kCorners + faces, "OFF 4 4 6\n# corners\n\n" + kCorners + faces,
        "4 4 6\r\n" + kCorners + faces,
        "COFF\n4 4 0\n0 0 0 255 0 0 255\n1 0 0 0 0 0 0\n0 1 0 0 0 0 0\n0 0 1 1 1 1 1\n" + faces,
        std::string("OFF\n4 4 0\n") + kCorners +
            "3 0 2 1 255 0 0\n3 0 1 3\n3 0 3 2\n3 1 2 3 0.5\n"}) {
    EXPECT_NEAR(volume_of(text), 1.0 / 6, 1e-12) << text;
  }
  // A square is two triangles.
  EXPECT_EQ(
      read_mesh_file(scratch_.write("b.off", "OFF\n4 1 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n"))
          .triangles.size(),
      2U);
  EXPECT_THAT(error_of("a.off", "OFF\n1000000000 1000000000 0\n0 0 0\n"), HasSubstr("truncated"));
  EXPECT_THAT(error_of("a.off", "OFF\n4 1 0\n" + kCorners + "3 element 0 3 2\n"),
              HasSubstr("face, number 0"));
  EXPECT_THAT(error_of("a.off", "OFF\n4 1 0\n" + kCorners + "0\n"), HasSubstr("face, number 0"));
  EXPECT_THAT(error_of("a.off", "OFF\n4 1 0\n" + kCorners + "4000000000 0 1 2\n"),
              HasSubstr("face, number 0"));
  EXPECT_THAT(error_of("a.off", "OFF\n4 1 0\n" + kCorners + "3 0 1 4\n"),
              HasSubstr("does not exist"));
  EXPECT_THAT(error_of("a.off", "OFF\n4 1 0\n" + kCorners + "3 0 1 -1\n"),
              HasSubstr("does not exist"));
  EXPECT_THAT(error_of("a.off", "OFF\n4 1 0\n0 0 0\n1 nan 0\n"), HasSubstr("vertex, number 1"));
  EXPECT_THAT(error_of("a.off", "4OFF\n4 1 0\n"), HasSubstr("4OFF"));
  EXPECT_THAT(error_of("a.off", "OFF BINARY\n"), HasSubstr("binary"));
  EXPECT_THAT(error_of("a.off", "OFF\n"), HasSubstr("counts"));
  EXPECT_THAT(error_of("a.off", "solid\n"), HasSubstr("counts"));
  EXPECT_THAT(error_of("a.off", "# nothing\n"), HasSubstr("is empty"));
}

TEST_F(HostileMeshes, PolygonsOfVeryManyCornersAreRefused) {
  const std::string corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  EXPECT_THAT(error_of("a.obj", corners + "f " + times("1 2 3 ", 100000) + "\n"),
              HasSubstr("too many corners"));
  EXPECT_EQ(error_of("a.obj", corners + "f 1 2 3\n"), "");
}

std::string nodes_of_collada(const std::string& nodes, const std::string& scene) {
  return R"(<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<library_geometries><geometry id="g"><mesh><source id="p"><float_array id="a" count="9">0 0 0 1 0 0 0 1 0</float_array>
<technique_common><accessor source="#a" count="3" stride="3"><param name="X" type="float"/><param name="Y" type="float"/>
<param name="Z" type="float"/></accessor></technique_common></source><vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="1"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p></triangles></mesh></geometry></library_geometries>
<library_nodes>)" +
         nodes + "</library_nodes><library_visual_scenes><visual_scene id='s'>" + scene +
         "</visual_scene></library_visual_scenes><scene><instance_visual_scene url='#s'/></scene>"
         "</COLLADA>";
}

TEST_F(HostileMeshes, ColladaNodesDoNotGrow) {
  const std::string leaf = "<node id='n0'><instance_geometry url='#g'/></node>";
  const std::string use = "<node><instance_node url='#n0'/></node>";
  EXPECT_EQ(error_of("a.dae", nodes_of_collada(leaf, use)), "");
  EXPECT_THAT(
      error_of("a.dae", nodes_of_collada("", times("<node>", 200000) + times("</node>", 200000))),
      HasSubstr("deeper than 100"));
  EXPECT_THAT(
      error_of("a.dae", nodes_of_collada("<node id='n0'><instance_node url='#n0'/></node>", use)),
      HasSubstr("in a ring"));
  EXPECT_THAT(
      error_of("a.dae", nodes_of_collada("<node name='n0'><instance_node url='#n0'/></node>", use)),
      HasSubstr("in a ring"));
  std::string doubling = leaf;
  for (int i = 0; i < 40; ++i) {
    const std::string one = "<instance_node url='#n" + std::to_string(i) + "'/>";
    doubling += "<node id='n" + std::to_string(i + 1) + "'>" + one + one + "</node>";
  }
  EXPECT_THAT(
      error_of("a.dae", nodes_of_collada(doubling, "<node><instance_node url='#n40'/></node>")),
      HasSubstr("100,000 times"));
}

/// The file above with one part changed.
std::string collada_but(const std::string& part, const std::string& other) {
  std::string all = nodes_of_collada("", "<node id='n'><instance_geometry url='#g'/></node>");
  const std::size_t at = all.find(part);
  return at == std::string::npos ? "no such part" : all.replace(at, part.size(), other);
}

TEST_F(HostileMeshes, ColladaNumbersAreAsManyAsIsSaid) {
  EXPECT_EQ(error_of("a.dae", collada_but("0 1 2", "0 1 2")), "");
  EXPECT_THAT(error_of("a.dae", collada_but("0 1 2", "0 1 2 \x01")), HasSubstr("whole numbers"));
  EXPECT_THAT(error_of("a.dae", collada_but("0 1 2", "0 -1 2")), HasSubstr("whole numbers"));
  EXPECT_THAT(error_of("a.dae", collada_but("0 1 2", "0 1 9")), Not(IsEmpty()));
  for (const char* count : {"-1", "4000000000", "10", "x", "1e3"}) {
    EXPECT_THAT(
        error_of("a.dae", collada_but("count=\"9\"", std::string("count=\"") + count + "\"")),
        AnyOf(HasSubstr("fewer numbers"), HasSubstr("no count")))
        << count;
  }
  EXPECT_THAT(error_of("a.dae", collada_but("count=\"9\"", "")), HasSubstr("beyond its list"));
  EXPECT_THAT(error_of("a.dae", collada_but("stride=\"3\"", "stride=\"4\"")),
              HasSubstr("beyond its list"));
  EXPECT_THAT(error_of("a.dae", collada_but("stride=\"3\"", "stride=\"3\" offset=\"1\"")),
              HasSubstr("beyond its list"));
  EXPECT_THAT(error_of("a.dae", collada_but("source=\"#a\"", "source=\"#none\"")),
              HasSubstr("no list of numbers"));
}

// What moves a mesh is left away: the joints' numbers of a skin would be believed, too.
TEST_F(HostileMeshes, SkinsAndAnimationsAreTheMeshAtRest) {
  const std::string skin =
      "<library_controllers><controller id='c'><skin source='#g'><vertex_weights "
      "count='4000000000'/></skin></controller><controller id='d'><skin source='#c'/></controller>"
      "<controller id='ring'><skin source='#ring'/></controller></library_controllers>"
      "<library_animations><animation><sampler id='s'/></animation></library_animations>"
      "<library_nodes>";
  std::string file = nodes_of_collada("", "<node id='n'><instance_controller url='#d'/></node>");
  file.replace(file.find("<library_nodes>"), std::string("<library_nodes>").size(), skin);
  EXPECT_EQ(error_of("a.dae", file), "");
  const TriangleMesh mesh = read_mesh_file(scratch_.write("a.dae", file));
  EXPECT_EQ(mesh.triangles.size(), 1U);
  EXPECT_TRUE(mesh.vertices.at(1).isApprox(Eigen::Vector3d(1, 0, 0)));
  file.replace(file.find("url='#d'"), 8, "url='#ring'");
  EXPECT_THAT(error_of("a.dae", file), Not(IsEmpty()));
}

std::string nodes_of_gltf(const std::string& nodes, const std::string& scene, int primitives = 1,
                          const std::string& count = "3") {
  std::string one = R"({"attributes": {"POSITION": 0}})", all = one;
  for (int i = 1; i < primitives; ++i) all += "," + one;
  // Corners (0 0 0), (1 0 0), (0 1 0).
  return R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [)" + scene +
         R"(]}], "nodes": [)" + nodes + R"(], "meshes": [{"primitives": [)" + all +
         R"(]}], "buffers": [{"byteLength": 36, "uri": "data:application/octet-stream;base64,)"
         R"(AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}],
"bufferViews": [{"buffer": 0, "byteLength": 36}], "accessors": [{"bufferView": 0, "componentType": 5126, "count": )" +
         count + R"(, "type": "VEC3"}]})";
}

TEST_F(HostileMeshes, GltfNodesAndMeshesDoNotGrow) {
  const std::string leaf = R"({"mesh": 0})";
  EXPECT_EQ(error_of("a.gltf", nodes_of_gltf(leaf, "0")), "");
  EXPECT_EQ(error_of("a.gltf", nodes_of_gltf(R"({"children": [1]},)" + leaf, "0")), "");
  EXPECT_THAT(error_of("a.gltf", R"({"asset": )" + times("[", 1000000)),
              HasSubstr("nested deeper than 32"));
  std::string row, doubling;
  for (int i = 1; i <= 100000; ++i) row += R"({"children": [)" + std::to_string(i) + "]},";
  EXPECT_THAT(error_of("a.gltf", nodes_of_gltf(row + leaf, "0")), HasSubstr("deeper than 100"));
  for (int i = 1; i <= 40; ++i) {
    const std::string n = std::to_string(i);
    doubling += R"({"children": [)" + n + "," + n + "]},";
  }
  EXPECT_THAT(error_of("a.gltf", nodes_of_gltf(doubling + leaf, "0")), HasSubstr("100,000 times"));
  EXPECT_THAT(error_of("a.gltf", nodes_of_gltf(leaf, "0" + times(",0", 100001))),
              HasSubstr("100,000 times"));
  EXPECT_THAT(error_of("a.gltf", nodes_of_gltf(R"({"children": [1]}, {"children": [0]})", "0")),
              HasSubstr("in a ring"));
  EXPECT_THAT(error_of("a.gltf", nodes_of_gltf(leaf, "0", 1000, "1000000")),
              HasSubstr("100 million"));
  EXPECT_THAT(
      error_of("a.glb", std::string("glTF\x02\0\0\0\xff\xff\xff\x7f\xff\xff\xff\x7fJSON", 20)),
      HasSubstr("truncated"));
}

}  // namespace
}  // namespace prehend::geometry
