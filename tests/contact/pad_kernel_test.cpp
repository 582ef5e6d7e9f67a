// The vector code against one texel at a time, and what must not change its result.

#include <numeric>

#include <gtest/gtest.h>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include "pads.h"
#include "prehend/contact/compression_curve.h"
#include "prehend/contact/texel.h"

namespace prehend::contact {
namespace {

using testing::fingertip;
using testing::random_state;
using testing::random_twist;

std::vector<TexelLaw> all_laws() {
  TexelLaw paper;
  paper.viscous_friction = 0.1;
  TexelLaw coulomb = paper;
  coulomb.static_friction = coulomb.dynamic_friction;
  TexelLaw elastic = paper;
  elastic.bristle_law = BristleLaw::kElastoPlastic;
  elastic.return_map = true;
  TexelLaw hunt_crossley = elastic;
  hunt_crossley.normal_law = NormalLaw::kHuntCrossley;
  hunt_crossley.stiffness = 3e4;
  hunt_crossley.damping = 3e5;
  TexelLaw foam = paper;
  foam.normal_law = NormalLaw::kTabulated;
  foam.curve = std::make_shared<CompressionCurve>(std::vector<CompressionCurve::Sample>{
      {0, 0}, {5e-4, 0.4}, {1.5e-3, 0.9}, {2.5e-3, 3.0}, {3e-3, 8.0}});
  TexelLaw frictionless = paper;
  frictionless.static_friction = frictionless.dynamic_friction = 0;
  return {paper, coulomb, elastic, hunt_crossley, foam, frictionless};
}

// The same response from texel.h, texel by texel.
PadResponse oracle(const PadLayout& pad, const TexelLaw& law, double h, const Vector6& twist,
                   const PadState& state) {
  PadResponse response;
  for (std::size_t i = 0; i < pad.size(); ++i) {
    const Eigen::Vector3d n = pad.normal(i);
    Eigen::Matrix<double, 3, 2> tangents;
    tangents << pad.first_tangent(i), pad.second_tangent(i);
    const Eigen::Vector3d c = pad.position(i) - state.depth[i] * n;
    Eigen::Matrix<double, 3, 6> J;
    J << 1, 0, 0, 0, c.z(), -c.y(), 0, 1, 0, -c.z(), 0, c.x(), 0, 0, 1, c.y(), -c.x(), 0;
    const Eigen::Vector3d w = J * twist;
    const Eigen::Vector2d bristle(state.bristle_u[i], state.bristle_v[i]);
    const Eigen::Vector2d slip = tangents.transpose() * w;
    const LinearisedContact l = linearise(law, h, state.depth[i], -n.dot(w), bristle, slip);
    if (!l.presses) continue;
    ++response.pressing;
    const Eigen::Matrix3d R =
        l.normal_damping * n * n.transpose() +
        (law.static_friction == 0 ? 0.0 : l.tangential_damping) * tangents * tangents.transpose();
    response.resistance += pad.scale[i] * J.transpose() * R * J;
    response.constant += pad.scale[i] * J.transpose() *
                         (l.normal_offset * n - l.bristle_gain * (tangents * bristle));
  }
  return response;
}

TEST(PadKernel, EqualsTheTexelsOneByOne) {
  std::mt19937 random(1);
  for (const PadLayout& pad : {PadLayout::flat({}), fingertip()}) {
    for (const TexelLaw& law : all_laws()) {
      for (const double h : {1e-5, 1e-3, 2e-2}) {
        const PadState state = random_state(pad, random);
        const Vector6 twist = random_twist(random);
        PadScratch scratch(pad);
        PadResponse response;
        respond(pad, law, h, twist, state, scratch, response);
        const PadResponse expected = oracle(pad, law, h, twist, state);
        EXPECT_EQ(response.pressing, expected.pressing);
        EXPECT_LT((response.constant - expected.constant).norm(),
                  1e-12 * (1 + expected.constant.norm()));
        EXPECT_LT((response.resistance - expected.resistance).norm(),
                  1e-12 * (1 + expected.resistance.norm()));
        const Eigen::SelfAdjointEigenSolver<Matrix6> eigen(response.resistance);
        EXPECT_GT(eigen.eigenvalues()[0], -1e-12 * eigen.eigenvalues()[5]);
      }
    }
  }
}

TEST(PadKernel, TexelForcesSumToTheResponse) {
  std::mt19937 random(2);
  for (const PadLayout& pad : {PadLayout::flat({}), fingertip()}) {
    for (const TexelLaw& law : all_laws()) {
      PadState state = random_state(pad, random);
      // Depth rates that keep every pressing texel pressing.
      const Vector6 twist = 0.05 * random_twist(random);
      PadScratch scratch(pad);
      PadResponse response;
      respond(pad, law, 1e-3, twist, state, scratch, response);
      const Vector6 expected = response.constant - response.resistance * twist;
      const std::vector<double> depth = state.depth;
      advance(pad, law, 1e-3, twist, state, scratch);
      Vector6 sum = Vector6::Zero();
      for (std::size_t i = 0; i < pad.size(); ++i) {
        const Eigen::Vector3d f = state.normal_force[i] * pad.normal(i) -
                                  state.friction_u[i] * pad.first_tangent(i) -
                                  state.friction_v[i] * pad.second_tangent(i);
        sum.head<3>() += f;
        sum.tail<3>() += (pad.position(i) - depth[i] * pad.normal(i)).cross(f);
      }
      EXPECT_LT((sum - expected).norm(), 1e-12 * (1 + expected.norm()));
    }
  }
}

TEST(PadKernel, BristlesAdvanceAsThoseOfSingleTexels) {
  std::mt19937 random(3);
  const PadLayout pad = PadLayout::flat({});
  for (const TexelLaw& law : all_laws()) {
    PadState state = random_state(pad, random);
    const PadState before = state;
    const Vector6 twist = (Vector6() << 0.02, -0.01, 0.03, 0, 0, 0).finished();
    PadScratch scratch(pad);
    PadResponse response;
    respond(pad, law, 1e-3, twist, state, scratch, response);
    advance(pad, law, 1e-3, twist, state, scratch);
    for (std::size_t i = 0; i < pad.size(); ++i) {
      const Eigen::Vector2d z(before.bristle_u[i], before.bristle_v[i]);
      const TexelStep step =
          implicit_step(law, 1e-3, before.depth[i], -0.03, z, Eigen::Vector2d(0.02, -0.01));
      EXPECT_NEAR(state.normal_force[i], step.normal_force, 1e-13);
      if (law.static_friction == 0) continue;
      EXPECT_NEAR(state.friction_u[i], step.friction_force.x(), 1e-13);
      EXPECT_NEAR(state.bristle_u[i], step.bristle.x(), 1e-16);
      EXPECT_NEAR(state.bristle_v[i], step.bristle.y(), 1e-16);
    }
  }
}

TEST(PadKernel, OrderOfTexelsAndRepetitionChangeNothing) {
  std::mt19937 random(4);
  const PadLayout pad = fingertip();
  const PadState state = random_state(pad, random);
  std::vector<std::size_t> order(pad.size());
  std::iota(order.begin(), order.end(), 0);
  std::shuffle(order.begin(), order.end(), random);
  const PadLayout shuffled = pad.reordered(order);
  PadState shuffled_state = state;
  for (std::size_t i = 0; i < order.size(); ++i) {
    shuffled_state.depth[i] = state.depth[order[i]];
    shuffled_state.bristle_u[i] = state.bristle_u[order[i]];
    shuffled_state.bristle_v[i] = state.bristle_v[order[i]];
  }
  const Vector6 twist = random_twist(random);
  PadScratch scratch(pad);
  PadResponse first, second, other;
  respond(pad, TexelLaw{}, 1e-3, twist, state, scratch, first);
  respond(pad, TexelLaw{}, 1e-3, twist, state, scratch, second);
  respond(shuffled, TexelLaw{}, 1e-3, twist, shuffled_state, scratch, other);
  EXPECT_EQ(first.constant, second.constant);
  EXPECT_EQ(first.resistance, second.resistance);
  EXPECT_LT((other.constant - first.constant).norm(), 1e-9 * first.constant.norm());
  EXPECT_LT((other.resistance - first.resistance).norm(), 1e-9 * first.resistance.norm());
}

TEST(PadKernel, ExplicitStepIsTheLimitOfTheImplicitOne) {
  std::mt19937 random(5);
  const PadLayout pad = PadLayout::flat({});
  for (const TexelLaw& law : all_laws()) {
    if (law.static_friction == 0) continue;
    PadState state = random_state(pad, random);
    // Bristles within what friction holds, as steps leave them.
    for (std::size_t i = 0; i < pad.size(); ++i) {
      const double fn = normal_force(law, state.depth[i], 0);
      const Eigen::Vector2d z =
          0.5 * return_mapped(law, fn, Eigen::Vector2d(state.bristle_u[i], state.bristle_v[i]));
      state.bristle_u[i] = z.x();
      state.bristle_v[i] = z.y();
    }
    const Vector6 twist = (Vector6() << 0.02, -0.01, 1e-4, 0, 0, 0).finished();
    PadState explicit_state = state;
    const Vector6 expected = explicit_step(pad, law, 1e-8, twist, explicit_state);
    PadScratch scratch(pad);
    PadResponse response;
    respond(pad, law, 1e-8, twist, state, scratch, response);
    EXPECT_LT((response.constant - response.resistance * twist - expected).norm(),
              1e-4 * expected.norm());
  }
}

}  // namespace
}  // namespace prehend::contact
