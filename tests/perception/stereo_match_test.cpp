// Block matching, confidence and filter on a rendered step: a textured square before a wall.

#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>

#include <gtest/gtest.h>

#include "prehend/perception/disparity_filter.h"
#include "prehend/perception/disparity_search.h"
#include "prehend/perception/stereo.h"
#include "prehend/perception/stereo_confidence.h"

namespace prehend::perception {
namespace {

constexpr int kMatchWidth = 320, kMatchHeight = 200;
constexpr int kFar = 20, kNear = 30;  // pixels of disparity
const float kUnknownDisparity = std::numeric_limits<float>::quiet_NaN();

geometry::StereoCamera camera() { return {{kMatchWidth, kMatchHeight, 400, 400, 160, 100}, 0.05}; }

bool in_square(int u, int v) { return u >= 130 && u < 220 && v >= 60 && v < 140; }
// Without texture, so that nothing can be matched.
bool in_blank(int u, int v) { return u >= 240 && u < 300 && v >= 20 && v < 60; }

struct MatchPair {
  GreyImage left{kMatchWidth, kMatchHeight}, right{kMatchWidth, kMatchHeight};
  DisparityImage truth{kMatchWidth, kMatchHeight};
};

MatchPair make_pair() {
  std::mt19937_64 random(3);
  GreyImage wall(kMatchWidth + 100, kMatchHeight), square(kMatchWidth + 100, kMatchHeight);
  for (auto* texture : {&wall, &square}) {
    for (std::uint8_t& value : texture->data) value = static_cast<std::uint8_t>(random() % 200);
  }
  for (std::uint8_t& value : square.data) value = static_cast<std::uint8_t>(value / 2 + 128);
  MatchPair pair;
  for (int v = 0; v < kMatchHeight; ++v) {
    for (int u = 0; u < kMatchWidth; ++u) {
      const bool near = in_square(u, v);
      pair.truth.at(u, v) = static_cast<float>(near ? kNear : kFar);
      pair.left.at(u, v) = near ? square.at(u, v) : in_blank(u, v) ? 90 : wall.at(u, v);
      const bool near_right = in_square(u + kNear, v);
      const int u_left = u + kFar;
      pair.right.at(u, v) = near_right            ? square.at(u + kNear, v)
                            : in_blank(u_left, v) ? 90
                                                  : wall.at(u_left, v);
    }
  }
  return pair;
}

struct Quality {
  double known = 0, wrong = 0;  // shares of the pixels, of the known ones
};

Quality quality_of(const DisparityImage& found, const DisparityImage& truth) {
  Quality q;
  for (std::size_t i = 0; i < truth.data.size(); ++i) {
    if (std::isnan(found.data[i])) continue;
    q.known += 1;
    q.wrong += std::abs(found.data[i] - truth.data[i]) > 1;
  }
  q.wrong /= std::max(q.known, 1.0);
  q.known /= static_cast<double>(truth.data.size());
  return q;
}

TEST(MatchStereo, BothMethodsFindTheStep) {
  const MatchPair pair = make_pair();
  for (const StereoMethod method : {StereoMethod::kSemiGlobal, StereoMethod::kBlockMatching}) {
    StereoOptions options;
    options.method = method;
    const StereoMatch match = match_stereo(pair.left, pair.right, camera(), options);
    const Quality q = quality_of(match.disparity, pair.truth);
    EXPECT_GT(q.known, 0.75) << static_cast<int>(method);
    EXPECT_LT(q.wrong, 0.06) << static_cast<int>(method);
    EXPECT_NEAR(match.disparity.at(175, 100), kNear, 0.5);
    EXPECT_NEAR(match.disparity.at(60, 100), kFar, 0.5);
    // Grey in three channels is the same picture.
    geometry::ColorImage left(kMatchWidth, kMatchHeight), right(kMatchWidth, kMatchHeight);
    for (std::size_t i = 0; i < left.data.size(); ++i) {
      left.data[i].fill(pair.left.data[i]);
      right.data[i].fill(pair.right.data[i]);
    }
    const Quality colored =
        quality_of(match_stereo(left, right, camera(), options).disparity, pair.truth);
    EXPECT_NEAR(colored.wrong, q.wrong, 0.01);
  }
}

TEST(MatchStereo, ConfidenceTellsWrongFromRight) {
  const MatchPair pair = make_pair();
  StereoOptions options;
  options.left_right_tolerance = -1;  // so that there is something wrong to find
  options.uniqueness_percent = 0;
  for (const bool both : {false, true}) {
    options.match_both_ways = both;
    const StereoMatch match = match_stereo(pair.left, pair.right, camera(), options);
    double right_sum = 0, right_count = 0, wrong_sum = 0, wrong_count = 0;
    for (std::size_t i = 0; i < match.disparity.data.size(); ++i) {
      if (std::isnan(match.disparity.data[i])) {
        EXPECT_EQ(match.confidence.data[i], 0);
        continue;
      }
      const bool wrong = std::abs(match.disparity.data[i] - pair.truth.data[i]) > 1;
      (wrong ? wrong_sum : right_sum) += match.confidence.data[i];
      (wrong ? wrong_count : right_count) += 1;
    }
    ASSERT_GT(wrong_count, 200);
    EXPECT_GT(right_sum / right_count, 0.75) << both;
    EXPECT_LT(wrong_sum / wrong_count, both ? 0.5 : 0.6) << both;
  }
}

TEST(MatchStereo, LeastConfidenceDropsPixels) {
  const MatchPair pair = make_pair();
  StereoOptions options;
  const Quality all =
      quality_of(match_stereo(pair.left, pair.right, camera(), options).disparity, pair.truth);
  options.min_confidence = 0.7;
  const Quality sure =
      quality_of(match_stereo(pair.left, pair.right, camera(), options).disparity, pair.truth);
  EXPECT_LT(sure.known, all.known);
  EXPECT_LT(sure.wrong, 0.5 * all.wrong);
  options.min_confidence = 1.5;
  EXPECT_THROW(match_stereo(pair.left, pair.right, camera(), options), std::invalid_argument);
}

// The rule's twin searches all disparities.
TEST(NarrowSearch, FindsWhatAllDisparitiesFind) {
  const MatchPair pair = make_pair();
  StereoOptions narrow, all;
  narrow.narrow_search = true;
  const DisparityRange range = seen_disparity_range(pair.left, pair.right, camera(), narrow);
  EXPECT_LT(range.count, disparity_range(camera(), all).count);
  EXPECT_LE(range.minimum, kFar - 2);
  EXPECT_GE(range.minimum + range.count, kNear + 2);
  for (const StereoMethod method : {StereoMethod::kSemiGlobal, StereoMethod::kBlockMatching}) {
    narrow.method = all.method = method;
    const DisparityImage found = match_stereo(pair.left, pair.right, camera(), narrow).disparity;
    const DisparityImage twin = match_stereo(pair.left, pair.right, camera(), all).disparity;
    std::size_t lost = 0, differ = 0;
    for (std::size_t i = 0; i < twin.data.size(); ++i) {
      // What is off the step's two planes may be lost: it is wrong.
      if (!(std::abs(twin.data[i] - pair.truth.data[i]) < 1)) continue;
      lost += std::isnan(found.data[i]);
      differ += std::abs(found.data[i] - twin.data[i]) > 1;
    }
    EXPECT_LT(lost, twin.data.size() / 200) << static_cast<int>(method);
    EXPECT_LT(differ, twin.data.size() / 200) << static_cast<int>(method);
    EXPECT_GE(quality_of(found, pair.truth).known, quality_of(twin, pair.truth).known - 0.01);
    EXPECT_LE(quality_of(found, pair.truth).wrong, quality_of(twin, pair.truth).wrong + 0.005);
  }
}

TEST(NarrowSearch, SearchesAllWhereLittleIsMatched) {
  std::mt19937_64 random(4);
  GreyImage left(kMatchWidth, kMatchHeight), right(kMatchWidth, kMatchHeight);
  for (std::uint8_t& value : left.data) value = static_cast<std::uint8_t>(random());
  for (std::uint8_t& value : right.data) value = static_cast<std::uint8_t>(random());
  const DisparityRange all = disparity_range(camera(), {});
  const DisparityRange range = seen_disparity_range(left, right, camera(), {});
  EXPECT_EQ(range.minimum, all.minimum);
  EXPECT_EQ(range.count, all.count);
}

// The small pair's disparities come in sixteens, too, and reach farther than those that are asked
// for.
TEST(NarrowSearch, WhatIsNearerThanTheNearestDepthIsNotSearched) {
  constexpr int kWidth = 512, kHeight = 64, kShift = 125;
  std::mt19937_64 random(6);
  GreyImage wall(kWidth + kShift, kHeight), left(kWidth, kHeight), right(kWidth, kHeight);
  for (int v = 0; v < kHeight; ++v) {
    // Texture that the small pair sees as well.
    for (int u = 0; u < wall.width; ++u) {
      wall.at(u, v) = v % 4 == 0 && u % 4 == 0 ? static_cast<std::uint8_t>(random() % 256)
                                               : wall.at(u - u % 4, v - v % 4);
    }
  }
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      left.at(u, v) = wall.at(u, v);
      right.at(u, v) = wall.at(u + kShift, v);
    }
  }
  const geometry::StereoCamera camera{{kWidth, kHeight, 400, 400, 256, 32}, 0.5};
  StereoOptions options;
  options.min_depth = 2.597;  // 77 pixels
  options.max_depth = 20;
  options.narrow_search = true;
  const DisparityRange all = disparity_range(camera, options);
  const DisparityRange range = seen_disparity_range(left, right, camera, options);
  EXPECT_GE(range.minimum, all.minimum);
  EXPECT_GE(range.count, 16);
  EXPECT_LE(range.count, all.count);
  EXPECT_NO_THROW(match_stereo(left, right, camera, options));
}

