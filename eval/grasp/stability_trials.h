#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "eval/data_sets.h"
#include "prehend/control/grip_judge.h"
#include "prehend/touch/grasp_stability.h"

// Grasps that a platform's cycle executes on objects that are not quite where and what they were
// taken for: what the pads feel when the hand has closed, and whether the lift holds.
namespace prehend::eval {

/// How a grasp is spoilt: what the plan does not know.
struct Disturbance {
  double across = 0;      // m, of the object on the table, along the tool's x
  double along = 0;       // m, along its y, in which fingers close
  double yaw = 0;         // rad, about its middle
  double depth = 1;       // share of the approach that is gone, in (0, 1]
  double force = 1;       // of the planned grasp's, or of the motors', in (0, 1]
  double mass = 1;        // of a household thing's of its size
  double friction = 0.7;  // on pads and fingers
};

struct StabilityTrial {
  std::string object, platform;
  bool realistic = false;  // pads
  Disturbance disturbance;
  touch::Grip closed;   // when the hand had closed and was about to lift; no frames: it was not
  touch::Grip lifting;  // when it had risen by kAsked; no frames: it did not
  bool held = false;    // lifted, and neither lost nor slid by more than kMostSlide
  double slide = 0;     // m, of the object in the hand where the pads touched it, by the lift's end
  double raised = 0;    // m, of its lowest point, by then
  std::string reason;   // of the cycle's end

  /// Closed, and felt something: a grasp that can be asked about.
  bool counts() const { return !closed.contacts.empty(); }
};

inline constexpr double kAsked = control::kAskedWhenRisen;  // m
inline constexpr double kMostSlide = 0.01;                  // m

struct StabilityTrialOptions {
  std::vector<int> grasps;  // that close and feel something, of each platform
  std::uint64_t seed = 1;
  bool realistic = true;  // of each platform's grasps every second one is felt by realistic pads
};

/// Grasps of each platform on each object, about equally many: fewer where no pad meets the object,
/// which others make up for. They are planned on
/// the truth; the same seed gives the same trials. `progress` is told what is at hand.
/// @throws as robot::read_platform().
std::vector<StabilityTrial> run_stability_trials(
    const std::vector<std::filesystem::path>& platforms, const std::vector<DataSet>& objects,
    const StabilityTrialOptions& options, const std::function<void(const std::string&)>& progress);

}  // namespace prehend::eval
