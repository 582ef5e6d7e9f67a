// Organized components against PCL's Euclidean clusters, and splitting of what touches.

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <random>
#include <set>

#include <gtest/gtest.h>

#include "prehend/perception/cloud_partition.h"
#include "prehend/perception/organized_components.h"
#include "prehend/perception/segmentation.h"
#include "prehend/perception/splitting.h"
#include "tests/perception/synthetic_view.h"

namespace prehend::perception {
namespace {

using testing::standing_box;

std::vector<int> finite_over(const geometry::PointCloud& cloud, const testing::SyntheticView& view,
                             double height) {
  std::vector<int> indices;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (!geometry::is_finite(cloud.points[i])) continue;
    if ((view.X_WC * cloud.points[i].cast<double>()).z() > height) {
      indices.push_back(static_cast<int>(i));
    }
  }
  return indices;
}

// Each point put into a map by its voxel; the points come in runs, as those of an image do, and
// also in any order.
TEST(VoxelGrids, AreWhatAMapOfVoxelsGives) {
  std::mt19937_64 random(5);
  std::vector<Eigen::Vector3f> points;
  std::vector<int> indices;
  for (int i = 0; i < 3000; ++i) {
    const float along = 0.0007F * static_cast<float>(i % 300),
                across = -0.1F + 0.02F * static_cast<float>(i / 300);
    points.emplace_back(along, across, 0.001F * static_cast<float>(random() % 20));
    if (random() % 9 != 0) indices.push_back(i);
  }
  for (const bool is_shuffled : {false, true}) {
    if (is_shuffled) std::shuffle(indices.begin(), indices.end(), random);
    std::map<std::array<int, 3>, std::vector<int>> oracle;
    for (const int i : indices) {
      const Eigen::Vector3d at = (points[i].cast<double>() / 0.01).array().floor();
      oracle[{static_cast<int>(at.z()), static_cast<int>(at.y()), static_cast<int>(at.x())}]
          .push_back(i);
    }
    const VoxelGrid grid = make_voxel_grid(points, indices, 0.01);
    ASSERT_EQ(grid.centroids.size(), oracle.size());
    ASSERT_EQ(grid.members.size(), oracle.size());
    std::size_t v = 0;
    for (auto& [voxel, members] : oracle) {
      std::sort(members.begin(), members.end());
      EXPECT_EQ(grid.members[v], members);
      Eigen::Vector3d mean = Eigen::Vector3d::Zero();
      for (const int i : members) mean += points[i].cast<double>();
      mean /= static_cast<double>(members.size());
      EXPECT_TRUE(grid.centroids[v].isApprox(mean.cast<float>(), 1e-6F));
      ++v;
    }
    EXPECT_EQ(voxel_centroids(points, indices, 0.01), grid.centroids);
    EXPECT_EQ(voxel_centroids(points, indices, 0), make_voxel_grid(points, indices, 0).centroids);
  }
  EXPECT_TRUE(voxel_centroids(points, {}, 0.01).empty());
}

// Against the sides of the outline that it gives.
TEST(PlaneOutlines, ContainWhatIsLeftOfAllOfTheirSides) {
  std::mt19937_64 random(3);
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * static_cast<double>(random() % 100000) / 100000;
  };
  const geometry::Plane plane{Eigen::Vector3d(0.2, -0.7, -0.5).normalized(), -0.6};
  const Eigen::Vector3d x = plane.normal.unitOrthogonal(), y = plane.normal.cross(x);
  const auto point = [&](double u, double v) {
    return Eigen::Vector3d(plane.offset * plane.normal + u * x + v * y);
  };
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i < 400; ++i) {
    points.push_back(point(uniform(0.1, 0.9), uniform(-0.2, 0.1)).cast<float>());
  }
  const PlaneOutline outline(plane, points);
  const std::vector<Eigen::Vector3d> corners = outline.vertices();
  for (const double margin : {0.0, 0.03, -0.02}) {
    int inside = 0;
    for (int i = 0; i < 4000; ++i) {
      const Eigen::Vector3d p =
          point(uniform(0, 1), uniform(-0.3, 0.2)) + uniform(0, 1) * plane.normal;
      double least = 1;  // m, to the left of a side
      for (std::size_t k = 0; k < corners.size(); ++k) {
        const Eigen::Vector3d edge = corners[(k + 1) % corners.size()] - corners[k];
        least = std::min(least, plane.normal.dot(edge.cross(p - corners[k])) / edge.norm());
      }
      if (std::abs(least + margin) < 1e-6) continue;
      EXPECT_EQ(outline.contains(p, margin), least > -margin) << least << " " << margin;
      inside += least > -margin;
    }
    EXPECT_GT(inside, 1000);
    EXPECT_LT(inside, 3500);
  }
}

