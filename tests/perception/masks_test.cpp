#include "prehend/perception/masks.h"

#include <cmath>

#include <gtest/gtest.h>

namespace prehend::perception {
namespace {

using geometry::DepthImage;
using geometry::MaskImage;

DepthImage known_within(int left, int top, int right, int bottom) {
  DepthImage depth(100, 80, NAN);
  for (int v = top; v <= bottom; ++v) {
    for (int u = left; u <= right; ++u) depth.at(u, v) = 1;
  }
  return depth;
}

MaskImage square(int left, int top, int side) {
  MaskImage mask(100, 80, 0);
  for (int v = top; v < top + side; ++v) {
    for (int u = left; u < left + side; ++u) mask.at(u, v) = 255;
  }
  return mask;
}

TEST(MeasuredArea, IsTheFrameOfTheKnownDepthsAndALittleLess) {
  const PixelRectangle area = measured_area(known_within(8, 5, 91, 79));
  EXPECT_EQ(area.left, 12);
  EXPECT_EQ(area.top, 9);
  EXPECT_EQ(area.right, 87);
  EXPECT_EQ(area.bottom, 75);
}

TEST(MeasuredArea, TakesTheImageWhereTheKnownDepthsEndInAnObject) {
  // The background above was cut away; one object sticks out.
  DepthImage depth = known_within(0, 40, 99, 79);
  for (int v = 10; v < 40; ++v) {
    for (int u = 30; u < 45; ++u) depth.at(u, v) = 1;
  }
  EXPECT_EQ(measured_area(depth).top, 0);
  EXPECT_EQ(measured_area(DepthImage(100, 80, NAN)).right, 99);
}

TEST(TouchesBorder, CountsTheMeasuredAreasBorderNotOnlyTheImages) {
  const PixelRectangle area = measured_area(known_within(8, 5, 91, 79));
  EXPECT_TRUE(touches_border(square(40, 6, 10), area, 2));
  EXPECT_FALSE(touches_border(square(40, 20, 10), area, 2));
  EXPECT_FALSE(touches_border(square(40, 6, 10), {0, 0, 99, 79}, 2));
  EXPECT_TRUE(touches_border(square(0, 20, 10), {0, 0, 99, 79}, 0));
  EXPECT_FALSE(touches_border(MaskImage(100, 80, 0), area, 2));
}

}  // namespace
}  // namespace prehend::perception
