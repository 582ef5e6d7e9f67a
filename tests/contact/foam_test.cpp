// Foam that remembers, creep and hysteresis, against closed forms, and what must hold for any of
// it.

#include "prehend/contact/foam.h"

#include <cmath>
#include <numeric>

#include <gtest/gtest.h>
#include <Eigen/Eigenvalues>

#include "pads.h"
#include "prehend/contact/compression_curve.h"
#include "prehend/contact/foam_texel.h"
#include "prehend/contact/texel.h"
#include "slabs.h"

namespace prehend::contact {
namespace {

using namespace testing;

constexpr double kTexels = 84;

TexelLaw foam_law(const FoamMemory& memory, double damping = 0) {
  TexelLaw law = elastic_law();
  law.damping = damping;
  law.memory = memory;
  return law;
}

// A pad under a flat face that moves along its normal as prescribed.
struct PressedTexel {
  PadLayout pad = PadLayout::flat({});
  TexelLaw law;
  PadState state;
  PadScratch scratch{pad};
  PadResponse response;
  double depth = 0, work = 0, force = 0;  // m, N m and N of one texel

  explicit PressedTexel(const TexelLaw& law_in) : law(law_in), state(pad, law_in) {}

  // One step to `to` [m]; returns a texel's force [N].
  double press(double h, double to) {
    std::fill(state.depth.begin(), state.depth.end(), depth);
    const Vector6 twist = (Vector6() << 0, 0, (depth - to) / h, 0, 0, 0).finished();
    respond(pad, law, h, twist, state, scratch, response);
    advance(pad, law, h, twist, state, scratch);
    const double before = force;
    force = state.normal_force[10];
    work += 0.5 * (before + force) * (to - depth);
    depth = to;
    return force;
  }
  // Slowly there in equal steps; returns the work done on a texel meanwhile [J].
  double ramp(double to, int steps, double h = 1) {
    const double from = depth, before = work;
    for (int i = 1; i <= steps; ++i) press(h, from + (to - from) * i / steps);
    return work - before;
  }
};

TEST(Foam, RelaxesAsItsPronySeries) {
  const FoamMemory memory{{{0.3, 0.05}, {0.5, 2}, {0.1, 1e-7}, {0.2, 1e7}}, {}};
  for (const double h : {1e-4, 1e-2, 0.7}) {
    PressedTexel pressed(foam_law(memory));
    const double depth = 1e-3, stiffness = 1000;
    pressed.press(1e-15, depth);
    for (int i = 1; i <= 20; ++i) {
      double expected = 1;
      for (const auto& term : memory.creep) expected += term.share * std::exp(-i * h / term.time);
      EXPECT_NEAR(pressed.press(h, depth), stiffness * depth * expected, 1e-7) << h;
    }
  }
}

TEST(Foam, FollowsARampExactlyForAnyStep) {
  const double share = 0.4, time = 0.1, speed = 1e-3;
  for (const double h : {1e-3, 0.05, 1.0}) {
    PressedTexel pressed(foam_law({{{share, time}}, {}}));
    double force = 0;
    const int steps = static_cast<int>(std::lround(1 / h));
    for (int i = 1; i <= steps; ++i) force = pressed.press(h, speed * h * i);
    EXPECT_NEAR(force, 1000 * speed * (1 + share * time * -std::expm1(-1 / time)), 1e-13) << h;
  }
}

// The standard linear solid under a load that comes at once: it gives way by W / k in the end, with
// the time constant (1 + share) time.
TEST(Foam, CreepsUnderAHeldForce) {
  const double share = 0.25, time = 2, weight = 3 * kGravity;
  for (const Integration integration :
       {Integration::kFirstOrder, Integration::kSecondOrder, Integration::kAdaptive}) {
    SlabOptions options{.mass = 3, .law = foam_law({{{share, time}}, {}}, 1)};
    GraspStepper stepper(slab(options), steps_of(1e-3, integration));
    const double rest = weight / (kTexels * 1000);
    for (const double t : {1.0, 2.0, 5.0, 40.0}) {
      stepper.advance(t);
      const double left = share / (1 + share) * std::exp(-t / (time * (1 + share)));
      EXPECT_NEAR(depth(stepper), rest * (1 - left), 2e-3 * share * rest) << t;
      EXPECT_NEAR(stepper.system().pad_force(stepper.state(), 0), weight, 1e-3 * weight);
    }
  }
}

// Held until relaxed and let go at once, it stands at share / (1 + share) of the depth and comes
// back with the same time constant; nothing is felt meanwhile, and a face meets it where it stands.
TEST(Foam, ComesBackWithoutForceAndIsMetWhereItStands) {
  const double share = 0.5, time = 1, depth = 1e-3, h = 0.01;
  PressedTexel pressed(foam_law({{{share, time}}, {}}));
  pressed.press(1e-9, depth);
  for (int i = 0; i < 40; ++i) pressed.press(1, depth);
  pressed.press(1e-12, -1e-3);
  for (int i = 1; i <= 200; ++i) {
    EXPECT_EQ(pressed.press(h, -1e-3), 0);
    const double expected = depth * share / (1 + share) * std::exp(-i * h / (time * (1 + share)));
    EXPECT_NEAR(pressed.state.foam[10], expected, 1e-5 * depth);
  }
  const double stands = pressed.state.foam[10];
  EXPECT_EQ(PressedTexel(pressed).press(1e-9, 0.99 * stands), 0);
  EXPECT_GT(PressedTexel(pressed).press(1e-9, 1.01 * stands), 0);
  // release() is the same with nothing near; in the end it is as new.
  PadState released = pressed.state;
  release(pressed.pad, pressed.law, h, released);
  pressed.press(h, -1e-3);
  EXPECT_EQ(released.foam, pressed.state.foam);
  for (int i = 0; i < 100; ++i) release(pressed.pad, pressed.law, 1, released);
  EXPECT_EQ(*std::max_element(released.foam.begin(), released.foam.end()), 0);
}

// Each slider gives way at f = share k depth: a loop over the range R loses 2 f (R - 2 depth).
TEST(Foam, LoopsEncloseTheAreaOfTheirSliders) {
  const FoamMemory memory{{}, {{0.1, 1e-4}, {0.2, 3e-4}}};
  PressedTexel pressed(foam_law(memory));
  pressed.ramp(2.5e-3, 250);
  const double top = pressed.force, down = pressed.ramp(1e-3, 150), bottom = pressed.force;
  const double up = pressed.ramp(2.5e-3, 150);
  double area = 0;
  for (const auto& term : memory.hysteresis) {
    area += 2 * term.share * 1000 * term.depth * (1.5e-3 - 2 * term.depth);
  }
  EXPECT_NEAR(down + up, area, 1e-15);
  EXPECT_NEAR(pressed.force, top, 1e-13);
  EXPECT_NEAR(top, 2.5 + 0.1 * 0.1 + 0.2 * 0.3, 1e-13);
  EXPECT_NEAR(bottom, 1.0 - 0.1 * 0.1 - 0.2 * 0.3, 1e-13);
}

TEST(Foam, InnerLoopsCloseAndLoseEnergy) {
  const FoamMemory memory{{}, {{0.1, 1e-4}, {0.2, 3e-4}}};
  PressedTexel pressed(foam_law(memory));
  pressed.ramp(2.5e-3, 250);
  const double top = pressed.force;
  pressed.ramp(1.0e-3, 150);
  const double inner_bottom = pressed.force;
  const double inner = pressed.ramp(1.5e-3, 50) + pressed.ramp(1.0e-3, 50);
  EXPECT_NEAR(pressed.force, inner_bottom, 1e-13) << "returns to the same point";
  // Over 0.5 mm the second slider does not give way.
  EXPECT_NEAR(inner, 2 * 0.1 * 1000 * 1e-4 * (0.5e-3 - 2e-4), 1e-15);
  pressed.ramp(2.5e-3, 150);
  EXPECT_NEAR(pressed.force, top, 1e-13) << "and so does the outer loop";
}

TEST(Foam, NoWayGivesEnergy) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> depth(-1e-3, 3e-3), logarithm(-4, 1);
  const FoamMemory memory{{{0.5, 1e-3}, {1, 0.3}}, {{0.5, 1e-4}, {2, 1e-3}}};
  TexelLaw curved = foam_law(memory);
  curved.normal_law = NormalLaw::kTabulated;
  curved.curve = std::make_shared<CompressionCurve>(
      std::vector<CompressionCurve::Sample>{{0, 0}, {1e-3, 0.4}, {2e-3, 2}, {3e-3, 6}});
  for (const TexelLaw& law : {foam_law(memory), curved}) {
    const auto elastic = [&](double d) {
      double sum = 0;
      for (int i = 0; i < 1000; ++i) sum += normal_force(law, d * (i + 0.5) / 1000, 0) * d / 1000;
      return sum;
    };
    for (int way = 0; way < 50; ++way) {
      PressedTexel pressed(law);
      double work = 0;  // with the force of each step's end, as steps do it
      for (int i = 0; i < 100; ++i) {
        const double to = depth(random), from = pressed.depth;
        work += pressed.press(std::pow(10, logarithm(random)), to) * (to - from);
        const double kept = elastic(std::max(0.0, pressed.state.foam[10])) +
                            foam_energy(pressed.pad, law, pressed.state, 10);
        ASSERT_GE(work, kept - 1e-9) << way << " " << i;
        ASSERT_GE(pressed.force, 0);
      }
    }
  }
}

TEST(Foam, ResponsesAreSymmetricPositiveAndTangent) {
  std::mt19937 random(8);
  std::uniform_real_distribution<double> stretch(-1e-4, 1e-4);
  const TexelLaw law = foam_law(FoamMemory::realistic(), 10);
  for (const PadLayout& pad : {PadLayout::flat({}), fingertip()}) {
    for (const double h : {1e-5, 1e-3, 1e-2, 0.1}) {
      PadState state(pad, law);
      const PadState plain = random_state(pad, random);
      state.depth = plain.depth;
      for (std::size_t i = 0; i < pad.size(); ++i) {
        state.foam[i] = std::max(0.0, state.depth[i]);
        for (int k = 1; k <= 3; ++k) state.foam[k * pad.padded_size() + i] = stretch(random);
      }
      PadScratch scratch(pad);
      PadResponse at, near;
      const Vector6 twist = 0.05 * random_twist(random);
      respond(pad, law, h, twist, state, scratch, at);
      EXPECT_EQ(at.resistance, at.resistance.transpose());
      const Eigen::SelfAdjointEigenSolver<Matrix6> eigen(at.resistance);
      EXPECT_GT(eigen.eigenvalues()[0], -1e-12 * eigen.eigenvalues()[5]);
      // The normal force, without friction and sliders that begin to slip, is its own linearisation
      // to first order.
      TexelLaw smooth = law;
      for (auto& term : smooth.memory.hysteresis) term.depth = 1;
      smooth.static_friction = smooth.dynamic_friction = 0;
      Vector6 by = Vector6::Zero();
      by[2] = 1e-9;
      respond(pad, smooth, h, twist, state, scratch, at);
      respond(pad, smooth, h, twist + by, state, scratch, near);
      const Vector6 there = near.constant - near.resistance * (twist + by);
      const Vector6 foreseen = at.constant - at.resistance * (twist + by);
      EXPECT_LT((there - foreseen).norm(), 1e-3 * (at.resistance * by).norm() + 1e-12) << h;
    }
  }
}

// 10 g to 10 kg: stable, and borne. (With tangents where sliders begin to slip 10 g were thrown
// off.)
TEST(Foam, HoldsLightAndHeavyAtAnyStep) {
  for (const double mass : {0.01, 0.3, 10.0}) {
    for (const double h : {1e-3, 1e-2}) {
      for (const Integration integration : {Integration::kFirstOrder, Integration::kSecondOrder}) {
        SlabOptions options{.mass = mass, .law = foam_law(FoamMemory::realistic(), 10)};
        GraspStepper stepper(slab(options), steps_of(h, integration));
        stepper.advance(60);
        const double weight = mass * kGravity;
        EXPECT_NEAR(stepper.system().pad_force(stepper.state(), 0), weight, 1e-6 * weight)
            << mass << " " << h << " " << static_cast<int>(integration) << " " << depth(stepper);
        EXPECT_LT(depth(stepper), weight / 84e3 * (1 + 1e-6));
        EXPECT_LT(stepper.state().velocity.norm(), 1e-6);
      }
    }
  }
}

// A heavy slab that is laid on the pad, swings and never leaves.
double end_depth(const FoamMemory& memory, Integration integration, double h) {
  SlabOptions options{.mass = 10, .law = foam_law(memory, 1)};
  GraspStepper stepper(slab(options), steps_of(h, integration));
  stepper.advance(0.25);
  return depth(stepper);
}

double order_of(const FoamMemory& memory, Integration integration) {
  const double exact = end_depth(memory, Integration::kSecondOrder, 0.25 / 32768);
  const double coarse = std::abs(end_depth(memory, integration, 0.25 / 1024) - exact);
  const double fine = std::abs(end_depth(memory, integration, 0.25 / 4096) - exact);
  return std::log(coarse / fine) / std::log(4);
}

TEST(Foam, StepsConvergeWithTheirOrder) {
  const FoamMemory creep{{{0.3, 0.02}, {0.3, 0.2}}, {}};
  EXPECT_GT(order_of(creep, Integration::kFirstOrder), 0.85);
  EXPECT_GT(order_of(creep, Integration::kSecondOrder), 1.8);
  // Where a slider gives way the force has a bend.
  const FoamMemory both{{{0.3, 0.02}}, {{0.2, 2e-5}, {0.1, 1e-4}}};
  EXPECT_GT(order_of(both, Integration::kFirstOrder), 0.8);
  EXPECT_GT(order_of(both, Integration::kSecondOrder), 0.8);
}

TEST(Foam, AdaptiveStepsKeepWhatTheFoamRemembersWithinTheTolerance) {
  const FoamMemory memory{{{0.5, 0.05}}, {{0.2, 1e-4}}};
  SlabOptions options{.mass = 10, .law = foam_law(memory, 10)};
  GraspStepper fine(slab(options), steps_of(2e-5, Integration::kSecondOrder));
  StepOptions adaptive = steps_of(1e-3, Integration::kAdaptive);
  GraspStepper stepper(slab(options), adaptive);
  for (const double t : {0.05, 0.2, 0.6}) {
    fine.advance(t);
    stepper.advance(t);
    EXPECT_NEAR(depth(stepper), depth(fine), 100 * adaptive.tolerance) << t;
    const PadMount& pad = fine.system().model().pads[0];
    EXPECT_LT(foam_difference(pad.layout, pad.law, stepper.state().pads[0], fine.state().pads[0]),
              100 * adaptive.tolerance);
  }
  EXPECT_LT(stepper.steps(), fine.steps() / 20);
}

TEST(Foam, SavedStatesGoOnBitwise) {
  SlabOptions options{.mass = 1, .law = foam_law(FoamMemory::realistic(), 10)};
  GraspStepper stepper(slab(options), steps_of(1e-3, Integration::kSecondOrder));
  stepper.advance(0.1);
  GraspStepper other(slab(options), steps_of(1e-3, Integration::kSecondOrder));
  other.set_state(stepper.state());
  stepper.advance(0.3);
  other.advance(0.3);
  EXPECT_EQ(other.state().p_WB, stepper.state().p_WB);
  EXPECT_EQ(other.state().pads[0].foam, stepper.state().pads[0].foam);
  options.law.memory = {};
  GraspStepper plain(slab(options), steps_of(1e-3));
  EXPECT_THROW(other.set_state(plain.state()), std::invalid_argument);
}

TEST(Foam, ExplicitStepsAreTheOracle) {
  SlabOptions options{.mass = 1, .law = foam_law({{{0.5, 0.02}}, {{0.2, 2e-5}}}, 1)};
  GraspStepper explicit_steps(slab(options), steps_of(2e-6, Integration::kExplicit));
  GraspStepper implicit_steps(slab(options), steps_of(2e-6, Integration::kSecondOrder));
  for (const double t : {0.01, 0.02, 0.03}) {
    explicit_steps.advance(t);
    implicit_steps.advance(t);
    EXPECT_NEAR(depth(explicit_steps), depth(implicit_steps), 5e-4 * depth(implicit_steps)) << t;
  }
}

TEST(Foam, OneTexelIsAsThePadsTexels) {
  std::mt19937 random(9);
  std::uniform_real_distribution<double> depth(-5e-4, 2e-3), step(1e-4, 0.1);
  PressedTexel pressed(foam_law(FoamMemory::realistic(), 10));
  FoamTexel texel(pressed.law);
  for (int i = 0; i < 500; ++i) {
    const double h = step(random), to = depth(random);
    const double force = texel.press(h, to);
    EXPECT_NEAR(pressed.press(h, to), force, 1e-12);
  }
}

TEST(Foam, WithoutItsTermsThereIsNothingToKeep) {
  const PadLayout pad = PadLayout::flat({});
  EXPECT_TRUE(PadState(pad).foam.empty());
  EXPECT_TRUE(PadState(pad, elastic_law()).foam.empty());
  EXPECT_EQ(PadState(pad, foam_law(FoamMemory::realistic())).foam.size(), 4 * pad.padded_size());
}

TEST(Foam, RefusesWhatIsNone) {
  const auto refused = [](const TexelLaw& law, const std::string& part) {
    try {
      validate(law);
      ADD_FAILURE() << part << " was not refused";
    } catch (const std::invalid_argument& error) {
      EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
    }
  };
  refused(foam_law({{{0.1, 0}}, {}}), "creep: time");
  refused(foam_law({{{-0.1, 1}}, {}}), "creep: share");
  refused(foam_law({{{0.1, std::nan("")}}, {}}), "creep: time");
  refused(foam_law({{}, {{0.1, -1}}}), "hysteresis: depth");
  refused(foam_law({{}, {{0, 1e-4}}}), "hysteresis: share");
  refused(foam_law({std::vector<FoamMemory::Creep>(9, {0.1, 1}), {}}), "8 terms");
  TexelLaw hertz = foam_law(FoamMemory::realistic());
  hertz.normal_law = NormalLaw::kHuntCrossley;
  refused(hertz, "linear or tabulated");
  // A state of another law.
  const PadLayout pad = PadLayout::flat({});
  PadState state(pad);
  PadScratch scratch(pad);
  PadResponse response;
  EXPECT_THROW(respond(pad, foam_law(FoamMemory::realistic()), 1e-3, Vector6::Zero(), state,
                       scratch, response),
               std::invalid_argument);
}

}  // namespace
}  // namespace prehend::contact
