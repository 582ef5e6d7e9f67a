#include "prehend/perception/segmentation.h"

#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "prehend/geometry/errors.h"
#include "prehend/perception/object_parts.h"
#include "tests/perception/synthetic_view.h"

namespace prehend::perception {
namespace {

using testing::back_wall;
using testing::render;
using testing::standing_box;
using testing::SyntheticView;
using testing::table_top;

double box_overlap(const geometry::MaskImage& mask, const geometry::Image<int>& owner, int box) {
  double both = 0;
  double either = 0;
  for (std::size_t i = 0; i < mask.data.size(); ++i) {
    const bool a = mask.data[i] != 0;
    const bool b = owner.data[i] == box;
    both += a && b;
    either += a || b;
  }
  return both / either;
}

SyntheticView three_boxes() {
  SyntheticView view;
  view.boxes = {table_top(), back_wall(), standing_box(-0.15, 0, {0.1, 0.1, 0.15}),
                standing_box(0.1, 0.1, {0.07, 0.12, 0.1}),
                standing_box(0.25, -0.1, {0.05, 0.05, 0.06})};
  return view;
}

TEST(Segment, FindsEveryBoxWithItsMask) {
  SyntheticView view = three_boxes();
  view.noise = 0.001;
  geometry::DepthImage depth;
  const geometry::Image<int> owner = testing::owners(view, depth);
  const SegmentedScene scene = segment(render(view), view.camera, view.X_WC);
  ASSERT_EQ(scene.objects.size(), 3U);
  EXPECT_GT(box_overlap(scene.objects[0].mask, owner, 2), 0.88);
  EXPECT_GT(box_overlap(scene.objects[1].mask, owner, 3), 0.85);
  EXPECT_GT(box_overlap(scene.objects[2].mask, owner, 4), 0.75);  // its lowest 8 mm are the table's
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_EQ(scene.objects[k].id, static_cast<int>(k));
    EXPECT_FALSE(scene.objects[k].touches_image_border);
    if (k > 0) {
      EXPECT_LE(scene.objects[k].cloud_W.size(), scene.objects[k - 1].cloud_W.size());
    }
  }
}

TEST(Segment, PutsPointsIntoTheGivenWorld) {
  const SyntheticView view = three_boxes();
  const SegmentedScene scene = segment(render(view), view.camera, view.X_WC);
  EXPECT_NEAR(scene.table_W.offset, 0, 1e-4);
  EXPECT_NEAR(scene.table_W.normal.z(), 1, 1e-6);
  for (const Eigen::Vector3f& p : scene.objects[0].cloud_W.points) {
    EXPECT_NEAR(p.x(), -0.15, 0.0501);
    EXPECT_NEAR(p.y(), 0, 0.0501);
    EXPECT_LT(p.z(), 0.1501);
  }
}

TEST(Segment, MakesTheWorldFromTheTable) {
  const SyntheticView view = three_boxes();
  const SegmentedScene scene = segment(render(view), view.camera);
  EXPECT_NEAR(scene.table_W.normal.z(), 1, 1e-9);
  EXPECT_NEAR(scene.table_W.offset, 0, 1e-9);
  EXPECT_NEAR(scene.X_WC.translation().z(), 0.6, 1e-3);  // height of the camera
  EXPECT_NEAR((scene.X_WC.linear() * scene.X_WC.linear().transpose()).trace(), 3, 1e-9);
  EXPECT_GT(scene.X_WC.linear().determinant(), 0);
  EXPECT_GT(scene.X_WC.linear()(0, 0), 0.99);  // x to the right of the image
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double count = 0;
  for (const ObjectHypothesis& object : scene.objects) {
    for (const Eigen::Vector3f& p : object.cloud_W.points) sum += p.cast<double>();
    count += static_cast<double>(object.cloud_W.size());
  }
  EXPECT_NEAR((sum / count).head<2>().norm(), 0, 1e-5);  // origin under the objects
}

// Of a camera whose pose in another world is known.
TEST(Segment, TheWorldOfTheTableIsTheSameFromAnyWorld) {
  const SyntheticView view = three_boxes();
  const SegmentedScene expected = segment(render(view), view.camera);
  geometry::RigidTransform X_WC = view.X_WC;
  X_WC.pretranslate(Eigen::Vector3d(3, -1, 0.7));
  X_WC.prerotate(Eigen::AngleAxisd(0.4, Eigen::Vector3d(1, 2, -1).normalized()));
  SegmentedScene other = segment(render(view), view.camera);
  const geometry::RigidTransform X_WN = X_WC * other.X_WC.inverse();
  for (ObjectHypothesis& object : other.objects) {
    object.cloud_W = geometry::transformed(object.cloud_W, X_WN);
  }
  const Eigen::Vector3d normal = X_WN.linear() * other.table_W.normal;
  other.table_W = {normal, other.table_W.offset + normal.dot(X_WN.translation())};
  other.objects[0].support_W = other.table_W;
  other.X_WC = X_WC;
  const SegmentedScene scene = in_table_world(other);
  EXPECT_NEAR(scene.table_W.normal.z(), 1, 1e-9);
  EXPECT_NEAR(scene.table_W.offset, 0, 1e-9);
  EXPECT_TRUE(scene.X_WC.isApprox(expected.X_WC, 1e-5));
  EXPECT_NEAR(scene.objects[0].support_W->offset, 0, 1e-9);
  ASSERT_EQ(scene.objects.size(), expected.objects.size());
  for (std::size_t k = 0; k < scene.objects.size(); ++k) {
    const auto& points = scene.objects[k].cloud_W.points;
    ASSERT_EQ(points.size(), expected.objects[k].cloud_W.points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
      EXPECT_LT((points[i] - expected.objects[k].cloud_W.points[i]).norm(), 1e-5f);
    }
  }
}

TEST(Segment, UnorganizedCloudGivesMasksWithoutHoles) {
  const SyntheticView view = three_boxes();
  const geometry::PointCloud cloud = geometry::without_invalid(render(view));
  geometry::DepthImage depth;
  const geometry::Image<int> owner = testing::owners(view, depth);
  const SegmentedScene scene = segment(cloud, view.camera, view.X_WC);
  ASSERT_EQ(scene.objects.size(), 3U);
  EXPECT_GT(box_overlap(scene.objects[0].mask, owner, 2), 0.85);
  EXPECT_EQ(scene.depth.width, view.camera.width);
}

// Stereo strews points along the edges of things: a line of them is no thing, a rod there is.
TEST(Segment, PointsStrewnAlongALineAreNoObject) {
  SyntheticView view;
  view.camera = {960, 720, 900, 900, 479.5, 359.5};
  view.boxes = {table_top(), standing_box(-0.1, 0.1, {0.1, 0.1, 0.15}),
                standing_box(0.05, -0.1, {0.15, 0.005, 0.012})};
  const geometry::PointCloud whole = render(view);
  ASSERT_EQ(segment(whole, view.camera, view.X_WC).objects.size(), 2U);
  geometry::DepthImage depth;
  const geometry::Image<int> owner = testing::owners(view, depth);
  geometry::PointCloud strewn = whole;
  for (std::size_t i = 0; i < strewn.size(); ++i) {
    const int u = static_cast<int>(i) % strewn.width, v = static_cast<int>(i) / strewn.width;
    if (owner.data[i] == 2 && (u % 4 != 0 || v % 4 != 0)) {
      strewn.points[i].setConstant(std::numeric_limits<float>::quiet_NaN());
    }
  }
  const SegmentedScene scene = segment(strewn, view.camera, view.X_WC);
  EXPECT_EQ(scene.objects.size(), 1U);
  EXPECT_THAT(scene.dropped, ::testing::Contains(::testing::HasSubstr("1.5 mm for its length")));
}

// Nothing vanishes in silence.
TEST(Segment, WhatIsNoObjectIsToldWithTheOption) {
  SyntheticView view;
  view.boxes = {table_top(), standing_box(-0.1, 0, {0.1, 0.1, 0.15}),
                standing_box(0.1, 0.0, {0.06, 0.06, 0.02})};
  SegmentationOptions options;
  options.min_object_height = 0.03;
  const SegmentedScene low = segment(render(view), view.camera, view.X_WC, options);
  ASSERT_EQ(low.objects.size(), 1U);
  ASSERT_EQ(low.dropped.size(), 1U);
  EXPECT_THAT(low.dropped[0], ::testing::HasSubstr("min_object_height"));
  EXPECT_THAT(low.dropped[0], ::testing::HasSubstr("(0.10 "));
  options = {};
  options.min_area = 0.5;
  const SegmentedScene small = segment(render(view), view.camera, view.X_WC, options);
  EXPECT_TRUE(small.objects.empty());
  EXPECT_EQ(small.dropped.size(), 2U);
  EXPECT_THAT(why_no_objects(small), ::testing::HasSubstr("(min_area"));
  options = {};
  options.max_objects = 1;
  const SegmentedScene one = segment(render(view), view.camera, view.X_WC, options);
  EXPECT_EQ(one.objects.size(), 1U);
  ASSERT_EQ(one.dropped.size(), 1U);
  EXPECT_THAT(one.dropped[0], ::testing::HasSubstr("(max_objects)"));
  EXPECT_EQ(segment(render(view), view.camera, view.X_WC).objects.size(), 2U);
}

TEST(Segment, TableOnlyHasNoObjects) {
  SyntheticView view;
  view.noise = 0.002;
  view.boxes = {table_top(), back_wall()};
  const SegmentedScene scene = segment(render(view), view.camera);
  EXPECT_TRUE(scene.objects.empty());
  EXPECT_NEAR(scene.table_W.offset, 0, 1e-9);
}

TEST(Segment, NoTableIsAnErrorWithAReason) {
  SyntheticView view;
  view.boxes = {standing_box(0, 0, {0.02, 0.02, 0.02})};
  try {
    segment(render(view), view.camera);
    FAIL() << "a table was found in a tiny box";
  } catch (const geometry::InputError& error) {
    EXPECT_NE(std::string(error.what()).find("No table"), std::string::npos) << error.what();
  }
}

TEST(Segment, ObjectAtTheBorderIsMarked) {
  SyntheticView view;
  view.boxes = {table_top(), standing_box(-0.5, -0.05, {0.2, 0.12, 0.12})};
  const SegmentedScene scene = segment(render(view), view.camera, view.X_WC);
  ASSERT_EQ(scene.objects.size(), 1U);
  EXPECT_TRUE(scene.objects[0].touches_image_border);
}

// The right one of a pair of images ends in the middle of the box that is farthest left: its other
// half was never measured.
TEST(Segment, WhatTheRightImageCutsIsMarked) {
  const SyntheticView view = three_boxes();
  const auto column = [&](const Eigen::Vector3d& p_C) {
    return view.camera.cx + view.camera.fx * p_C.x() / p_C.z();
  };
  Eigen::Vector3d leftmost_C;
  double first = std::numeric_limits<double>::infinity();
  for (const Eigen::Vector3d& p_W :
       {Eigen::Vector3d(-0.15, 0, 0.1), Eigen::Vector3d(0.1, 0.1, 0.07),
        Eigen::Vector3d(0.25, -0.1, 0.04)}) {
    const Eigen::Vector3d p_C = view.X_WC.inverse() * p_W;
    if (column(p_C) >= first) continue;
    first = column(p_C);
    leftmost_C = p_C;
  }
  SegmentationOptions options;
  options.baseline = first * leftmost_C.z() / view.camera.fx;
  geometry::PointCloud cloud = render(view);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const int u = static_cast<int>(i) % cloud.width;
    if (u - view.camera.fx * options.baseline / cloud.points[i].z() < 0)
      cloud.points[i].setConstant(std::numeric_limits<float>::quiet_NaN());
  }
  const auto cut = [&](const SegmentationOptions& with) {
    int marked = 0;
    for (const ObjectHypothesis& object : segment(cloud, view.camera, view.X_WC, with).objects) {
      if (!object.touches_image_border) continue;
      ++marked;
      const Eigen::Vector3d p_C =
          view.X_WC.inverse() * object.cloud_W.points.front().cast<double>();
      EXPECT_NEAR(column(p_C), first, 60) << "another one";
    }
    return marked;
  };
  EXPECT_EQ(cut(options), 1);
  EXPECT_EQ(cut({}), 0) << "of a sensor that measures all that it sees";
  options.baseline = -1;
  EXPECT_THROW(segment(cloud, view.camera, view.X_WC, options), std::invalid_argument);
}

