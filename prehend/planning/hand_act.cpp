#include "prehend/planning/hand_act.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>
#include <Eigen/Geometry>

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

void check_budget(steady_clock::time_point until) {
  if (steady_clock::now() <= until) return;
  throw ActEnds{TouchOutcome::kBudgetUsed, "the budget is used up"};
}

RigidTransform far_above() {
  RigidTransform X_TH = RigidTransform::Identity();
  X_TH.translation().z() = kFarAbove;
  return X_TH;
}

}  // namespace

HandAct::HandAct(const robot::HandModel& hand, const ObjectToFeel& object,
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

void HandAct::begin(const GraspToFeel& grasp) {
  const robot::Preshape& shape = hand_.preshape(grasp.preshape);
  way_ = robot::closing_way(hand_, shape, grasp.open, grasp.closed);
  world_.restore(*standing_);
  world_.set_carrier(X_TW_ * hand_root(hand_, grasp));
  world_.set_hand(way_.open);
  wanted_ = grasp.force > 0 ? grasp.force : options_.grip.grip_force;
  share_ = wanted_ > 0 ? robot::first_effort_share(grasp.effort) : 1.0;
}

void HandAct::close() {
  if (options_.grip.gather > 0) move(-options_.grip.gather, share_);
  move(options_.grip.overrun, share_);
  stopped_ = world_.hand_positions();
  if (share_ < 1) press(wanted_, share_);
  run_for(options_.grip.settle_time);
}

void HandAct::lift(double height, double duration) {
  RigidTransform X_TH = world_.X_WH();
  X_TH.translation().z() += height;
  world_.carry(X_TH, duration);
  while (!world_.carried()) step();
  run_for(options_.grip.settle_time);
}

simulation::RobotBodyReading HandAct::object() const { return world_.body(kFelt); }

geometry::RigidTransform HandAct::X_HO() const {
  return world_.X_WH().inverse(Eigen::Isometry) * world_.body(kFelt).X_WB *
         X_TB_start_.inverse(Eigen::Isometry) * X_TW_;
}

Eigen::VectorXd HandAct::all_joints() const {
  const std::vector<simulation::JointReading> readings = world_.joints();
  Eigen::VectorXd positions = hand_.all_positions(world_.hand_positions());
  for (std::size_t i = 0; i < hand_.model.joints.size(); ++i) {
    const auto found = std::find_if(readings.begin(), readings.end(), [&](const auto& one) {
      return one.name == hand_.model.joints[i].name;
    });
    if (found != readings.end()) positions[static_cast<Eigen::Index>(i)] = found->position;
  }
  return positions;
}

void HandAct::step() {
  world_.step();
  if (after_step) after_step();
  constexpr long kCheckEvery = 16;
  if (++steps_ % kCheckEvery == 0) check_budget(until_);
}

void HandAct::run_for(double seconds) {
  const double end = world_.time() + seconds - 0.5 * world_.options().step;
  while (world_.time() < end) step();
}

void HandAct::check_object(TouchOutcome outcome, const std::string& what) const {
  const RigidTransform X_TB = world_.body(kFelt).X_WB;
  if (!X_TB.matrix().allFinite()) throw ActEnds{outcome, "the object flies off"};
  const Eigen::Matrix3d turn = X_TB.linear() * X_TB_start_.linear().transpose();
  const double tilt = std::acos(std::clamp(turn(2, 2), -1.0, 1.0));
  if (tilt > options_.largest_tilt) {
    throw ActEnds{outcome,
                  fmt::format("the object {}: it tilts by {:.0f} degrees", what, tilt * kDegrees)};
  }
  if ((X_TB.translation() - X_TB_start_.translation()).norm() > kFarthest) {
    throw ActEnds{outcome, "the object is thrown out of the hand"};
  }
}

void HandAct::move(double beyond, double share) {
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

void HandAct::press(double wanted, double share) {
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

std::vector<PredictedPad> HandAct::read() const {
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

Eigen::Vector3d HandAct::center_of(const PredictedPad& pad,
                                   const contact::PadLayout& layout) const {
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

robot::MeanTouch HandAct::mean(const std::vector<PredictedPad>& pads) const {
  std::vector<robot::PadPercept> percepts;
  for (const PredictedPad& pad : pads) percepts.push_back({pad.sum, pad.area, 0});
  return robot::mean_touch(percepts, options_.grip.touch_force,
                           std::numeric_limits<double>::infinity());
}

RigidTransform hand_root(const robot::HandModel& hand, const GraspToFeel& grasp) {
  return grasp.X_WG * (hand.X_HP * hand.preshape(grasp.preshape).X_PG).inverse(Eigen::Isometry);
}

void check_act(const robot::HandModel& hand, const GraspToFeel& grasp, const ObjectToFeel& object) {
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

}  // namespace prehend::planning
