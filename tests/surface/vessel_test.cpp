#include "prehend/surface/vessel.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "prehend/geometry/mesh_query.h"
#include "prehend/surface/model.h"
#include "prehend/surface/reconstruct.h"

namespace prehend::surface {
namespace {

constexpr double kSpacing = 0.0012;  // m
constexpr double kRadius = 0.04;     // m, outside
constexpr double kHeight = 0.09;     // m
constexpr double kWall = 0.004;      // m

struct Seen {
  geometry::PointCloud cloud;
  std::vector<bool> seen;

  void add(const Eigen::Vector3d& p, const Eigen::Vector3d& n, bool was_seen = true) {
    cloud.points.push_back(p.cast<float>());
    cloud.normals.push_back(n.cast<float>());
    seen.push_back(was_seen);
  }
};

/// Points of an upright cup: `angles` of its outside (from -x), all of its inside down to
/// `deepest` over the table, its rim but for `gap` [rad] about +y.
Seen cup(double outside_angles, double deepest, double gap = 0) {
  Seen seen;
  const int around = static_cast<int>(2 * std::numbers::pi * kRadius / kSpacing);
  for (int k = 0; k < around; ++k) {
    const double angle = 2 * std::numbers::pi * k / around;
    const Eigen::Vector3d out(std::cos(angle), std::sin(angle), 0);
    if (std::abs(angle - 0.5 * std::numbers::pi) < 0.5 * gap) continue;
    for (double z = kSpacing / 2; z < kHeight; z += kSpacing) {
      const Eigen::Vector3d up = z * Eigen::Vector3d::UnitZ();
      if (std::abs(angle - std::numbers::pi) < outside_angles) seen.add(kRadius * out + up, out);
      if (z > deepest) seen.add((kRadius - kWall) * out + up, -out);
    }
    for (double r = kRadius - kWall + kSpacing / 2; r < kRadius; r += kSpacing) {
      seen.add(r * out + kHeight * Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitZ());
    }
  }
  if (deepest > kWall) return seen;
  for (double x = -kRadius; x < kRadius; x += kSpacing) {
    for (double y = -kRadius; y < kRadius; y += kSpacing) {
      if (std::hypot(x, y) < kRadius - kWall) {
        seen.add({x, y, kWall}, Eigen::Vector3d::UnitZ());
      }
    }
  }
  return seen;
}

double cup_volume() {
  return std::numbers::pi *
         (kRadius * kRadius * kHeight - (kRadius - kWall) * (kRadius - kWall) * (kHeight - kWall));
}

TEST(Basin, OfACupHasItsDepthAndArea) {
  const Seen seen = cup(4, 0);
  const auto basin = find_basin(seen.cloud, geometry::Plane{}, kSpacing);
  ASSERT_TRUE(basin);
  EXPECT_NEAR(basin->rim, kHeight, 1e-3);
  EXPECT_NEAR(basin->depth, kHeight - kWall, 2e-3);
  const double inner = kRadius - kWall;
  EXPECT_NEAR(basin->area, std::numbers::pi * inner * inner,
              0.15 * std::numbers::pi * inner * inner);
  for (std::size_t i = 0; i < seen.cloud.size(); ++i) {
    const Eigen::Vector3f& p = seen.cloud.points[i];
    if (p.z() > 0.08f) continue;
    EXPECT_EQ(basin->lines[i], p.head<2>().norm() < kRadius - 0.5 * kWall) << p.transpose();
  }
}

TEST(Basin, DoesNotDrainThroughAMissingPatchButThroughASlot) {
  const double cell = 3 * kSpacing / kRadius;  // rad
  EXPECT_TRUE(find_basin(cup(4, 0, 0.9 * cell).cloud, geometry::Plane{}, kSpacing));
  EXPECT_FALSE(find_basin(cup(4, 0, 5 * cell).cloud, geometry::Plane{}, kSpacing));
}

TEST(Basin, IsNoneInWhatHoldsNoWater) {
  // A block with a dent of 5 mm, and one whose top is level.
  for (const double dent : {0.005, 0.0}) {
    Seen block;
    for (double x = -0.03; x <= 0.03; x += kSpacing) {
      for (double y = -0.03; y <= 0.03; y += kSpacing) {
        const double z = std::hypot(x, y) < 0.02 ? 0.06 - dent : 0.06;
        block.add({x, y, z}, Eigen::Vector3d::UnitZ());
      }
    }
    EXPECT_FALSE(find_basin(block.cloud, geometry::Plane{}, kSpacing)) << dent;
  }
  EXPECT_FALSE(find_basin({}, geometry::Plane{}, kSpacing));
}

// The near half of the outside, the inside as deep as one looks, nothing of the floor.
TEST(VesselWalls, MakeACupOfWhatACameraSeesOfIt) {
  for (const double deepest : {0.0, 0.04}) {
    Seen seen = cup(0.5 * std::numbers::pi, deepest);
    const auto basin = find_basin(seen.cloud, geometry::Plane{}, kSpacing);
    ASSERT_TRUE(basin) << deepest;
    const VesselWall wall =
        add_vessel_walls(seen.cloud, seen.seen, *basin, kSpacing, 1.8 * kSpacing);
    EXPECT_TRUE(wall.measured);
    EXPECT_NEAR(wall.thickness, kWall, 0.5e-3);
    EXPECT_EQ(seen.seen.size(), seen.cloud.size());
    const auto mesh = reconstruct(seen.cloud, geometry::Plane{}, {});
    EXPECT_TRUE(geometry::find_defects(mesh).watertight());
    EXPECT_NEAR(geometry::mass_properties(mesh).volume, cup_volume(), 0.3 * cup_volume())
        << deepest;
    const geometry::MeshQuery query(mesh);
    EXPECT_FALSE(query.contains({0, 0, 0.05})) << "the hollow is filled";
    EXPECT_FALSE(query.contains({0.02, 0, 0.02})) << "the hollow is filled";
  }
}

// A mirrored outside that is off by more than the wall is thick would turn the wall inside out.
TEST(VesselWalls, TakeTheOtherSideFromTheSeenOne) {
  Seen seen = cup(0.5 * std::numbers::pi, 0);
  const std::size_t count = seen.cloud.size();
  for (std::size_t i = 0; i < count; ++i) {
    const Eigen::Vector3f p = seen.cloud.points[i], n = seen.cloud.normals[i];
    if (p.head<2>().norm() < kRadius - 1e-4) continue;
    // Mirrored at x = -3 mm: 6 mm too near, inside of the far wall's seen side.
    seen.add({-0.006 - static_cast<double>(p.x()), p.y(), p.z()}, {-n.x(), n.y(), n.z()}, false);
  }
  const auto basin = find_basin(seen.cloud, geometry::Plane{}, kSpacing);
  ASSERT_TRUE(basin);
  add_vessel_walls(seen.cloud, seen.seen, *basin, kSpacing, 1.8 * kSpacing);
  const auto mesh = reconstruct(seen.cloud, geometry::Plane{}, {});
  EXPECT_NEAR(geometry::mass_properties(mesh).volume, cup_volume(), 0.4 * cup_volume());
  const geometry::MeshQuery query(mesh);
  EXPECT_TRUE(query.contains({kRadius - 0.5 * kWall, 0, 0.05})) << "the far wall is lost";
}

}  // namespace
}  // namespace prehend::surface
