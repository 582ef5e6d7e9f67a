// Pictures with fewer pixels against means and medians by hand, and their camera against the rays
// of the pixels that it covers.

#include <cmath>
#include <limits>
#include <stdexcept>

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