TEST(OrganizedComponents, AgreeWithEuclideanClusters) {
  std::mt19937_64 random(11);
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * static_cast<double>(random() % 10000) / 10000;
  };
  for (int trial = 0; trial < 10; ++trial) {
    testing::SyntheticView view;
    view.boxes = {testing::table_top()};
    for (int k = 0; k < 6; ++k) {
      view.boxes.push_back(
          standing_box(uniform(-0.35, 0.35), uniform(-0.25, 0.25),
                       {uniform(0.03, 0.1), uniform(0.03, 0.1), uniform(0.03, 0.2)}));
    }
    const geometry::PointCloud cloud = testing::render(view);
    const std::vector<int> indices = finite_over(cloud, view, 0.01);
    std::vector<Eigen::Vector3f> points;
    for (const int i : indices) points.push_back(cloud.points[i]);
    std::vector<std::vector<int>> oracle;
    for (const auto& cluster : euclidean_clusters(points, 0.02, 20)) {
      auto& members = oracle.emplace_back();
      for (const int i : cluster) members.push_back(indices[i]);
    }
    // Neighbours within 2 cm are up to ten pixels apart here.
    EXPECT_EQ(organized_components(cloud, indices, 0.02, 12, 20), oracle) << trial;
  }
}

TEST(OrganizedComponents, BridgesSmallHolesOnly) {
  geometry::PointCloud cloud;
  cloud.width = 40;
  cloud.height = 2;
  std::vector<int> indices;
  for (int i = 0; i < 80; ++i) {
    cloud.points.emplace_back(0.001F * static_cast<float>(i % 40), 0.0F, 1.0F);
    const bool hole = i % 40 == 10 || (i % 40 >= 20 && i % 40 < 25);
    if (!hole) indices.push_back(i);
  }
  EXPECT_EQ(organized_components(cloud, indices, 0.02, 1, 1).size(), 3U);
  EXPECT_EQ(organized_components(cloud, indices, 0.02, 2, 1).size(), 2U);
  EXPECT_EQ(organized_components(cloud, indices, 0.02, 6, 1).size(), 1U);
  EXPECT_TRUE(organized_components(cloud, {}, 0.02, 1, 1).empty());
  EXPECT_THROW(organized_components(cloud, indices, 0, 1, 1), std::invalid_argument);
  EXPECT_THROW(organized_components(cloud, indices, 0.02, 0, 1), std::invalid_argument);
  cloud.width = cloud.height = 0;
  EXPECT_THROW(organized_components(cloud, indices, 0.02, 1, 1), std::invalid_argument);
}

