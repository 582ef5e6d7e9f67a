#include "prehend/planning/touch_prediction.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <optional>
#include <thread>
#include <utility>

#include <fmt/format.h>

#include "prehend/geometry/errors.h"
#include "prehend/grasp/parallel.h"
#include "prehend/planning/hand_act.h"
#include "prehend/text/require.h"

namespace prehend::planning {
namespace {

using std::chrono::steady_clock;

PredictedTouch close(HandAct& act, const GraspToFeel& grasp) {
  act.begin(grasp);
  act.close();
  act.check_object(TouchOutcome::kFallsOver, "falls over when the hand closes");
  PredictedTouch touch;
  touch.outcome = TouchOutcome::kPredicted;
  touch.pads = act.read();
  touch.mean = act.mean(touch.pads);
  touch.stopped = act.stopped();
  if (touch.mean.pads > 0) return touch;
  if (!act.object().touches_robot) {
    throw ActEnds{TouchOutcome::kMissed, "the fingers close beside the object"};
  }
  throw ActEnds{TouchOutcome::kBesidePads, "the hand touches the object beside its pads"};
}

steady_clock::time_point end_of(double budget) {
  if (budget <= 0) return steady_clock::time_point::max();
  return steady_clock::now() +
         std::chrono::duration_cast<steady_clock::duration>(std::chrono::duration<double>(budget));
}

// What `simulate` predicts, or why it does not.
PredictedTouch told(const std::function<PredictedTouch()>& simulate) {
  PredictedTouch none;
  try {
    return simulate();
  } catch (const ActEnds& end) {
    none.outcome = end.outcome;
    none.problem = end.why;
  } catch (const geometry::InputError& error) {
    none.outcome = TouchOutcome::kNotSimulated;
    none.problem = fmt::format("it cannot be simulated: {}", error.what());
  }
  return none;
}

}  // namespace

simulation::RobotWorldOptions TouchPredictionOptions::coarse() {
  simulation::RobotWorldOptions world;
  world.step = 0.004;
  return world;
}

void TouchPredictionOptions::validate() const {
  grip.validate("TouchPredictionOptions::grip.");
  const text::Require require{"TouchPredictionOptions::"};
  require(touch_counts >= 0, "touch_counts must not be negative");
  require(std::isfinite(friction) && friction >= 0, "friction must not be negative");
  require(std::isfinite(largest_tilt) && largest_tilt > 0, "largest_tilt must be positive");
  require(std::isfinite(budget) && budget >= 0, "budget must not be negative");
  require(threads >= 0, "threads must not be negative");
}

PredictedTouch predict_touch(const robot::HandModel& hand, const GraspToFeel& grasp,
                             const ObjectToFeel& object, const TouchPredictionOptions& options) {
  return predict_touches(hand, {grasp}, object, options).front();
}

std::vector<PredictedTouch> predict_touches(const robot::HandModel& hand,
                                            const std::vector<GraspToFeel>& grasps,
                                            const ObjectToFeel& object,
                                            const TouchPredictionOptions& options) {
  options.validate();
  for (const GraspToFeel& grasp : grasps) check_act(hand, grasp, object);
  std::vector<PredictedTouch> touches(grasps.size());
  if (hand.pads.empty()) {
    PredictedTouch none;
    none.outcome = TouchOutcome::kNoPads;
    none.problem = fmt::format("the hand '{}' has no tactile pads", hand.name);
    touches.assign(grasps.size(), none);
    return touches;
  }
  const auto until = end_of(options.budget);
  const std::size_t cores = std::max(1u, std::thread::hardware_concurrency());
  const std::size_t worlds = std::min(
      options.threads > 0 ? static_cast<std::size_t>(options.threads) : cores, grasps.size());
  grasp::for_each_index(worlds, static_cast<int>(worlds), [&](std::size_t world) {
    std::optional<HandAct> felt;
    const PredictedTouch standing = told([&] {
      if (steady_clock::now() > until) {
        throw ActEnds{TouchOutcome::kBudgetUsed, "the budget is used up"};
      }
      felt.emplace(hand, object, options, until);
      return PredictedTouch();
    });
    for (std::size_t i = world; i < grasps.size(); i += worlds) {
      touches[i] = felt ? told([&] { return close(*felt, grasps[i]); }) : standing;
    }
  });
  return touches;
}

GraspToFeel grasp_to_feel(const grasp::Grasp& grasp) {
  constexpr double kLeastEffort = 1e-3;  // share
  return {grasp.X_WG,   grasp.preshape, grasp.open,
          grasp.closed, grasp.force,    std::clamp(grasp.effort, kLeastEffort, 1.0)};
}

std::vector<PredictedTouch> add_touch(const robot::HandModel& hand,
                                      const surface::ObjectModel& object,
                                      const geometry::Plane& table,
                                      const TouchPredictionOptions& options,
                                      std::vector<grasp::Grasp>* grasps) {
  if (grasps->empty()) return {};
  std::vector<GraspToFeel> to_feel;
  for (const grasp::Grasp& grasp : *grasps) to_feel.push_back(grasp_to_feel(grasp));
  const ObjectToFeel body{object.mesh_W, table, grasps->front().predicted.lifted_mass};
  std::vector<PredictedTouch> touches = predict_touches(hand, to_feel, body, options);
  for (std::size_t i = 0; i < grasps->size(); ++i) {
    const PredictedTouch& touch = touches[i];
    if (touch.outcome != TouchOutcome::kPredicted && !touch.is_refuted()) continue;
    (*grasps)[i].predicted.contact_area = touch.mean.area;
    (*grasps)[i].predicted.tactile_sum = touch.mean.sum;
  }
  return touches;
}

}  // namespace prehend::planning
