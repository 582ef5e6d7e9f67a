#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "prehend/robot/robot_model.h"

namespace prehend::eval {

/// A robot of a URDF and an SRDF, of which one group is planned for.
struct PlanningRobot {
  robot::RobotModel model;
  std::string base, tip;                                       // links of the group's chain
  std::vector<std::pair<std::string, std::string>> may_touch;  // links
};

/// @param group of the SRDF, with a chain
/// @throws geometry::InputError naming the file: what is no URDF or SRDF, a group that is not there
/// or has no chain.
PlanningRobot read_planning_robot(const std::filesystem::path& urdf,
                                  const std::filesystem::path& srdf, const std::string& group);

/// The robot with joints beside its chain where `positions` [rad or m] has them, for good.
PlanningRobot with_fixed(const PlanningRobot& robot,
                         const std::map<std::string, double>& positions);

}  // namespace prehend::eval
