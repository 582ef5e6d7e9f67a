#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "eval/belief/toucher.h"
#include "eval/data_sets.h"
#include "prehend/belief/percept_forecast.h"
#include "prehend/belief/percept_surprise.h"
#include "prehend/surface/deviation.h"

// Acts on predictions that are right and on such that are not, and what is perceived of them.
namespace prehend::eval {

/// What is the matter with what is grasped.
enum class ActTruth {
  kRight,   // contacts and all of its surface are where they are predicted, each within 3 mm on
            // average, 95 % of the surface within 8 mm; it is held
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
  belief::SimulatedAct act;
};

/// One object, seen once, one grasp, several truths.
struct SurpriseCase {
  std::string name, group;
  std::string problem;  // why there is nothing of it
  belief::PerceptForecast predicted;
  double prediction_seconds = 0;  // of processor, for each shape
  int shapes = 0;
  surface::DeviationStatistics shape_off;  // m, of the object's surface from what is believed
  int left_out = 0;  // acts that were none of the above, or could not be simulated
  std::vector<SurpriseAct> acts;
};

/// Sees, believes, plans, predicts, and acts: by the hand alone, in simulation::RobotWorld with
/// steps of 2 ms, realistic pads (TactileSensorOptions::realistic(), FoamMemory::realistic()) and
/// 0.1 N of noise at the wrist; predictions have neither, and steps of 4 ms. Same arguments, same
/// answer. What throws is the case's problem.
SurpriseCase run_surprise_trial(const Case& one, const TouchingHand& hand);

}  // namespace prehend::eval
