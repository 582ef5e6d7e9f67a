#include "prehend/shape/neighbors.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "prehend/perception/segmented_scene.h"
#include "prehend/shape/scene_completion.h"
#include "prehend/shape/symmetry.h"
#include "tests/shape/synthetic_view.h"

namespace prehend::shape {
namespace {

using testing::IsEmpty;
using testing::SizeIs;

/// An upright sheet 10 cm wide and high at `x` [m].
void add_sheet(CompletedShape& shape, double x, PointOrigin origin) {
  for (int i = 0; i <= 20; ++i) {
    for (int j = 0; j <= 20; ++j) {
      shape.cloud_W.points.emplace_back(x, 0.005 * i - 0.05, 0.005 * j);
      shape.origin.push_back(origin);
      shape.support.push_back(origin == PointOrigin::kSeen ? PointSupport::kSeen
                                                           : PointSupport::kOccluded);
      shape.point_confidence.push_back(0.5f);
    }
  }
}

/// Seen at `front`, predicted to reach to `back` by sheets 1 cm apart [m].
CompletedShape body(double front, double back) {
  CompletedShape shape;
  add_sheet(shape, front, PointOrigin::kSeen);
  for (double x = front + 0.01; x < back + 1e-9; x += 0.01) {
    add_sheet(shape, x, PointOrigin::kMirrored);
  }
  return shape;
}

double farthest(const CompletedShape& shape) {
  double x = -1;
  for (const auto& p : shape.cloud_W.points) x = std::max(x, static_cast<double>(p.x()));
  return x;
}

TEST(KeepApart, OneEndsWhereTheNextWasSeenToBegin) {
  CompletedShape first = body(0, 0.08), second = body(0.05, 0.12);
  first.alternatives.push_back(body(0, 0.10));
  for (const auto& p : first.cloud_W.points) {
    first.cloud_W.colors.push_back({static_cast<std::uint8_t>(1000 * p.x()), 0, 0});
  }
  const std::size_t of_second = second.cloud_W.size();
  keep_apart({&first, &second}, {});

  ASSERT_THAT(first.bounds_W, SizeIs(1));
  ASSERT_THAT(second.bounds_W, SizeIs(1));
  EXPECT_NEAR(first.bounds_W[0].signed_distance({0, 0, 0}), 0.05, 0.004);
  EXPECT_NEAR(first.bounds_W[0].signed_distance({0.05, 0, 0}), 0, 0.004);
  EXPECT_EQ(second.bounds_W[0].normal, -first.bounds_W[0].normal);
  EXPECT_EQ(second.bounds_W[0].offset, -first.bounds_W[0].offset);
  EXPECT_NEAR(farthest(first), 0.05, 0.011);
  EXPECT_NEAR(farthest(first.alternatives[0]), 0.05, 0.011);
  EXPECT_EQ(second.cloud_W.size(), of_second);
  EXPECT_EQ(first.origin.size(), first.cloud_W.size());
  EXPECT_EQ(first.support.size(), first.cloud_W.size());
  EXPECT_EQ(first.point_confidence.size(), first.cloud_W.size());
  ASSERT_EQ(first.cloud_W.colors.size(), first.cloud_W.size());
  for (std::size_t i = 0; i < first.cloud_W.size(); ++i) {
    EXPECT_EQ(first.cloud_W.colors[i][0],
              static_cast<std::uint8_t>(1000 * first.cloud_W.points[i].x()));
  }
  EXPECT_NEAR(first.region_confidence[1], 0.5, 1e-6);
}

TEST(KeepApart, TheOrderOfTheBodiesDoesNotMatter) {
  CompletedShape a = body(0, 0.08), b = body(0.047, 0.12), c = a, d = b;
  keep_apart({&a, &b}, {});
  keep_apart({&d, &c}, {});
  EXPECT_TRUE(a.cloud_W.points == c.cloud_W.points);
  EXPECT_TRUE(b.cloud_W.points == d.cloud_W.points);
}

TEST(KeepApart, WhatDoesNotOverlapStaysAsItIs) {
  CompletedShape first = body(0, 0.04), second = body(0.05, 0.12);
  const auto points = first.cloud_W.points;
  keep_apart({&first, &second}, {});
  EXPECT_THAT(first.bounds_W, IsEmpty());
  EXPECT_THAT(second.bounds_W, IsEmpty());
  EXPECT_EQ(first.cloud_W.points, points);
}

// One stands on the other, set back: an upright plane is between what was seen of them.
TEST(KeepApart, WhatStandsOnAnotherAndThatAreLeftAlone) {
  CompletedShape lower = body(0, 0.08), upper = body(0.02, 0.06);
  for (auto& p : upper.cloud_W.points) p.z() += 0.1f;
  keep_apart({&lower, &upper}, {});
  EXPECT_THAT(lower.bounds_W, IsEmpty());
  EXPECT_THAT(upper.bounds_W, IsEmpty());
}

// One plane goes through both in every direction.
TEST(KeepApart, WhatWasSeenWithinEachOtherIsLeftAlone) {
  CompletedShape wide = body(0, 0.08), within = body(0.02, 0.06);
  add_sheet(wide, 0.06, PointOrigin::kSeen);
  keep_apart({&wide, &within}, {});
  EXPECT_THAT(wide.bounds_W, IsEmpty());
}

TEST(KeepApart, BodiesWithoutPointsAreLeftAlone) {
  CompletedShape empty, first = body(0, 0.08);
  keep_apart({&empty, &first}, {});
  keep_apart({}, {});
  EXPECT_THAT(first.bounds_W, IsEmpty());
}

perception::SegmentedScene scene_of(const SyntheticView& view, int objects) {
  perception::SegmentedScene scene;
  scene.camera = view.camera;
  scene.X_WC = view.X_WC;
  scene.depth = view.depth;
  scene.table_W = view.table_W;
  for (int i = 0; i < objects; ++i) scene.objects.push_back({i, view.cloud_W, view.mask});
  return scene;
}

TEST(CompleteScene, IsThatOfEachObject) {
  const SyntheticView view =
      synthetic_view(standing(geometry::make_box({0.06, 0.08, 0.1}), 0.4), {.width = 320});
  const auto scene = scene_of(view, 1);
  const auto shapes = complete_scene(scene);
  ASSERT_THAT(shapes, SizeIs(1));
  EXPECT_EQ(shapes[0].get().cloud_W.points, complete_by_symmetry(view.view()).cloud_W.points);
  EXPECT_GT(shapes[0].seconds, 0);
}

TEST(CompleteScene, AnObjectThatFailsCostsNoOther) {
  const SyntheticView view =
      synthetic_view(standing(geometry::make_box({0.06, 0.08, 0.1}), 0.4), {.width = 320});
  auto scene = scene_of(view, 2);
  scene.objects[0].cloud_W.points.resize(5);
  const auto shapes = complete_scene(scene);
  ASSERT_THAT(shapes, SizeIs(2));
  EXPECT_ANY_THROW(shapes[0].get());
  EXPECT_FALSE(shapes[1].get().cloud_W.empty());
  EXPECT_THROW(complete_scene(scene, {.shifts = 1})[1].get(), std::invalid_argument);
}

}  // namespace
}  // namespace prehend::shape
