#include "msgs/convert/gripper.h"

#include <fstream>
#include <iterator>
#include <string>

namespace prehend::convert {

msgs::GripperDescription describe_gripper(const std::filesystem::path& file) {
  msgs::GripperDescription message;
  if (file.empty()) {
    message.set_file("the default gripper");
    message.set_yaml("{}");
    return message;
  }
  robot::read_gripper_model(file);  // is one
  std::ifstream in(file, std::ios::binary);
  message.set_file(file.lexically_normal().string());
  message.set_yaml({std::istreambuf_iterator<char>(in), {}});
  return message;
}

robot::GripperModel from_message(const msgs::GripperDescription& message) {
  return robot::parse_gripper_model(message.yaml(), message.file());
}

}  // namespace prehend::convert
