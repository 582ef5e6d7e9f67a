#include "prehend/perception/mean_color.h"

#include <limits>

#include <gtest/gtest.h>

namespace prehend::perception {
namespace {

geometry::PointCloud two(const geometry::Rgb& a, const geometry::Rgb& b) {
  geometry::PointCloud cloud;
  cloud.points = {{0, 0, 1}, {0, 0, 1}};
  cloud.colors = {a, b};
  return cloud;
}

double hues(const geometry::Rgb& a, const geometry::Rgb& b) {
  return hue_difference(two(a, b), {0}, {1});
}

TEST(HueDifference, ShadeMakesNone) {
  // sRGB of 0.6 of the light, after IEC 61966-2-1.
  EXPECT_LT(hues({200, 40, 40}, {159, 29, 29}), 0.05);
  EXPECT_LT(hues({40, 60, 200}, {29, 46, 159}), 0.05);
  EXPECT_GT(color_difference(two({200, 40, 40}, {159, 29, 29}), {0}, {1}), 15);
}

TEST(HueDifference, TellsColorsApartAndNotBlackFromWhite) {
  EXPECT_GT(hues({200, 40, 40}, {40, 60, 200}), 0.5);
  EXPECT_GT(hues({200, 40, 40}, {128, 128, 128}), 0.5);
  EXPECT_LT(hues({10, 10, 10}, {250, 250, 250}), 0.05);
}

TEST(HueDifference, IsNothingWithoutColors) {
  geometry::PointCloud cloud;
  cloud.points = {{0, 0, 1}, {0, 0, 1}};
  EXPECT_EQ(hue_difference(cloud, {0}, {1}), 0);
  EXPECT_EQ(color_difference(cloud, {0}, {1}), std::numeric_limits<double>::infinity());
  EXPECT_EQ(hue_difference(two({1, 2, 3}, {200, 2, 3}), {}, {1}), 0);
}

}  // namespace
}  // namespace prehend::perception
