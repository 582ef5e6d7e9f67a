#include "prehend/planning/touch_prediction.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <thread>
#include <utility>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include "prehend/geometry/errors.h"
#include "prehend/grasp/parallel.h"
#include "prehend/robot/closing_way.h"
#include "prehend/text/require.h"

namespace prehend::planning {
namespace {

using geometry::RigidTransform;
using std::chrono::steady_clock;

constexpr double kStandingTime = 0.5;  // s, until an object that stands has come to rest
// Fingers that press creep on for seconds; what they feel is known by then.
constexpr double kSteadyTime = 0.2, kSteady = 0.02;  // s, change of the pads' mean in it
constexpr double kFarAbove = 10;                     // m, of a hand that is not to touch
constexpr double kMotionTimeout = 10;                // s, of one motion of the fingers
constexpr double kFarthest = 0.3;                    // m, that a closing hand may push it
constexpr double kDegrees = 180 / M_PI;
const std::string kFelt = "object";

// The world whose z = 0 is the table.
RigidTransform on_table(const geometry::Plane& table_W) {
  RigidTransform X_TW = RigidTransform::Identity();
  X_TW.linear() =
      Eigen::Quaterniond::FromTwoVectors(table_W.normal, Eigen::Vector3d::UnitZ()).matrix();
  X_TW.translation().z() = -table_W.offset;
  return X_TW;
}

void check(const robot::HandModel& hand, const GraspToFeel& grasp, const ObjectToFeel& object) {
  const text::Require require{"predict_touch: "};
  require(grasp.X_WG.matrix().allFinite(), "X_WG must be finite");
  require(grasp.closed.size() == hand.size() && grasp.closed.allFinite(),
          "closed must be one finite position for each motor of the hand");
  require(grasp.open.size() == 0 || (grasp.open.size() == hand.size() && grasp.open.allFinite()),
          "open must be empty or one finite position for each motor of the hand");
  hand.preshape(grasp.preshape);
  require(std::isfinite(grasp.force) && grasp.force >= 0, "force must not be negative");
  require(grasp.effort > 0 && grasp.effort <= 1, "effort must be in (0, 1]");
  require(std::isfinite(object.mass) && object.mass > 0, "mass must be positive");
  require(std::isfinite(object.table_W.offset) && std::abs(object.table_W.normal.norm() - 1) < 1e-6,
          "the table's normal must be a unit vector");
}

// Why a run ends early.
struct NotPredicted {
  TouchOutcome outcome;
  std::string why;
};

void check_budget(steady_clock::time_point until) {
  if (steady_clock::now() <= until) return;
  throw NotPredicted{TouchOutcome::kBudgetUsed, "the budget is used up"};
}

// A hand and an object that stands on its table, to be closed on again and again.
class FeltObject {
 public:
  FeltObject(const robot::HandModel& hand, const ObjectToFeel& object,
             const TouchPredictionOptions& options, steady_clock::time_point until)
      : hand_(hand),
        options_(options),
        until_(until),
        X_TW_(on_table(object.table_W)),
        world_(hand, far_above(), "", options.world) {
    world_.add_object(kFelt, geometry::transformed(object.mesh_W, X_TW_), object.mass, false,
                      options.friction);
    X_TB_start_ = world_.body(kFelt).X_WB;
    const double end = world_.time() + kStandingTime;
    while (world_.time() < end && !world_.body(kFelt).asleep) step();
    check_object(TouchOutcome::kNotStanding, "does not stand as it was predicted");
    standing_ = world_.save();
  }

  PredictedTouch close(const GraspToFeel& grasp) {
    const robot::Preshape& shape = hand_.preshape(grasp.preshape);
    way_ = robot::closing_way(hand_, shape, grasp.open, grasp.closed);
    world_.restore(*standing_);
    world_.set_carrier(X_TW_ * grasp.X_WG * (hand_.X_HP * shape.X_PG).inverse(Eigen::Isometry));
    world_.set_hand(way_.open);
    const double wanted = grasp.force > 0 ? grasp.force : options_.grip.grip_force;
    double share = wanted > 0 ? robot::first_effort_share(grasp.effort) : 1.0;
    if (options_.grip.gather > 0) move(-options_.grip.gather, share);
    move(options_.grip.overrun, share);
    stopped_ = world_.hand_positions();
    if (share < 1) press(wanted, share);
    run_for(options_.grip.settle_time);
    check_object(TouchOutcome::kFallsOver, "falls over when the hand closes");
    return felt();
  }

 private:
  void step() {
    world_.step();
    constexpr long kCheckEvery = 16;
    if (++steps_ % kCheckEvery == 0) check_budget(until_);
  }

  void run_for(double seconds) {
    const double end = world_.time() + seconds - 0.5 * world_.options().step;
    while (world_.time() < end) step();
  }

  static RigidTransform far_above() {
    RigidTransform X_TH = RigidTransform::Identity();
    X_TH.translation().z() = kFarAbove;
    return X_TH;
  }

