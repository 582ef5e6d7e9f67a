#pragma once

#include <functional>
#include <string>
#include <vector>

#include "prehend/planning/remedies.h"

namespace prehend::planning {

/// What plan_grasps() is given, to be changed.
struct GraspCase {
  const surface::ObjectModel* object = nullptr;
  geometry::Plane table_W;
  const grasp::Obstacles* obstacles = nullptr;
  robot::HandModel hand;
  grasp::Reachability reachability;
  grasp::PlannerOptions options;
};

/// A thing of a case that can be changed, in equal steps.
struct Lever {
  RemedyChange change = RemedyChange::kOpening;
  double planned = 0;  // the value it has
  int most = 1;        // > 0, steps
  int first = 1;       // 1..most: the least number of steps that the ledger lets one hope for
  std::function<double(int steps)> value;
  std::function<void(int steps, GraspCase* changed)> pull;
  std::function<std::string(int steps)> text;  // "6 mm more opening (75 mm)"
};

/// Those that a ledger suggests, friction last: it rarely helps where fingers take long to plan.
std::vector<Lever> levers_for(const GraspCase& planned,
                              const std::vector<grasp::Rejection>& ledger);

}  // namespace prehend::planning