// A wall at 1 m, before which a point, a thread and a square of nine pixels are seen.
TEST(FlyingPoints, AreThoseWithoutCompany) {
  geometry::PointCloud cloud;
  cloud.width = cloud.height = 40;
  const auto near = [](int u, int v) {
    return (u == 5 && v == 5) || u == 20 || (u >= 30 && u < 33 && v >= 30 && v < 33);
  };
  std::vector<int> all, expected;
  for (int i = 0; i < 1600; ++i) {
    const int u = i % 40, v = i / 40;
    const float z = near(u, v) ? 0.8F : 1.0F;
    cloud.points.emplace_back(0.002F * static_cast<float>(u) * z,
                              0.002F * static_cast<float>(v) * z, z);
    all.push_back(i);
    if (u != 5 || v != 5) expected.push_back(i);
  }
  EXPECT_EQ(without_flying_points(cloud, all, 0.02, 500), expected);
  EXPECT_EQ(without_flying_points(cloud, all, 0.3, 500), all) << "as near as the wall";
  // With few others round it nobody can tell.
  const float nothing = std::numeric_limits<float>::quiet_NaN();
  for (int i = 0; i < 1600; ++i) {
    if (i % 40 < 10 && i != 5 * 40 + 5) cloud.points[i] = {nothing, nothing, nothing};
  }
  EXPECT_EQ(without_flying_points(cloud, {5 * 40 + 5}, 0.02, 500).size(), 1U);
  EXPECT_TRUE(without_flying_points(cloud, {}, 0.02, 500).empty());
  EXPECT_THROW(without_flying_points(cloud, {}, 0, 500), std::invalid_argument);
  cloud.width = cloud.height = 0;
  EXPECT_THROW(without_flying_points(cloud, {}, 0.02, 500), std::invalid_argument);
}

// One pixel in twenty of a picture has 0.5 to 1.5 times its depth; once all of the air over the
// table was one object with the box.
TEST(FlyingPoints, LeaveTheObjectAsItIs) {
  testing::SyntheticView view;
  view.boxes = {testing::table_top(), standing_box(0, 0, {0.06, 0.08, 0.12})};
  geometry::PointCloud cloud = testing::render(view);
  std::mt19937_64 random(3);
  for (Eigen::Vector3f& p : cloud.points) {
    if (random() % 20 == 0) p *= 0.5F + static_cast<float>(random() % 1000) / 1000;
  }
  const SegmentedScene scene = segment(cloud, view.camera, view.X_WC);
  ASSERT_FALSE(scene.objects.empty());
  Eigen::AlignedBox3f box;
  for (const Eigen::Vector3f& p : scene.objects.front().cloud_W.points) box.extend(p);
  EXPECT_LT(box.sizes().x(), 0.06 + 0.04);
  EXPECT_LT(box.sizes().y(), 0.08 + 0.04);
  EXPECT_NEAR(box.max().z(), 0.12, 0.02);
}

// A view of boxes on a table at a resolution where creases can be seen; colours by box.
struct ColoredView {
  testing::SyntheticView view;
  geometry::PointCloud cloud;
  geometry::Image<int> owner;

  ColoredView(std::vector<testing::Box> boxes, const std::vector<geometry::Rgb>& colors,
              double noise) {
    view.camera = {640, 480, 800, 800, 319.5, 239.5};
    view.X_WC = geometry::look_at({0, -0.55, 0.5}, {0, 0, 0.05});
    view.boxes = {testing::table_top()};
    view.boxes.insert(view.boxes.end(), boxes.begin(), boxes.end());
    view.noise = noise;
    cloud = testing::render(view);
    geometry::DepthImage depth;
    owner = testing::owners(view, depth);
    for (const int k : owner.data) {
      cloud.colors.push_back(k < 1 ? geometry::Rgb{120, 100, 80} : colors.at(k - 1));
    }
  }
};

constexpr geometry::Rgb kRed{200, 40, 40}, kBlue{40, 60, 190};

// Share of the pixels of the box that are in the part that has most of them.
double purity(const ColoredView& seen, const std::vector<std::vector<int>>& parts, int box) {
  double most = 0, all = 0;
  for (const auto& part : parts) {
    double count = 0;
    for (const int i : part) count += seen.owner.data[i] == box;
    most = std::max(most, count);
    all += count;
  }
  return most / all;
}

TEST(SplitTouching, StackedBoxesOfTwoColours) {
  const ColoredView seen(
      {standing_box(0, 0, {0.14, 0.12, 0.06}), standing_box(0.01, 0.01, {0.06, 0.06, 0.1}, 0.06)},
      {kRed, kBlue}, 0.001);
  const std::vector<int> members = finite_over(seen.cloud, seen.view, 0.008);
  const auto parts = split_touching(seen.cloud, seen.view.camera, members);
  ASSERT_EQ(parts.size(), 2U);
  EXPECT_GT(purity(seen, parts, 1), 0.95);
  EXPECT_GT(purity(seen, parts, 2), 0.95);
  std::set<int> together(parts[0].begin(), parts[0].end());
  together.insert(parts[1].begin(), parts[1].end());
  EXPECT_EQ(together.size(), members.size());
  EXPECT_EQ(parts[0].size() + parts[1].size(), members.size());
}

