// A mesh of Inventor or VRML, which may include itself and `part.iv`: `kind byte | file`, of odd
// kind VRML's.

#include <cstdint>

#include "prehend/geometry/errors.h"
#include "prehend/robot/formats/inventor_mesh.h"
#include "tests/fuzz/folder.h"
#include "tests/fuzz/fuzz_input.h"
#include "tests/fuzz/library_leaks.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace prehend;
  static const fuzz::Folder folder;
  static const auto part =
      folder.write("part.iv", "#Inventor V2.1 ascii\nSeparator { Cube { width 2 } }\n");
  fuzz::FuzzInput input(data, size);
  const char* const name = input.byte() % 2 != 0 ? "mesh.wrl" : "mesh.iv";
  const auto file = folder.write(name, input.rest());
  try {
    const geometry::TriangleMesh mesh = robot::formats::read_inventor_mesh(file);
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