// A tower of 0.5 m is seen whole; what is over 0.45 m is dropped, so that its mesh would be too
// low.
TEST(Segment, WhatGoesOnOverMaxHeightIsMarkedAsCut) {
  testing::SyntheticView view;
  view.X_WC = geometry::look_at({0, -1.6, 1.2}, {0, 0, 0.2});
  view.boxes = {table_top(), standing_box(0, 0, {0.1, 0.1, 0.5})};
  const geometry::PointCloud cloud = testing::render(view);
  SegmentationOptions options;
  const SegmentedScene cut = segment(cloud, view.camera, view.X_WC, options);
  ASSERT_EQ(cut.objects.size(), 1U);
  EXPECT_TRUE(cut.objects[0].touches_image_border);
  options.max_height = 0.6;
  const SegmentedScene whole = segment(cloud, view.camera, view.X_WC, options);
  ASSERT_EQ(whole.objects.size(), 1U);
  EXPECT_FALSE(whole.objects[0].touches_image_border);
}

TEST(Segment, LeavesOutWhatIsBesideTheTableOrTooFar) {
  SyntheticView view;
  view.boxes = {table_top(0.6, 0.5), standing_box(0, 0, {0.08, 0.08, 0.12}),
                standing_box(0.6, 0, {0.1, 0.1, 0.2})};
  const geometry::PointCloud cloud = render(view);
  const SegmentedScene scene = segment(cloud, view.camera, view.X_WC);
  ASSERT_EQ(scene.objects.size(), 1U);
  const PointsLeftOut& points = scene.left_out;
  EXPECT_GT(points.beside_table, 0U);
  EXPECT_EQ(points.too_far, 0U);
  EXPECT_EQ(points.not_finite + points.low + points.over_max_height + points.too_far +
                points.beside_table + points.flying + scene.objects[0].cloud_W.size(),
            cloud.size());
  SegmentationOptions options;
  options.max_distance = 0.5;
  const SegmentedScene near = segment(cloud, view.camera, view.X_WC, options);
  EXPECT_TRUE(near.objects.empty());
  EXPECT_GE(near.left_out.too_far, scene.objects[0].cloud_W.size());
}