TEST(SplitTouching, OneColourIsOneObjectUnlessToldOtherwise) {
  const ColoredView seen(
      {standing_box(0, 0, {0.14, 0.12, 0.06}), standing_box(0.01, 0.01, {0.06, 0.06, 0.1}, 0.06)},
      {kRed, kRed}, 0.001);
  const std::vector<int> members = finite_over(seen.cloud, seen.view, 0.008);
  EXPECT_EQ(split_touching(seen.cloud, seen.view.camera, members).size(), 1U);
  SplitOptions options;
  options.min_color_difference = 0;
  EXPECT_EQ(split_touching(seen.cloud, seen.view.camera, members, options).size(), 2U);
}

TEST(SplitTouching, ConvexEdgesDoNotSplit) {
  const ColoredView seen({standing_box(0, 0, {0.12, 0.1, 0.15})}, {kRed}, 0.001);
  const std::vector<int> members = finite_over(seen.cloud, seen.view, 0.008);
  SplitOptions options;
  options.min_color_difference = 0;
  EXPECT_EQ(split_touching(seen.cloud, seen.view.camera, members, options),
            std::vector<std::vector<int>>{members});
  EXPECT_TRUE(split_touching(seen.cloud, seen.view.camera, {}).empty());
  options.min_crease = 0;
  EXPECT_THROW(split_touching(seen.cloud, seen.view.camera, members, options),
               std::invalid_argument);
}

TEST(Segmentation, OrganizedClusteringAndSplittingFindTheBoxes) {
  const ColoredView seen(
      {standing_box(0, 0, {0.14, 0.12, 0.06}), standing_box(0.01, 0.01, {0.06, 0.06, 0.1}, 0.06),
       standing_box(0.2, 0.05, {0.06, 0.06, 0.12})},
      {kRed, kBlue, kRed}, 0.0005);
  SegmentationOptions options;
  const auto count = [&] {
    return segment(seen.cloud, seen.view.camera, seen.view.X_WC, options).objects.size();
  };
  EXPECT_EQ(count(), 3U);
  options.split = Splitting::kNone;
  EXPECT_EQ(count(), 2U);
  options.clustering = Clustering::kOrganized;
  EXPECT_EQ(count(), 2U);
  options.split = Splitting::kTouching;
  EXPECT_EQ(count(), 3U);
}

TEST(Segmentation, ObjectsHiddenByOthersAreMarked) {
  // The camera looks along +y: the second box is behind the first.
  const ColoredView seen(
      {standing_box(0, -0.1, {0.08, 0.04, 0.1}), standing_box(0.03, 0, {0.12, 0.05, 0.12})},
      {kRed, kBlue}, 0);
  const SegmentedScene scene = segment(seen.cloud, seen.view.camera, seen.view.X_WC);
  ASSERT_EQ(scene.objects.size(), 2U);
  for (const ObjectHypothesis& object : scene.objects) {
    const bool behind = geometry::centroid(object.cloud_W).y() > -0.05;
    if (behind) {
      EXPECT_GT(object.occluded_share, 0.1);
      ASSERT_FALSE(object.nearer.data.empty());
      // The other object's depths, where that is seen, and nothing else.
      const ObjectHypothesis& other = scene.objects[object.id == 0 ? 1 : 0];
      for (std::size_t i = 0; i < object.nearer.data.size(); ++i) {
        EXPECT_EQ(object.nearer.data[i] > 0, other.mask.data[i] != 0 && scene.depth.data[i] > 0);
      }
    } else {
      EXPECT_EQ(object.occluded_share, 0);
      EXPECT_TRUE(object.nearer.data.empty());
    }
  }
}

}  // namespace
}  // namespace prehend::perception
