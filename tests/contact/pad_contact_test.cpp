// A pad's equations and a slide's step, as solvers use them.

#include "prehend/contact/pad_contact.h"

#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>

#include <gtest/gtest.h>

#include "prehend/contact/rotation.h"
#include "prehend/contact/sdirk.h"
#include "prehend/contact/slide_step.h"

namespace prehend::contact {
namespace {

class RandomPad : public ::testing::Test {
 protected:
  Eigen::Vector3d any(double scale) {
    return scale * Eigen::Vector3d(unit_(random_), unit_(random_), unit_(random_));
  }
  PadMount mount() {
    PadMount mount{PadLayout::flat({}), {}, {}, 0, any(0.5)};
    mount.X_GP = pose();
    return mount;
  }
  geometry::RigidTransform pose() {
    return geometry::make_transform(rotation_by(any(2)), any(0.1));
  }
  std::mt19937 random_{5};
  std::uniform_real_distribution<double> unit_{-1, 1};
};

// The blocks are the response's affine wrench, seen from the body's centre of mass and the slide:
// matrix u - right = -h wrench for every u.
TEST_F(RandomPad, BlocksAreTheResponseInTheBodysAndTheSlidesCoordinates) {
  for (int i = 0; i < 50; ++i) {
    const PadMount pad = mount();
    const double h = 0.003;
    const PadPlacement place = place_pad(pad, pose(), any(0.3), any(2), 0.01, h);
    PadState state(pad.layout);
    for (std::size_t k = 0; k < pad.layout.size(); ++k) {
      state.depth[k] = 0.001 * (1 + unit_(random_));
      state.bristle_u[k] = 1e-4 * unit_(random_);
    }
    PadScratch scratch(pad.layout);
    PadResponse response;
    const Eigen::Vector3d p_WB = any(0.1);
    Vector6 guess;
    guess << any(0.02), any(0.2);
    respond(pad.layout, pad.law, h, guess, state, scratch, response);
    ASSERT_GT(response.pressing, 0);
    const PadBlocks blocks = pad_blocks(place, response, h, p_WB);

    const Eigen::Vector3d v = any(0.2), w = any(2);
    const double slide = 0.05 * unit_(random_);
    Vector6 u;
    u << v, w;
    const Vector6 wrench_P =
        response.constant - response.resistance * relative_twist(pad, place, slide, v, w, p_WB);
    const Eigen::Vector3d force = place.R_WP * wrench_P.head<3>();
    const Eigen::Vector3d torque =
        place.R_WP * wrench_P.tail<3>() + (place.p_WP - p_WB).cross(force);
    const Vector6 body =
        blocks.body_right - blocks.body_body * u + blocks.slide_body.transpose() * slide;
    EXPECT_LT((body.head<3>() - h * force).norm(), 1e-12);
    EXPECT_LT((body.tail<3>() - h * torque).norm(), 1e-12);
    const double on_slide =
        -blocks.slide_right - blocks.slide_slide * slide + blocks.slide_body.dot(u.transpose());
    EXPECT_NEAR(on_slide, -h * place.direction_W.dot(force), 1e-12);
  }
}

// At the end of the step the pad is where the gripper and the slide take it, exactly.
TEST_F(RandomPad, EndsWhereTheGripperTakesIt) {
  const PadMount pad = mount();
  const geometry::RigidTransform X_WG = pose();
  const double h = 0.02, q = 0.01, slide_velocity = 0.08;
  const PadPlacement place = place_pad(pad, X_WG, any(0.3), any(2), q, h);
  geometry::RigidTransform X_GP = pad.X_GP;
  X_GP.translation() += (q + h * slide_velocity) * pad.direction_G;
  const geometry::RigidTransform expected = X_WG * X_GP;
  EXPECT_LT((place.X_WP_at_end(pad, X_WG.linear(), h, slide_velocity).matrix() - expected.matrix())
                .norm(),
            1e-14);
}

TEST(SlideStep, CutsTheServoAndSettles) {
  SlideStep slide(SlideModel{});
  SlideCommand command;
  command.force = 1;
  command.stiffness = 1e4;
  command.reference = 0.01;
  command.damping = 10;
  command.speed = 0.1;
  command.limit = 20;
  slide.set_command(command, 2.0);
  // 1e4 (0.01 + 0.5 * 0.1 - 0.06) + 10 (0.1 - 0.3)
  EXPECT_NEAR(slide.servo_force(2.5, 0.06, 0.3), -2, 1e-9);
  EXPECT_NEAR(slide.drive_force(2.5, 0.06, 0.3), -1, 1e-9);
  EXPECT_NEAR(slide.drive_force(2.0, 0, 0), 21, 1e-12) << "cut at the limit";
  EXPECT_NEAR(slide.most_force(2.0, 0, 0), 21, 1e-12);
  EXPECT_TRUE(slide.update_saturation(0, 1e-3, 2.0, 0, true));
  slide.linearise(0, 0, 1e-3, 2.0, 0);
  EXPECT_NEAR(slide.offset(), 21, 1e-12);
  EXPECT_EQ(slide.slope(), 0);
  // From one limit to the other by way of none.
  EXPECT_TRUE(slide.update_saturation(0, 1e-3, 2.0, 100, false));
  slide.linearise(0, 0, 1e-3, 2.0, 0);
  EXPECT_NEAR(slide.slope(), 1e-3 * 1e4 + 10, 1e-12);
  EXPECT_TRUE(slide.update_saturation(0, 1e-3, 2.0, 100, false));
  EXPECT_FALSE(slide.update_saturation(0, 1e-3, 2.0, 100, false));
  command.limit = -1;
  EXPECT_THROW(slide.set_command(command, 0), std::invalid_argument);
  command.limit = 1;
  command.force = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(slide.set_command(command, 0), std::invalid_argument);
}

// Where the method says that its second step begins.
TEST(Sdirk, ExtrapolatesMotionsThatAddUp) {
  EXPECT_NEAR(kSdirkGamma, 1 - 1 / std::sqrt(2.0), 1e-16);
  EXPECT_NEAR(sdirk_extrapolated(2.0, 2.0 + kSdirkGamma), 2.0 + 1 - kSdirkGamma, 1e-15);
  // Turning steadily about a main axis.
  const Eigen::Matrix3d inertia = Eigen::Vector3d(1, 2, 3).asDiagonal();
  RigidMotion base, first;
  base.angular_velocity = first.angular_velocity = Eigen::Vector3d(0, 0, 0.7);
  first.q_WB = rotation_by(Eigen::Vector3d(0, 0, 0.7 * kSdirkGamma));
  const RigidMotion out = sdirk_extrapolated(base, first, inertia);
  EXPECT_LT((rotation_vector(out.q_WB) - Eigen::Vector3d(0, 0, 0.7 * (1 - kSdirkGamma))).norm(),
            1e-15);
  EXPECT_LT((out.angular_velocity - base.angular_velocity).norm(), 1e-15);
  EXPECT_EQ(sdirk_extrapolated(RigidMotion{}, RigidMotion{}, inertia).angular_velocity.norm(), 0);
}

}  // namespace
}  // namespace prehend::contact
