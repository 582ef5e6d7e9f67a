// A simulation's scene, as config/scenes has it: YAML that may name a gripper and a mesh beside it.

#include <cstdint>

#include "prehend/geometry/errors.h"
#include "prehend/simulation/scene.h"
#include "tests/fuzz/folder.h"
#include "tests/fuzz/fuzz_input.h"

namespace {

using namespace prehend;

/// The files that an input may name.
class Neighbours {
 public:
  Neighbours() {
    folder_.write("gripper.yaml",
                  "name: g\nmax_opening: 0.07\nmax_speed: 0.08\ndrive: {supply: 24}\n");
    folder_.write("mesh.obj",
                  "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\n"
                  "f 2 3 4\n");
  }
  std::filesystem::path input(std::string_view content) const {
    return folder_.write("scene.yaml", content);
  }

 private:
  const fuzz::Folder folder_;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const Neighbours neighbours;
  const auto file = neighbours.input({reinterpret_cast<const char*>(data), size});
  try {
    const simulation::Scene scene = simulation::read_scene(file);
    simulation::validate(scene);
    for (const auto& object : scene.objects) {
      FUZZ_CHECK(!simulation::object_mesh(object).triangles.empty());
    }
  } catch (const geometry::InputError&) {
  }
  return 0;
}