  void check_object(TouchOutcome outcome, const std::string& what) const {
    const RigidTransform X_TB = world_.body(kFelt).X_WB;
    if (!X_TB.matrix().allFinite()) throw NotPredicted{outcome, "the object flies off"};
    const Eigen::Matrix3d turn = X_TB.linear() * X_TB_start_.linear().transpose();
    const double tilt = std::acos(std::clamp(turn(2, 2), -1.0, 1.0));
    if (tilt > options_.largest_tilt) {
      throw NotPredicted{
          outcome, fmt::format("the object {}: it tilts by {:.0f} degrees", what, tilt * kDegrees)};
    }
    if ((X_TB.translation() - X_TB_start_.translation()).norm() > kFarthest) {
      throw NotPredicted{outcome, "the object is thrown out of the hand"};
    }
  }

  void move(double beyond, double share) {
    simulation::HandCommand command;
    command.speed = options_.grip.closing_speed;
    command.until_contact = true;
    command.position = way_.at(beyond);
    command.effort = share * world_.hand().most_efforts();
    world_.move_hand(command);
    const double end = world_.time() + kMotionTimeout;
    double felt = 0;
    while (world_.hand().moving() && world_.time() < end) {
      const double next_look = world_.time() + kSteadyTime;
      while (world_.hand().moving() && world_.time() < next_look) step();
      const double now = mean(read()).sum;
      if (now > 0 && std::abs(now - felt) < kSteady * now) return;
      felt = now;
    }
  }

  void press(double wanted, double share) {
    const double begin = world_.time();
    while (true) {
      const double moved = world_.time();
      move(options_.grip.overrun, share);
      run_for(moved + robot::kPressTime - world_.time());
      const auto next = robot::next_effort_share(share, mean(read()), wanted);
      if (!next || world_.time() - begin > options_.grip.force_timeout) return;
      share = *next;
    }
  }

  std::vector<PredictedPad> read() const {
    std::vector<PredictedPad> pads;
    for (simulation::HandPadReading& reading : world_.pads()) {
      const contact::PadLayout& layout = *hand_.pads[pads.size()].layout;
      PredictedPad pad{std::move(reading.name),   reading.rows, reading.columns,
                       std::move(reading.counts), reading.sum,  0,
                       Eigen::Vector3d::Zero()};
      pad.area = robot::touched_area(pad.counts, options_.touch_counts, layout);
      pad.center_P = center_of(pad, layout);
      pads.push_back(std::move(pad));
    }
    return pads;
  }

  Eigen::Vector3d center_of(const PredictedPad& pad, const contact::PadLayout& layout) const {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    double counts = 0;
    for (std::size_t i = 0; i < pad.counts.size(); ++i) {
      const int count = pad.counts[i];
      if (count <= options_.touch_counts) continue;
      counts += count;
      sum += count * layout.position(i);
    }
    return counts > 0 ? Eigen::Vector3d(sum / counts) : sum;
  }

  robot::MeanTouch mean(const std::vector<PredictedPad>& pads) const {
    std::vector<robot::PadPercept> percepts;
    for (const PredictedPad& pad : pads) percepts.push_back({pad.sum, pad.area, 0});
    return robot::mean_touch(percepts, options_.grip.touch_force,
                             std::numeric_limits<double>::infinity());
  }

  PredictedTouch felt() const {
    PredictedTouch touch;
    touch.outcome = TouchOutcome::kPredicted;
    touch.pads = read();
    touch.mean = mean(touch.pads);
    touch.stopped = stopped_;
    if (touch.mean.pads > 0) return touch;
    if (!world_.body(kFelt).touches_robot) {
      throw NotPredicted{TouchOutcome::kMissed, "the fingers close beside the object"};
    }
    throw NotPredicted{TouchOutcome::kBesidePads, "the hand touches the object beside its pads"};
  }

  const robot::HandModel& hand_;
  const TouchPredictionOptions& options_;
  steady_clock::time_point until_;
  RigidTransform X_TW_;
  simulation::RobotWorld world_;
  std::shared_ptr<const simulation::RobotWorld::State> standing_;
  robot::ClosingWay way_;
  RigidTransform X_TB_start_ = RigidTransform::Identity();
  Eigen::VectorXd stopped_;
  long steps_ = 0;
};

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
  } catch (const NotPredicted& end) {
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
  for (const GraspToFeel& grasp : grasps) check(hand, grasp, object);
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
    std::optional<FeltObject> felt;
    const PredictedTouch standing = told([&] {
      check_budget(until);
      felt.emplace(hand, object, options, until);
      return PredictedTouch();
    });
    for (std::size_t i = world; i < grasps.size(); i += worlds) {
      touches[i] = felt ? told([&] { return felt->close(grasps[i]); }) : standing;
    }
  });
  return touches;
}

std::vector<PredictedTouch> add_touch(const robot::HandModel& hand,
                                      const surface::ObjectModel& object,
                                      const geometry::Plane& table,
                                      const TouchPredictionOptions& options,
                                      std::vector<grasp::Grasp>* grasps) {
  constexpr double kLeastEffort = 1e-3;  // share; of grasps that need next to none
  if (grasps->empty()) return {};
  std::vector<GraspToFeel> to_feel;
  for (const grasp::Grasp& grasp : *grasps) {
    to_feel.push_back({grasp.X_WG, grasp.preshape, grasp.open, grasp.closed, grasp.force,
                       std::clamp(grasp.effort, kLeastEffort, 1.0)});
  }
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
