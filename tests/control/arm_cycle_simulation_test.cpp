// The cycle of arm and hand in simulation, along a plan written by hand: KR5 with SDH-2 and PA10
// with BarrettHand.

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "prehend/control/arm_in_world.h"
#include "prehend/control/cycle_in_world.h"
#include "prehend/planning/touch_prediction.h"
#include "prehend/robot/inverse_kinematics.h"
#include "prehend/robot/platform.h"
#include "prehend/simulation/robot_world.h"
#include "prehend/simulation/shapes.h"
#include "tests/grasp/hand_scene.h"

namespace prehend::control {
namespace {

using geometry::RigidTransform;

/// From a stand at `from` to a stand at `to`, by way of `between` poses of the tool: as many points
/// of inverse kinematics as make straight lines straight.
class PlanByHand {
 public:
  PlanByHand(const robot::Platform& platform, const robot::Preshape& preshape)
      : platform_(platform),
        preshape_(preshape),
        inverse_(platform.arm_chain()),
        q_(platform.homes.front().arm) {}

  JointTrajectory jump(const RigidTransform& X_WG) {
    const robot::Positions from = q_;
    move_to(X_WG);
    return timed({from, q_}, 3.0);
  }
  JointTrajectory straight(const RigidTransform& X_WG_from, const RigidTransform& X_WG_to) {
    std::vector<robot::Positions> way{q_};
    constexpr int kParts = 12;
    for (int i = 1; i <= kParts; ++i) {
      RigidTransform X = X_WG_to;
      const double share = static_cast<double>(i) / kParts;
      X.translation() = (1 - share) * X_WG_from.translation() + share * X_WG_to.translation();
      move_to(X);
      way.push_back(q_);
    }
    return timed(way, 2.0);
  }

 private:
  void move_to(const RigidTransform& X_WG) {
    const robot::InverseAnswer answer = inverse_.solve(platform_.X_BF(X_WG, preshape_), q_);
    if (answer.solutions.empty()) throw std::runtime_error(answer.reason);
    q_ = answer.solutions.front();
  }
  // Points at even shares of a smooth motion, with its velocities.
  JointTrajectory timed(const std::vector<robot::Positions>& way, double duration) const {
    JointTrajectory result;
    for (const robot::ChainJoint& joint : inverse_.chain().joints()) {
      result.joints.push_back(joint.name);
    }
    const std::size_t parts = way.size() - 1;
    for (int k = 0; k <= 40; ++k) {
      const double t = k / 40.0, s = t * t * t * (10 + t * (6 * t - 15));
      const double rate = 30 * t * t * (1 - t) * (1 - t) / duration;
      const double x = s * static_cast<double>(parts);
      const std::size_t i = std::min(parts - 1, static_cast<std::size_t>(x));
      JointTrajectory::Point point;
      point.time = t * duration;
      const robot::Positions delta = way[i + 1] - way[i];
      for (Eigen::Index j = 0; j < delta.size(); ++j) {
        point.position.push_back(way[i][j] + (x - static_cast<double>(i)) * delta[j]);
        point.velocity.push_back(rate * static_cast<double>(parts) * delta[j]);
      }
      result.points.push_back(point);
    }
    return result;
  }

  const robot::Platform& platform_;
  const robot::Preshape& preshape_;
  robot::InverseKinematics inverse_;
  robot::Positions q_;
};

struct PlatformSetup {
  const char* platform;
  const char* preshape;
  bool reacts;
  double height;  // m, of the tool over the table when it closes
  double way;     // rad, that motors close as planned
};

class InSimulation : public testing::TestWithParam<PlatformSetup> {
 protected:
  explicit InSimulation(double mass = 0.4) {
    world.add_object("box", box, mass);
    RigidTransform at = RigidTransform::Identity();
    at.linear() = Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX()).toRotationMatrix();
    at.translation() = Eigen::Vector3d(0, 0, setup.height);
    const auto over = [&](double y, double dz) {
      RigidTransform X = at;
      X.translation() += Eigen::Vector3d(0, y, dz);
      return X;
    };
    X_WG = at;
    const robot::Preshape& preshape = platform.hand.preshape(setup.preshape);
    PlanByHand plan(platform, preshape);
    using motion::SegmentKind;
    grasp.segments.emplace_back(SegmentKind::kReach, plan.jump(over(0, 0.12)));
    grasp.segments.emplace_back(SegmentKind::kApproach, plan.straight(over(0, 0.12), over(0, 0)));
    grasp.segments.emplace_back(SegmentKind::kLift, plan.straight(over(0, 0), over(0, 0.1)));
    grasp.segments.emplace_back(SegmentKind::kCarry, plan.straight(over(0, 0.1), over(0.15, 0.1)));
    grasp.segments.emplace_back(SegmentKind::kPlace,
                                plan.straight(over(0.15, 0.1), over(0.15, 0.002)));
    grasp.segments.emplace_back(SegmentKind::kRetreat,
                                plan.straight(over(0.15, 0.002), over(0.15, 0.12)));
    grasp.hand_joints = platform.hand.actuated_names();
    Eigen::VectorXd closed = preshape.open;
    for (int i = 0; i < platform.hand.size(); ++i) {
      closed[i] += setup.way * preshape.closing[static_cast<std::size_t>(i)].rate;
    }
    grasp.hand = robot::closing_way(platform.hand, preshape, preshape.open, closed);
    grasp.lifted_mass = 0.4;
  }

