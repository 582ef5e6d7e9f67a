// The block in which robots' files have what their format cannot say: applied to a robot that the
// rest of a file says. What is kept of it is checked, written as prehend's own text, and is read
// again.

#include <cstdint>
#include <string>

#include "prehend/geometry/errors.h"
#include "prehend/robot/formats/extension.h"
#include "prehend/robot/formats/model_check.h"
#include "prehend/robot/formats/robot_format.h"
#include "tests/fuzz/fuzz_input.h"
#include "tests/fuzz/memory_file.h"

namespace {

using namespace prehend;
using namespace prehend::robot::formats;

RobotDescription small_robot() {
  constexpr std::string_view kText = R"(<robot name='r'><link name='a'><inertial><mass value='1'/>
    <inertia ixx='1' ixy='0' ixz='0' iyy='1' iyz='0' izz='1'/></inertial><visual><geometry>
    <box size='1 2 3'/></geometry></visual></link><link name='b'><collision><geometry>
    <sphere radius='1'/></geometry></collision></link><link name='c'/>
    <joint name='j' type='revolute'><parent link='a'/><child link='b'/><axis xyz='0 0 1'/>
    <limit lower='-1' upper='1' effort='1' velocity='1'/></joint>
    <joint name='k' type='prismatic'><parent link='b'/><child link='c'/><mimic joint='j'/>
    <limit lower='0' upper='1' effort='1' velocity='1'/></joint></robot>)";
  const fuzz::MemoryFile file(kText);
  LossReport loss;
  return read_robot(file.path(), loss);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const RobotDescription kRobot = small_robot();
  // As it stands in a file: read_robot() looks at numbers after the block is applied.
  const std::string block(reinterpret_cast<const char*>(data), size);
  RobotDescription robot = kRobot;
  try {
    LossReport loss;
    apply_extension(block, "file:1", robot, loss);
  } catch (const geometry::InputError&) {
    return 0;
  }
  try {
    check_model(robot, "/nowhere");
    LossReport loss;
    const std::string text = format_named("json").write(robot, loss);
    const fuzz::MemoryFile file({text.data(), text.size()});
    read_robot(file.path(), loss);
  } catch (const geometry::InputError&) {
  }
  return 0;
}
