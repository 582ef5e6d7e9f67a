#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

namespace prehend::drivers::ros_link {

/// Names of goals that no two clients give: 16 random bytes, as version 4 of RFC 4122.
using GoalId = std::array<char, 16>;
GoalId random_goal_id();
inline std::string_view bytes_of(const GoalId& id) { return {id.data(), id.size()}; }
/// As ROS 1 names goals: any text.
std::string text_of(const GoalId& id);
/// By which a client's requests are told from others'.
std::uint64_t random_client_id();

}  // namespace prehend::drivers::ros_link
