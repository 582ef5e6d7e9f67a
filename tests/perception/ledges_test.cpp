#include "prehend/perception/ledges.h"

#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <random>
#include <set>

#include <gtest/gtest.h>

namespace prehend::perception {
namespace {

/// What is seen of boxes and cylinders from in front (-y) and above, in a frame whose z is up.
struct Pile {
  geometry::PointCloud cloud;
  std::vector<int> body;  // one per point
  std::mt19937 random{5};

  void add(double x, double y, double z, int of, const geometry::Rgb& color) {
    std::normal_distribution<float> noise(0, 0.0007f);
    cloud.points.emplace_back(static_cast<float>(x) + noise(random),
                              static_cast<float>(y) + noise(random),
                              static_cast<float>(z) + noise(random));
    cloud.colors.push_back(color);
    body.push_back(of);
  }
  /// From `low` to `high`; what `hidden` says of a point is left out.
  void box(const Eigen::Vector3d& low, const Eigen::Vector3d& high, int of,
           const geometry::Rgb& color = {200, 40, 40}) {
    constexpr double kStep = 0.002;
    for (double x = low.x(); x <= high.x(); x += kStep) {
      for (double y = low.y(); y <= high.y(); y += kStep) add(x, y, high.z(), of, color);
      for (double z = low.z(); z <= high.z(); z += kStep) add(x, low.y(), z, of, color);
    }
  }
  /// Points that another box stands on are not seen.
  void hide_under(const Eigen::Vector3d& low, const Eigen::Vector3d& high) {
    Pile kept;
    for (std::size_t i = 0; i < body.size(); ++i) {
      const Eigen::Vector3d p = cloud.points[i].cast<double>();
      const bool hidden = p.x() > low.x() && p.x() < high.x() && p.y() > low.y() + 0.002 &&
                          p.y() < high.y() && p.z() < low.z() + 0.003;
      if (hidden) continue;
      kept.cloud.points.push_back(cloud.points[i]);
      kept.cloud.colors.push_back(cloud.colors[i]);
      kept.body.push_back(body[i]);
    }
    cloud = kept.cloud;
    body = kept.body;
  }
  std::vector<std::vector<int>> split(const LedgeOptions& options = {}) const {
    std::vector<int> members(cloud.size());
    std::iota(members.begin(), members.end(), 0);
    std::vector<std::vector<int>> parts;
    for (LedgePart& part : split_at_ledges(cloud, geometry::Plane{}, members, options)) {
      parts.push_back(std::move(part.members));
    }
    return parts;
  }
  /// Share of the points that are in a part that is mostly of their body, every body having one.
  double agreement(const std::vector<std::vector<int>>& parts) const {
    std::set<int> bodies;
    double right = 0;
    for (const auto& part : parts) {
      std::map<int, int> count;
      for (const int i : part) ++count[body[i]];
      const auto most =
          std::max_element(count.begin(), count.end(),
                           [](const auto& a, const auto& b) { return a.second < b.second; });
      bodies.insert(most->first);
      right += most->second;
    }
    const std::set<int> all(body.begin(), body.end());
    return bodies == all ? right / static_cast<double>(cloud.size()) : 0;
  }
};

constexpr geometry::Rgb kLedgeRed{200, 40, 40}, kLedgeBlue{40, 60, 200}, kLedgeGreen{40, 180, 60};

Pile stack(const geometry::Rgb& upper) {
  Pile pile;
  pile.box({-0.075, -0.05, 0}, {0.075, 0.05, 0.07}, 0, kLedgeRed);
  pile.hide_under({-0.05, -0.035, 0.07}, {0.05, 0.035, 0.13});
  pile.box({-0.05, -0.035, 0.07}, {0.05, 0.035, 0.13}, 1, upper);
  return pile;
}

TEST(Ledges, DivideAStackOfTwo) {
  const Pile pile = stack(kLedgeBlue);
  const auto parts = pile.split();
  ASSERT_EQ(parts.size(), 2u);
  EXPECT_EQ(parts[0].size() + parts[1].size(), pile.cloud.size());
  EXPECT_GT(pile.agreement(parts), 0.95);
}

TEST(Ledges, DivideAStackOfThree) {
  Pile pile = stack(kLedgeBlue);
  pile.hide_under({-0.03, -0.02, 0.13}, {0.03, 0.02, 0.17});
  pile.box({-0.03, -0.02, 0.13}, {0.03, 0.02, 0.17}, 2, kLedgeGreen);
  const auto parts = pile.split();
  ASSERT_EQ(parts.size(), 3u);
  EXPECT_GT(pile.agreement(parts), 0.95);
}

// One thing with a step, or two in one colour: nobody can tell, and that is said.
TEST(Ledges, AStepInOneColourMayBeSeveral) {
  const auto parts_of = [](const Pile& pile) {
    std::vector<int> members(pile.cloud.size());
    std::iota(members.begin(), members.end(), 0);
    return split_at_ledges(pile.cloud, geometry::Plane{}, members);
  };
  const auto alike = parts_of(stack(kLedgeRed));
  ASSERT_EQ(alike.size(), 1u);
  EXPECT_TRUE(alike[0].may_be_several);
  for (const LedgePart& part : parts_of(stack(kLedgeBlue))) EXPECT_FALSE(part.may_be_several);
  Pile box;
  box.box({-0.05, -0.05, 0}, {0.05, 0.05, 0.1}, 0, kLedgeRed);
  EXPECT_FALSE(parts_of(box).front().may_be_several);
}

// Of the middle one only a strip is seen: known colours tell it from a lid.
TEST(Ledges, ARimIsALedgeWhereTheColorsSaySo) {
  for (const auto& [upper, parts] : {std::pair{kLedgeGreen, 3u}, std::pair{kLedgeBlue, 2u}}) {
    Pile pile = stack(kLedgeBlue);
    pile.hide_under({-0.031, -0.034, 0.13}, {0.049, 0.034, 0.17});
    pile.box({-0.031, -0.034, 0.13}, {0.049, 0.034, 0.17}, 2, upper);
    EXPECT_EQ(pile.split().size(), parts);
    pile.cloud.colors.clear();
    EXPECT_EQ(pile.split().size(), 2u);
  }
}

// A wall in the shade, a face in the light.
TEST(Ledges, ShadesOfOneColorAreOneThing) { EXPECT_EQ(stack({110, 20, 20}).split().size(), 1u); }

// Without hues brightness tells whose the wall is.
TEST(Ledges, DivideWhiteOnBlackWithFlushFronts) {
  Pile pile;
  pile.box({-0.075, -0.05, 0}, {0.075, 0.05, 0.07}, 0, {20, 20, 20});
  pile.hide_under({-0.05, -0.05, 0.07}, {0.05, 0.02, 0.13});
  pile.box({-0.05, -0.05, 0.07}, {0.05, 0.02, 0.13}, 1, {235, 235, 235});
  const auto parts = pile.split();
  ASSERT_EQ(parts.size(), 2u);
  EXPECT_GT(pile.agreement(parts), 0.95);
}

// Seen from 30 degrees above, 1 cm more of height hides 1.7 cm behind it.
TEST(Ledges, AreBehindSomethingTallerAsFarAsItsShadowReaches) {
  constexpr double kAway = 0.7, kOver = 0.4;  // m, of the camera, along and over the table
  for (const auto& [gap, parts] : {std::pair{0.045, 2u}, std::pair{0.12, 1u}}) {
    Pile pile;
    pile.box({-0.04, kAway, 0}, {0.04, kAway + 0.06, 0.12}, 0, kLedgeRed);
    for (double x = -0.04; x <= 0.04; x += 0.002) {
      for (double y = 0; y <= 0.05; y += 0.002) {
        pile.add(x, kAway + 0.06 + gap + y, 0.095, 1, kLedgeBlue);
      }
    }
    for (Eigen::Vector3f& p : pile.cloud.points) p.z() -= static_cast<float>(kOver);
    std::vector<int> members(pile.cloud.size());
    std::iota(members.begin(), members.end(), 0);
    const geometry::Plane table{Eigen::Vector3d::UnitZ(), -kOver};
    EXPECT_EQ(split_at_ledges(pile.cloud, table, members, {}).size(), parts) << gap;
  }
}

// Nobody can see whether the ledge has a wall under it.
TEST(Ledges, DivideALowerThingBehindATallerOne) {
  Pile pile;
  pile.box({-0.04, 0.30, 0}, {0.04, 0.36, 0.1}, 0, kLedgeRed);
  const std::size_t front = pile.cloud.size();
  for (double x = -0.04; x <= 0.04; x += 0.002) {
    for (double y = 0.37; y <= 0.42; y += 0.002) pile.add(x, y, 0.085, 1, kLedgeBlue);
  }
  const auto parts = pile.split();
  ASSERT_EQ(parts.size(), 2u);
  EXPECT_GT(pile.agreement(parts), 0.95);
  // A wing: the table is seen before it.
  for (std::size_t i = front; i < pile.cloud.size(); ++i) pile.cloud.points[i].y() -= 0.13f;
  EXPECT_EQ(pile.split().size(), 1u);
}

TEST(Ledges, DivideWhatStandsSideBySide) {
  Pile pile;
  pile.box({-0.08, -0.03, 0}, {0, 0.03, 0.09}, 0, kLedgeRed);
  pile.box({0.003, -0.03, 0}, {0.07, 0.03, 0.1}, 1, kLedgeBlue);
  const auto parts = pile.split();
  ASSERT_EQ(parts.size(), 2u);
  EXPECT_GT(pile.agreement(parts), 0.95);
}

// The upper one's front over the lower one's: the lower wall seems to go on.
TEST(Ledges, ColorsTellFlushFrontsApart) {
  Pile pile;
  pile.box({-0.075, -0.05, 0}, {0.075, 0.05, 0.07}, 0, kLedgeRed);
  pile.hide_under({-0.04, -0.05, 0.07}, {0.04, 0.05, 0.13});
  pile.box({-0.04, -0.05, 0.07}, {0.04, 0.05, 0.13}, 1, kLedgeBlue);
  const auto parts = pile.split();
  ASSERT_EQ(parts.size(), 2u);
  EXPECT_GT(pile.agreement(parts), 0.95);
}

TEST(Ledges, OneColorIsOneThingAndWithoutColorsTheShapeDecides) {
  Pile pile = stack(kLedgeRed);
  EXPECT_EQ(pile.split().size(), 1u);
  pile.cloud.colors.clear();
  EXPECT_EQ(pile.split().size(), 2u);
}

TEST(Ledges, AreNotTheFloorOfAHollowTheShoulderOfANeckNorABrim) {
  // A tray: its rim rises round its floor.
  Pile tray;
  tray.box({-0.1, -0.07, 0}, {0.1, 0.07, 0.02}, 0);
  tray.cloud.colors.clear();
  for (double x = -0.1; x <= 0.1; x += 0.002) {
    for (double y = -0.07; y <= 0.07; y += 0.002) {
      if (std::abs(x) > 0.085 || std::abs(y) > 0.055) tray.add(x, y, 0.06, 0, kLedgeRed);
    }
  }
  tray.cloud.colors.clear();
  EXPECT_EQ(tray.split().size(), 1u);

  // A carton with a neck of 16 mm.
  Pile carton;
  carton.box({-0.04, -0.04, 0}, {0.04, 0.04, 0.1}, 0);
  carton.box({-0.008, -0.008, 0.1}, {0.008, 0.008, 0.14}, 0);
  carton.cloud.colors.clear();
  EXPECT_EQ(carton.split().size(), 1u);

  // A gable: its slopes are no tops, in no part.
  Pile gable;
  gable.box({-0.04, -0.04, 0}, {0.04, 0.04, 0.1}, 0);
  for (double x = -0.04; x <= 0.04; x += 0.001) {
    for (double y = -0.04; y <= 0.04; y += 0.002) {
      gable.add(x, y, 0.11 + 0.6 * (0.04 - std::abs(x)), 0, kLedgeRed);
    }
  }
  gable.cloud.colors.clear();
  EXPECT_EQ(gable.split().size(), 1u);

  // Wings: nothing is seen under them.
  Pile wings;
  wings.box({-0.1, -0.03, 0.045}, {0.1, 0.03, 0.05}, 0);
  wings.box({-0.02, -0.06, 0.05}, {0.02, 0.06, 0.09}, 0);
  wings.cloud.colors.clear();
  EXPECT_EQ(wings.split().size(), 1u);
}

TEST(Ledges, KeepEveryPointOfHostileClusters) {
  Pile pile = stack(kLedgeBlue);
  EXPECT_TRUE(split_at_ledges(pile.cloud, geometry::Plane{}, {}, {}).front().members.empty());
  const auto few = split_at_ledges(pile.cloud, geometry::Plane{}, {1, 5, 9}, {});
  ASSERT_EQ(few.size(), 1u);
  EXPECT_EQ(few[0].members.size(), 3u);
  // A point a kilometre off: no map is made of that.
  pile.cloud.points.front() = {1000, 0, 0.1f};
  EXPECT_EQ(pile.split().size(), 1u);
}

TEST(Ledges, BadOptionsAreRefused) {
  const Pile pile = stack(kLedgeBlue);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(pile.split({.cell = 0}), std::invalid_argument);
  EXPECT_THROW(pile.split({.cell = nan}), std::invalid_argument);
  EXPECT_THROW(pile.split({.flatness = 0.01}), std::invalid_argument);
  EXPECT_THROW(pile.split({.least_level_share = 2}), std::invalid_argument);
}

}  // namespace
}  // namespace prehend::perception
