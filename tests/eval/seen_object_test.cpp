// What is believed of a rendered object and of what is beside it.

#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "eval/grasp/seen_object.h"

namespace prehend::eval {
namespace {

std::shared_ptr<const geometry::TriangleMesh> box_at(const Eigen::Vector3d& middle,
                                                     const Eigen::Vector3d& size) {
  geometry::TriangleMesh mesh = geometry::make_box(size);
  for (Eigen::Vector3d& p : mesh.vertices) p += middle;
  return std::make_shared<geometry::TriangleMesh>(std::move(mesh));
}

// A carton, and a lower one 0.15 m beside it.
EvaluationObject carton(bool with_another) {
  EvaluationObject object;
  object.name = "carton";
  object.mesh_B = box_at({0, 0, 0.06}, {0.06, 0.08, 0.12});
  if (with_another) object.viewing.others_B = {box_at({0, 0.15, 0.04}, {0.06, 0.06, 0.08})};
  return object;
}

TEST(BelievedObject, WhatIsBesideItIsAnObstacle) {
  const auto sets = make_data_sets("test", {carton(true)});
  const Case one{&sets.front(), 0, 1};
  const Belief belief = believed_object(one, see_object(one, one.X_WB(), 0), PlannedOn::kPredicted);
  Eigen::AlignedBox3d obstacles, pieces;
  for (const auto& mesh : belief.others.meshes_W) obstacles.extend(geometry::bounds(mesh));
  for (const auto& piece : belief.others.pieces_W) pieces.extend(geometry::bounds(piece));
  EXPECT_TRUE(pieces.isApprox(obstacles, 0.01)) << "of the same";
  ASSERT_FALSE(obstacles.isEmpty());
  EXPECT_NEAR(obstacles.center().y(), 0.15, 0.02);
  EXPECT_NEAR(obstacles.max().z(), 0.08, 0.02);
  EXPECT_GT(obstacles.min().y(), geometry::bounds(belief.object.mesh_W).max().y());
}

TEST(BelievedObject, AloneItHasNoObstacles) {
  const auto sets = make_data_sets("test", {carton(false)});
  const Case one{&sets.front(), 0, 1};
  const Belief belief = believed_object(one, see_object(one, one.X_WB(), 0), PlannedOn::kDelaunay);
  EXPECT_TRUE(belief.others.meshes_W.empty());
  EXPECT_FALSE(belief.object.mesh_W.empty());
}

}  // namespace
}  // namespace prehend::eval
