#include "nodes/grasp_planning/placed_objects.h"

#include <gtest/gtest.h>

#include "msgs/convert/objects.h"
#include "prehend/geometry/errors.h"
#include "prehend/surface/model.h"

namespace prehend::nodes {
namespace {

msgs::ObjectModel box_at(double x, double y) {
  return convert::to_message(surface::model_of_mesh(geometry::transformed(
      geometry::make_box({0.06, 0.06, 0.1}),
      geometry::make_transform(Eigen::Quaterniond::Identity(), {x, y, 0.05}))));
}

// Regression: what stood beside the camera's view was pushed over by what was put there next.
TEST(PlacedObjects, AreInTheWayWhereNothingIsSeen) {
  PlacedObjects placed;
  EXPECT_TRUE(placed.unseen({}).meshes_W.empty());
  placed.add(box_at(0, 0.3), nullptr);
  placed.add(box_at(0.2, 0.3), nullptr);
  EXPECT_EQ(placed.unseen({}).meshes_W.size(), 2u);
  EXPECT_EQ(placed.unseen({}).pieces_W.size(), 2u);
  // One of them is seen, a little beside where it was put.
  const planning::Neighbours unseen = placed.unseen({{4, neighbour_of(box_at(0.01, 0.31))}});
  ASSERT_EQ(unseen.meshes_W.size(), 1u);
  EXPECT_NEAR(geometry::bounds(unseen.meshes_W.front()).center().x(), 0.2, 1e-6);
}

// Regression: a box round what had fallen over reached to what stood beside it, unseen, and a
// bottle was put on that.
TEST(PlacedObjects, AreInTheWayBesideWhatIsSeen) {
  PlacedObjects placed;
  placed.add(box_at(0.12, 0.4), nullptr);
  const auto unseen_beside = [&placed](const msgs::ObjectModel& seen) {
    return placed.unseen({{0, neighbour_of(seen)}}).meshes_W.size();
  };
  EXPECT_EQ(unseen_beside(box_at(0.07, 0.37)), 1u) << "its corner is in the other's box";
  EXPECT_EQ(unseen_beside(box_at(0.10, 0.39)), 0u);
  const auto block = [](const Eigen::Vector3d& size, const Eigen::Vector3d& at) {
    return convert::to_message(surface::model_of_mesh(geometry::transformed(
        geometry::make_box(size), geometry::make_transform(Eigen::Quaterniond::Identity(), at))));
  };
  EXPECT_EQ(unseen_beside(block({0.02, 0.02, 0.03}, {0.1, 0.38, 0.09})), 1u) << "a part of it";
  EXPECT_EQ(unseen_beside(block({0.2, 0.1, 0.1}, {0.18, 0.4, 0.05})), 0u) << "with another thing";
}

// Regression: what was put down, picked again and put elsewhere stood at both places.
TEST(PlacedObjects, AreNoMoreWhereTheyWerePickedAgain) {
  PlacedObjects placed;
  placed.add(box_at(0, 0.3), nullptr);
  placed.add(box_at(0.2, 0.3), nullptr);
  const planning::Neighbours seen = neighbour_of(box_at(0.01, 0.3));
  placed.add(box_at(0.4, 0.3), &seen);
  const planning::Neighbours unseen = placed.unseen({});
  ASSERT_EQ(unseen.meshes_W.size(), 2u);
  EXPECT_NEAR(geometry::bounds(unseen.meshes_W[0]).center().x(), 0.2, 1e-6);
  EXPECT_NEAR(geometry::bounds(unseen.meshes_W[1]).center().x(), 0.4, 1e-6);
}

TEST(PlacedObjects, KeepsNoMoreThanItCan) {
  PlacedObjects placed;
  for (int i = 0; i < 80; ++i) placed.add(box_at(0.1 * i, 0), nullptr);
  EXPECT_EQ(placed.unseen({}).meshes_W.size(), 64u);
  msgs::ObjectModel broken = box_at(0, 0);
  broken.mutable_mesh()->set_vertex_count(3);
  EXPECT_THROW(placed.add(broken, nullptr), geometry::InputError);
  EXPECT_EQ(placed.unseen({}).meshes_W.size(), 64u);
  placed.clear();
  EXPECT_TRUE(placed.unseen({}).meshes_W.empty()) << "somebody may have taken them away";
}

}  // namespace
}  // namespace prehend::nodes
