// LuGre friction of a whole pad against closed forms.

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "prehend/contact/pad_readings.h"
#include "slabs.h"

namespace prehend::contact {
namespace {

using namespace testing;

// A pad under uniform depth whose partner moves as prescribed.
struct Rubbed {
  PadLayout pad = PadLayout::flat({});
  TexelLaw law;
  PadState state{pad};
  PadScratch scratch{pad};
  PadResponse response;

  explicit Rubbed(const TexelLaw& law_in, double depth = 5e-4) : law(law_in) {
    std::fill(state.depth.begin(), state.depth.end(), depth);
  }
  // Friction along x [N] after a step.
  double move(double h, const Vector6& twist) {
    respond(pad, law, h, twist, state, scratch, response);
    advance(pad, law, h, twist, state, scratch);
    double sum = 0;
    for (std::size_t i = 0; i < pad.size(); ++i) sum += state.friction_u[i];
    return sum;
  }
  double move(double h, double speed) {
    return move(h, (Vector6() << speed, 0, 0, 0, 0, 0).finished());
  }
};

TEST(FrictionClosedForms, SteadySlidingIsTheStribeckCurve) {
  TexelLaw law;
  law.viscous_friction = 0.3;
  for (const double speed : {1e-4, 1e-3, 0.01, 0.1, 1.0}) {
    Rubbed rubbed(law);
    double friction = 0;
    for (int i = 0; i < 6000; ++i) friction = rubbed.move(0.1, speed);
    const double g = 0.5 * (0.7 + 0.1 * std::exp(-std::pow(speed / 0.01, 2)));
    EXPECT_NEAR(friction / 84, g + 0.3 * speed, 1e-10) << speed;
    for (const SlipState slip : slip_states(rubbed.pad, law, rubbed.state)) {
      EXPECT_EQ(slip, SlipState::kSlips);
    }
  }
}

TEST(FrictionClosedForms, TransientAtConstantVelocity) {
  const TexelLaw law;
  const double speed = 0.01, h = 5e-5;
  Rubbed rubbed(law);
  const double g = 0.5 * (0.7 + 0.1 * std::exp(-1.0)), rate = 200 * speed / g;
  for (int i = 1; i <= 8000; ++i) {
    rubbed.move(h, speed);
    ASSERT_NEAR(rubbed.state.bristle_u[10], g / 200 * -std::expm1(-rate * i * h), 1e-3 * g / 200);
  }
}

Vector6 push_along_x(double force) { return (Vector6() << force, 0, 0, 0, 0, 0).finished(); }

// A slab so hard to turn that it only shifts, as on rails.
GraspModel guided_slab(const SlabOptions& options) {
  GraspModel model = slab(options);
  model.inertia *= 1e12;
  return model;
}

TEST(FrictionClosedForms, PreslidingSagAndStiffness) {
  for (const BristleLaw bristle : {BristleLaw::kLuGre, BristleLaw::kElastoPlastic}) {
    SlabOptions options;
    options.mass = 1;
    options.law.bristle_law = bristle;
    options.law.bristle_damping = 5;
    GraspStepper stepper(guided_slab(options), steps_of(1e-3));
    stepper.advance(2);
    const double start = stepper.state().p_WB.x(), push = 0.01 * 0.8 * kGravity;
    // Slowly, so that nothing swings beyond.
    for (int i = 1; i <= 1000; ++i) {
      stepper.system().set_body_wrench(push_along_x(push * i / 1000));
      stepper.advance(2 + i * 1e-3);
    }
    stepper.advance(8);
    const double sag = stepper.state().p_WB.x() - start;
    EXPECT_NEAR(sag, push / (84 * 200.0), (bristle == BristleLaw::kLuGre ? 0.01 : 1e-6) * sag);
  }
}

TEST(FrictionClosedForms, BreaksAwayAtTheStaticLimit) {
  for (const BristleLaw bristle : {BristleLaw::kLuGre, BristleLaw::kElastoPlastic}) {
    SlabOptions options;
    options.mass = 1;
    options.law.bristle_law = bristle;
    GraspStepper stepper(guided_slab(options), steps_of(1e-3));
    stepper.advance(1);
    const double ramp = 0.2;  // N/s
    double push = 0;
    // Once it slides, static friction has gone and it runs away.
    while (stepper.state().velocity.x() < 0.02 && push < 9) {
      push += ramp * 1e-3;
      stepper.system().set_body_wrench(push_along_x(push));
      stepper.step(1e9);
    }
    EXPECT_NEAR(push, 0.8 * kGravity, 0.01 * 0.8 * kGravity);
  }
}

TEST(FrictionClosedForms, HysteresisLoopClosesAndDissipates) {
  for (const BristleLaw bristle : {BristleLaw::kLuGre, BristleLaw::kElastoPlastic}) {
    TexelLaw law;
    law.bristle_law = bristle;
    law.bristle_damping = 0;
    Rubbed rubbed(law);
    const double amplitude = 4e-3, h = 1e-4;
    double x = 0, last_force = 0, loop_start = 0, work = 0, most = 0;
    for (int cycle = 0; cycle < 4; ++cycle) {
      loop_start = last_force;
      work = 0;
      for (int i = 1; i <= 20000; ++i) {
        const double next = amplitude * std::sin(2 * std::numbers::pi * i / 20000);
        const double speed = (next - x) / h;
        last_force = rubbed.move(h, speed);
        work += last_force * (next - x);
        most = std::max(most, std::abs(last_force));
        x = next;
      }
    }
    EXPECT_NEAR(last_force, loop_start, 0.005 * most);
    EXPECT_GE(work, 0) << "dissipates";
    EXPECT_GT(work, 0.05 * amplitude * most) << "and not nothing: it slides at the ends";
  }
}

// A slope as a lateral share of the weight that comes within `ramp` [s], at last gently: near
// break-away the bristles yield (1 - load)^-1 as fast as the load grows, and what moves at v_s has
// lost its static friction.
GraspStepper slope(double angle, double ramp) {
  SlabOptions options;
  options.mass = 0.5;
  options.size = {2.0, 0.2, 0.004};
  options.gravity = kGravity * std::cos(angle);
  options.law.bristle_law = BristleLaw::kElastoPlastic;
  options.law.bristle_damping = 2;
  GraspStepper stepper(guided_slab(options), steps_of(1e-3));
  stepper.advance(1);
  const double push = options.mass * kGravity * std::sin(angle);
  for (double t = 1e-3; t < ramp; t += 1e-3) {
    const double left = 1 - t / ramp;
    stepper.system().set_body_wrench(push_along_x(push * (1 - left * left * left)));
    stepper.advance(1 + t);
  }
  stepper.system().set_body_wrench(push_along_x(push));
  return stepper;
}

TEST(FrictionClosedForms, SticksOnASlopeBelowTheFrictionAngleOnly) {
  const double limit = std::atan(0.8), margin = 0.05 * std::numbers::pi / 180;
  GraspStepper sticks = slope(limit - margin, 4);
  sticks.advance(6);
  const double before = sticks.state().p_WB.x();
  sticks.advance(10);
  EXPECT_NEAR(sticks.state().p_WB.x(), before, 1e-6);
  GraspStepper slides = slope(limit + margin, 4);
  slides.advance(10);
  EXPECT_GT(slides.state().velocity.x(), 0.1);
}

TEST(FrictionClosedForms, SlidesDownASlopeAsCoulombSays) {
  for (const double angle : {0.72, 0.85}) {
    GraspStepper stepper = slope(angle, 0);
    while (stepper.state().velocity.x() < 0.2) stepper.step(1e9);
    const double v0 = stepper.state().velocity.x(), t0 = stepper.state().time;
    stepper.advance(t0 + 0.1);
    const double expected = kGravity * (std::sin(angle) - 0.7 * std::cos(angle));
    EXPECT_NEAR((stepper.state().velocity.x() - v0) / 0.1, expected, 1e-3 * expected) << angle;
  }
}

TEST(FrictionClosedForms, HoldingTorqueOfTheRectangularPad) {
  TexelLaw law = elastic_law();
  Rubbed rubbed(law);
  rubbed.move(1e-3, 0.0);
  const double force = total_normal_force(rubbed.pad, rubbed.state);
  EXPECT_NEAR(force, 42, 1e-9);
  double sum = 0;
  for (std::size_t i = 0; i < 84; ++i)
    sum += 0.8 * 0.5 * std::hypot(rubbed.pad.x[i], rubbed.pad.y[i]);
  const double torque = holding_torque(rubbed.pad, rubbed.state, 0.8);
  EXPECT_NEAR(torque, sum, 1e-9 * sum);
  const double integral = rectangle_holding_torque(0.8, force, 6 * 0.0034, 14 * 0.0034);
  EXPECT_NEAR(torque, integral, 0.005 * integral);
  // Twisted until it slips, it resists with that.
  for (int i = 0; i < 3000; ++i) rubbed.move(1e-3, (Vector6() << 0, 0, 0, 0, 0, 2).finished());
  double resisted = 0;
  for (std::size_t i = 0; i < 84; ++i) {
    resisted +=
        rubbed.pad.x[i] * rubbed.state.friction_v[i] - rubbed.pad.y[i] * rubbed.state.friction_u[i];
  }
  EXPECT_NEAR(resisted, torque, 1e-6 * torque);
  EXPECT_NEAR(centre_of_pressure(rubbed.pad, rubbed.state).norm(), 0, 1e-15);
}

// Sliding about a centre at x = -offset: force and torque are those of the limit surface (Goyal,
// Ruina, Papadopoulos, "Planar Sliding with Dry Friction", 1991), here by fine quadrature.
TEST(FrictionClosedForms, TorsionWithShearStaysOnTheLimitSurface) {
  const double a = 6 * 0.0034, b = 14 * 0.0034;
  for (const double offset : {0.0, 0.002, 0.005, 0.01, 0.03, 0.2}) {
    Rubbed rubbed(elastic_law());
    const double spin = 0.05 / (offset + 0.01);
    for (int i = 0; i < 2000; ++i) {
      rubbed.move(1e-2, (Vector6() << 0, spin * offset, 0, 0, 0, spin).finished());
    }
    double shear = 0, torsion = 0;
    for (std::size_t i = 0; i < 84; ++i) {
      shear += rubbed.state.friction_v[i];
      torsion += rubbed.pad.x[i] * rubbed.state.friction_v[i] -
                 rubbed.pad.y[i] * rubbed.state.friction_u[i];
    }
    double expected_shear = 0, expected_torsion = 0;
    constexpr int kPoints = 400;
    for (int i = 0; i < kPoints; ++i) {
      for (int j = 0; j < kPoints; ++j) {
        const double x = a * ((i + 0.5) / kPoints - 0.5), y = b * ((j + 0.5) / kPoints - 0.5);
        const double r = std::hypot(x + offset, y), f = 0.8 * 42 / (kPoints * kPoints);
        expected_shear += f * (x + offset) / r;
        expected_torsion += f * (x * (x + offset) + y * y) / r;
      }
    }
    const double most_torsion = rectangle_holding_torque(0.8, 42, a, b);
    EXPECT_NEAR(shear, expected_shear, 0.02 * 0.8 * 42) << offset;
    EXPECT_NEAR(torsion, expected_torsion, 0.02 * most_torsion) << offset;
  }
}

}  // namespace
}  // namespace prehend::contact
