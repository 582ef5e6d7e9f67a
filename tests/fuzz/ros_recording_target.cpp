// A recording of ROS: opened, every message of it read by its own definition and converted.

#include <google/protobuf/message.h>

#include <cstdint>

#include "msgs/ros/from_ros.h"
#include "prehend/geometry/errors.h"
#include "prehend/recording/ros_recording.h"
#include "tests/fuzz/fuzz_input.h"
#include "tests/fuzz/memory_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace prehend;
  const fuzz::MemoryFile file({reinterpret_cast<const char*>(data), size});
  try {
    recording::RosRecording recording(file.path());
    while (const auto message = recording.next()) {
      try {
        const auto made = ros::from_ros(message->type, message->read());
        if (made) FUZZ_CHECK(made->ByteSizeLong() < (std::size_t{1} << 31));
      } catch (const recording::RosError&) {
      } catch (const geometry::InputError&) {
      }
    }
  } catch (const recording::McapError&) {
  }
  return 0;
}