TEST(StereoDisparity, IsThatOfTheMatch) {
  const MatchPair pair = make_pair();
  geometry::ColorImage left(kMatchWidth, kMatchHeight), right = left;
  for (std::size_t i = 0; i < left.data.size(); ++i) {
    left.data[i].fill(pair.left.data[i]);
    right.data[i].fill(pair.right.data[i]);
  }
  for (const double least : {0.0, 0.6}) {
    StereoOptions options;
    options.min_confidence = least;
    const DisparityImage alone = stereo_disparity(left, right, camera(), options);
    const DisparityImage match = match_stereo(left, right, camera(), options).disparity;
    for (std::size_t i = 0; i < match.data.size(); ++i) {
      ASSERT_TRUE(alone.data[i] == match.data[i] ||
                  (std::isnan(alone.data[i]) && std::isnan(match.data[i])));
    }
  }
}

TEST(FilteredDisparity, FillsHolesUpToEdgesOfTheGuide) {
  const int n = 60;
  DisparityImage disparity(n, n, 10.0F);
  geometry::Image<float> confidence(n, n, 1.0F);
  GreyImage guide(n, n, 50);
  for (int v = 0; v < n; ++v) {
    for (int u = 30; u < n; ++u) {
      disparity.at(u, v) = 40;
      guide.at(u, v) = 200;
    }
    for (int u = 26; u < 34; ++u) disparity.at(u, v) = kUnknownDisparity;
  }
  const DisparityImage filtered = filtered_disparity(disparity, confidence, guide);
  for (int u = 0; u < n; ++u) EXPECT_NEAR(filtered.at(u, 20), u < 30 ? 10 : 40, 0.5) << u;

  // Where nothing is known nearby, nothing is invented.
  const DisparityImage nothing(n, n, kUnknownDisparity);
  for (const float d : filtered_disparity(nothing, confidence, guide).data) {
    EXPECT_TRUE(std::isnan(d));
  }
}

