// What stands beside a URDF: groups, postures, end effectors, pairs of links. What is kept of it is
// written, and is read again as it was.

#include <cstdint>
#include <string>

#include "prehend/geometry/errors.h"
#include "prehend/robot/formats/srdf.h"
#include "tests/fuzz/fuzz_input.h"
#include "tests/fuzz/memory_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace prehend;
  using namespace prehend::robot::formats;
  RobotDescription robot;
  for (const char* link : {"a", "b", "c"}) robot.links.push_back({link, {}, {}, {}});
  for (int i = 0; i < 2; ++i) {
    JointDescription joint;
    joint.name = i == 0 ? "j" : "k";
    joint.kind = JointDescription::Kind::kRevolute;
    joint.parent = robot.links[static_cast<std::size_t>(i)].name;
    joint.child = robot.links[static_cast<std::size_t>(i) + 1].name;
    robot.joints.push_back(joint);
  }
  RobotDescription again = robot;
  const fuzz::MemoryFile file({reinterpret_cast<const char*>(data), size});
  try {
    LossReport loss;
    read_srdf(file.path(), robot, loss);
  } catch (const geometry::InputError&) {
    return 0;
  }
  LossReport loss;
  const std::string text = write_srdf(robot, loss);
  const fuzz::MemoryFile written({text.data(), text.size()});
  read_srdf(written.path(), again, loss);
  FUZZ_CHECK(again.disabled_collisions == robot.disabled_collisions);
  FUZZ_CHECK(again.postures.size() == robot.postures.size());
  FUZZ_CHECK(again.manipulators.size() == robot.manipulators.size());
  return 0;
}
