#include <cmath>
#include <limits>
#include <stdexcept>

#include <gtest/gtest.h>

#include "eval/segmentation_accuracy.h"
#include "eval/stereo_accuracy.h"

namespace prehend::eval {
namespace {

const float kNan = std::numeric_limits<float>::quiet_NaN();

TEST(DisparityErrors, CountsBadAndMissingPixels) {
  perception::DisparityImage truth(10, 1, 20.0F), found(10, 1, 20.0F);
  truth.at(0, 0) = kNan;                   // does not count, whatever was found
  found.at(1, 0) = found.at(2, 0) = kNan;  // missing
  found.at(3, 0) = 21.5F;                  // bad at 1 px
  found.at(4, 0) = 17;                     // bad at 1 and 2 px
  found.at(5, 0) = 40;                     // bad at all
  geometry::Image<float> confidence(10, 1, 0.9F);
  for (int u = 3; u < 6; ++u) confidence.at(u, 0) = 0.1F;
  const DisparityErrors e = disparity_errors(found, truth, confidence);
  EXPECT_NEAR(e.density, 7.0 / 9, 1e-12);
  EXPECT_NEAR(e.bad[0], 3.0 / 7, 1e-12);
  EXPECT_NEAR(e.bad[1], 2.0 / 7, 1e-12);
  EXPECT_NEAR(e.bad[2], 1.0 / 7, 1e-12);
  EXPECT_NEAR(e.bad_or_missing[0], 5.0 / 9, 1e-12);
  EXPECT_EQ(e.sure_bad, 0);
  EXPECT_NEAR(e.unsure_bad, 3.0 / 4, 1e-12);
  EXPECT_THROW(disparity_errors(found, perception::DisparityImage(3, 3)), std::invalid_argument);
  const DisparityErrors none = disparity_errors(perception::DisparityImage(10, 1, kNan), truth);
  EXPECT_EQ(none.density, 0);
  EXPECT_EQ(none.bad_or_missing[0], 1);
}

TEST(SegmentationErrors, CountsMissedSplitAndMerged) {
  // Columns 0-9, 10-19, 20-29 are objects 0, 1, 2; the rest is table.
  geometry::Image<std::int16_t> labels(40, 20, -1);
  const auto mask = [](int first, int last) {
    geometry::MaskImage m(40, 20);
    for (int v = 0; v < 20; ++v) {
      for (int u = first; u < last; ++u) m.at(u, v) = 255;
    }
    return m;
  };
  for (int v = 0; v < 20; ++v) {
    for (int u = 0; u < 30; ++u) labels.at(u, v) = static_cast<std::int16_t>(u / 10);
  }
  const SegmentationErrors right =
      segmentation_errors({mask(0, 10), mask(10, 20), mask(20, 30)}, labels);
  EXPECT_EQ(right.truths, 3);
  EXPECT_EQ(right.missed + right.split + right.merged, 0);
  EXPECT_DOUBLE_EQ(right.iou, 1);

  const SegmentationErrors wrong =
      segmentation_errors({mask(0, 20), mask(20, 25), mask(25, 30)}, labels);
  EXPECT_EQ(wrong.merged, 1);
  EXPECT_EQ(wrong.split, 1);
  EXPECT_EQ(wrong.missed, 0);
  EXPECT_DOUBLE_EQ(wrong.iou, 0.5);

  const SegmentationErrors none = segmentation_errors({}, labels);
  EXPECT_EQ(none.missed, 3);
  EXPECT_EQ(none.iou, 0);
  const SegmentationErrors sum = right + none;
  EXPECT_EQ(sum.truths, 6);
  EXPECT_DOUBLE_EQ(sum.iou, 0.5);
  EXPECT_THROW(segmentation_errors({geometry::MaskImage(2, 2)}, labels), std::invalid_argument);
}

}  // namespace
}  // namespace prehend::eval
