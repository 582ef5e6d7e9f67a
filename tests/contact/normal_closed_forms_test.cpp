// Normal contact against closed forms: static load, oscillator, Winkler foundation, coverage.

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "prehend/contact/pad_readings.h"
#include "prehend/contact/parallel_grasp.h"
#include "slabs.h"

namespace prehend::contact {
namespace {

using namespace testing;

TEST(NormalClosedForms, StaticLoad) {
  for (const double mass : {0.01, 0.3, 10.0}) {
    for (const Integration integration : {Integration::kFirstOrder, Integration::kSecondOrder}) {
      GraspStepper stepper(slab({.mass = mass}), steps_of(1e-3, integration));
      stepper.advance(4);
      const double weight = mass * kGravity;
      EXPECT_NEAR(stepper.system().pad_force(stepper.state(), 0), weight, 1e-9 * weight);
      EXPECT_NEAR(depth(stepper), weight / (84 * 1000.0), 1e-9 * weight / 84e3) << mass;
    }
  }
}

// A lightly damped slab, pushed 40 % beyond its rest.
GraspStepper oscillator(double h, Integration integration) {
  SlabOptions options;
  options.mass = 1;
  options.law.damping = 0.05;
  options.height = -1.4 * options.mass * kGravity / 84e3;
  return GraspStepper(slab(options), steps_of(h, integration));
}
constexpr double kStiffness = 84e3, kDamping = 84 * 0.05;
constexpr double kDecay = kDamping / 2;

double exact_deviation(double t) {
  const double w = std::sqrt(kStiffness - kDecay * kDecay);
  return 0.4 * kGravity / kStiffness * std::exp(-kDecay * t) *
         (std::cos(w * t) + kDecay / w * std::sin(w * t));
}

TEST(NormalClosedForms, DampedOscillatorsFrequencyAndDecrement) {
  GraspStepper stepper = oscillator(5e-5, Integration::kSecondOrder);
  const double rest = kGravity / kStiffness;
  std::vector<double> crossings, peaks;
  double before = depth(stepper) - rest, peak = before;
  while (crossings.size() < 11) {
    stepper.step(1);
    const double now = depth(stepper) - rest;
    peak = std::max(peak, now);
    if (before < 0 && now >= 0) {
      crossings.push_back(stepper.state().time - 5e-5 * now / (now - before));
      if (crossings.size() > 1) peaks.push_back(peak);
      peak = 0;
    }
    before = now;
  }
  const double w = std::sqrt(kStiffness - kDecay * kDecay);
  const double period = (crossings.back() - crossings.front()) / 10;
  EXPECT_NEAR(period, 2 * std::numbers::pi / w, 1e-3 * period);
  const double decrement = std::log(peaks.front() / peaks.back()) / 9;
  EXPECT_NEAR(decrement, kDecay * 2 * std::numbers::pi / w, 0.01 * decrement);
}

TEST(NormalClosedForms, SecondOrderStepIsOfSecondOrderAndFirstOfFirst) {
  const auto error = [](double h, Integration integration) {
    GraspStepper stepper = oscillator(h, integration);
    stepper.advance(0.05);
    return std::abs(depth(stepper) - kGravity / kStiffness - exact_deviation(0.05));
  };
  const double second =
      std::log2(error(4e-4, Integration::kSecondOrder) / error(2e-4, Integration::kSecondOrder));
  EXPECT_GE(second, 1.8);
  const double first =
      std::log2(error(2e-6, Integration::kFirstOrder) / error(1e-6, Integration::kFirstOrder));
  EXPECT_NEAR(first, 1, 0.1);
}

TEST(NormalClosedForms, SphereOnAWinklerFoundation) {
  const double radius = 0.05, indentation = 1e-3;
  GraspModel model = slab({});
  model.shape = Shape::sphere(radius);
  model.body_is_fixed = true;
  model.X_WB.translation().z() = radius - indentation;
  GraspStepper stepper(model, steps_of(1e-3));
  stepper.advance(2e-3);
  double expected = 0;
  const PadLayout& pad = stepper.system().model().pads[0].layout;
  for (std::size_t i = 0; i < pad.size(); ++i) {
    const double r2 = pad.x[i] * pad.x[i] + pad.y[i] * pad.y[i];
    expected += std::max(0.0, 1000 * (indentation - (radius - std::sqrt(radius * radius - r2))));
  }
  EXPECT_NEAR(stepper.system().pad_force(stepper.state(), 0), expected, 1e-9 * expected);
  // Integral of (indentation - sag) over the touched disc, by the volume of a spherical cap.
  const double volume = std::numbers::pi * indentation * indentation * (radius - indentation / 3);
  const double integral = 1000 / kReferenceTexelArea * volume;
  RecordProperty("sensor_resolution_percent", std::to_string(100 * (expected / integral - 1)));
  EXPECT_NEAR(expected, integral, 0.03 * integral) << "3.4 mm texels under a 20 mm wide touch";
  // Finer texels come nearer.
  model.pads[0].layout = PadLayout::flat(refined({}, 8));
  GraspStepper fine(model, steps_of(1e-3));
  fine.advance(2e-3);
  EXPECT_NEAR(fine.system().pad_force(fine.state(), 0), integral, 1e-3 * integral);
}

// A jaw presses its pad on a fixed box that covers some of its rows.
class Coverage : public ::testing::TestWithParam<int> {};
TEST_P(Coverage, StiffnessIsThatOfTheTouchedTexelsAndTheForceIsTheDrives) {
  const int rows = GetParam();
  const double force = 5;
  for (const int factor : {1, 2, 5}) {
    ParallelGraspOptions options;
    options.pad = refined({}, factor);
    options.box_size.z() = 0.1;
    GraspModel model = parallel_grasp(options);
    model.body_is_fixed = true;
    // The box's top edge is between two rows.
    const double edge = -0.5 * 14 * 0.0034 + rows * 0.0034;
    model.X_WB.translation().z() = edge - 0.05;
    GraspStepper stepper(model, steps_of(1e-3));
    stepper.system().set_command(0, {.force = force}, 0);
    stepper.system().set_command(1, {.force = force}, 0);
    stepper.advance(4);
    const GraspState& state = stepper.state();
    EXPECT_NEAR(stepper.system().pad_force(state, 0), force, 1e-9 * force);
    EXPECT_NEAR(state.slide_position[0] - 0.005, force / (rows * 6 * 1000.0), 1e-12)
        << rows << " rows, each texel divided into " << factor << " x " << factor;
    EXPECT_NEAR(stepper.system().pad_force(state, 1), stepper.system().pad_force(state, 0),
                1e-12 * force);
  }
}
// 15, 30, 60 and 100 % of 14 rows, to the nearest row.
INSTANTIATE_TEST_SUITE_P(FifteenToHundredPercent, Coverage, ::testing::Values(2, 4, 8, 14));

TEST(NormalClosedForms, OppositePadsFeelTheSame) {
  ParallelGraspOptions options;
  GraspModel model = parallel_grasp(options);
  model.gravity.setZero();
  GraspStepper stepper(model, steps_of(1e-3));
  stepper.system().set_command(0, {.force = 20}, 0);
  stepper.system().set_command(1, {.force = 20}, 0);
  stepper.advance(2);
  const auto& left = stepper.state().pads[0].normal_force;
  const auto& right = stepper.state().pads[1].normal_force;
  for (std::size_t i = 0; i < 84; ++i) EXPECT_NEAR(left[i], right[i], 1e-12 * left[i]);
  EXPECT_NEAR(stepper.system().pad_force(stepper.state(), 0), 20, 1e-9);
}

// The jaw's force doubles: m x'' + c x' + k x = F.
TEST(NormalClosedForms, ForceStepResponse) {
  const double force = 5, mass = 0.05, k = 84e3, c = 840;
  GraspModel model = parallel_grasp({});
  model.body_is_fixed = true;
  GraspStepper stepper(model, steps_of(1e-3, Integration::kSecondOrder));
  stepper.system().set_command(0, {.force = force}, 0);
  stepper.advance(2);
  GraspStepper fast(model, steps_of(1e-5, Integration::kSecondOrder));
  GraspState state = stepper.state();
  state.time = 0;
  fast.set_state(state);
  fast.system().set_command(0, {.force = 2 * force}, 0);
  const double root = std::sqrt(c * c - 4 * mass * k);
  const double s1 = (-c + root) / (2 * mass), s2 = (-c - root) / (2 * mass);
  for (int i = 0; i < 5000; ++i) {
    fast.step(1);
    const double t = fast.state().time;
    const double x = force / k * (1 + (s2 * std::exp(s1 * t) - s1 * std::exp(s2 * t)) / (s1 - s2));
    const double v = force / k * s1 * s2 / (s1 - s2) * (std::exp(s1 * t) - std::exp(s2 * t));
    ASSERT_NEAR(fast.system().pad_force(fast.state(), 0), force + k * x + c * v, 0.01 * force) << t;
  }
}

}  // namespace
}  // namespace prehend::contact
