#include "prehend/perception/stereo.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "prehend/geometry/errors.h"

namespace prehend::perception {
namespace {

using geometry::InputError;
using geometry::StereoCamera;

StereoCamera test_camera(int width = 320, int height = 120) {
  return {{width, height, 400, 400, 0.5 * (width - 1), 0.5 * (height - 1)}, 0.06};
}

// A smooth random texture that can be sampled between pixels.
class Texture {
 public:
  explicit Texture(std::uint64_t seed) : noise_(1024, 256) {
    std::mt19937_64 random(seed);
    for (float& value : noise_.data) value = static_cast<float>(random() % 256);
  }
  std::uint8_t sample(double x, double y) const {
    const double wrapped = std::fmod(x + 4096, noise_.width - 1.0);
    const int u = static_cast<int>(wrapped);
    const double t = wrapped - u;
    const int v = static_cast<int>(y) % noise_.height;
    return static_cast<std::uint8_t>(
        std::lround((1 - t) * noise_.at(u, v) + t * noise_.at(u + 1, v)));
  }

 private:
  geometry::Image<float> noise_;
};

// A plane's images: the right image is textured, and left(u, v) = right(u - d(u, v), v).
struct Pair {
  GreyImage left;
  GreyImage right;
  DisparityImage truth;
};

template <typename Disparity>
Pair make_pair(const StereoCamera& camera, Disparity disparity) {
  const Texture texture(7);
  const int width = camera.left.width;
  const int height = camera.left.height;
  Pair pair{{width, height}, {width, height}, {width, height}};
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      const double d = disparity(u, v);
      pair.right.at(u, v) = texture.sample(u, v);
      pair.left.at(u, v) = texture.sample(u - d, v);
      pair.truth.at(u, v) = static_cast<float>(d);
    }
  }
  return pair;
}

struct Errors {
  double mean = 0;
  double valid = 0;     // share of the pixels that have a match in the right image
  double outliers = 0;  // share of the valid ones, over one pixel
};

Errors compare(const DisparityImage& found, const DisparityImage& truth) {
  Errors errors;
  double seen = 0;
  double valid = 0;
  for (int v = 8; v < truth.height - 8; ++v) {
    for (int u = 0; u < truth.width - 8; ++u) {
      if (static_cast<double>(truth.at(u, v)) > u - 8) continue;
      seen += 1;
      if (std::isnan(found.at(u, v))) continue;
      valid += 1;
      const double e = std::abs(static_cast<double>(found.at(u, v) - truth.at(u, v)));
      errors.mean += e;
      errors.outliers += e > 1;
    }
  }
  errors.mean /= valid;
  errors.outliers /= valid;
  errors.valid = valid / seen;
  return errors;
}

TEST(DisparityBySgbm, FrontoParallelPlaneOfWholePixels) {
  const StereoCamera camera = test_camera();
  const Pair pair = make_pair(camera, [](int, int) { return 30.0; });
  const Errors errors = compare(disparity_by_sgbm(pair.left, pair.right, camera), pair.truth);
  EXPECT_GT(errors.valid, 0.98);
  EXPECT_LT(errors.mean, 0.05);
}

TEST(DisparityBySgbm, SlantedPlaneToAFractionOfAPixel) {
  const StereoCamera camera = test_camera();
  const Pair pair = make_pair(camera, [](int u, int v) { return 18 + 0.03 * u + 0.05 * v; });
  const Errors errors = compare(disparity_by_sgbm(pair.left, pair.right, camera), pair.truth);
  EXPECT_GT(errors.valid, 0.9);
  EXPECT_LT(errors.mean, 0.2);
  EXPECT_LT(errors.outliers, 0.01);
}

TEST(DisparityBySgbm, MatchesTheLeftMarginDownToItsOwnDisparity) {
  const StereoCamera camera = test_camera();
  const Pair pair = make_pair(camera, [](int, int) { return 12.0; });
  const DisparityImage found = disparity_by_sgbm(pair.left, pair.right, camera);
  int left_margin = 0;  // pixels that OpenCV alone gives up: u < 68
  for (int v = 10; v < 110; ++v) {
    for (int u = 20; u < 60; ++u) left_margin += std::abs(found.at(u, v) - 12.0F) < 0.5F;
    for (int u = 0; u < 12; ++u) EXPECT_TRUE(std::isnan(found.at(u, v)));
  }
  EXPECT_GT(left_margin, 0.95 * 100 * 40);
}

