#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "prehend/grasp/planner.h"

namespace prehend::control {

/// The hand is where it was with the other grasp: within 6 mm and 0.15 rad. A parallel gripper
/// turned by half about its approach is the same.
bool is_like(const grasp::Grasp& a, const grasp::Grasp& b);

/// The first of the grasps that was not tried and is like none that failed, which would fail again
/// where nothing has moved; else the first that was not tried; none when all were.
/// @pre tried.size() == grasps.size()
std::optional<std::size_t> next_to_try(const std::vector<grasp::Grasp>& grasps,
                                       const std::vector<bool>& tried,
                                       const std::vector<grasp::Grasp>& failed);

}  // namespace prehend::control
