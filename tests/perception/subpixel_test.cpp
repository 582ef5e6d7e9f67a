#include "prehend/perception/subpixel.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>

#include <gtest/gtest.h>

#include "prehend/perception/stereo.h"

namespace prehend::perception {
namespace {

constexpr int kWidth = 320, kHeight = 240;

/// A smooth texture with little contrast, as a matt table has.
class MattTexture {
 public:
  explicit MattTexture(unsigned seed) : random_(seed) {
    std::uniform_real_distribution<double> part(0, 1);
    for (Wave& wave : waves_) {
      wave = {0.1 + 0.9 * part(random_), 0.1 + 0.9 * part(random_), 7 * part(random_)};
    }
  }
  double at(double u, double v) const {
    double sum = 128;
    for (const Wave& wave : waves_) sum += 1.5 * std::sin(wave.x * u + wave.y * v + wave.phase);
    return sum;
  }
  std::uint8_t noisy(double u, double v) {
    std::normal_distribution<double> noise(0, 1);
    return static_cast<std::uint8_t>(std::clamp(at(u, v) + noise(random_), 0.0, 255.0));
  }

 private:
  struct Wave {
    double x, y, phase;
  };
  std::mt19937 random_;
  Wave waves_[24];
};

struct SlopedPair {
  GreyImage left{kWidth, kHeight}, right{kWidth, kHeight};
  DisparityImage truth{kWidth, kHeight};
  // With these disparities are a pixel's numbers 1 / depth.
  geometry::StereoCamera camera{{kWidth, kHeight, 100, 100, 0, 0}, 0.01};
  StereoOptions options{.min_depth = 1.0 / 60, .max_depth = 1.0 / 10};
};

/// A plane whose disparity grows by `slope` from row to row, in the middle it is 35.
SlopedPair sloped_plane(double slope, unsigned seed = 1) {
  SlopedPair pair;
  MattTexture texture(seed);
  for (int v = 0; v < kHeight; ++v) {
    const double d = 35 + slope * (v - kHeight / 2.0);
    for (int u = 0; u < kWidth; ++u) {
      pair.left.at(u, v) = texture.noisy(u, v);
      pair.right.at(u, v) = texture.noisy(u + d, v);
      pair.truth.at(u, v) = static_cast<float>(d);
    }
  }
  return pair;
}

struct Off {
  double mean = 0, deviation = 0;
  int count = 0;
};
/// Of the disparities within two pixels of the truth.
Off error_of(const DisparityImage& found, const DisparityImage& truth) {
  Off error;
  double squares = 0;
  for (std::size_t i = 0; i < found.data.size(); ++i) {
    const double off = found.data[i] - truth.data[i];
    if (!(std::abs(off) < 2)) continue;
    error.mean += off;
    squares += off * off;
    ++error.count;
  }
  error.mean /= error.count;
  error.deviation = std::sqrt(squares / error.count - error.mean * error.mean);
  return error;
}

DisparityImage matched(const SlopedPair& pair, const StereoOptions& options) {
  return match_stereo(pair.left, pair.right, pair.camera, options).disparity;
}

TEST(RefinedDisparity, DoesNotLagOnSlopes) {
  for (const double slope : {-0.15, -0.05, 0.05, 0.15}) {
    const SlopedPair pair = sloped_plane(slope);
    StereoOptions plain = pair.options;
    plain.subpixel.window = 0;
    const Off lagging = error_of(matched(pair, plain), pair.truth);
    const Off error = error_of(matched(pair, pair.options), pair.truth);
    ASSERT_GT(error.count, kWidth * kHeight / 2) << slope;
    EXPECT_GT(-lagging.mean * slope, 0) << "behind what is above, " << slope;
    EXPECT_LT(std::abs(error.mean), 0.5 * std::abs(lagging.mean)) << slope;
    EXPECT_LT(std::abs(error.mean), 0.06) << slope;
    EXPECT_LT(error.deviation, 1.1 * lagging.deviation) << slope;
  }
}

TEST(RefinedDisparity, MovesForwardsOnSlopesAlone) {
  const SlopedPair slope = sloped_plane(0.12), level = sloped_plane(0);
  for (const float offset : {-0.5F, -0.2F, 0.3F}) {  // behind, but for the last
    const auto left_of = [offset](const SlopedPair& pair) {
      DisparityImage moved = pair.truth;
      for (float& d : moved.data) d += offset;
      return error_of(refined_disparity(pair.left, pair.right, moved), pair.truth).mean;
    };
    EXPECT_NEAR(left_of(level), offset, 1e-3) << "nothing lags there";
    EXPECT_NEAR(left_of(slope), offset < 0 ? 0 : offset, 0.06) << offset;
  }
}

TEST(RefinedDisparity, LeavesWhatItCannotKnow) {
  const SlopedPair pair = sloped_plane(0);
  DisparityImage disparity = pair.truth;
  constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();
  for (int v = 100; v < 120; ++v) {
    for (int u = 100; u < 120; ++u) disparity.at(u, v) = kUnknown;
  }
  for (int v = 0; v < kHeight; ++v) {  // an edge
    for (int u = 200; u < kWidth; ++u) disparity.at(u, v) = 20;
  }
  const DisparityImage refined = refined_disparity(pair.left, pair.right, disparity);
  EXPECT_TRUE(std::isnan(refined.at(110, 110)));
  EXPECT_FALSE(std::isnan(refined.at(99, 110)));
  for (int v = 20; v < kHeight; v += 20) {
    EXPECT_NEAR(refined.at(199, v), 35, 0.01) << "as its own side does";
  }
  for (std::size_t i = 0; i < refined.data.size(); ++i) {
    if (std::isfinite(refined.data[i])) {
      EXPECT_LE(std::abs(refined.data[i] - disparity.data[i]), 0.7501F);
    }
  }
  // Nothing to see, and nothing to look at.
  const GreyImage grey(kWidth, kHeight, 100);
  EXPECT_EQ(refined_disparity(grey, grey, pair.truth).data, pair.truth.data);
  EXPECT_TRUE(refined_disparity({}, {}, {}).empty());
  DisparityImage far = pair.truth;
  std::fill(far.data.begin(), far.data.end(), 1e30F);
  EXPECT_EQ(refined_disparity(pair.left, pair.right, far).data, far.data);
}

TEST(RefinedDisparity, RefusesNonsense) {
  const SlopedPair pair = sloped_plane(0);
  const auto refused = [&](auto change) {
    SubpixelOptions options;
    change(options);
    EXPECT_THROW(refined_disparity(pair.left, pair.right, pair.truth, options),
                 std::invalid_argument);
    StereoOptions stereo = pair.options;
    stereo.subpixel = options;
    EXPECT_THROW(matched(pair, stereo), std::invalid_argument);
  };
  for (const int window : {-1, 1, 2, 4, 33}) {
    refused([&](SubpixelOptions& o) { o.window = window; });
  }
  refused([](SubpixelOptions& o) { o.iterations = 0; });
  refused([](SubpixelOptions& o) { o.most = 0; });
  refused([](SubpixelOptions& o) { o.texture = std::nan(""); });
  refused([](SubpixelOptions& o) { o.edge = -1; });
  EXPECT_THROW(refined_disparity(pair.left, GreyImage(3, 3), pair.truth), std::invalid_argument);
  EXPECT_THROW(refined_disparity(pair.left, pair.right, DisparityImage(3, 3)),
               std::invalid_argument);
}

}  // namespace
}  // namespace prehend::perception
