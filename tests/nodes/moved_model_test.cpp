// A predicted object that has moved, as a message for new plans.

#include <numbers>

#include <gtest/gtest.h>

#include "msgs/convert/geometry.h"
#include "msgs/convert/objects.h"
#include "nodes/grasp_cycle/predicted_objects.h"

namespace prehend::nodes {
namespace {

using geometry::RigidTransform;

msgs::ObjectModel box_model() {
  surface::ObjectModel model;
  model.mesh_W = geometry::make_box({0.04, 0.06, 0.1});
  model.convex_pieces_W = {model.mesh_W, geometry::make_box({0.01, 0.01, 0.01})};
  model.alternatives_W = {geometry::make_box({0.04, 0.06, 0.2})};
  model.mass_properties = geometry::mass_properties(model.mesh_W);
  msgs::ObjectModel message = convert::to_message(model);
  message.set_id(3);
  message.set_valid(true);
  message.set_confidence(0.7);
  message.mutable_header()->set_stamp(5);
  *message.mutable_table() = convert::to_message(geometry::Plane{Eigen::Vector3d::UnitZ(), -0.05});
  *message.mutable_known()->mutable_x_wo() = convert::to_message(RigidTransform::Identity());
  return message;
}

TEST(MovedModel, MovesAllThatMovesWithTheBodyAndNothingElse) {
  RigidTransform X = RigidTransform::Identity();
  X.translation() = Eigen::Vector3d(0.1, -0.2, 0.03);
  X.rotate(Eigen::AngleAxisd(std::numbers::pi / 2, Eigen::Vector3d::UnitX()));
  const msgs::ObjectModel before = box_model(), after = moved_model(before, X);
  const surface::ObjectModel was = convert::from_message(before), is = convert::from_message(after);
  ASSERT_EQ(is.mesh_W.vertices.size(), was.mesh_W.vertices.size());
  for (std::size_t i = 0; i < is.mesh_W.vertices.size(); ++i) {
    EXPECT_TRUE(is.mesh_W.vertices[i].isApprox(X * was.mesh_W.vertices[i], 1e-6));
  }
  EXPECT_EQ(is.mesh_W.triangles, was.mesh_W.triangles);
  ASSERT_EQ(is.convex_pieces_W.size(), 2u);
  ASSERT_EQ(is.alternatives_W.size(), 1u);
  // As computed of the moved mesh.
  const auto truth = geometry::mass_properties(is.mesh_W);
  EXPECT_NEAR(is.mass_properties.volume, truth.volume, 1e-9);
  EXPECT_TRUE(is.mass_properties.center_of_mass.isApprox(truth.center_of_mass, 1e-6));
  EXPECT_LT((is.mass_properties.unit_density_inertia - truth.unit_density_inertia).norm(),
            1e-6 * truth.unit_density_inertia.norm());
  EXPECT_TRUE(convert::from_message(after.known().x_wo()).isApprox(X, 1e-9));
  EXPECT_EQ(after.id(), 3u);
  EXPECT_EQ(after.confidence(), before.confidence());
  EXPECT_EQ(after.table().SerializeAsString(), before.table().SerializeAsString());
}

TEST(MovedModel, WhatHasNotMovedIsTheSame) {
  const msgs::ObjectModel model = box_model();
  EXPECT_EQ(moved_model(model, RigidTransform::Identity()).SerializeAsString(),
            model.SerializeAsString());
}

}  // namespace
}  // namespace prehend::nodes
