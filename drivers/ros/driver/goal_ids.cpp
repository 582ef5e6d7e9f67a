#include "drivers/ros/driver/goal_ids.h"

#include <random>

namespace prehend::drivers::ros_link {

std::uint64_t random_client_id() {
  std::random_device device;
  return (std::uint64_t{device()} << 32) | device();
}

GoalId random_goal_id() {
  GoalId id{};
  for (std::size_t half = 0; half < 2; ++half) {
    const std::uint64_t bits = random_client_id();
    for (std::size_t i = 0; i < 8; ++i) id[8 * half + i] = static_cast<char>(bits >> (8 * i));
  }
  id[6] = static_cast<char>((id[6] & 0x0F) | 0x40);
  id[8] = static_cast<char>((id[8] & 0x3F) | 0x80);
  return id;
}

std::string text_of(const GoalId& id) {
  constexpr const char* kDigits = "0123456789abcdef";
  std::string text = "prehend-";
  for (const char c : id) {
    text += kDigits[static_cast<unsigned char>(c) >> 4];
    text += kDigits[static_cast<unsigned char>(c) & 15];
  }
  return text;
}

}  // namespace prehend::drivers::ros_link
