// What the shipped cycle perceives, against what was foretold of the same grasp.

#include "prehend/control/percept_watch.h"

#include <functional>
#include <optional>
#include <string>

#include <gtest/gtest.h>

#include "prehend/belief/percept_forecast.h"
#include "prehend/belief/percept_surprise.h"
#include "prehend/control/arm_in_world.h"
#include "prehend/control/stage_in_world.h"
#include "prehend/simulation/shapes.h"
#include "prehend/simulation/stage_arm.h"
#include "tests/control/pick_of.h"

namespace prehend::control {
namespace {

constexpr double kPerceivedMass = 0.3;  // kg

geometry::TriangleMesh box_of(double width, double aside = 0) {
  geometry::RigidTransform X = geometry::RigidTransform::Identity();
  X.translation().x() = aside;
  return geometry::transformed(simulation::make_standing_box({width, width, 0.14}), X);
}

class PerceivedBox : public testing::TestWithParam<const char*> {
 protected:
  using Change = std::function<void(ArmPercepts&)>;

  PerceivedBox() : plan_(planned_.plan(box_of(0.05))) {}

  // One attempt at what is there, planned on the box of 50 mm.
  PerceptWatch watched(const geometry::TriangleMesh& mesh_W, const Change& change = nullptr) {
    PerceptWatch watch(planned_.platform());
    if (planned_.platform().hand_port == robot::HandPort::kGripper) {
      simulation::Scene scene = scene_with_wrist();
      scene.gripper = *planned_.platform().hand.gripper;
      scene.start_opening = scene.gripper.max_opening;
      scene.carrier = simulation::carrier_of(planned_.platform(), "side");
      simulation::World world(scene);
      world.add_object("thing", mesh_W, kPerceivedMass, false, 0.7);
      StageInWorld stage(world, planned_.platform(), "side");
      run(stage, change, &watch);
    } else {
      simulation::RobotWorld world(planned_.platform(), scene_with_wrist(), "side");
      world.add_object("thing", mesh_W, kPerceivedMass);
      ArmInWorld arm(world);
      run(arm, change, &watch);
    }
    return watch;
  }

  belief::PerceptSurprise surprise(const PerceptWatch& watch) {
    if (!forecast_) {
      forecast_ = belief::predict_percepts(planned_.platform().hand,
                                           planning::grasp_to_feel(plan_.picks.front().grasp),
                                           {{"box", {box_of(0.05), {}, kPerceivedMass}, 1}});
    }
    return belief::percept_surprise(*forecast_, watch.percepts(), model_);
  }

  /// More surprising than what comes true.
  void expect_surprise(const PerceptWatch& watch) {
    const belief::PerceptSurprise bits = surprise(watch);
    EXPECT_GT(bits.bits, surprise(watched(box_of(0.05))).bits + 10) << bits.to_string();
    EXPECT_TRUE(bits.alarm) << bits.to_string();
  }

  static simulation::Scene scene_with_wrist() {
    simulation::Scene scene;
    scene.wrench.emplace();
    scene.wrench->force_noise = 0.1;
    return scene;
  }

 private:
  void run(CycleWorld& world, const Change& change, PerceptWatch* watch) {
    ArmCycleOptions options = reacting();
    options.largest_attempts = 1;
    CycleInWorld in_world(world, options);
    in_world.run(planned_.to_try(plan_), nullptr, [&] {
      ArmPercepts percepts = in_world.percepts();
      if (change) change(percepts);
      watch->step(in_world.cycle(), percepts);
    });
  }

  const PickOf planned_{GetParam()};
  const planning::PlatformPlan plan_;
  const belief::SurpriseModel model_ = belief::SurpriseModel::load_for(
      "config/touch/percept_surprise", planned_.platform().hand.name);
  std::optional<belief::PerceptForecast> forecast_;
};

TEST_P(PerceivedBox, IsNoSurpriseWhereItIsAsForetold) {
  const PerceptWatch watch = watched(box_of(0.05));
  ASSERT_EQ(watch.concluded(), 1);
  EXPECT_EQ(watch.grasp_index(), 0);
  const belief::Percepts& percepts = watch.percepts();
  ASSERT_TRUE(percepts.weight.has_value());
  EXPECT_NEAR(*percepts.weight, kPerceivedMass * 9.81, 0.3);
  for (const belief::PerceivedMotor& motor : percepts.motors) {
    EXPECT_TRUE(motor.at[belief::kLifted].has_value()) << motor.name;
  }
  const belief::PerceptSurprise bits = surprise(watch);
  EXPECT_FALSE(bits.alarm) << bits.to_string();
}

TEST_P(PerceivedBox, SurprisesWhereNothingIs) {
  const PerceptWatch watch = watched(box_of(0.05, 0.5));
  ASSERT_EQ(watch.concluded(), 1) << "the hand has closed, on nothing";
  EXPECT_FALSE(watch.percepts().wrist[belief::kLifted].has_value()) << "it did not lift";
  expect_surprise(watch);
}

TEST_P(PerceivedBox, SurprisesWhereItIsThinner) { expect_surprise(watched(box_of(0.025))); }

TEST_P(PerceivedBox, LeavesOutWhatThereIsNoSensorFor) {
  const PerceptWatch watch = watched(box_of(0.05), [](ArmPercepts& percepts) {
    percepts.wrist_torque.reset();
    percepts.frames.clear();
  });
  ASSERT_EQ(watch.concluded(), 1);
  EXPECT_FALSE(watch.percepts().closing.has_value());
  EXPECT_FALSE(watch.percepts().weight.has_value());
  for (const belief::PerceivedPad& pad : watch.percepts().pads) {
    EXPECT_TRUE(pad.at[belief::kClosed].texels.empty()) << pad.name;
  }
  for (const belief::SenseSurprise& sense : surprise(watch).senses) {
    EXPECT_TRUE(sense.sense == "joints" || sense.sense == "time") << sense.sense;
  }
  EXPECT_EQ(watched(box_of(0.05),
                    [](ArmPercepts& percepts) {
                      percepts.names.clear();
                      percepts.positions.clear();
                    })
                .concluded(),
            0)
      << "nothing says where the hand is";
}

INSTANTIATE_TEST_SUITE_P(Platforms, PerceivedBox,
                         testing::Values("stage_pg70", "kr5_pg70", "kr5_sdh", "pa10_barrett"));

}  // namespace
}  // namespace prehend::control