TEST(DisparityBySgbm, ColourAndRepetitionGiveTheSame) {
  const StereoCamera camera = test_camera();
  const Pair pair = make_pair(camera, [](int u, int) { return 20 + 0.02 * u; });
  geometry::ColorImage left(320, 120);
  geometry::ColorImage right(320, 120);
  for (std::size_t i = 0; i < left.data.size(); ++i) {
    left.data[i].fill(pair.left.data[i]);
    right.data[i].fill(pair.right.data[i]);
  }
  const DisparityImage once = disparity_by_sgbm(left, right, camera);
  const DisparityImage again = disparity_by_sgbm(left, right, camera);
  EXPECT_LT(compare(once, pair.truth).mean, 0.2);
  for (std::size_t i = 0; i < once.data.size(); ++i) {
    EXPECT_TRUE(once.data[i] == again.data[i] ||
                (std::isnan(once.data[i]) && std::isnan(again.data[i])));
  }
}

TEST(DisparityBySgbm, ImagesWithoutTextureGiveNoRandomDepth) {
  const StereoCamera camera = test_camera();
  const GreyImage grey(320, 120, 128);
  const DisparityImage found = disparity_by_sgbm(grey, grey, camera);
  // A flat image matches everywhere alike; whatever is kept must be in the searched range.
  const DisparityRange range = disparity_range(camera, {});
  for (const float d : found.data) {
    if (std::isnan(d)) continue;
    EXPECT_GE(d, static_cast<float>(range.minimum));
    EXPECT_LT(d, static_cast<float>(range.minimum + range.count));
  }
}

TEST(DisparityRange, CoversTheDepths) {
  StereoOptions options;
  options.min_depth = 0.4;
  options.max_depth = 2.0;
  const StereoCamera camera = test_camera();
  const DisparityRange range = disparity_range(camera, options);
  EXPECT_LE(range.minimum, 400 * 0.06 / 2.0);
  EXPECT_GE(range.minimum + range.count, 400 * 0.06 / 0.4);
  EXPECT_EQ(range.count % 16, 0);
}

TEST(DisparityRange, RejectsBadOptionsAndCameras) {
  const auto with = [](auto change) {
    StereoOptions options;
    change(options);
    return options;
  };
  const StereoCamera camera = test_camera();
  EXPECT_THROW(disparity_range(camera, with([](auto& o) { o.min_depth = 0; })),
               std::invalid_argument);
  EXPECT_THROW(disparity_range(camera, with([](auto& o) { o.max_depth = 0.1; })),
               std::invalid_argument);
  EXPECT_THROW(disparity_range(camera, with([](auto& o) { o.block_size = 4; })),
               std::invalid_argument);
  EXPECT_THROW(disparity_range(camera, with([](auto& o) { o.large_step_penalty = 8; })),
               std::invalid_argument);
  StereoCamera without_baseline = camera;
  without_baseline.baseline = 0;
  EXPECT_THROW(disparity_range(without_baseline, {}), InputError);
  StereoCamera far_too_wide = camera;
  far_too_wide.baseline = 60;  // millimetres
  EXPECT_THROW(disparity_range(far_too_wide, {}), InputError);
}

TEST(DisparityBySgbm, RejectsImagesOfOtherSizes) {
  const GreyImage image(320, 120);
  EXPECT_THROW(disparity_by_sgbm(image, GreyImage(320, 119), test_camera()), InputError);
  EXPECT_THROW(disparity_by_sgbm(image, image, test_camera(640, 480)), InputError);
  EXPECT_THROW(disparity_by_sgbm(GreyImage(), GreyImage(), test_camera()), InputError);
}

TEST(CloudFromDisparity, PutsEachPixelOnItsRay) {
  const StereoCamera camera = test_camera(4, 3);
  DisparityImage disparity(4, 3, 24.0F);
  disparity.at(1, 1) = std::numeric_limits<float>::quiet_NaN();
  disparity.at(2, 1) = 0;
  const geometry::PointCloud cloud = cloud_from_disparity(disparity, camera);
  ASSERT_TRUE(cloud.organized());
  EXPECT_FALSE(geometry::is_finite(cloud.points[1 * 4 + 1]));
  EXPECT_FALSE(geometry::is_finite(cloud.points[1 * 4 + 2]));
  const Eigen::Vector3f p = cloud.points[2 * 4 + 3];
  EXPECT_NEAR(p.z(), 400 * 0.06 / 24, 1e-6);
  const Eigen::Vector2d pixel = camera.left.project(p.cast<double>());
  EXPECT_NEAR(pixel.x(), 3, 1e-4);
  EXPECT_NEAR(pixel.y(), 2, 1e-4);
  EXPECT_FLOAT_EQ(depth_of(cloud).at(3, 2), p.z());
  EXPECT_THROW(cloud_from_disparity(disparity, camera, geometry::ColorImage(3, 3)), InputError);
}

}  // namespace
}  // namespace prehend::perception
