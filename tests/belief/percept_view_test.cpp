#include "prehend/belief/percept_view.h"

#include <cmath>
#include <limits>
#include <stdexcept>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "prehend/geometry/errors.h"
#include "prehend/geometry/mesh_query.h"
#include "prehend/geometry/rigid_transform.h"
#include "prehend/simulation/shapes.h"

namespace prehend::belief {
namespace {

using geometry::RigidTransform;
using geometry::TriangleMesh;

constexpr double kHeight = 0.2;  // m, of the box's middle over the table

TriangleMesh shifted(const TriangleMesh& mesh, const Eigen::Vector3d& by) {
  RigidTransform X = RigidTransform::Identity();
  X.translation() = by;
  return geometry::transformed(mesh, X);
}

TriangleMesh box_at(const Eigen::Vector3d& middle_W, double width = 0.06) {
  return shifted(simulation::make_standing_box({width, width, 0.1}),
                 middle_W - Eigen::Vector3d(0, 0, 0.05));
}

constexpr double kWall = -0.3;  // m

// A box held before a camera that looks at it level from 0.6 m, along -x of the world, at a wall,
// which takes the table's place.
LiftedView view_of(const TriangleMesh& thought_W) {
  LiftedView view;
  view.camera = {640, 480, 525, 525, 319.5, 239.5};
  view.X_WC = geometry::look_at({0.6, 0, kHeight}, {0, 0, kHeight});
  view.table_W = {Eigen::Vector3d::UnitX(), kWall};
  view.X_WH.translation() = Eigen::Vector3d(0, 0, kHeight + 0.1);
  view.thought_W = thought_surface(thought_W);
  return view;
}

const Eigen::Vector3d kMiddle(0, 0, kHeight);

TEST(PerceptView, OfABoxIsItsFace) {
  const PerceivedView seen = predicted_view(box_at(kMiddle), view_of(box_at(kMiddle)));
  // Less the pixels along its outline: two each side of the coarser picture, of 2 mm each.
  const double pixel = 0.57 * 2 / 525, edge = 2 * pixel;
  EXPECT_NEAR(seen.area, (0.06 - 2 * edge) * (0.1 - 2 * edge), 4e-4);
  // The hand is above it; the camera's y is down, and its z away from it.
  EXPECT_NEAR(seen.center_C.x(), 0, pixel);
  EXPECT_NEAR(seen.center_C.y(), 0.1, pixel);
  EXPECT_NEAR(seen.center_C.z(), -0.03, 1e-5);
  EXPECT_NEAR(seen.spread.x(), (0.06 - 2 * edge) / std::sqrt(12), pixel);
  EXPECT_NEAR(seen.spread.y(), (0.1 - 2 * edge) / std::sqrt(12), pixel);
  int shown = 0;
  for (const float z : seen.depth.data) shown += std::isfinite(z);
  EXPECT_NEAR(shown * pixel * pixel, seen.area, 1e-5);
}

TEST(PerceptView, ShowsWhereItIsBesideWhatIsThought) {
  const LiftedView view = view_of(box_at(kMiddle));
  const PerceivedView there = predicted_view(box_at(kMiddle), view);
  const Eigen::Vector3d by(0.004, 0.012, -0.008);
  const PerceivedView beside = predicted_view(box_at(kMiddle + by), view);
  // Right in the picture is +y of the world where one looks along -x.
  const Eigen::Vector3d moved_C = view.X_WC.linear().transpose() * by;
  EXPECT_LT((beside.center_C - there.center_C - moved_C).norm(), 0.0015);
  EXPECT_EQ(beside.depth.width, there.depth.width) << "pictures are of the same part";
  const PerceivedView thin = predicted_view(box_at(kMiddle, 0.04), view);
  EXPECT_LT(thin.area, 0.75 * there.area);
  EXPECT_EQ(predicted_view(shifted(box_at(kMiddle), {0, 0.5, 0}), view).area, 0) << "it is gone";
}

TEST(PerceptView, WhatTheRobotHidesIsNotSeenNorTakenForIt) {
  LiftedView view = view_of(box_at(kMiddle));
  const PerceivedView all = predicted_view(box_at(kMiddle), view);
  // A plate before its lower half.
  view.robot_W = {
      shifted(simulation::make_standing_box({0.005, 0.2, 0.1}), {0.1, 0, kHeight - 0.1})};
  const PerceivedView upper = predicted_view(box_at(kMiddle), view);
  EXPECT_LT(upper.area, 0.6 * all.area);
  EXPECT_GT(upper.area, 0.3 * all.area);
  EXPECT_LT(upper.center_C.y(), all.center_C.y() - 0.015);
  // Held by nothing but the plate: nothing of it is the object.
  const TriangleMesh elsewhere = shifted(box_at(kMiddle), {0, 0.5, 0});
  EXPECT_EQ(predicted_view(elsewhere, view).area, 0);
}

// What is measured of the same scene, at full size, by rays of a test's own.
TEST(PerceptView, WhatIsMeasuredIsAsItWasToBeSeen) {
  const TriangleMesh box = box_at(kMiddle + Eigen::Vector3d(0, 0.005, 0.003));
  const LiftedView view = view_of(box_at(kMiddle));
  const geometry::MeshQuery query(box);
  geometry::DepthImage depth(view.camera.width, view.camera.height,
                             std::numeric_limits<float>::quiet_NaN());
  for (int v = 0; v < depth.height; ++v) {
    for (int u = 0; u < depth.width; ++u) {
      const Eigen::Vector3d ray_C = view.camera.unproject(u, v, 1);
      const auto hit =
          query.cast_ray(view.X_WC.translation(), (view.X_WC.linear() * ray_C).normalized());
      const double wall = view.X_WC.translation().x() - kWall;  // along the optical axis
      depth.at(u, v) = static_cast<float>(hit ? hit->distance / ray_C.norm() : wall);
    }
  }
  const PerceivedView measured = perceived_view(depth, view), foretold = predicted_view(box, view);
  EXPECT_NEAR(measured.area, foretold.area, 0.05 * foretold.area);
  EXPECT_LT((measured.center_C - foretold.center_C).norm(), 5e-4);
  EXPECT_LT((measured.spread - foretold.spread).norm(), 5e-4);
  geometry::DepthImage unknown(640, 480, std::numeric_limits<float>::quiet_NaN());
  EXPECT_EQ(perceived_view(unknown, view).area, 0);
}

TEST(PerceptView, RefusesWhatCannotBeCompared) {
  LiftedView view = view_of(box_at(kMiddle));
  EXPECT_THROW(perceived_view(geometry::DepthImage(320, 240, 1), view), std::invalid_argument);
  EXPECT_THROW(predicted_view(TriangleMesh(), view), geometry::InputError);
  view.thought_W = {};
  EXPECT_THROW(predicted_view(box_at(kMiddle), view), std::invalid_argument);
  view = view_of(box_at(kMiddle));
  view.camera.width = 0;
  EXPECT_THROW(predicted_view(box_at(kMiddle), view), std::invalid_argument);
  // The camera is within what it looks at, or it is behind the camera: no crash.
  view = view_of(box_at(kMiddle));
  view.X_WC.translation() = kMiddle;
  EXPECT_GE(predicted_view(box_at(kMiddle), view).area, 0);
  view.X_WC = geometry::look_at({0.6, 0, kHeight}, {1.2, 0, kHeight});
  EXPECT_EQ(predicted_view(box_at(kMiddle), view).area, 0);
}

}  // namespace
}  // namespace prehend::belief
