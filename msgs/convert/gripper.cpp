#include "msgs/convert/gripper.h"

#include <fstream>
#include <iterator>
#include <string>

namespace prehend::convert {
namespace {

using robot::GripperMode;
using robot::JointMode;

// The same modes in the same order.
constexpr bool is_same(GripperMode mode, msgs::GripperCommand::Mode message) {
  return static_cast<int>(mode) == static_cast<int>(message);
}
static_assert(is_same(GripperMode::kStop, msgs::GripperCommand::STOP));
static_assert(is_same(GripperMode::kPosition, msgs::GripperCommand::POSITION));
static_assert(is_same(GripperMode::kVelocity, msgs::GripperCommand::VELOCITY));
static_assert(is_same(GripperMode::kCurrent, msgs::GripperCommand::CURRENT));
static_assert(is_same(GripperMode::kVoltage, msgs::GripperCommand::VOLTAGE));
static_assert(is_same(GripperMode::kVoltage, msgs::GripperCommand::Mode_MAX));

constexpr bool is_same(JointMode mode, msgs::JointCommand::Mode message) {
  return static_cast<int>(mode) == static_cast<int>(message);
}
static_assert(is_same(JointMode::kStop, msgs::JointCommand::STOP));
static_assert(is_same(JointMode::kPosition, msgs::JointCommand::POSITION));
static_assert(is_same(JointMode::kVelocity, msgs::JointCommand::VELOCITY));
static_assert(is_same(JointMode::kEffort, msgs::JointCommand::EFFORT));
static_assert(is_same(JointMode::kVoltage, msgs::JointCommand::VOLTAGE));
static_assert(is_same(JointMode::kVoltage, msgs::JointCommand::Mode_MAX));

}  // namespace

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

std::optional<GripperMode> from_message(msgs::GripperCommand::Mode mode) {
  if (!msgs::GripperCommand::Mode_IsValid(mode)) return std::nullopt;
  return static_cast<GripperMode>(mode);
}

std::optional<JointMode> from_message(msgs::JointCommand::Mode mode) {
  if (!msgs::JointCommand::Mode_IsValid(mode)) return std::nullopt;
  return static_cast<JointMode>(mode);
}

}  // namespace prehend::convert
