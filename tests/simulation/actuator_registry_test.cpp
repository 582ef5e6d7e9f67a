// Actuators by name, another project's among them.

#include <cmath>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "prehend/geometry/errors.h"
#include "prehend/simulation/actuator_registry.h"
#include "tests/simulation/flap.h"

namespace prehend::simulation {
namespace {

using robot::JointMode;
using ::testing::AllOf;
using testing::Flap;
using ::testing::HasSubstr;
using testing::joint;
using testing::run_for;

class AnotherProjectsActuator : public ::testing::Test {
 protected:
  AnotherProjectsActuator() { setenv("PREHEND_ACTUATORS", PREHEND_ACTUATOR_EXAMPLE, 1); }
  ~AnotherProjectsActuator() override { unsetenv("PREHEND_ACTUATORS"); }
};

std::string trouble_of(const std::string& motor) {
  try {
    Flap("motor: {" + motor + "}\n").world();
  } catch (const geometry::InputError& error) {
    return error.what();
  }
  return "";
}

TEST(ActuatorRegistry, KnowsItsOwnAndSaysWhatThereIs) {
  const ActuatorRegistry registry(std::vector<std::filesystem::path>{});
  EXPECT_EQ(registry.names(), std::vector<std::string>{"dc_motor"});
  EXPECT_EQ(registry.create("dc_motor")->name(), "dc_motor");
  try {
    registry.create("dc_motr");
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(), HasSubstr("the nearest is 'dc_motor'"));
  }
}

TEST(ActuatorRegistry, FilesErrorsNameLineKeyAndMend) {
  const std::string most =
      "supply: 12, resistance: 2, torque_constant: 0.02, gear_ratio: 50, rotor_inertia: 1e-6";
  const std::string good = most + ", nominal_current: 1.8";
  ASSERT_EQ(trouble_of("hinge: {" + good + "}"), "");
  const auto at = [](const char* words) {
    return AllOf(HasSubstr("flap.yaml:7: hand.motor.hinge"), HasSubstr(words));
  };
  EXPECT_THAT(trouble_of("hinge: {" + most + "}"), at("'nominal_current' is missing"));
  EXPECT_THAT(trouble_of("hinge: {" + good + ", suply: 3}"),
              at("dc_motor has no 'suply'; did you mean \"supply\"?"));
  EXPECT_THAT(trouble_of("hinge: {actuator: dc_motr, " + good + "}"), at("'dc_motor'"));
  EXPECT_THAT(trouble_of("hinge: {" + good + ", efficiency: 1.5}"), at("efficiency must be"));
  EXPECT_THAT(trouble_of("hinge: {" + good + ", spindle_lead: 0.01}"), at("the joint turns"));
  EXPECT_THAT(trouble_of("hinge: {" + good + ", friction: -1}"), at("friction must be"));
  EXPECT_THAT(trouble_of("hinge: {" + good + ", friction: much}"), HasSubstr("flap.yaml:7"));
  EXPECT_THAT(trouble_of("hinge: {" + good + ", friction: .nan}"), HasSubstr("flap.yaml:7"));
  EXPECT_THAT(trouble_of("hing: {" + good + "}"), HasSubstr("hinge"));
  EXPECT_THAT(trouble_of("slide: {" + good + "}"), HasSubstr("spindle_lead must be"));
  EXPECT_THAT(trouble_of("hinge: 3"), HasSubstr("flap.yaml:7"));
}

TEST_F(AnotherProjectsActuator, IsFoundByItsName) {
  EXPECT_THAT(ActuatorRegistry().names(), ::testing::ElementsAre("dc_motor", "series_elastic"));
  EXPECT_THAT(trouble_of("hinge: {actuator: series_elastic}"), HasSubstr("'stiffness' is missing"));
  EXPECT_THAT(trouble_of("hinge: {actuator: series_elastic, stiffness: 0}"),
              HasSubstr("stiffness must be positive"));
}

// On its side the flap's weight bends the spring: k (q - q_ref) = -m g d cos q.
TEST_F(AnotherProjectsActuator, HoldsAWeightByItsSpring) {
  const Flap flap("motor: {hinge: {actuator: series_elastic, stiffness: 2, damping: 0.02}}\n");
  RobotWorld world = flap.world(1e-3, M_PI / 2);
  for (const double reference : {0.0, 0.5, -0.7}) {
    world.command_hand({JointMode::kPosition, {0}, {reference}});
    run_for(world, 3);
    const double q = joint(world, 0).position;
    EXPECT_NEAR(2 * (q - reference), -Flap::kFlapMass * 9.81 * 0.1 * std::cos(q), 1e-4);
    EXPECT_LT(q, reference - 0.02);
  }
}

// After a step of the motor the flap swings by sqrt(k / I).
TEST_F(AnotherProjectsActuator, SwingsByItsSpring) {
  const Flap flap("motor: {hinge: {actuator: series_elastic, stiffness: 2}}\n");
  RobotWorld world = flap.world(1e-4);
  world.command_hand({JointMode::kPosition, {0}, {0.2}});
  run_for(world, 0.1);
  const double period = 2 * M_PI * std::sqrt(Flap::kFlapInertia / 2);
  std::vector<double> turns;  // s
  double before = joint(world, 0).velocity;
  while (turns.size() < 9) {
    world.step();
    ASSERT_LT(world.time(), 3);
    const double v = joint(world, 0).velocity;
    if (v * before < 0) turns.push_back(world.time());
    before = v;
  }
  EXPECT_NEAR((turns.back() - turns.front()) / 4, period, 0.005 * period);
}

TEST_F(AnotherProjectsActuator, EffortIsItsSpringsAndVoltageIsRefused) {
  const Flap flap("motor: {hinge: {actuator: series_elastic, stiffness: 50}}\n");
  RobotWorld world = flap.world(1e-4);
  world.command_hand({JointMode::kEffort, {0}, {0.2}});
  run_for(world, 0.02);
  EXPECT_NEAR(joint(world, 0).velocity, 0.2 * 0.02 / Flap::kFlapInertia, 0.2);
  try {
    world.command_hand({JointMode::kVoltage, {0}, {1}});
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(), HasSubstr("series_elastic of 'hinge' takes no voltage"));
  }
}

TEST_F(AnotherProjectsActuator, ItsStateIsTheWorlds) {
  const Flap flap("motor: {hinge: {actuator: series_elastic, stiffness: 2}}\n");
  RobotWorld world = flap.world();
  world.command_hand({JointMode::kVelocity, {0}, {1}});
  run_for(world, 0.2);
  const auto saved = world.save();
  run_for(world, 0.3);
  const double q = joint(world, 0).position;
  run_for(world, 0.5);
  world.restore(*saved);
  run_for(world, 0.3);
  EXPECT_EQ(joint(world, 0).position, q);
}

}  // namespace
}  // namespace prehend::simulation
