#include "prehend/shape/seen_space.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "prehend/shape/symmetry.h"
#include "tests/shape/synthetic_view.h"

namespace prehend::shape {
namespace {

constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();
constexpr double kNever = -std::numeric_limits<double>::infinity();

/// A wall 1 m before the camera; its left half (columns below 50) only 0.6 m.
struct Step {
  geometry::PinholeCamera camera{100, 80, 100, 100, 49.5, 39.5};
  geometry::RigidTransform X_WC = geometry::RigidTransform::Identity();
  geometry::DepthImage depth{100, 80, 1.f};
  geometry::Plane table{-Eigen::Vector3d::UnitZ(), -2};  // 2 m before the camera

  Step() {
    for (int v = 0; v < 80; ++v) {
      for (int u = 0; u < 50; ++u) depth.at(u, v) = 0.6f;
    }
  }
  SeenSpace around(const std::vector<Eigen::Vector3f>& points, int margin) const {
    return make_seen_space(depth, camera, X_WC, table, points, margin);
  }
  /// All of the image.
  SeenSpace whole() const { return around({{0, 0, 1}}, 200); }
  Eigen::Vector3d at(double u, double v, double z) const { return camera.unproject(u, v, z); }
};

TEST(SeenSpace, IsEmptyBeforeWhatWasSeenAndNotBehind) {
  const Step step;
  const SeenSpace space = step.whole();
  EXPECT_NEAR(depth_in_empty_space(space, step.at(70, 40, 0.7)), 0.3, 1e-6);
  EXPECT_NEAR(depth_in_empty_space(space, step.at(70, 40, 1.2)), -0.2, 1e-6);
  EXPECT_NEAR(depth_in_empty_space(space, step.at(20, 40, 0.7)), -0.1, 1e-6);
}

TEST(SeenSpace, AnEdgeIsNoSurerThanTwoPixels) {
  const Step step;
  const SeenSpace space = step.whole();
  for (const double u : {50., 51.}) {
    EXPECT_NEAR(depth_in_empty_space(space, step.at(u, 40, 0.7)), -0.1, 1e-6) << u;
  }
  EXPECT_NEAR(depth_in_empty_space(space, step.at(52, 40, 0.7)), 0.3, 1e-6);
}

// A sheet on the table is as low as noise: where the table is seen to be bare, nothing is.
TEST(SeenSpace, BareTableIsEmptyDownToIt) {
  Step step;
  step.table.offset = -1.001;
  const SeenSpace space = step.whole();
  EXPECT_GT(depth_in_empty_space(space, step.at(80, 40, 1.0)), 0.04);
  // Beside what is nearer than the table, as far as that may look like it.
  EXPECT_LT(depth_in_empty_space(space, step.at(51, 40, 1.0)), 0);
  EXPECT_LT(depth_in_empty_space(space, step.at(40, 40, 0.7)), 0);
}

TEST(SeenSpace, NothingIsKnownBesideTheImageBehindTheCameraAndWhereNothingWasMeasured) {
  Step step;
  step.depth.at(80, 40) = kUnknown;
  step.depth.at(82, 40) = 0;
  const SeenSpace space = step.whole();
  EXPECT_EQ(depth_in_empty_space(space, step.at(80, 40, 0.5)), kNever);
  EXPECT_EQ(depth_in_empty_space(space, step.at(82, 40, 0.5)), kNever);
  EXPECT_NEAR(depth_in_empty_space(space, step.at(81, 40, 0.5)), 0.5, 1e-6);
  EXPECT_EQ(depth_in_empty_space(space, step.at(101, 40, 0.5)), kNever);
  EXPECT_EQ(depth_in_empty_space(space, {0, 0, -0.5}), kNever);
  EXPECT_EQ(depth_in_empty_space(space, {0, 0, 0}), kNever);
  EXPECT_EQ(depth_in_empty_space(space, Eigen::Vector3d::Constant(kUnknown)), kNever);
  EXPECT_EQ(depth_in_empty_space({}, step.at(70, 40, 0.5)), kNever);
}

TEST(SeenSpace, AWindowSaysTheSameAsTheWholeImage) {
  const Step step;
  const std::vector<Eigen::Vector3f> points = {step.at(55, 30, 0.9).cast<float>(),
                                               step.at(65, 45, 0.9).cast<float>()};
  const SeenSpace window = step.around(points, 3);
  EXPECT_EQ(window.camera.width, 65 - 55 + 1 + 6);
  EXPECT_EQ(window.camera.height, 45 - 30 + 1 + 6);
  for (int v = 27; v <= 48; ++v) {
    for (int u = 52; u <= 68; ++u) {
      EXPECT_EQ(depth_in_empty_space(window, step.at(u, v, 0.8)),
                depth_in_empty_space(step.whole(), step.at(u, v, 0.8)));
    }
  }
  EXPECT_EQ(depth_in_empty_space(window, step.at(51, 30, 0.8)), kNever);
  // Beside the image or behind the camera there is no window.
  EXPECT_TRUE(step.around({{9, 9, 1}}, 3).empty_until.empty());
  EXPECT_TRUE(step.around({{0, 0, -1}}, 3).empty_until.empty());
  EXPECT_TRUE(step.around({}, 3).empty_until.empty());
}

TEST(SeenSpace, ACompletedShapeKnowsWhereTheViewLookedThrough) {
  const auto truth = standing(geometry::make_box({0.06, 0.09, 0.12}), 0.4);
  SyntheticView view = synthetic_view(truth, {.width = 320});
  const CompletedShape shape = complete_by_symmetry(view.view());
  const geometry::RigidTransform X_CW = view.X_WC.inverse();
  // 5 cm over the box; its middle.
  EXPECT_GT(depth_in_empty_space(shape.seen_space, X_CW * Eigen::Vector3d(0, 0, 0.15)), 0.02);
  EXPECT_LT(depth_in_empty_space(shape.seen_space, X_CW * Eigen::Vector3d(0, 0, 0.06)), -0.02);
  for (const Eigen::Vector3f& p_W : shape.cloud_W.points) {
    EXPECT_LT(depth_in_empty_space(shape.seen_space, X_CW * p_W.cast<double>()), 0.005);
  }
  view.depth = {};
  EXPECT_TRUE(complete_by_symmetry(view.view()).seen_space.empty_until.empty());
  view.depth = geometry::DepthImage(3, 4, 1.f);
  EXPECT_THROW(complete_by_symmetry(view.view()), geometry::InputError);
}

}  // namespace
}  // namespace prehend::shape
