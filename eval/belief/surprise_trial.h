#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "eval/belief/platform_act.h"
#include "eval/data_sets.h"
#include "prehend/belief/percept_surprise.h"

// Acts on predictions that are right and on such that are not, and what is perceived of them.
namespace prehend::eval {

/// What is the matter with what is grasped.
enum class ActTruth {
  kRight,   // contacts where they are predicted, within 3 mm on average; it is held
  kWrong,   // contacts are 8 mm off or more on average: it is larger or smaller than believed
  kMoved,   // by 8 to 20 mm along the table since it was seen
  kFell,    // lies where it stood
  kSlips,   // slippery and heavy: it slides in the hand by more than 10 mm, or stays behind
  kAbsent,  // there is nothing
};
std::string to_string(ActTruth truth);
const std::vector<ActTruth>& act_truths();

struct SurpriseAct {
  ActTruth truth = ActTruth::kRight;
  double off = 0;  // m: mean distance of the predicted contacts from the surface; of kMoved: by
                   // how much
  PlatformAct act;
};

/// A platform that is made ready to plan and act with.
class SurprisedPlatform {
 public:
  /// @param name of config/robots, or a file. @throws as robot::read_platform() and in_reach().
  explicit SurprisedPlatform(const std::string& name);

  const robot::Platform& platform() const { return planner_.platform(); }
  const std::string& home() const { return home_; }
  /// By the shipped planner. None without a motion, for a reason in words.
  planning::PlatformPlan plan(const Belief& belief) const;

 private:
  planning::PlatformPlanner planner_;
  std::string home_;
};

/// One object, seen once, one grasp, several truths.
struct SurpriseCase {
  std::string name, group;
  std::string problem;  // why there is nothing of it
  belief::PerceptForecast predicted;
  double prediction_seconds = 0;  // of processor, for each shape
  int shapes = 0;
  int left_out = 0;  // acts that were none of the above, or could not be simulated
  int stopped = 0;   // others than right ones that the cycle ended before the hand closed
  std::vector<SurpriseAct> acts;
};

/// Sees, completes, plans, predicts as the node `belief` does, and acts: by the shipped cycle with
/// arm and hand (act_once()), with realistic pads (TactileSensorOptions::realistic(),
/// FoamMemory::realistic()) and 0.1 N of noise at the wrist; predictions have neither, and coarser
/// steps. Same arguments, same answer. What throws is the case's problem.
SurpriseCase run_surprise_trial(const Case& one, const SurprisedPlatform& platform);

}  // namespace prehend::eval
