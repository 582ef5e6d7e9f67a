// Pictures with fewer pixels against means and medians by hand, and their camera against the rays
// of the pixels that it covers.

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <tuple>

#include <gtest/gtest.h>

#include "prehend/geometry/errors.h"
#include "prehend/perception/binning.h"

namespace prehend::perception {
namespace {

constexpr float kNoDepth = std::numeric_limits<float>::quiet_NaN();

TEST(Binned, MeansColoursAndLeavesOutWhatFillsNoPixel) {
  geometry::ColorImage image(5, 3, {200, 200, 200});
  image.at(0, 0) = {0, 10, 20};
  image.at(1, 0) = {100, 10, 20};
  image.at(0, 1) = {0, 10, 40};
  image.at(1, 1) = {100, 10, 40};
  const geometry::ColorImage small = binned(image, 2);
  ASSERT_EQ(small.width, 2);
  ASSERT_EQ(small.height, 1);
  EXPECT_EQ(small.at(0, 0), (geometry::Rgb{50, 10, 30}));
  EXPECT_EQ(small.at(1, 0), (geometry::Rgb{200, 200, 200}));
  EXPECT_EQ(binned(image, 1).data, image.data);

  geometry::Image<std::uint8_t> grey(4, 4);
  for (std::size_t i = 0; i < grey.data.size(); ++i) grey.data[i] = static_cast<std::uint8_t>(i);
  // 0, 1, 4, 5 and so on: means of 2.5 are rounded one way or the other.
  EXPECT_NEAR(binned(grey, 2).at(0, 0), 2.5, 0.5);
  EXPECT_NEAR(binned(grey, 4).at(0, 0), 7.5, 0.5);
}

TEST(Binned, DepthIsOneOfThoseThatWereSeen) {
  geometry::DepthImage depth(4, 2, kNoDepth);
  // A body before the wall: nothing comes out between the two.
  depth.at(0, 0) = 0.5F;
  depth.at(1, 0) = 2.0F;
  depth.at(0, 1) = 0.6F;
  depth.at(1, 1) = 2.1F;
  // Half of it is unknown.
  depth.at(2, 0) = 1.0F;
  depth.at(3, 0) = 1.0F;
  const geometry::DepthImage small = binned(depth, 2);
  EXPECT_EQ(small.at(0, 0), 0.6F);
  EXPECT_TRUE(std::isnan(small.at(1, 0)));
  depth.at(2, 1) = 1.5F;
  EXPECT_EQ(binned(depth, 2).at(1, 0), 1.0F);
}

// The point that the depth image would keep, with what belongs to it, where the camera sees it.
TEST(Binned, CloudsKeepOneOfTheirPoints) {
  const geometry::PinholeCamera camera{6, 4, 10, 10, 2.5, 1.5};
  geometry::DepthImage depth(6, 4, kNoDepth);
  geometry::PointCloud cloud_C;
  cloud_C.width = 6;
  cloud_C.height = 4;
  for (int i = 0; i < 24; ++i) {
    const int u = i % 6, v = i / 6;
    depth.data[i] = i % 5 == 0 || u > 3 ? kNoDepth : 1.0F + 0.1F * static_cast<float>(i * 7 % 11);
    cloud_C.points.push_back(camera.unproject(u, v, depth.data[i]).cast<float>());
    cloud_C.colors.push_back({static_cast<std::uint8_t>(i), 0, 0});
  }
  const geometry::DepthImage small_depth = binned(depth, 2);
  const geometry::PointCloud small = binned(cloud_C, 2);
  const std::vector<int> chosen = binned_points(cloud_C, 2);
  const geometry::PinholeCamera small_camera = binned(camera, 2);
  ASSERT_TRUE(small.organized());
  ASSERT_EQ(small.width, 3);
  ASSERT_EQ(small.size(), chosen.size());
  EXPECT_TRUE(small.normals.empty());
  int known = 0;
  for (std::size_t i = 0; i < small.size(); ++i) {
    EXPECT_EQ(chosen[i] < 0, std::isnan(small_depth.data[i])) << i;
    EXPECT_EQ(chosen[i] < 0, !geometry::is_finite(small.points[i])) << i;
    if (chosen[i] < 0) continue;
    ++known;
    EXPECT_EQ(small.points[i].z(), small_depth.data[i]);
    EXPECT_EQ(small.points[i], cloud_C.points[chosen[i]]);
    EXPECT_EQ(small.colors[i][0], chosen[i]);
    const Eigen::Vector2d pixel = small_camera.project(small.points[i].cast<double>());
    EXPECT_NEAR(pixel.x(), static_cast<double>(i % 3), 0.5);
    EXPECT_NEAR(pixel.y(), static_cast<double>(i / 3), 0.5);
  }
  EXPECT_EQ(known, 3);
  EXPECT_EQ(binned(cloud_C, 1).points[1], cloud_C.points[1]);
  EXPECT_EQ(binning_to(cloud_C, 0), 1);
  EXPECT_EQ(binning_to(cloud_C, 30), 1);
  EXPECT_EQ(binning_to(cloud_C, 6), 2);
  EXPECT_EQ(binning_to(cloud_C, 1), 4) << "no more than a side has";
  geometry::PointCloud large;
  for (const auto& [width, height, n] : {std::tuple(1024, 768, 4), std::tuple(640, 480, 2),
                                         std::tuple(320, 240, 1), std::tuple(1000000, 0, 1)}) {
    large.points.resize(static_cast<std::size_t>(width) * std::max(1, height));
    large.width = width;
    large.height = height;
    EXPECT_EQ(binning_to(large, 50000), n) << width;
  }
  EXPECT_THROW(binned(cloud_C, 5), geometry::InputError);
  EXPECT_THROW(binned(cloud_C, 0), std::invalid_argument);
  cloud_C.height = 0;
  EXPECT_THROW(binned(cloud_C, 2), std::invalid_argument);
}

TEST(Binned, CameraSeesAPointInThePixelThatCoversItsOwn) {
  const geometry::StereoCamera camera{{641, 482, 512.5, 498, 311.7, 250.2}, 0.12};
  for (const int n : {1, 2, 3, 4, 16}) {
    const geometry::StereoCamera small = binned(camera, n);
    EXPECT_EQ(small.left.width, 641 / n);
    EXPECT_EQ(small.left.height, 482 / n);
    EXPECT_EQ(small.baseline, camera.baseline);
    for (const Eigen::Vector3d& p_C : {Eigen::Vector3d(0.1, -0.2, 0.9),
                                       Eigen::Vector3d(-0.4, 0.3, 2.0), Eigen::Vector3d(0, 0, 1)}) {
      // In pixels' corners, of which (0, 0) is the same in both.
      const Eigen::Vector2d before = camera.left.project(p_C) + Eigen::Vector2d::Constant(0.5);
      const Eigen::Vector2d after = small.left.project(p_C) + Eigen::Vector2d::Constant(0.5);
      EXPECT_LT((before / n - after).norm(), 1e-12) << n;
    }
  }
}

TEST(Binned, RefusesWhatLeavesNothing) {
  EXPECT_THROW(binned(geometry::ColorImage(8, 8), 0), std::invalid_argument);
  EXPECT_THROW(binned(geometry::ColorImage(8, 8), -2), std::invalid_argument);
  EXPECT_THROW(binned(geometry::ColorImage(8, 3), 4), geometry::InputError);
  EXPECT_THROW(binned(geometry::DepthImage(), 2), geometry::InputError);
  EXPECT_THROW(binned(geometry::PinholeCamera{3, 3, 1, 1, 1, 1}, 4), geometry::InputError);
}

}  // namespace
}  // namespace prehend::perception
