// A message that comes from ROS, of any type that is exchanged with it: read, converted, and
// written again. The first byte says the version, the second the type.

#include <google/protobuf/message.h>

#include <cstdint>
#include <string>
#include <vector>

#include "msgs/ros/definitions.h"
#include "msgs/ros/from_ros.h"
#include "prehend/geometry/errors.h"
#include "tests/fuzz/fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace prehend;
  if (size < 2) return 0;
  const ros::Version version = data[0] % 2 == 0 ? ros::Version::kRos1 : ros::Version::kRos2;
  static const std::vector<std::string> kTypes[2] = {ros::message_types(ros::Version::kRos1),
                                                     ros::message_types(ros::Version::kRos2)};
  const auto& types = kTypes[data[0] % 2];
  const std::string& type = types[data[1] % types.size()];
  const std::string_view bytes(reinterpret_cast<const char*>(data) + 2, size - 2);
  const recording::RosType& reader = ros::type_of(type, version);
  try {
    const recording::RosValue message = reader.read(bytes, ros::encoding_of(version));
    // What was read can be written, and is the same when it is read again.
    const std::string written = reader.write(message, ros::encoding_of(version));
    const recording::RosValue again = reader.read(written, ros::encoding_of(version));
    FUZZ_CHECK(reader.write(again, ros::encoding_of(version)) == written);
    const auto made = ros::from_ros(type, message);
    if (made) FUZZ_CHECK(made->ByteSizeLong() < (std::size_t{1} << 31));
  } catch (const recording::RosError&) {
  } catch (const geometry::InputError&) {
  }
  return 0;
}
