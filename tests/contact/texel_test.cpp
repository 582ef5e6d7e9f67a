#include "prehend/contact/texel.h"

#include <cmath>
#include <complex>
#include <limits>
#include <stdexcept>

#include <gtest/gtest.h>

namespace prehend::contact {
namespace {

using Eigen::Vector2d;

// A body of one normal and one tangential degree of freedom on `count` equal texels.
struct Slab {
  TexelLaw law;
  int count = 84;
  double mass = 0.05;
  double gravity = 9.81;
  double depth = 0, depth_rate = 0;  // m, m/s
  double x = 0, v = 0;               // m, m/s, tangential
  double push = 0;                   // N, tangential
  double z = 0;                      // m, of each texel's bristle

  void step(double h) {
    using Vector1d = Eigen::Matrix<double, 1, 1>;
    double v_end = v, rate_end = depth_rate;
    LinearisedContact contact;
    for (int iteration = 0; iteration < 2; ++iteration) {
      contact = linearise(law, h, depth, rate_end, Vector1d(z), Vector1d(v_end));
      const double n = contact.presses ? count : 0;
      rate_end = (mass * depth_rate + h * mass * gravity - h * n * contact.normal_offset) /
                 (mass + h * n * contact.normal_damping);
      v_end = (mass * v + h * push - h * n * contact.bristle_gain * z) /
              (mass + h * n * contact.tangential_damping);
    }
    z = contact.presses ? advanced_bristle(contact, h, Vector1d(z), Vector1d(v_end))[0] : 0.0;
    v = v_end;
    depth_rate = rate_end;
    x += h * v;
    depth += h * depth_rate;
  }
};

TEST(TexelLaw, CarriesStaticLoadAtItsClosedFormDepth) {
  for (const double mass : {0.01, 0.05, 1.0, 10.0}) {
    Slab slab;
    slab.mass = mass;
    for (int i = 0; i < 20000; ++i) slab.step(1e-3);
    const double expected = mass * slab.gravity / (slab.count * slab.law.stiffness);
    EXPECT_NEAR(slab.depth, expected, 1e-9 * expected) << mass;
    EXPECT_NEAR(slab.count * normal_force(slab.law, slab.depth, slab.depth_rate),
                mass * slab.gravity, 1e-9 * mass * slab.gravity);
  }
}

// Backward Euler multiplies each mode exp(s t) of the linear oscillator by 1 / (1 - h s).
TEST(TexelLaw, OscillatesAsBackwardEulerOfTheDampedOscillator) {
  Slab slab;
  slab.law.damping = 0.05;
  const double k = slab.count * slab.law.stiffness, c = slab.count * slab.law.damping;
  const double rest = slab.mass * slab.gravity / k, h = 1e-5;
  slab.depth = 1.4 * rest;
  const double decay = c / (2 * slab.mass);
  const std::complex<double> s(-decay, std::sqrt(k / slab.mass - decay * decay));
  const std::complex<double> mode = 1.0 / (1.0 - h * s);
  // deviation = Re(a mode^n) with value 0.4 rest and rate 0 at n = 0.
  const std::complex<double> a(0.4 * rest, 0.4 * rest * s.real() / s.imag());
  std::complex<double> power = 1;
  for (int n = 1; n <= 2000; ++n) {
    slab.step(h);
    power *= mode;
    ASSERT_NEAR(slab.depth - rest, (a * power).real(), 1e-9 * rest) << "step " << n;
  }
}

TEST(TexelLaw, ApproachesTheContinuousOscillatorLinearlyInTheStep) {
  const auto error_at = [](double h) {
    Slab slab;
    slab.law.damping = 0.05;
    const double k = slab.count * slab.law.stiffness, c = slab.count * slab.law.damping;
    const double rest = slab.mass * slab.gravity / k, duration = 0.004;
    slab.depth = 1.4 * rest;
    const int steps = static_cast<int>(std::lround(duration / h));
    for (int i = 0; i < steps; ++i) slab.step(h);
    const double decay = c / (2 * slab.mass), w = std::sqrt(k / slab.mass - decay * decay);
    const double exact = 0.4 * rest * std::exp(-decay * duration) *
                         (std::cos(w * duration) + decay / w * std::sin(w * duration));
    return std::abs(slab.depth - rest - exact) / rest;
  };
  EXPECT_LT(error_at(1e-7), 1e-3);
  EXPECT_NEAR(error_at(2e-7) / error_at(1e-7), 2, 0.1);
}

TEST(TexelLaw, SlidesSteadilyOnTheStribeckCurve) {
  TexelLaw law;
  law.viscous_friction = 0.3;
  const double depth = 5e-4, normal = law.stiffness * depth;
  for (const double speed : {1e-4, 1e-3, 0.005, 0.01, 0.02, 0.1, 1.0}) {
    TexelStep step;
    Vector2d z = Vector2d::Zero();
    const Vector2d velocity = speed * Vector2d(0.6, -0.8);
    for (int i = 0; i < 200000; ++i) {
      step = implicit_step(law, 0.1, depth, 0, z, velocity);
      if ((step.bristle - z).norm() == 0) break;
      z = step.bristle;
    }
    const double g = normal * (0.7 + 0.1 * std::exp(-std::pow(speed / 0.01, 2)));
    EXPECT_NEAR(step.friction_force.norm(), g + 0.3 * speed, 1e-10) << speed;
    EXPECT_NEAR(step.friction_force.normalized().dot(velocity.normalized()), 1, 1e-12);
  }
}

TEST(TexelLaw, PreslidesWithTheBristleStiffness) {
  const TexelLaw law;
  const double displacement = 1e-7, duration = 1.0, h = 1e-3;  // so slow that nothing slides
  Vector2d z = Vector2d::Zero();
  TexelStep step;
  for (int i = 0; i < 1000; ++i) {
    step = implicit_step(law, h, 1e-3, 0, z, Vector2d(displacement / duration, 0));
    z = step.bristle;
  }
  EXPECT_NEAR(step.friction_force.x() / displacement, law.bristle_stiffness,
              1e-3 * law.bristle_stiffness + law.bristle_damping / duration);
}

TEST(TexelLaw, ImplicitStepAgreesWithTheExplicitOracleForSmallSteps) {
  const TexelLaw law;
  const double h = 1e-6;
  Vector2d implicit_z = Vector2d::Zero(), explicit_z = Vector2d::Zero();
  for (int i = 0; i < 200000; ++i) {
    const double t = i * h;
    const double depth = 1e-3 + 3e-4 * std::sin(30 * t), rate = 9e-3 * std::cos(30 * t);
    const Vector2d v(0.03 * std::sin(40 * t), 0.01 * std::cos(25 * t));
    const double normal = normal_force(law, depth, rate);
    const Vector2d z_rate = bristle_rate(law, explicit_z, v, normal);
    const Vector2d expected = friction_force(law, explicit_z, z_rate, v);
    explicit_z += h * z_rate;
    const TexelStep step = implicit_step(law, h, depth, rate, implicit_z, v);
    implicit_z = step.bristle;
    ASSERT_NEAR((step.friction_force - expected).norm(), 0, 2e-4) << t;
    ASSERT_NEAR(step.normal_force, normal, 1e-4);
  }
}

TEST(TexelLaw, ImplicitStepIsStableFromTenGramsToTenKilogramsAtTwentyMilliseconds) {
  for (const double mass : {0.01, 0.05, 0.3, 1.0, 3.0, 10.0}) {
    for (const double h : {1e-4, 1e-3, 5e-3, 20e-3}) {
      Slab slab;
      slab.mass = mass;
      slab.depth = mass * slab.gravity / (slab.count * slab.law.stiffness);
      // Pushed up to 0.4 of the weight, below break-away at 0.8, so slowly that nothing swings.
      const double push = 0.4 * mass * slab.gravity;
      const int steps = static_cast<int>(8 / h);
      for (int i = 0; i < steps; ++i) {
        slab.push = push * std::min(1.0, i * h / 4);
        slab.step(h);
        ASSERT_LT(std::abs(slab.v), 0.1) << mass << " kg, " << h << " s";
      }
      EXPECT_NEAR(slab.v, 0, 1e-6) << mass << " kg, " << h << " s";
      // Integral of dz = dx (1 - sigma0 z / g): x = -g / sigma0 ln(1 - F / g).
      const double g = 0.8 * mass * slab.gravity;
      const double expected =
          -g / (slab.count * slab.law.bristle_stiffness) * std::log(1 - push / g);
      EXPECT_NEAR(slab.x, expected, 0.1 * expected) << mass << " kg, " << h << " s";
    }
  }
}

TEST(TexelLaw, PushAboveBreakAwaySlidesOff) {
  Slab slab;
  slab.depth = slab.mass * slab.gravity / (slab.count * slab.law.stiffness);
  slab.push = 0.9 * slab.mass * slab.gravity;
  for (int i = 0; i < 1000; ++i) slab.step(1e-3);
  // Sliding: (0.9 - 0.7) g once past the Stribeck velocity.
  EXPECT_NEAR(slab.v, 0.2 * 9.81 * 1.0, 0.1);
}

TEST(TexelLaw, NoPenetrationNoForce) {
  const TexelLaw law;
  EXPECT_EQ(normal_force(law, 0, 1), 0);
  EXPECT_EQ(normal_force(law, -1e-3, 5), 0);
  EXPECT_EQ(normal_force(law, 1e-4, -1), 0) << "never pulls";
  const TexelStep step = implicit_step(law, 1e-3, -1e-3, 0, Vector2d(1e-3, 0), Vector2d(1, 0));
  EXPECT_EQ(step.friction_force.norm(), 0);
  EXPECT_EQ(step.bristle.norm(), 0);
}

TEST(TexelLaw, ReturnMapCutsABristleThatUnloadingLeftTooLong) {
  const TexelLaw law;
  const Vector2d z(3e-3, 4e-3);
  EXPECT_NEAR(return_mapped(law, 0.5, z).norm() * law.bristle_stiffness, 0.8 * 0.5, 1e-12);
  EXPECT_EQ(return_mapped(law, 100.0, z), z);
}

TEST(TexelLaw, PaperConstantsAreNotPassiveUntilViscousFrictionIsAdded) {
  TexelLaw law;
  EXPECT_FALSE(is_passive(law));
  law.viscous_friction = 0.08;
  EXPECT_TRUE(is_passive(law));
}

TEST(TexelLaw, RefusesBadConstantsByName) {
  const auto expect_refused = [](auto change, const std::string& field) {
    TexelLaw law;
    change(law);
    try {
      validate(law);
      FAIL() << field << " was accepted";
    } catch (const std::invalid_argument& error) {
      EXPECT_NE(std::string(error.what()).find(field), std::string::npos) << error.what();
    }
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  validate(TexelLaw{});
  expect_refused([&](TexelLaw& l) { l.stiffness = -1; }, "stiffness");
  expect_refused([&](TexelLaw& l) { l.stiffness = nan; }, "stiffness");
  expect_refused([&](TexelLaw& l) { l.damping = infinity; }, "damping");
  expect_refused([&](TexelLaw& l) { l.bristle_stiffness = 0; }, "bristle_stiffness");
  expect_refused([&](TexelLaw& l) { l.bristle_damping = -1e-9; }, "bristle_damping");
  expect_refused([&](TexelLaw& l) { l.viscous_friction = nan; }, "viscous_friction");
  expect_refused([&](TexelLaw& l) { l.static_friction = -0.1; }, "static_friction");
  expect_refused([&](TexelLaw& l) { l.dynamic_friction = 0.9; }, "dynamic_friction");
  expect_refused([&](TexelLaw& l) { l.stribeck_velocity = 0; }, "stribeck_velocity");
  EXPECT_THROW(implicit_step(TexelLaw{}, 0, 1e-3, 0, Vector2d::Zero(), Vector2d::Zero()),
               std::invalid_argument);
}

}  // namespace
}  // namespace prehend::contact
