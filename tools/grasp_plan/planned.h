#pragma once

#include <optional>
#include <string>
#include <vector>

#include "prehend/grasp/ledger.h"
#include "prehend/planning/platform_pick.h"
#include "tools/grasp_plan/target.h"

namespace prehend::tools {

/// A ranked grasp of any hand, for people and programs.
struct PlannedGrasp {
  planning::PlatformGrasp pose;
  Eigen::VectorXd all;  // of all joints of the hand's model when it has closed [rad or m]
  double score = 0;
  double quality = 0;      // epsilon
  double robustness = -1;  // 0..1; negative: not assessed
  double effort = 0;       // share of what the hand can, with the safety factor
  std::string generator;
  std::string remark;
};

struct Planned {
  robot::HandModel hand;
  std::optional<robot::Platform> platform;
  std::vector<PlannedGrasp> grasps;  // best first
  std::vector<grasp::Rejection> rejections;
  int candidates = 0;
  std::string problem;           // why there is no grasp
  grasp::Remembered remembered;  // what the database had to do with it
  std::string chosen;            // by the budget from the measured front, in words
  std::optional<planning::PlatformPick> arm;
  StageTimes times;
};

/// Plans the grasps and, with an arm, its motion; `progress` is told the stages.
/// @throws geometry::InputError naming what is wrong and the mend; std::invalid_argument.
Planned make_plan(const PlanChoices& choices, const PlanTarget& target, Progress& progress);

}  // namespace prehend::tools
