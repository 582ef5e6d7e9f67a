// What stands on what, from the points that one view shows.

#include <gtest/gtest.h>

#include "prehend/perception/supports.h"

namespace prehend::perception {
namespace {

const geometry::Plane kTable{Eigen::Vector3d::UnitZ(), 0};

// The front (y = low.y) and the top of a box, as a camera at -y over the table sees it.
geometry::PointCloud front_and_top(const Eigen::Vector3f& low, const Eigen::Vector3f& high) {
  geometry::PointCloud cloud;
  for (float x = low.x(); x <= high.x(); x += 0.004F) {
    for (float z = low.z(); z <= high.z(); z += 0.004F) cloud.points.emplace_back(x, low.y(), z);
    for (float y = low.y(); y <= high.y(); y += 0.004F) cloud.points.emplace_back(x, y, high.z());
  }
  return cloud;
}

// Of what the other one hides nothing is seen.
geometry::PointCloud without(geometry::PointCloud cloud, const Eigen::Vector3f& low,
                             const Eigen::Vector3f& high) {
  std::erase_if(cloud.points, [&](const Eigen::Vector3f& p) {
    return (p.array() > low.array() - 1e-4F).all() && (p.array() < high.array() + 1e-4F).all();
  });
  return cloud;
}

TEST(Supports, TheUpperOfTwoStandsOnTheLower) {
  const auto lower = without(front_and_top({-0.05F, -0.07F, 0}, {0.05F, 0.07F, 0.07F}),
                             {-0.035F, -0.05F, 0.069F}, {0.035F, 0.07F, 0.2F});
  const auto upper = front_and_top({-0.035F, -0.05F, 0.07F}, {0.035F, 0.05F, 0.13F});
  const auto heights = support_heights({&lower, &upper}, kTable);
  EXPECT_EQ(heights[0], 0);
  EXPECT_NEAR(heights[1], 0.07, 0.002);
}

TEST(Supports, AnOverhangingOneStandsOnWhatIsSeenOfTheLower) {
  const auto lower = front_and_top({-0.04F, -0.04F, 0}, {0.04F, -0.039F, 0.1F});  // its front
  const auto upper = front_and_top({-0.06F, -0.06F, 0.105F}, {0.06F, 0.06F, 0.15F});
  EXPECT_NEAR(support_heights({&upper, &lower}, kTable)[0], 0.1, 0.003);
}

TEST(Supports, ThingsBesideTallerOrLowerOnesStandOnTheTable) {
  const auto tall = front_and_top({-0.04F, -0.04F, 0}, {0.04F, 0.04F, 0.2F});
  const auto beside = front_and_top({0.05F, -0.04F, 0.0F}, {0.1F, 0.04F, 0.06F});
  EXPECT_EQ(support_heights({&tall, &beside}, kTable), (std::vector<double>{0, 0}));
  // Its lower part is hidden, and what is seen near is much lower or higher.
  const auto floating = front_and_top({0.05F, -0.04F, 0.08F}, {0.1F, 0.04F, 0.12F});
  const auto low = front_and_top({0.05F, -0.06F, 0}, {0.1F, -0.05F, 0.02F});
  EXPECT_EQ(support_heights({&floating, &tall, &low}, kTable)[0], 0);
}

TEST(Supports, PointsOnALineOrNoneHaveNone) {
  geometry::PointCloud line, none;
  for (int i = 0; i < 50; ++i) line.points.emplace_back(0.001F * static_cast<float>(i), 0, 0.1F);
  EXPECT_EQ(support_heights({&line, &none}, kTable), (std::vector<double>{0, 0}));
  EXPECT_TRUE(support_heights({}, kTable).empty());
}

}  // namespace
}  // namespace prehend::perception
