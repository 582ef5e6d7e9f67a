#include "prehend/belief/held_object.h"

#include <cmath>
#include <limits>
#include <stdexcept>

#include <gtest/gtest.h>

#include "prehend/geometry/mesh_query.h"
#include "tests/belief/predicted.h"

namespace prehend::belief {
namespace {

using geometry::RigidTransform;

/// Turned about an axis through `middle`, and raised.
RigidTransform turned(const Eigen::Vector3d& middle, double angle, const Eigen::Vector3d& axis,
                      double height = 0.2) {
  RigidTransform X = RigidTransform::Identity();
  X.linear() = Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
  X.translation() = middle - X.linear() * middle + height * Eigen::Vector3d::UnitZ();
  return X;
}

/// Seen by the camera of `predicted`, which stands still, when the hand says that it is at X_WO and
/// it is `slipped` in the hand.
HeldLook look_at(const Predicted& predicted, const RigidTransform& X_WO,
                 const RigidTransform& slipped = RigidTransform::Identity(),
                 const std::vector<geometry::TriangleMesh>& hand_W = {}) {
  std::vector<geometry::TriangleMesh> all_W = hand_W;
  all_W.push_back(geometry::transformed(predicted.truth_W, X_WO * slipped));
  const geometry::MeshQuery query(geometry::concatenated(all_W));
  const shape::SyntheticView& view = predicted.view;
  geometry::DepthImage depth(view.camera.width, view.camera.height,
                             std::numeric_limits<float>::quiet_NaN());
  const Eigen::Vector3d eye = view.X_WC.translation();
  for (int v = 0; v < depth.height; ++v) {
    for (int u = 0; u < depth.width; ++u) {
      const Eigen::Vector3d ray =
          (view.X_WC.linear() * view.camera.unproject(u, v, 1)).normalized();
      const double cosine = ray.dot(view.X_WC.linear().col(2));
      const auto hit = query.cast_ray(eye, ray);
      const double to_table = -view.table_W.signed_distance(eye) / view.table_W.normal.dot(ray);
      const double along = hit ? hit->distance : to_table;
      if (along > 0) depth.at(u, v) = static_cast<float>(along * cosine);
    }
  }
  geometry::PointCloud thought_W = predicted.shape.cloud_W;
  thought_W.normals.clear();
  HeldLook look = held_look(depth, view.camera, view.X_WC, view.table_W, hand_W,
                            geometry::transformed(thought_W, X_WO));
  look.X_WO = X_WO;
  return look;
}

// The far side is predicted 2 cm too deep: what is seen when it is turned mends it, though the hand
// holds it otherwise than it was gripped.
TEST(HeldObject, TurningClosesTheModel) {
  const Predicted predicted = too_deep(box(), 0.02);
  const Eigen::Vector3d middle = geometry::bounds(predicted.truth_W).center();
  HeldObject held(predicted.shape, predicted.view.table_W);
  const double before = deviation_of(held.model().mesh_W, predicted.truth_W);
  const double guessed = held.model().guessed_area;
  EXPECT_GT(before, 0.0015);
  RigidTransform slipped = turned(middle, 0.08, {0.2, 1, 0.4}, 0);
  slipped.translation() += Eigen::Vector3d(0.003, -0.002, 0.002);
  for (const double angle : {0.0, 0.9, 1.8, 2.7, 3.6, 4.5}) {
    const RigidTransform X_WO = turned(middle, angle, Eigen::Vector3d::UnitZ());
    const TakenLook taken = held.add(look_at(predicted, X_WO, slipped));
    EXPECT_EQ(taken.problem, "") << angle;
    const Eigen::Vector3d off = taken.X_WO * middle - X_WO * slipped * middle;
    EXPECT_LT(off.norm(), 0.002) << angle;
  }
  EXPECT_EQ(held.looks(), 6);
  const surface::ObjectModel model = held.model();
  EXPECT_TRUE(model.defects.watertight());
  EXPECT_LT(deviation_of(model.mesh_W, predicted.truth_W), 0.001);
  EXPECT_LT(model.guessed_area, 0.5 * guessed);
}

// Points of the links before it are none of its, and what they hide stays unknown.
TEST(HeldObject, TheHandIsNoPartOfIt) {
  const Predicted predicted(box());
  const Eigen::Vector3d middle = geometry::bounds(predicted.truth_W).center();
  const RigidTransform X_WO = turned(middle, 0, Eigen::Vector3d::UnitZ());
  RigidTransform X_WL = X_WO;
  X_WL.translation() += middle + Eigen::Vector3d(0.05, 0, 0);
  const std::vector<geometry::TriangleMesh> finger{
      geometry::transformed(geometry::make_box({0.015, 0.02, 0.12}), X_WL)};
  const HeldLook look = look_at(predicted, X_WO, RigidTransform::Identity(), finger);
  EXPECT_GT(look.seen_W.size(), 500U);
  const geometry::MeshQuery truth(geometry::transformed(predicted.truth_W, X_WO));
  for (const Eigen::Vector3f& p : look.seen_W.points) {
    ASSERT_LT(truth.nearest(p.cast<double>())->distance, 1e-4);
  }
  HeldObject held(predicted.shape, predicted.view.table_W);
  EXPECT_EQ(held.add(look).problem, "");
  EXPECT_LT(deviation_of(held.model().mesh_W, predicted.truth_W), 0.0015);
}

TEST(HeldObject, WhatIsNotThereIsNotTaken) {
  const Predicted predicted(box());
  const Eigen::Vector3d middle = geometry::bounds(predicted.truth_W).center();
  const RigidTransform X_WO = turned(middle, 0.3, Eigen::Vector3d::UnitZ());
  RigidTransform fallen = RigidTransform::Identity();
  fallen.translation().x() = -1;
  HeldObject held(predicted.shape, predicted.view.table_W);
  const TakenLook lost = held.add(look_at(predicted, X_WO, fallen));
  EXPECT_NE(lost.problem.find("not held any more"), std::string::npos) << lost.problem;
  // It hangs 3 cm lower than the hand says.
  RigidTransform low = RigidTransform::Identity();
  low.translation().z() = -0.03;
  const TakenLook slid = held.add(look_at(predicted, X_WO, low));
  EXPECT_NE(slid.problem, "");
  EXPECT_EQ(held.looks(), 0);
  EXPECT_LT(deviation_of(held.model().mesh_W, predicted.truth_W), 0.0015);
}

TEST(HeldObject, SameLooksSameModel) {
  const Predicted predicted = too_deep(box(), 0.01);
  const Eigen::Vector3d middle = geometry::bounds(predicted.truth_W).center();
  HeldObject first(predicted.shape, predicted.view.table_W);
  HeldObject second(predicted.shape, predicted.view.table_W);
  for (const double angle : {0.0, 1.0, 2.0}) {
    const HeldLook look = look_at(predicted, turned(middle, angle, Eigen::Vector3d::UnitZ()));
    first.add(look);
    second.add(look);
  }
  EXPECT_EQ(first.model().mesh_W.vertices, second.model().mesh_W.vertices);
}

TEST(HeldObject, RefusesWhatIsNoLook) {
  const Predicted predicted(box());
  HeldObject held(predicted.shape, predicted.view.table_W);
  HeldLook look;
  look.seen_W.points.assign(100, Eigen::Vector3f::Constant(std::nanf("")));
  EXPECT_THROW(held.add(look), std::invalid_argument);
  HeldObjectOptions options;
  options.closing.turn = 0;
  EXPECT_THROW(HeldObject(predicted.shape, predicted.view.table_W, options), std::invalid_argument);
  const shape::SyntheticView& view = predicted.view;
  EXPECT_THROW(held_look({}, view.camera, view.X_WC, view.table_W, {}, predicted.shape.cloud_W),
               std::invalid_argument);
  HeldLookOptions taking;
  taking.step = 0;
  EXPECT_THROW(held_look(view.depth, view.camera, view.X_WC, view.table_W, {},
                         predicted.shape.cloud_W, taking),
               std::invalid_argument);
  geometry::PointCloud bare = predicted.shape.cloud_W;
  bare.normals.clear();
  EXPECT_THROW(held_poses(bare, {}, {}, {}), std::invalid_argument);
  EXPECT_THROW(held_poses({}, {}, {0, 1}, {}), std::invalid_argument);
  EXPECT_TRUE(held_poses({}, {}, {}, {}).empty());
}

}  // namespace
}  // namespace prehend::belief
