// Bad, huge and tiny inputs: a right answer or one clear error.

#include <cmath>
#include <limits>
#include <random>
#include <string>

#include <gtest/gtest.h>

#include "prehend/geometry/errors.h"
#include "prehend/perception/organized_components.h"
#include "prehend/perception/segmentation.h"
#include "prehend/perception/stereo.h"
#include "tests/perception/synthetic_view.h"

namespace prehend::perception {
namespace {

using geometry::InputError;
using geometry::PointCloud;
using testing::standing_box;

const float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInf = std::numeric_limits<float>::infinity();

testing::SyntheticView two_boxes() {
  testing::SyntheticView view;
  view.boxes = {testing::table_top(), standing_box(-0.15, 0, {0.1, 0.08, 0.12}),
                standing_box(0.15, 0.05, {0.06, 0.06, 0.2})};
  return view;
}

std::vector<SegmentationOptions> both_ways_of_clustering() {
  SegmentationOptions organized;
  organized.clustering = Clustering::kOrganized;
  organized.split = Splitting::kTouching;
  return {SegmentationOptions(), organized};
}

TEST(PerceptionExtremes, SprinkledNanAndInfinityDoNotMatter) {
  const testing::SyntheticView view = two_boxes();
  PointCloud cloud = testing::render(view);
  std::mt19937_64 random(1);
  for (Eigen::Vector3f& p : cloud.points) {
    const auto draw = random() % 20;
    if (draw == 0) p.setConstant(kNan);
    if (draw == 1) p.z() = kInf;
    if (draw == 2) p.x() = -kInf;
  }
  for (const SegmentationOptions& options : both_ways_of_clustering()) {
    const SegmentedScene scene = segment(cloud, view.camera, view.X_WC, options);
    ASSERT_EQ(scene.objects.size(), 2U);
    EXPECT_NEAR(scene.table_W.offset, 0, 0.002);
    for (const ObjectHypothesis& object : scene.objects) {
      for (const Eigen::Vector3f& p : object.cloud_W.points) ASSERT_TRUE(p.allFinite());
    }
  }
}

TEST(PerceptionExtremes, NothingAFewPointsOnePointALine) {
  const testing::SyntheticView view = two_boxes();
  const auto is_refused = [&](const PointCloud& cloud) {
    try {
      segment(cloud, view.camera, view.X_WC);
    } catch (const InputError& error) {
      return std::string(error.what()).rfind("No table", 0) == 0;
    }
    return false;
  };
  PointCloud cloud;
  EXPECT_TRUE(is_refused(cloud));
  cloud.points = {{0, 0, 1}, {0.1F, 0, 1}, {0, 0.1F, 1}};
  EXPECT_TRUE(is_refused(cloud));
  cloud.points.assign(5000, Eigen::Vector3f(0.1F, 0.2F, 1));
  EXPECT_TRUE(is_refused(cloud));
  for (std::size_t i = 0; i < cloud.size(); ++i)
    cloud.points[i].x() = 1e-4F * static_cast<float>(i);
  EXPECT_TRUE(is_refused(cloud));
  cloud.points.assign(5000, Eigen::Vector3f::Constant(kNan));
  EXPECT_TRUE(is_refused(cloud));
}

TEST(PerceptionExtremes, EmptyTableGivesNoObjectAndWallAloneNoTable) {
  testing::SyntheticView view;
  view.boxes = {testing::table_top()};
  for (const SegmentationOptions& options : both_ways_of_clustering()) {
    EXPECT_TRUE(segment(testing::render(view), view.camera, view.X_WC, options).objects.empty());
  }
  view.boxes = {testing::back_wall()};
  EXPECT_THROW(segment(testing::render(view), view.camera, view.X_WC), InputError);
}

TEST(PerceptionExtremes, SeveralTablesComeBestFirst) {
  testing::SyntheticView view = two_boxes();
  // A shelf of bare board over the table, farther back.
  view.boxes.push_back({{-0.5, 0.35, 0.25}, {0.5, 0.45, 0.27}});
  view.boxes.push_back(testing::back_wall());
  const PointCloud cloud = testing::render(view);
  const Eigen::Vector3d up_C = view.X_WC.linear().transpose() * Eigen::Vector3d::UnitZ();
  const std::vector<Table> tables = find_tables(cloud, {}, up_C);
  ASSERT_GE(tables.size(), 1U);
  EXPECT_TRUE(tables[0].plane_C.normal.isApprox(find_table(cloud, {}, up_C).plane_C.normal));
  const Eigen::Vector3d foot = view.X_WC * tables[0].plane_C.project(Eigen::Vector3d(0, 0, 1));
  EXPECT_NEAR(foot.z(), 0, 0.003);
  for (const Table& table : tables) {
    // The wall is no table, since up is known.
    EXPECT_GT(table.plane_C.normal.dot(up_C), 0.8);
  }
}

TEST(PerceptionExtremes, RolledCameraFindsTheTableWithAHintOfGravity) {
  testing::SyntheticView view = two_boxes();
  view.X_WC.linear() =
      view.X_WC.linear() * Eigen::AngleAxisd(1.2, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  const SegmentedScene scene = segment(testing::render(view), view.camera, view.X_WC);
  EXPECT_GT(scene.table_W.normal.z(), 0.999);
  EXPECT_EQ(scene.objects.size(), 2U);
}

TEST(PerceptionExtremes, LargeObjectBeyondTheImageIsMarkedAsCut) {
  testing::SyntheticView view;
  view.X_WC = geometry::look_at({0, -0.45, 0.4}, {0, 0, 0.1});
  view.boxes = {testing::table_top(), standing_box(0.2, 0.02, {0.4, 0.1, 0.12})};
  const SegmentedScene scene = segment(testing::render(view), view.camera, view.X_WC);
  ASSERT_EQ(scene.objects.size(), 1U);
  EXPECT_TRUE(scene.objects[0].touches_image_border);
}

TEST(PerceptionExtremes, HolesInTheCloudLeaveOneObject) {
  const testing::SyntheticView view = two_boxes();
  PointCloud cloud = testing::render(view);
  // A lattice of holes of 2 x 2 pixels, as of missing disparities.
  for (int v = 0; v < cloud.height; ++v) {
    for (int u = 0; u < cloud.width; ++u) {
      if (u % 7 < 2 && v % 7 < 2) cloud.points[v * cloud.width + u].setConstant(kNan);
    }
  }
  for (const SegmentationOptions& options : both_ways_of_clustering()) {
    const SegmentedScene scene = segment(cloud, view.camera, view.X_WC, options);
    ASSERT_EQ(scene.objects.size(), 2U);
    // The masks are closed over the holes.
    for (const ObjectHypothesis& object : scene.objects) {
      int inside = 0;
      for (const std::uint8_t value : object.mask.data) inside += value != 0;
      EXPECT_GT(inside, static_cast<int>(object.cloud_W.size()));
    }
  }
}

// The world may be far away: only the camera's pose is large.
TEST(PerceptionExtremes, WorldTenKilometresAway) {
  const testing::SyntheticView view = two_boxes();
  const PointCloud cloud = testing::render(view);
  geometry::RigidTransform X_FW = geometry::RigidTransform::Identity();
  X_FW.translation() = Eigen::Vector3d(10000, -10000, 0);
  const SegmentedScene near = segment(cloud, view.camera, view.X_WC);
  const SegmentedScene far = segment(cloud, view.camera, X_FW * view.X_WC);
  ASSERT_EQ(far.objects.size(), near.objects.size());
  for (std::size_t k = 0; k < near.objects.size(); ++k) {
    EXPECT_EQ(far.objects[k].mask.data, near.objects[k].mask.data);
    // Points are floats: a millimetre at this distance.
    EXPECT_LT((geometry::centroid(far.objects[k].cloud_W) - X_FW.translation() -
               geometry::centroid(near.objects[k].cloud_W))
                  .norm(),
              0.002);
  }
}

TEST(PerceptionExtremes, OrganizedComponentsAtAnyScale) {
  for (const float scale : {1e-3F, 1.0F, 1e3F}) {
    PointCloud cloud;
    cloud.width = 60;
    cloud.height = 10;
    std::vector<int> all;
    for (int i = 0; i < 600; ++i) {
      const float gap = i % 60 >= 30 ? 0.1F : 0.0F;
      cloud.points.emplace_back(scale * (0.01F * static_cast<float>(i % 60) + gap),
                                scale * 0.01F * static_cast<float>(i / 60), scale);
      all.push_back(i);
    }
    EXPECT_EQ(organized_components(cloud, all, 0.05 * static_cast<double>(scale), 2, 1).size(), 2U)
        << scale;
  }
}

TEST(PerceptionExtremes, FiveMillionPoints) {
  // The view's points, each many times with a little noise, as one cloud without order.
  const testing::SyntheticView view = two_boxes();
  const PointCloud once = testing::render(view);
  PointCloud many;
  many.points.reserve(5'000'000);
  std::uint32_t random = 1;
  const auto noise = [&random] {
    random = random * 1664525u + 1013904223u;
    return (static_cast<float>(random >> 8) / (1 << 24) - 0.5f) * 1e-3f;
  };
  while (many.points.size() < 5'000'000) {
    for (const Eigen::Vector3f& p : once.points) {
      many.points.push_back(p + Eigen::Vector3f(noise(), noise(), noise()));
    }
  }
  const SegmentedScene scene = segment(many, view.camera, view.X_WC);
  ASSERT_EQ(scene.objects.size(), 2U);
  EXPECT_NEAR(scene.table_W.offset, 0, 0.002);
  const SegmentedScene few = segment(once, view.camera, view.X_WC);
  for (std::size_t k = 0; k < 2; ++k) {
    const Eigen::Vector3d moved = geometry::centroid(scene.objects[k].cloud_W) -
                                  geometry::centroid(few.objects.at(k).cloud_W);
    EXPECT_LT(moved.norm(), 0.003);
  }
}

TEST(PerceptionExtremes, StereoOfBlackAndWhiteImagesInventsNothing) {
  const geometry::StereoCamera camera{{160, 120, 200, 200, 80, 60}, 0.06};
  for (const std::uint8_t level : {0, 255}) {
    const GreyImage flat(160, 120, level);
    for (const StereoMethod method : {StereoMethod::kSemiGlobal, StereoMethod::kBlockMatching}) {
      StereoOptions options;
      options.method = method;
      options.filter = true;
      options.min_confidence = 0.1;
      const StereoMatch match = match_stereo(flat, flat, camera, options);
      for (std::size_t i = 0; i < match.disparity.data.size(); ++i) {
        ASSERT_TRUE(std::isnan(match.disparity.data[i]));
        ASSERT_EQ(match.confidence.data[i], 0);
      }
    }
  }
}

}  // namespace
}  // namespace prehend::perception
