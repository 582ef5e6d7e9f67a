// A robot's file of any format that is read: it is read, checked, and written in the others.

#include <cstdint>
#include <cstdlib>
#include <string>

#include "prehend/geometry/errors.h"
#include "prehend/robot/formats/model_check.h"
#include "prehend/robot/formats/robot_format.h"
#include "tests/fuzz/fuzz_input.h"
#include "tests/fuzz/memory_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace prehend;
  using namespace prehend::robot::formats;
  const std::string text(reinterpret_cast<const char*>(data), size);
  // What MuJoCo's compiler makes of it is MuJoCo's.
  if (text.find("<mujoco") != std::string::npos) return 0;
  const fuzz::MemoryFile file({text.data(), text.size()});
  try {
    LossReport loss;
    const RobotDescription robot = read_robot(file.path(), loss);
    FUZZ_CHECK(!robot.links.empty());
    check_model(robot, "/nowhere");
    for (const auto& format : robot_formats()) {
      if (!format->can_write()) continue;
      LossReport written;
      FUZZ_CHECK(!format->write(robot, written).empty());
    }
  } catch (const geometry::InputError&) {
  }
  return 0;
}