  /// Runs to the end; after each step of the cycle `also` is called.
  void run(CycleInWorld& in_world, const std::function<void()>& also = nullptr) {
    in_world.run({{grasp}, ""}, nullptr, [&] {
      highest = std::max(highest, world.body("box").height);
      if (also) also();
    });
  }
  ArmCycleOptions options() const {
    ArmCycleOptions made;
    made.reacts = setup.reacts;
    return made;
  }

  const PlatformSetup setup = GetParam();
  const robot::Platform platform =
      robot::read_platform(std::string("config/robots/") + setup.platform);
  const geometry::TriangleMesh box = simulation::make_standing_box({0.06, 0.06, 0.14});
  simulation::RobotWorld world{platform, simulation::Scene()};
  ArmInWorld arm{world};
  RigidTransform X_WG = RigidTransform::Identity();  // of the grasp
  ArmGrasp grasp;
  double highest = 0;  // m, of the box
};

TEST_P(InSimulation, PicksABoxAndPutsItDown) {
  CycleInWorld in_world(arm, options());
  run(in_world);
  const ArmCycle& cycle = in_world.cycle();
  EXPECT_TRUE(cycle.result().success()) << cycle.result().reason;
  EXPECT_GT(highest, 0.09);
  for (int i = 0; i < 500; ++i) world.step();
  const simulation::RobotBodyReading put = world.body("box");
  EXPECT_NEAR(put.X_WB.translation().y(), 0.15, 0.02);
  EXPECT_LT(put.height, 0.003);
  EXPECT_TRUE(put.touches_table);
  EXPECT_FALSE(put.touches_robot);
  for (const Surprise& surprise : cycle.surprises()) {
    if (surprise.kind != SurpriseKind::kLiftedWeight) continue;
    EXPECT_NEAR(surprise.felt, 0.4 * 9.81, 0.3);
  }
}

// Regressions: a weight at a guessed density was asked for, and an overrun beyond the joints'
// limits was refused.
TEST_P(InSimulation, HoldsWhatIsMuchLighterThanGuessedWithAnyOverrun) {
  grasp.lifted_mass = 4;
  ArmCycleOptions far = options();
  far.overrun = 2.5;
  CycleInWorld in_world(arm, far);
  run(in_world);
  const ArmCycle& cycle = in_world.cycle();
  EXPECT_TRUE(cycle.result().success()) << cycle.result().reason;
  EXPECT_LT(world.body("box").height, 0.003);
}

// Regression: success was said without an object.
TEST_P(InSimulation, ABoxThatFallsWhileItIsCarriedIsNoticed) {
  CycleInWorld in_world(arm, options());
  const ArmCycle& cycle = in_world.cycle();
  bool gone = false;
  run(in_world, [&] {
    if (gone || cycle.detail() != "arm: carry") return;
    gone = true;
    RigidTransform elsewhere = RigidTransform::Identity();
    elsewhere.translation() = Eigen::Vector3d(0.2, -0.3, 0);
    world.place_object("box", elsewhere);
  });
  EXPECT_TRUE(gone);
  EXPECT_FALSE(cycle.result().success());
  EXPECT_NE(cycle.result().reason.find("lost while carrying"), std::string::npos)
      << cycle.result().reason;
  EXPECT_TRUE(std::any_of(cycle.surprises().begin(), cycle.surprises().end(), [](const auto& s) {
    return s.kind == SurpriseKind::kHeldWhileCarried && s.surprising;
  }));
}

// It slips out of the hand while it is lifted.
TEST_P(InSimulation, WhatIsTooSlipperyIsNoticed) {
  world.add_object("box", box, 2, false, 0.02);
  ArmCycleOptions once = options();
  once.largest_attempts = 1;
  CycleInWorld in_world(arm, once);
  run(in_world);
  const ArmCycle& cycle = in_world.cycle();
  EXPECT_FALSE(cycle.result().success()) << cycle.result().reason;
  EXPECT_LT(world.body("box").height, 0.003);
  EXPECT_TRUE(std::any_of(cycle.surprises().begin(), cycle.surprises().end(), [](const auto& s) {
    return (s.kind == SurpriseKind::kSlip || s.kind == SurpriseKind::kHeldAfterLift) &&
           s.surprising;
  }));
}

class BesideTheMiddle : public InSimulation {
 protected:
  /// How far the box is pushed until the lift begins [m].
  double push(double gather) {
    simulation::RobotWorld fresh(platform, simulation::Scene());
    fresh.add_object("box", beside, 0.4);
    const Eigen::Vector3d start = fresh.body("box").X_WB.translation();
    ArmCycleOptions gathering = options();
    gathering.gather = gather;
    ArmInWorld fresh_arm(fresh);
    CycleInWorld in_world(fresh_arm, gathering);
    std::optional<double> pushed;
    in_world.run({{grasp}, ""}, nullptr, [&] {
      if (pushed || in_world.cycle().phase() != Phase::kLift) return;
      pushed = (fresh.body("box").X_WB.translation() - start).norm();
    });
    EXPECT_TRUE(in_world.cycle().result().success()) << in_world.cycle().result().reason;
    return pushed.value_or(-1);
  }

