#include "eval/grasp/stability_trials.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <random>
#include <utility>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include "eval/grasp/in_reach.h"
#include "eval/grasp/trial_setup.h"
#include "eval/grasp/world_under_test.h"
#include "eval/household_objects.h"
#include "eval/resting_pose.h"
#include "prehend/control/cycle_in_world.h"
#include "prehend/control/planned_grasp.h"
#include "prehend/planning/platform_plan.h"

namespace prehend::eval {
namespace {

using control::Phase;
using geometry::RigidTransform;
using motion::SegmentKind;

constexpr int kPlans = 3;     // grasps with a motion, of each object
constexpr int kTries = 3;     // trials for each grasp that is to close
constexpr int kPatience = 4;  // trials, with objects that no pad meets
const std::string kHome = "grasp";
constexpr double kLeastRaised = 0.02;  // m, of what was lifted

// A cycle's grasp and lift, and no more.
const control::Task& only_lift() {
  static const control::Task task = control::parse_task(R"(
description: grasp and lift
start: look
states:
  look: {do: look, done: approach, otherwise: failure}
  approach: {do: approach, done: grasp, failed: failure}
  grasp: {do: grasp, done: lift, failed: failure}
  lift: {do: lift, done: success, otherwise: failure}
)",
                                                        "only_lift.yaml");
  return task;
}

simulation::TactileOptions pads(bool realistic, std::uint32_t seed) {
  simulation::TactileOptions tactile;
  if (!realistic) return tactile;
  tactile.sensor = simulation::TactileSensorOptions::realistic();
  tactile.sensor.seed = seed;
  tactile.foam = contact::FoamMemory::realistic();
  return tactile;
}

// Along the table: the part of the tool's axes that is level.
RigidTransform displaced(const Disturbance& by, const RigidTransform& X_WG,
                         const Eigen::Vector3d& middle) {
  Eigen::Vector3d shift = by.across * X_WG.linear().col(0) + by.along * X_WG.linear().col(1);
  shift.z() = 0;
  RigidTransform X = RigidTransform::Identity();
  X.linear() = Eigen::AngleAxisd(by.yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  X.translation() = middle + shift - X.linear() * middle;
  return X;
}

Disturbance drawn(std::mt19937& random) {
  std::uniform_real_distribution<double> unit(0, 1);
  const auto between = [&](double a, double b) { return a + (b - a) * unit(random); };
  Disturbance by;
  // A third is as planned, a third near, a third anyhow.
  const double much = unit(random) < 0.33 ? 0.0 : (unit(random) < 0.5 ? 0.5 : 1.0);
  by.across = much * between(-0.03, 0.03);
  by.along = much * between(-0.008, 0.008);
  by.yaw = much * between(-0.7, 0.7);
  if (unit(random) < 0.6 * much) by.depth = between(0.5, 1);
  const bool is_weak = unit(random) < 0.6;
  by.force = is_weak ? std::exp(between(std::log(0.03), std::log(0.6))) : between(0.6, 1);
  if (unit(random) < 0.3) by.mass = between(2, 4);
  if (unit(random) < 0.3) by.friction = between(0.3, 0.5);
  return by;
}

// What is gone of a planned grasp: to where it closes, and up.
control::ArmGrasp to_lift(control::ArmGrasp grasp, const Disturbance& by) {
  std::vector<std::pair<SegmentKind, control::JointTrajectory>> segments;
  for (auto& [kind, path] : grasp.segments) {
    if (kind == SegmentKind::kApproach) path = control::part_of(path, by.depth);
    if (kind == SegmentKind::kApproach || kind == SegmentKind::kLift) {
      segments.emplace_back(kind, std::move(path));
    }
  }
  grasp.segments = std::move(segments);
  grasp.force *= by.force;
  for (double& effort : grasp.largest_effort) effort *= by.force;
  return grasp;
}

const control::JointTrajectory& approach_of(const control::ArmGrasp& grasp) {
  return std::find_if(grasp.segments.begin(), grasp.segments.end(),
                      [](const auto& one) { return one.first == SegmentKind::kApproach; })
      ->second;
}

/// The object of a data set, as it rests, and the grasps that were planned for it.
struct PlannedObject {
  const DataSet* data_set;
  TrueObject truth;
  std::vector<control::ArmGrasp> grasps;
};

class StabilityRun {
 public:
  StabilityRun(const robot::Platform& platform) : platform_(platform), touch_(platform.hand) {}

  StabilityTrial run(const PlannedObject& object, const control::ArmGrasp& planned,
                     const Disturbance& by, bool realistic, std::uint32_t seed) {
    StabilityTrial trial;
    trial.object = object.data_set->name;
    trial.platform = platform_.name;
    trial.realistic = realistic;
    trial.disturbance = by;
    TrueObject truth = object.truth;
    const Eigen::Vector3d middle = geometry::bounds(truth.mesh_W).center();
    truth.mesh_W = geometry::transformed(truth.mesh_W, displaced(by, planned.pose.X_WG, middle));
    truth.mass *= by.mass;
    truth.friction = by.friction;
    const control::ArmGrasp grasp = to_lift(planned, by);
    robot::Platform standing = platform_;
    standing.homes.push_back({kHome, {}});
    const control::JointTrajectory& approach = approach_of(grasp);
    standing.homes.back().arm = platform_.homes.front().arm;
    for (std::size_t i = 0; i < approach.joints.size(); ++i) {
      standing.homes.back().arm[i] = approach.points.front().position[i];
    }
    const auto world = world_under_test(standing, kHome, truth, pads(realistic, seed));
    control::ArmCycleOptions options;
    options.task = only_lift();
    options.largest_attempts = 1;
    control::CycleInWorld cycle(world->robot(), options);
    const double rested = world->object().height;
    double start = 0;     // m, height of the hand when it had closed
    RigidTransform X_HB;  // then
    bool lifts = false;
    const auto watch = [&] {
      const bool lifts_now = cycle.cycle().phase() == Phase::kLift;
      if (lifts_now && !lifts) {
        X_HB = world->object().X_HB;
        start = height_of_hand(*world);
        trial.closed = felt(world->robot(), grasp);
      }
      if (lifts_now && trial.lifting.frames.empty() && height_of_hand(*world) > start + kAsked) {
        trial.lifting = felt(world->robot(), grasp);
      }
      if (lifts && !lifts_now) judge(world->object(), X_HB, rested, &trial);
      lifts = lifts_now;
    };
    cycle.run({{grasp}, ""}, nullptr, watch);
    trial.reason = cycle.cycle().result().reason;
    return trial;
  }

 private:
  static double height_of_hand(const WorldUnderTest& world) {
    const ObjectReading object = world.object();
    return (object.X_WB * object.X_HB.inverse()).translation().z();
  }

  touch::Grip felt(control::CycleWorld& robot, const control::ArmGrasp& grasp) const {
    return control::felt_grip(touch_, robot.percepts(robot::kTouchCounts), grasp.hand_joints,
                              robot.hand().positions());
  }

  void judge(const ObjectReading& now, const RigidTransform& X_HB_then, double rested,
             StabilityTrial* trial) const {
    // Of a gripper on its stage the hand is said in its frame G.
    RigidTransform X = RigidTransform::Identity();
    if (platform_.hand_port == robot::HandPort::kGripper) {
      X = (platform_.hand.X_HP * platform_.hand.preshapes.front().X_PG).inverse();
    }
    const std::vector<touch::PadContact>& contacts = trial->closed.contacts;
    if (contacts.empty()) return;
    Eigen::Vector3d center = Eigen::Vector3d::Zero();
    for (const touch::PadContact& contact : contacts) center += X * contact.p_H;
    center /= static_cast<double>(contacts.size());
    trial->slide = (now.X_HB * X_HB_then.inverse() * center - center).norm();
    trial->raised = now.height - rested;
    trial->held = trial->slide <= kMostSlide && trial->raised > kLeastRaised;
  }

  const robot::Platform& platform_;
  touch::HandTouch touch_;
};

// Of `left`, when so many are still to get something.
int share_of(int left, std::size_t takers) {
  return static_cast<int>(std::ceil(left / static_cast<double>(takers)));
}

std::vector<control::ArmGrasp> planned_grasps(const planning::PlatformPlanner& planner,
                                              const TrueObject& truth) {
  const robot::Platform& platform = planner.platform();
  planning::PlatformPlanOptions options(platform.hand);
  options.grasps.threads = 1;
  options.motions = kPlans;
  options.arm.pick.budget = 0;  // of wall time: plans would not be repeatable
  const planning::PlatformPlan plan = planner.plan(belief_of(truth.mesh_W, {}).object, {}, {}, {},
                                                   platform.home("home").arm, options);
  std::vector<control::ArmGrasp> grasps;
  for (const planning::PlannedPick& pick : plan.picks) {
    if (!pick.segments.empty()) grasps.push_back(control::arm_grasp(platform, pick));
  }
  return grasps;
}

}  // namespace

std::vector<StabilityTrial> run_stability_trials(
    const std::vector<std::filesystem::path>& platforms, const std::vector<DataSet>& objects,
    const StabilityTrialOptions& options, const std::function<void(const std::string&)>& progress) {
  std::vector<TrueObject> truths;
  for (const DataSet& set : objects) {
    const double mass = household_mass(geometry::mass_properties(*set.mesh_B).volume);
    const RigidTransform X_WB = resting_pose(*set.mesh_B, RigidTransform::Identity(), mass);
    truths.push_back({geometry::transformed(*set.mesh_B, X_WB), mass, {}});
  }
  std::vector<StabilityTrial> trials;
  for (std::size_t p = 0; p < platforms.size(); ++p) {
    const planning::PlatformPlanner planner(in_reach(robot::read_platform(platforms[p])));
    StabilityRun run(planner.platform());
    std::vector<PlannedObject> planned;
    for (std::size_t i = 0; i < objects.size(); ++i) {
      progress(fmt::format("{}: planning grasps of {}", planner.platform().name, objects[i].name));
      PlannedObject object{&objects[i], truths[i], planned_grasps(planner, truths[i])};
      if (!object.grasps.empty()) planned.push_back(std::move(object));
    }
    int here = options.grasps.at(p);
    const int most = 2 * share_of(here, std::max<std::size_t>(1, planned.size()));
    for (std::size_t i = 0; i < planned.size(); ++i) {
      std::mt19937 random(static_cast<std::uint32_t>(options.seed * 1000003 + p * 1009 + i));
      const int wanted = std::min(most, share_of(here, planned.size() - i));
      int counted = 0;
      for (int tries = 0; counted < wanted && tries < kTries * wanted; ++tries) {
        if (counted == 0 && tries == kPatience) break;
        const Disturbance by = drawn(random);
        const auto& grasps = planned[i].grasps;
        const auto& grasp = grasps[static_cast<std::size_t>(tries) % grasps.size()];
        const auto seed = static_cast<std::uint32_t>(random());
        trials.push_back(
            run.run(planned[i], grasp, by, options.realistic && counted % 2 == 1, seed));
        counted += trials.back().counts() ? 1 : 0;
      }
      here -= counted;
      progress(fmt::format("{}: {} of {} objects, {} trials", planner.platform().name, i + 1,
                           planned.size(), trials.size()));
    }
  }
  return trials;
}

}  // namespace prehend::eval