TEST(FilteredDisparity, SmoothesNoiseWithoutBias) {
  const int n = 80;
  std::mt19937_64 random(5);
  std::normal_distribution<float> noise(0, 0.5F);
  DisparityImage disparity(n, n);
  for (int v = 0; v < n; ++v) {
    for (int u = 0; u < n; ++u) disparity.at(u, v) = 20 + 0.05F * u + noise(random);
  }
  const DisparityImage filtered =
      filtered_disparity(disparity, geometry::Image<float>(n, n, 1.0F), GreyImage(n, n, 90),
                         {.smoothness = 30, .color_scale = 1.5});
  double bias = 0, squares = 0, count = 0;
  for (int v = 10; v < n - 10; ++v) {
    for (int u = 10; u < n - 10; ++u) {
      const double error = filtered.at(u, v) - (20 + 0.05 * u);
      bias += error;
      squares += error * error;
      count += 1;
    }
  }
  EXPECT_LT(std::abs(bias / count), 0.05);
  EXPECT_LT(std::sqrt(squares / count), 0.25);
}

TEST(FilteredDisparity, RejectsBadOptionsAndSizes) {
  const DisparityImage image(8, 8, 1.0F);
  const geometry::Image<float> confidence(8, 8, 1.0F);
  EXPECT_THROW(filtered_disparity(image, confidence, GreyImage(8, 9)), std::invalid_argument);
  EXPECT_THROW(
      filtered_disparity(image, confidence, GreyImage(8, 8), {.smoothness = kUnknownDisparity}),
      std::invalid_argument);
  EXPECT_THROW(filtered_disparity(image, confidence, GreyImage(8, 8), {.iterations = 0}),
               std::invalid_argument);
  EXPECT_THROW(stereo_confidence(GreyImage(8, 8), image, {}, 4), std::invalid_argument);
  EXPECT_THROW(stereo_confidence(GreyImage(7, 8), image), std::invalid_argument);
}

}  // namespace
}  // namespace prehend::perception