TEST(Segment, SurvivesInvalidPixels) {
  const SyntheticView view = three_boxes();
  geometry::PointCloud cloud = render(view);
  std::mt19937_64 random(5);
  for (Eigen::Vector3f& p : cloud.points) {
    if (random() % 4 == 0) p.setConstant(std::numeric_limits<float>::quiet_NaN());
  }
  EXPECT_EQ(segment(cloud, view.camera, view.X_WC).objects.size(), 3U);
}

TEST(Segment, SameInputSameBits) {
  SyntheticView view = three_boxes();
  view.noise = 0.002;
  const geometry::PointCloud cloud = render(view);
  const SegmentedScene a = segment(cloud, view.camera);
  const SegmentedScene b = segment(cloud, view.camera);
  ASSERT_EQ(a.objects.size(), b.objects.size());
  EXPECT_EQ(a.X_WC.matrix(), b.X_WC.matrix());
  for (std::size_t k = 0; k < a.objects.size(); ++k) {
    EXPECT_EQ(a.objects[k].mask.data, b.objects[k].mask.data);
    EXPECT_EQ(a.objects[k].cloud_W.points, b.objects[k].cloud_W.points);
  }
}

TEST(Segment, RejectsBadOptionsAndCameras) {
  const SyntheticView view = three_boxes();
  const geometry::PointCloud cloud = render(view);
  SegmentationOptions options;
  options.leaf_size = 0.05;
  EXPECT_THROW(segment(cloud, view.camera, view.X_WC, options), std::invalid_argument);
  options = {};
  options.max_height = 0;
  EXPECT_THROW(segment(cloud, view.camera, view.X_WC, options), std::invalid_argument);
  geometry::PinholeCamera other = view.camera;
  other.width = 100;
  EXPECT_THROW(segment(cloud, other, view.X_WC), std::invalid_argument);
}

