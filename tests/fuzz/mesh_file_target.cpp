// A mesh's file: `kind byte | file`, whose ending is the kind's.

#include <array>
#include <cstdint>
#include <string>

#include "prehend/geometry/errors.h"
#include "prehend/geometry/mesh_files.h"
#include "prehend/geometry/ply_mesh.h"
#include "tests/fuzz/folder.h"
#include "tests/fuzz/fuzz_input.h"
#include "tests/fuzz/library_leaks.h"

namespace {

using namespace prehend;

void read_colors(const std::filesystem::path& file) {
  try {
    geometry::PlyColors colors;
    const geometry::TriangleMesh mesh = geometry::read_ply_mesh(file, 1, &colors);
    for (const auto& [part, most] : {std::pair(&colors.vertices, mesh.vertices.size()),
                                     std::pair(&colors.triangles, mesh.triangles.size())}) {
      FUZZ_CHECK(part->size() <= most);
      for (const auto& color : *part) {
        for (const int one : color) FUZZ_CHECK(one >= 0 && one <= 255);
      }
    }
  } catch (const geometry::InputError&) {
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  // Printed signs, so that the corpus can be read: s, p, o, ... of the endings.
  constexpr std::array<std::pair<char, const char*>, 7> kEndings{{{'s', ".stl"},
                                                                  {'p', ".ply"},
                                                                  {'o', ".obj"},
                                                                  {'f', ".off"},
                                                                  {'d', ".dae"},
                                                                  {'g', ".gltf"},
                                                                  {'b', ".glb"}}};
  static const fuzz::Folder folder;
  fuzz::FuzzInput input(data, size);
  const std::uint8_t kind = input.byte();
  const char* ending = nullptr;
  for (const auto& [sign, one] : kEndings) {
    if (kind == static_cast<std::uint8_t>(sign)) ending = one;
  }
  if (ending == nullptr) return 0;
  const auto file = folder.write(std::string("mesh") + ending, input.rest());
  if (kind == 'p') read_colors(file);
  try {
    const geometry::TriangleMesh mesh = geometry::read_mesh_file(file, 0.001);
    FUZZ_CHECK(!mesh.triangles.empty());
    for (const Eigen::Vector3i& triangle : mesh.triangles) {
      FUZZ_CHECK(triangle.minCoeff() >= 0);
      FUZZ_CHECK(triangle.maxCoeff() < static_cast<int>(mesh.vertices.size()));
    }
    for (const Eigen::Vector3d& vertex : mesh.vertices) FUZZ_CHECK(vertex.allFinite());
  } catch (const geometry::InputError&) {
  }
  return 0;
}
