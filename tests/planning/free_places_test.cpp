#include "prehend/planning/free_places.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "prehend/geometry/errors.h"

namespace prehend::planning {
namespace {

using ::testing::HasSubstr;
using Points = std::vector<Eigen::Vector3d>;

Points box(double x, double y, double half, double height) {
  Points corners;
  for (const double dx : {-half, half}) {
    for (const double dy : {-half, half}) {
      for (const double z : {0.0, height}) corners.emplace_back(x + dx, y + dy, z);
    }
  }
  return corners;
}

// Between two boxes [m], 0 where they overlap.
double gap(const Points& object, const Eigen::Vector3d& move, const Points& other) {
  Eigen::AlignedBox2d a, b;
  for (const auto& p : object) a.extend((p + move).head<2>());
  for (const auto& p : other) b.extend(p.head<2>());
  return a.exteriorDistance(b);
}

TEST(FreePlaces, AloneItGoesAlongY) {
  const FreePlaces places = free_places({}, box(0, 0, 0.03, 0.1), {});
  ASSERT_FALSE(places.moves_W.empty());
  EXPECT_NEAR((places.moves_W.front() - Eigen::Vector3d(0, 0.15, 0)).norm(), 0, 1e-12);
  EXPECT_TRUE(places.moves_W.back().isZero()) << "where it stands is free once it is lifted";
}

// Regression: two of three objects of config/scenes/demo.yaml had their place taken.
TEST(FreePlaces, KeepsAwayFromTheOthersOfTheDemo) {
  const std::vector<Points> all{box(0, 0, 0.043, 0.115), box(-0.06, 0.2, 0.048, 0.09),
                                box(0.03, -0.145, 0.045, 0.09)};
  for (std::size_t i = 0; i < all.size(); ++i) {
    std::vector<Points> others = all;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(i));
    const FreePlaces places = free_places({}, all[i], others);
    ASSERT_GT(places.moves_W.size(), 2u);
    for (std::size_t k = 0; k + 1 < places.moves_W.size(); ++k) {
      EXPECT_GE(places.moves_W[k].norm(), 0.149);
      for (const Points& other : others) {
        EXPECT_GE(gap(all[i], places.moves_W[k], other), PlaceOptions().clearance - 1e-9);
      }
    }
    for (const Points& other : others) {
      EXPECT_GE(gap(all[i], places.moves_W.front(), other), PlaceOptions().enough - 1e-9);
    }
  }
}

TEST(FreePlaces, RoomIsNeverOverestimatedAndHardlyUnderestimated) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (int n = 0; n < 300; ++n) {
    const Points object = box(0, 0, 0.03, 0.1);
    const Points other = box(0.4 * uniform(random), 0.4 * uniform(random), 0.04, 0.1);
    PlaceOptions options;
    options.given_W = Eigen::Vector2d(0.3 * uniform(random), 0.3 * uniform(random));
    if (options.given_W->norm() < 0.03) continue;
    const Eigen::Vector3d move(options.given_W->x(), options.given_W->y(), 0);
    const double true_gap = gap(object, move, other);
    options.clearance = std::max(1e-9, 0.997 * true_gap - 1e-9);
    options.enough = options.clearance;
    EXPECT_EQ(free_places({}, object, {other}, options).problem.empty(), true_gap > 1e-6) << n;
    options.clearance = options.enough = 1.001 * true_gap + 1e-6;
    EXPECT_FALSE(free_places({}, object, {other}, options).problem.empty()) << n;
  }
}

TEST(FreePlaces, OnlyWhereItCanBeCarried) {
  PlaceOptions options;
  options.unreachable = [](const Eigen::Vector3d& move) -> std::string {
    return std::abs(move.x()) < 0.01 && move.y() < 0.1 && move.y() > -0.2 ? "" : "too far";
  };
  const FreePlaces places = free_places({}, box(0, 0, 0.02, 0.1), {}, options);
  ASSERT_EQ(places.moves_W.size(), 2u);
  EXPECT_NEAR(places.moves_W.front().y(), -0.15, 1e-9);
}

TEST(FreePlaces, WhatIsPutStandsOnATiltedTableToo) {
  const geometry::Plane slope{Eigen::Vector3d(0.1, -0.2, 1).normalized(), 0.05};
  for (const Eigen::Vector3d& move : free_places(slope, box(0, 0, 0.02, 0.1), {}).moves_W) {
    EXPECT_NEAR(move.dot(slope.normal), 0, 1e-12);
  }
  PlaceOptions options;
  options.given_W = Eigen::Vector2d(0.2, 0.1);
  const FreePlaces given = free_places(slope, box(0, 0, 0.02, 0.1), {}, options);
  ASSERT_EQ(given.moves_W.size(), 1u) << given.problem;
  EXPECT_NEAR(given.moves_W[0].dot(slope.normal), 0, 1e-12);
}

TEST(FreePlaces, AGivenPlaceIsTakenOrRefused) {
  const Points object = box(0.1, 0, 0.03, 0.1);
  PlaceOptions options;
  options.given_W = Eigen::Vector2d(0.1, -0.2);
  const FreePlaces free = free_places({}, object, {box(0, 0.2, 0.05, 0.1)}, options);
  ASSERT_EQ(free.moves_W.size(), 1u) << free.problem;
  EXPECT_NEAR((free.moves_W[0] - Eigen::Vector3d(0, -0.2, 0)).norm(), 0, 1e-12);
  const FreePlaces occupied = free_places({}, object, {box(0.12, -0.22, 0.05, 0.1)}, options);
  EXPECT_TRUE(occupied.moves_W.empty());
  EXPECT_EQ(occupied.problem,
            "the place 0.100, -0.200 is occupied by what stands at 0.120, -0.220");
  options.unreachable = [](const Eigen::Vector3d&) { return "it is behind the wall"; };
  EXPECT_EQ(free_places({}, object, {}, options).problem,
            "the place 0.100, -0.200 cannot be reached: it is behind the wall");
  options.given_W = Eigen::Vector2d(0.101, 0.001);
  EXPECT_THAT(free_places({}, object, {}, options).problem, HasSubstr("stands at the place"));
}