TEST(WorldFromTable, CameraLookingAlongTheTableAndStraightDown) {
  // Straight down: the camera's x is in the table.
  const geometry::RigidTransform X_WC =
      world_from_table({-Eigen::Vector3d::UnitZ(), -1}, {0, 0, 0.9});
  EXPECT_TRUE(X_WC.translation().isApprox(Eigen::Vector3d(0, 0, 1), 1e-12));
  // Lying on its side: the camera's x stands on the table.
  const geometry::RigidTransform side =
      world_from_table({Eigen::Vector3d::UnitX(), -0.5}, {0, 0, 1});
  EXPECT_NEAR(side.linear().determinant(), 1, 1e-12);
  EXPECT_NEAR(side.translation().z(), 0.5, 1e-12);
}

// Points of a cylinder's wall between two angles, seen by a camera at the origin of C that looks
// along z with the table below (y down).
std::vector<Eigen::Vector3f> wall(double from, double to, double radius, double bottom,
                                  double top) {
  std::vector<Eigen::Vector3f> points;
  for (double angle = from; angle <= to; angle += 0.05) {
    for (double height = bottom; height <= top; height += 0.005) {
      points.emplace_back(static_cast<float>(radius * std::cos(angle)),
                          static_cast<float>(0.3 - height),
                          static_cast<float>(0.8 + radius * std::sin(angle)));
    }
  }
  return points;
}

