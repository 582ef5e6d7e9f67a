#include "prehend/geometry/mesh_files.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <stdexcept>

#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <assimp/Importer.hpp>

#include "prehend/geometry/errors.h"
#include "prehend/geometry/file_headers.h"
#include "prehend/geometry/mesh_guards.h"
#include "prehend/geometry/off_mesh.h"
#include "prehend/geometry/ply_mesh.h"
#include "prehend/geometry/stl_mesh.h"

namespace prehend::geometry {
namespace {

[[noreturn]] void fail(const std::filesystem::path& path, const std::string& what,
                       const std::string& mend = "Copy or export the file again") {
  throw InputError('\'' + path.string() + "' " + what, mend);
}

TriangleMesh from_assimp(const aiScene& scene, double scale) {
  TriangleMesh mesh;
  for (unsigned m = 0; m < scene.mNumMeshes; ++m) {
    const aiMesh& part = *scene.mMeshes[m];
    const int first = static_cast<int>(mesh.vertices.size());
    for (unsigned i = 0; i < part.mNumVertices; ++i) {
      const aiVector3D& v = part.mVertices[i];
      mesh.vertices.push_back(scale * Eigen::Vector3d(v.x, v.y, v.z));
    }
    for (unsigned i = 0; i < part.mNumFaces; ++i) {
      const aiFace& face = part.mFaces[i];
      if (face.mNumIndices != 3) continue;  // loose points and lines
      mesh.triangles.push_back(Eigen::Vector3i(static_cast<int>(face.mIndices[0]),
                                               static_cast<int>(face.mIndices[1]),
                                               static_cast<int>(face.mIndices[2])) +
                               Eigen::Vector3i::Constant(first));
    }
  }
  return mesh;
}

void check_mesh(const TriangleMesh& mesh, const std::filesystem::path& path) {
  if (mesh.triangles.empty()) fail(path, "has no triangles", "Pass a mesh of a solid");
  for (const Eigen::Vector3d& v : mesh.vertices) {
    if (!v.allFinite()) fail(path, "has a vertex that is not a number");
  }
  const int count = static_cast<int>(mesh.vertices.size());
  for (const Eigen::Vector3i& t : mesh.triangles) {
    if (t.minCoeff() < 0 || t.maxCoeff() >= count) {
      fail(path, "has a triangle with a vertex that does not exist");
    }
  }
}

// The format repeats shared vertices, as rounded as the program that wrote them left them.
TriangleMesh joined_stl(const std::filesystem::path& path, double scale) {
  constexpr double kRounding = 1e-6;  // of the mesh's extent
  TriangleMesh mesh = read_binary_stl(path, scale);
  check_mesh(mesh, path);
  const double tolerance = kRounding * bounds(mesh).sizes().maxCoeff();
  if (tolerance > 0) mesh = with_merged_vertices(mesh, tolerance);
  check_mesh(mesh, path);
  return mesh;
}

template <typename T>
void append(std::string& bytes, const T& value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

void append_point(std::string& bytes, const Eigen::Vector3d& p) {
  for (int k = 0; k < 3; ++k) append(bytes, static_cast<float>(p[k]));
}

std::string encode_ply(const TriangleMesh& mesh) {
  std::string bytes = "ply\nformat binary_little_endian 1.0\nelement vertex " +
                      std::to_string(mesh.vertices.size()) +
                      "\nproperty float x\nproperty float y\nproperty float z\nelement face " +
                      std::to_string(mesh.triangles.size()) +
                      "\nproperty list uchar int vertex_indices\nend_header\n";
  for (const Eigen::Vector3d& v : mesh.vertices) append_point(bytes, v);
  for (const Eigen::Vector3i& t : mesh.triangles) {
    append(bytes, std::uint8_t{3});
    for (int k = 0; k < 3; ++k) append(bytes, std::int32_t{t[k]});
  }
  return bytes;
}

std::string encode_stl(const TriangleMesh& mesh) {
  std::string bytes = "prehend mesh, metres";  // must not begin with "solid"
  bytes.resize(80, ' ');
  append(bytes, static_cast<std::uint32_t>(mesh.triangles.size()));
  for (const Eigen::Vector3i& t : mesh.triangles) {
    const Eigen::Vector3d& a = mesh.vertices[t[0]];
    const Eigen::Vector3d& b = mesh.vertices[t[1]];
    const Eigen::Vector3d& c = mesh.vertices[t[2]];
    append_point(bytes, (b - a).cross(c - a).normalized());
    for (const Eigen::Vector3d* p : {&a, &b, &c}) append_point(bytes, *p);
    append(bytes, std::uint16_t{0});
  }
  return bytes;
}

std::string encode_obj(const TriangleMesh& mesh) {
  std::string text = "# prehend mesh, metres\n";
  std::array<char, 128> line{};
  for (const Eigen::Vector3d& v : mesh.vertices) {
    const int n =
        std::snprintf(line.data(), line.size(), "v %.9g %.9g %.9g\n", v.x(), v.y(), v.z());
    text.append(line.data(), static_cast<std::size_t>(n));
  }
  for (const Eigen::Vector3i& t : mesh.triangles) {
    text += "f " + std::to_string(t[0] + 1) + ' ' + std::to_string(t[1] + 1) + ' ' +
            std::to_string(t[2] + 1) + '\n';
  }
  return text;
}

}  // namespace

TriangleMesh read_mesh_file(const std::filesystem::path& path, double scale) {
  if (!std::isfinite(scale) || scale <= 0) {
    throw std::invalid_argument("read_mesh_file: scale must be positive");
  }
  const std::size_t size = checked_file_size(path);
  const std::string extension = lower_case_extension(path);
  const bool is_gltf = extension == ".gltf" || extension == ".glb";
  if (extension == ".ply") {
    TriangleMesh mesh = read_ply_mesh(path, scale);
    check_mesh(mesh, path);
    return mesh;
  }
  if (extension == ".stl") {
    // Assimp takes a text STL that stops in the middle for a whole one.
    if (is_binary_stl(path, size)) return joined_stl(path, scale);
  } else if (extension == ".off") {
    TriangleMesh mesh = read_off_mesh(path, scale);
    check_mesh(mesh, path);
    return mesh;
  } else if (extension != ".obj" && extension != ".dae" && !is_gltf) {
    fail(path, "is neither a .dae, .gltf, .glb, .obj, .off, .ply nor .stl file",
         "Convert it, e.g. with MeshLab");
  }

  Assimp::Importer importer;
  // Without normals, texture and colour, vertices at one place become one.
  importer.SetPropertyInteger(AI_CONFIG_PP_RVC_FLAGS,
                              aiComponent_NORMALS | aiComponent_TANGENTS_AND_BITANGENTS |
                                  aiComponent_COLORS | aiComponent_TEXCOORDS |
                                  aiComponent_MATERIALS | aiComponent_TEXTURES);
  // Assimp applies COLLADA's unit, so that its meshes are in metres, and would turn all to y up.
  importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, true);
  // Of a file without a mesh it would make pyramids, one for each node.
  importer.SetPropertyBool(AI_CONFIG_IMPORT_NO_SKELETON_MESHES, true);
  const aiScene* scene = nullptr;
  if (extension == ".dae") {
    const std::string text = sound_collada(path);
    scene = importer.ReadFileFromMemory(text.data(), text.size(), 0, "dae");
  } else {
    if (is_gltf) refuse_unsound_gltf(path, extension == ".glb");
    scene = importer.ReadFile(path.string(), 0);
  }
  if (scene != nullptr) {
    refuse_unsound_scene(path, *scene);
    scene = importer.ApplyPostProcessing(aiProcess_Triangulate | aiProcess_RemoveComponent |
                                         aiProcess_PreTransformVertices |
                                         aiProcess_JoinIdenticalVertices);
  }
  if (scene == nullptr) fail(path, std::string("could not be read: ") + importer.GetErrorString());
  TriangleMesh mesh = from_assimp(*scene, scale);
  if (is_gltf) {
    for (Eigen::Vector3d& v : mesh.vertices) v = {v.x(), -v.z(), v.y()};
  }
  check_mesh(mesh, path);
  return mesh;
}

void write_mesh_file(const std::filesystem::path& path, const TriangleMesh& mesh) {
  check_mesh(mesh, path);
  const std::string extension = lower_case_extension(path);
  std::string bytes;
  if (extension == ".ply") {
    bytes = encode_ply(mesh);
  } else if (extension == ".stl") {
    bytes = encode_stl(mesh);
  } else if (extension == ".obj") {
    bytes = encode_obj(mesh);
  } else {
    fail(path, "is neither an .obj, .ply nor .stl name", "Choose one of these endings");
  }
  std::ofstream stream(path, std::ios::binary);
  stream.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  stream.close();
  if (!stream) {
    fail(path, "could not be written", "Check that the folder exists, is writable and has space");
  }
}

}  // namespace prehend::geometry
