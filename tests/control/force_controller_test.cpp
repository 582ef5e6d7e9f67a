#include "prehend/control/force_controller.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include <gtest/gtest.h>

namespace prehend::control {
namespace {

// f = force_per_current u - b, without delay but for one sample.
struct StaticPlant {
  double force_per_current = 30;
  double loss = 8;  // N
  double force = 0;
  void apply(double current) { force = std::max(0.0, force_per_current * current - loss); }
};

TEST(ForceController, ErrorDecaysAsTheClosedForm) {
  ForceControllerOptions options;
  options.force_rate = 1e9;
  options.tolerance = 1e-9;
  options.largest_current = 10;
  options.proportional_gain = 0.4;
  options.integral_gain = 4;
  ForceController controller(options);
  StaticPlant plant;
  controller.start(20, 20);
  const double dt = 1e-4;
  // e(t) = b / (1 + Kp) exp(-Ki t / (1 + Kp)) once the one sample of delay has died out.
  double time = 0;
  for (int i = 1; i <= 10000; ++i) {
    plant.apply(controller.update(plant.force, dt));
    time += dt;
    if (i % 1000 == 0) {
      const double expected = 8 / 1.4 * std::exp(-4 * time / 1.4);
      EXPECT_NEAR(20 - plant.force, expected, 0.01 * 8) << time;
    }
  }
}

TEST(ForceController, DryFrictionLeavesNoError) {
  for (double loss : {0.0, 3.0, 8.0, 15.0}) {
    ForceController controller(ForceControllerOptions{});
    StaticPlant plant;
    plant.loss = loss;
    controller.start(15, 0.3);
    for (int i = 0; i < 300; ++i) plant.apply(controller.update(plant.force, 0.01));
    EXPECT_TRUE(controller.settled()) << loss;
    EXPECT_NEAR(plant.force, 15, 0.05 * 15 + 1e-9) << loss;
  }
}

TEST(ForceController, DoesNotOvershootMuch) {
  ForceController controller(ForceControllerOptions{});
  StaticPlant plant;
  plant.loss = 0;
  controller.start(15, 0.3);
  double most = 0;
  for (int i = 0; i < 300; ++i) {
    plant.apply(controller.update(plant.force, 0.01));
    most = std::max(most, plant.force);
  }
  EXPECT_LT(most, 1.15 * 15);
}

TEST(ForceController, ReferenceRisesAtItsRate) {
  ForceControllerOptions options;
  options.force_rate = 50;
  ForceController controller(options);
  controller.start(20, 0);
  for (int i = 0; i < 10; ++i) controller.update(0, 0.01);
  EXPECT_NEAR(controller.reference(), 5, 1e-9);
  EXPECT_FALSE(controller.settled());
}

TEST(ForceController, DoesNotWindUpAtTheLimit) {
  ForceControllerOptions options;
  options.largest_current = 1;
  ForceController controller(options);
  // A jaw that feels nothing for 20 s, then all at once what the current gives.
  controller.start(20, 0);
  for (int i = 0; i < 2000; ++i) EXPECT_LE(controller.update(0, 0.01), 1.0);
  StaticPlant plant;
  plant.loss = 0;
  plant.apply(controller.current());
  for (int i = 0; i < 100; ++i) plant.apply(controller.update(plant.force, 0.01));
  EXPECT_NEAR(plant.force, 20, 0.05 * 20 + 1e-9);
}

TEST(ForceController, NonsenseLeavesTheCommand) {
  ForceController controller(ForceControllerOptions{});
  controller.start(10, 1);
  const double before = controller.update(1, 0.01);
  EXPECT_EQ(controller.update(std::numeric_limits<double>::quiet_NaN(), 0.01), before);
  EXPECT_EQ(controller.update(1, 0), before);
  EXPECT_EQ(controller.update(1, -1), before);
  EXPECT_THROW(controller.start(0, 0), std::invalid_argument);
  EXPECT_THROW(controller.start(std::numeric_limits<double>::infinity(), 0), std::invalid_argument);
  ForceControllerOptions options;
  options.largest_current = options.least_current;
  EXPECT_THROW(ForceController{options}, std::invalid_argument);
}

}  // namespace
}  // namespace prehend::control