class Parts : public ::testing::Test {
 protected:
  std::size_t count(const std::vector<std::vector<Eigen::Vector3f>>& parts,
                    std::vector<char> is_cut = {}, bool look_alike = false) {
    std::vector<Eigen::Vector3f> points;
    std::vector<std::vector<int>> clusters;
    for (const auto& part : parts) {
      clusters.emplace_back();
      for (const Eigen::Vector3f& p : part) {
        clusters.back().push_back(static_cast<int>(points.size()));
        points.push_back(p);
      }
    }
    is_cut.resize(parts.size(), 0);
    const JoinedParts joined =
        joined_parts(points, clusters, is_cut, {-Eigen::Vector3d::UnitY(), -0.3}, {},
                     [&](std::size_t, std::size_t) { return look_alike; });
    hanging_ = joined.hanging.size();
    return joined.objects.size();
  }
  static constexpr double kPi = 3.14159265358979;
  std::size_t hanging_ = 0;
};

TEST_F(Parts, NearAndFarWallOfABowlAreOneObject) {
  EXPECT_EQ(count({wall(-kPi + 0.3, -0.3, 0.08, 0.01, 0.1), wall(0.3, kPi - 0.3, 0.08, 0.03, 0.1)}),
            1U);
}

TEST_F(Parts, TwoCansOneBehindTheOtherAreTwo) {
  auto behind = wall(-kPi + 0.3, -0.3, 0.05, 0.01, 0.1);
  for (Eigen::Vector3f& p : behind) p.z() += 0.12F;
  EXPECT_EQ(count({wall(-kPi + 0.3, -0.3, 0.05, 0.01, 0.1), behind}), 2U);
}

TEST_F(Parts, FloatingHandleJoinsAndHangingLampIsNoObject) {
  const auto can = wall(-kPi, 0, 0.05, 0.01, 0.15);
  EXPECT_EQ(count({can, wall(0, 0.3, 0.06, 0.06, 0.08)}), 1U);
  const auto lamp = wall(-kPi, 0, 0.2, 0.3, 0.4);  // goes on above
  EXPECT_EQ(count({can, lamp}, {0, 1}), 1U);
  EXPECT_EQ(hanging_, 1U);
  EXPECT_EQ(count({lamp}, {1}), 0U);
}

// A pitcher lying on its handle: what joins them is hidden.
TEST_F(Parts, WhatFloatsBesideAThingOfItsColorThatCannotCarryItIsOneWithIt) {
  const auto body = wall(-kPi, 0, 0.06, 0.06, 0.15);
  auto handle = wall(-kPi / 2 - 0.3, -kPi / 2 + 0.3, 0.06, 0.01, 0.04);
  EXPECT_EQ(count({body, handle}, {}, true), 1U);
  EXPECT_EQ(count({body, handle}, {}, false), 2U);
  const auto larger = wall(-kPi / 2 - 0.9, -kPi / 2 + 0.9, 0.1, 0.01, 0.1);
  EXPECT_EQ(count({wall(-kPi, -kPi / 2, 0.06, 0.06, 0.12), larger}, {}, true), 2U);
  const auto stand = wall(-kPi, kPi, 0.05, 0.01, 0.04);  // under the middle
  EXPECT_EQ(count({wall(-kPi, kPi, 0.06, 0.06, 0.15), stand}, {}, true), 2U);
}

TEST_F(Parts, CrumbsWithinAnOutlineBelongToItAndThingsBesideItDoNot) {
  const auto can = wall(-kPi, 0, 0.045, 0.01, 0.15);
  auto crumb = wall(-kPi, 0, 0.01, 0.01, 0.06);
  EXPECT_EQ(count({can, crumb}), 1U);
  for (Eigen::Vector3f& p : crumb) p.x() += 0.08F;
  EXPECT_EQ(count({can, crumb}), 2U) << "a small thing of its own";
}

// A pitcher on its handle, which is hidden: "the table is empty" was said of it.
TEST_F(Parts, WhatFloatsWholeStandsOnSomethingHidden) {
  EXPECT_EQ(count({wall(-kPi, 0, 0.06, 0.06, 0.15)}), 1U);
  EXPECT_EQ(hanging_, 0U);
}

}  // namespace
}  // namespace prehend::perception