  const geometry::TriangleMesh beside = grasp::moved(box, Eigen::Vector3d(0, 0.02, 0));
};

TEST_P(BesideTheMiddle, GatheredFingersDoNotPush) {
  const grasp::TouchedMesh touched(beside);
  const grasp::TestHand hand(platform.hand.name);
  const robot::Preshape& shape = hand.model.preshape(setup.preshape);
  const grasp::ClosedFingers met =
      hand.close(setup.preshape, X_WG * (hand.model.X_HP * shape.X_PG).inverse(), touched.scene);
  Eigen::VectorXd closed(hand.model.size());
  for (int i = 0; i < hand.model.size(); ++i) {
    closed[i] = met.all[hand.model.actuated[static_cast<std::size_t>(i)]];
  }
  grasp.hand = robot::closing_way(platform.hand, shape, shape.open, closed);
  const double gathered = push(0.1), at_once = push(0);
  EXPECT_GE(gathered, 0);
  EXPECT_LT(gathered, 0.4 * at_once);
  EXPECT_GT(at_once, 0.01);
}

// What is predicted on the true shape, by a hand alone in coarser steps, is what the arm's hand
// feels.
class FeltInSimulation : public InSimulation {
 protected:
  void expect_felt_as_predicted(double force) {
    grasp.force = force;
    grasp.effort = 0.3;
    for (const int joint : platform.hand.actuated) {
      grasp.largest_effort.push_back(
          platform.hand.model.joints[static_cast<std::size_t>(joint)].max_effort);
    }
    const planning::PredictedTouch touch = planning::predict_touch(
        platform.hand,
        {X_WG, setup.preshape, grasp.hand.open, grasp.hand.closed, force, grasp.effort},
        {box, {}, 0.4});
    ASSERT_EQ(touch.outcome, planning::TouchOutcome::kPredicted) << touch.problem;
    grasp.contact_area = touch.mean.area;
    grasp.tactile_sum = touch.mean.sum;
    grasp.closure = grasp.hand.closure(touch.stopped);
    CycleInWorld in_world(arm, options());
    run(in_world);
    const ArmCycle& cycle = in_world.cycle();
    EXPECT_TRUE(cycle.result().success()) << cycle.result().reason;
    int compared = 0;
    for (const Surprise& surprise : cycle.surprises()) {
      const bool touches =
          surprise.kind == SurpriseKind::kContactArea || surprise.kind == SurpriseKind::kTactileSum;
      compared += touches ? 1 : 0;
      if (touches) {
        EXPECT_NEAR(surprise.felt, surprise.predicted, 0.1 * surprise.predicted);
      }
      if (surprise.kind != SurpriseKind::kFingersAtContact) continue;
      EXPECT_NEAR(surprise.felt, surprise.predicted, 0.01);
    }
    EXPECT_EQ(compared, 2);
  }
};

TEST_P(FeltInSimulation, AsPredictedWhenTheMotorsPress) { expect_felt_as_predicted(0); }

TEST_P(FeltInSimulation, AsPredictedWhenThePadsAreToFeelAForce) { expect_felt_as_predicted(8); }

INSTANTIATE_TEST_SUITE_P(
    Platforms, InSimulation,
    testing::Values(PlatformSetup{"kr5_sdh.yaml", "parallel", false, 0.09, 0.3},
                    PlatformSetup{"pa10_barrett.yaml", "spread_0", true, 0.09, 1.0}));

INSTANTIATE_TEST_SUITE_P(Platforms, BesideTheMiddle,
                         testing::Values(PlatformSetup{"pa10_barrett.yaml", "spread_0", true, 0.09,
                                                       1.0}));

INSTANTIATE_TEST_SUITE_P(Platforms, FeltInSimulation,
                         testing::Values(PlatformSetup{"kr5_sdh.yaml", "parallel", false, 0.09,
                                                       0.3},
                                         PlatformSetup{"kr5_sdh.yaml", "pinch", true, 0.09, 0.3}));

}  // namespace
}  // namespace prehend::control