TEST(FreePlaces, AMiddleThatIsGivenIsWhatStandsThere) {
  const Points object = box(0.1, 0, 0.03, 0.1);
  PlaceOptions options;
  options.middle_W = Eigen::Vector2d(0.12, 0.01);
  options.given_W = Eigen::Vector2d(0.1, -0.2);
  const FreePlaces given = free_places({}, object, {}, options);
  ASSERT_EQ(given.moves_W.size(), 1u) << given.problem;
  EXPECT_NEAR((given.moves_W[0] - Eigen::Vector3d(-0.02, -0.21, 0)).norm(), 0, 1e-12);
  options.given_W.reset();
  options.region_W = {"beside", {0, 0.3}, {0.1, 0.05}};
  for (const Eigen::Vector3d& move : free_places({}, object, {}, options).moves_W) {
    const Eigen::Vector2d from_middle =
        *options.middle_W + move.head<2>() - options.region_W->center;
    EXPECT_LE(std::abs(from_middle.x()), 0.05);
    EXPECT_LE(std::abs(from_middle.y()), 0.025);
  }
}

// Regression: a can was put at the edge of its place, stood 2 mm beside it, and was moved twice
// more.
TEST(FreePlaces, TheEdgeOfARegionIsLast) {
  PlaceOptions options;
  options.region_W = {"beside", {0, 0.3}, {0.2, 0.2}};
  const FreePlaces places = free_places({}, box(0, 0, 0.03, 0.1), {}, options);
  const auto is_at_edge = [](const Eigen::Vector3d& move) {
    return std::max(std::abs(move.x()), std::abs(move.y() - 0.3)) > 0.07;
  };
  const auto first = std::find_if(places.moves_W.begin(), places.moves_W.end(), is_at_edge);
  EXPECT_EQ(first - places.moves_W.begin(), 9);
  EXPECT_TRUE(std::all_of(first, places.moves_W.end(), is_at_edge));
  // Better there than nowhere.
  const FreePlaces beside =
      free_places({}, box(0, 0, 0.03, 0.1), {box(0, 0.3, 0.02, 0.1)}, options);
  ASSERT_FALSE(beside.moves_W.empty());
  EXPECT_TRUE(is_at_edge(beside.moves_W.front()));
}

TEST(FreePlaces, WhatStoodOnAnotherIsPutOnTheTable) {
  Points object = box(0, 0, 0.03, 0.1);
  for (Eigen::Vector3d& p : object) p.z() += 0.25;
  const FreePlaces places = free_places({}, object, {box(0, 0, 0.05, 0.25)});
  ASSERT_GT(places.moves_W.size(), 1u);
  for (std::size_t k = 0; k + 1 < places.moves_W.size(); ++k) {
    EXPECT_NEAR(places.moves_W[k].z(), -0.25, 1e-12);
  }
  EXPECT_TRUE(places.moves_W.back().isZero());
  for (Eigen::Vector3d& p : object) p.z() -= 0.245;  // by so much predictions are off
  EXPECT_EQ(free_places({}, object, {}).moves_W.front().z(), 0);
  PlaceOptions options;
  options.given_W = Eigen::Vector2d(0.3, 0);
  for (Eigen::Vector3d& p : object) p.z() += 0.1;
  EXPECT_NEAR(free_places({}, object, {}, options).moves_W.front().z(), -0.105, 1e-12);
}

TEST(FreePlaces, RefusesWhatIsNone) {
  EXPECT_THROW(free_places({}, {}, {}), std::invalid_argument);
  const auto refused = [](auto change) {
    PlaceOptions options;
    change(options);
    EXPECT_THROW(free_places({}, box(0, 0, 0.02, 0.1), {}, options), std::invalid_argument);
  };
  refused([](PlaceOptions& o) { o.distance = 0; });
  refused([](PlaceOptions& o) { o.farthest = 0.1; });
  refused([](PlaceOptions& o) { o.directions = 0; });
  refused([](PlaceOptions& o) { o.step = 0; });
  refused([](PlaceOptions& o) { o.clearance = -1; });
  refused([](PlaceOptions& o) { o.enough = 0; });
  refused([](PlaceOptions& o) { o.given_W = Eigen::Vector2d(std::nan(""), 0); });
  refused([](PlaceOptions& o) { o.middle_W = Eigen::Vector2d(std::nan(""), 0); });
}

TEST(ReadPlace, TakesTwoNumbers) {
  EXPECT_FALSE(read_place(""));
  EXPECT_EQ(*read_place("0.1,-0.2"), Eigen::Vector2d(0.1, -0.2));
  EXPECT_EQ(*read_place("1e-1, 0"), Eigen::Vector2d(0.1, 0));
  for (const char* text :
       {"0.1", "a,b", "0.1,", ",1", "1,2,3", "0.1 0.2", "nan,0", "1,inf", "1m,2"}) {
    EXPECT_THROW(read_place(text), geometry::InputError) << text;
  }
}

}  // namespace
}  // namespace prehend::planning
