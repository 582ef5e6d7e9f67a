#include "prehend/grasp/wrench/force_closure.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>

namespace prehend::grasp {
namespace {

const Eigen::Vector3d kOrigin = Eigen::Vector3d::Zero();

// Two fingers on the faces y = +-half of a cube.
std::vector<Contact> opposite_fingers(double half, double friction, double torsion_radius) {
  return {{{0, half, 0}, {0, -1, 0}, friction, torsion_radius},
          {{0, -half, 0}, {0, 1, 0}, friction, torsion_radius}};
}

TEST(ForceClosure, TwoPointContactsAreNeverClosed) {
  // No point contact resists a torque about the line of both, whatever the friction.
  for (double friction : {0.1, 0.5, 1.0, 10.0, 100.0}) {
    const auto result = evaluate_force_closure(opposite_fingers(0.025, friction, 0), kOrigin, 0.05);
    EXPECT_FALSE(result.closed) << friction;
    EXPECT_EQ(result.rank, 5) << friction;
    EXPECT_EQ(result.quality, 0) << friction;
  }
}

TEST(ForceClosure, RandomPairsOfPointContactsAreNeverClosed) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const auto vector = [&] {
    return Eigen::Vector3d(uniform(random), uniform(random), uniform(random));
  };
  for (int i = 0; i < 200; ++i) {
    const std::vector<Contact> contacts{{vector(), vector().normalized(), 2.0, 0},
                                        {vector(), vector().normalized(), 2.0, 0}};
    EXPECT_FALSE(evaluate_force_closure(contacts, vector(), 1.0).closed);
  }
}

TEST(ForceClosure, TwoSoftFingersOppositeAreClosed) {
  const auto result = evaluate_force_closure(opposite_fingers(0.025, 0.5, 0.01), kOrigin, 0.05);
  EXPECT_TRUE(result.closed);
  EXPECT_EQ(result.rank, 6);
  EXPECT_GT(result.quality, 0);
}

// Nguyen, "Constructing force-closure grasps", 1988: two soft fingers are closed exactly when the
// line through both points lies strictly inside both friction cones.
TEST(ForceClosure, TwoSoftFingersFollowNguyensConeCondition) {
  const double friction = 0.5;
  const double cone = std::atan(friction);
  for (double angle : {0.0, 0.5 * cone, 0.9 * cone, 1.1 * cone, 1.5 * cone}) {
    // The right contact is shifted along x, so the line of both leaves the normals by `angle`. The
    // shift is towards an edge of the linearised cone only in some directions, hence 64 edges.
    std::vector<Contact> contacts = opposite_fingers(0.025, friction, 0.01);
    contacts[1].point.x() = 0.05 * std::tan(angle);
    ForceClosureOptions options;
    options.cone_edges = 64;
    EXPECT_EQ(evaluate_force_closure(contacts, kOrigin, 0.05, options).closed, angle < cone)
        << angle / cone;
  }
}

TEST(ForceClosure, ThreeFingersAroundADisc) {
  // Point contacts with friction at 120 degrees: closed in space. Without friction: never, since
  // all normals meet in the centre. Within 100 degrees: not closed for a small cone.
  const auto at = [](double degrees, double friction) {
    const double a = degrees * M_PI / 180;
    const Eigen::Vector3d out(std::cos(a), std::sin(a), 0);
    return Contact{0.03 * out, -out, friction, 0};
  };
  const auto closed = [&](double spread, double friction) {
    return evaluate_force_closure({at(0, friction), at(spread, friction), at(-spread, friction)},
                                  kOrigin, 0.03)
        .closed;
  };
  EXPECT_TRUE(closed(120, 0.3));
  EXPECT_FALSE(closed(120, 0.0));
  EXPECT_FALSE(closed(50, 0.1));
}

TEST(ForceClosure, FrictionlessNeedsSevenContacts) {
  // Two contacts on each of three faces' pairs, placed so that they turn both ways: a cube held by
  // 12 frictionless contacts, of which subsets of six or fewer never close.
  std::vector<Contact> contacts;
  for (int axis = 0; axis < 3; ++axis) {
    for (double side : {-1.0, 1.0}) {
      for (double shift : {-0.5, 0.5}) {
        Contact contact;
        contact.point = side * Eigen::Vector3d::Unit(axis) +
                        side * shift * Eigen::Vector3d::Unit((axis + 1) % 3);
        contact.normal = -side * Eigen::Vector3d::Unit(axis);
        contacts.push_back(contact);
        // The same shift mirrored makes the opposite torque.
        contact.point = side * Eigen::Vector3d::Unit(axis) -
                        side * shift * Eigen::Vector3d::Unit((axis + 1) % 3);
        contacts.push_back(contact);
      }
    }
  }
  EXPECT_TRUE(evaluate_force_closure(contacts, kOrigin, 1.0).closed);
  std::mt19937 random(3);
  for (int trial = 0; trial < 300; ++trial) {
    std::shuffle(contacts.begin(), contacts.end(), random);
    const std::vector<Contact> six(contacts.begin(), contacts.begin() + 6);
    EXPECT_FALSE(evaluate_force_closure(six, kOrigin, 1.0).closed);
  }
}

TEST(ForceClosure, SevenFrictionlessContactsCanClose) {
  // Six normals whose wrenches are independent, and a seventh that is their negative mean: found by
  // a plane that carries the needed force along the needed line (pitch zero).
  // Forces +x, +y, +z at points that give independent torques, answered in pairs.
  std::vector<Contact> contacts{{{0, 1, 0}, {1, 0, 0}, 0, 0},  {{0, 0, 1}, {0, 1, 0}, 0, 0},
                                {{1, 0, 0}, {0, 0, 1}, 0, 0},  {{0, -1, 0}, {1, 0, 0}, 0, 0},
                                {{0, 0, -1}, {0, 1, 0}, 0, 0}, {{-1, 0, 0}, {0, 0, 1}, 0, 0}};
  EXPECT_EQ(evaluate_force_closure(contacts, kOrigin, 1.0).rank, 6);
  EXPECT_FALSE(evaluate_force_closure(contacts, kOrigin, 1.0).closed);
  contacts.push_back({{0, 0, 0}, -Eigen::Vector3d::Ones().normalized(), 0, 0});
  EXPECT_TRUE(evaluate_force_closure(contacts, kOrigin, 1.0).closed);
}

// For contacts with unit normal force on the cube's faces and W symmetric, the largest pure force
// along the closing direction y is that of one finger alone against nothing: the other's weight is
// zero, so r_y = 1; along x both cones' edges give mu.
TEST(ForceClosure, QualityOfOppositeFingersByHand) {
  const double friction = 0.4, radius = 0.01, half = 0.025, length = 0.05;
  const auto result =
      evaluate_force_closure(opposite_fingers(half, friction, radius), kOrigin, length);
  // Candidates: force x or z: mu. Torque about y: mu radius / length. Torque about x or z: one
  // finger pushes up, the other down: mu half / length. Force y: 1. The least is the torsion.
  EXPECT_NEAR(result.quality, friction * radius / length, 1e-9);
}

TEST(ForceClosure, DoesNotChangeWithScale) {
  std::vector<Contact> contacts = opposite_fingers(0.025, 0.5, 0.01);
  contacts[0].point.x() = 0.004;
  const auto reference = evaluate_force_closure(contacts, {0.001, 0.002, 0.003}, 0.05);
  for (double scale : {1e-3, 0.1, 10.0, 1e3}) {
    std::vector<Contact> scaled = contacts;
    for (auto& contact : scaled) {
      contact.point *= scale;
      contact.torsion_radius *= scale;
    }
    const auto result =
        evaluate_force_closure(scaled, scale * Eigen::Vector3d(0.001, 0.002, 0.003), scale * 0.05);
    EXPECT_EQ(result.closed, reference.closed);
    EXPECT_NEAR(result.quality, reference.quality, 1e-8);
  }
}

TEST(ForceClosure, QualityGrowsWithFrictionAndPatch) {
  double before = 0;
  for (double friction : {0.2, 0.4, 0.8}) {
    const double q =
        evaluate_force_closure(opposite_fingers(0.025, friction, 0.01), kOrigin, 0.05).quality;
    EXPECT_GT(q, before);
    before = q;
  }
}

TEST(ForceClosure, QualityBoundsTheLargestBall) {
  // The support function of the hull in any direction is at least the ball's radius, so no
  // direction may fall below quality / sqrt(6).
  const auto contacts = opposite_fingers(0.025, 0.5, 0.01);
  const auto result = evaluate_force_closure(contacts, kOrigin, 0.05);
  const auto wrenches = primitive_wrenches(contacts, kOrigin, 0.05, 8);
  std::mt19937 random(11);
  std::normal_distribution<double> normal;
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 20000; ++i) {
    Eigen::Matrix<double, 6, 1> u;
    for (int k = 0; k < 6; ++k) u[k] = normal(random);
    least = std::min(least, (u.normalized().transpose() * wrenches).maxCoeff());
  }
  EXPECT_GE(least, result.quality / std::sqrt(6.0));
}

// The programmes are degenerate; with tight tolerances GLPK once cycled for ever on the contacts of
// a bumpy box. Nearly symmetric pairs come close to every tie.
TEST(ForceClosure, NearlySymmetricPairsEnd) {
  std::mt19937 random(5);
  int closed = 0;
  for (int i = 0; i < 1500; ++i) {
    const double noise = std::pow(10.0, -3.0 - i % 12);
    std::normal_distribution<double> normal(0, noise);
    const auto jitter = [&] {
      return Eigen::Vector3d(normal(random), normal(random), normal(random));
    };
    std::vector<Contact> contacts = opposite_fingers(0.024, 0.6, 0.012);
    for (auto& contact : contacts) {
      contact.point += 0.02 * jitter();
      contact.normal = (contact.normal + jitter()).normalized();
      contact.torsion_radius += 0.01 * std::abs(normal(random));
    }
    closed += evaluate_force_closure(contacts, 0.01 * jitter(), 0.07).closed;
  }
  EXPECT_EQ(closed, 1500);
}

TEST(ForceClosure, OneContactOrNone) {
  EXPECT_FALSE(evaluate_force_closure({}, kOrigin, 1).closed);
  EXPECT_FALSE(evaluate_force_closure({{{0, 1, 0}, {0, -1, 0}, 1, 1}}, kOrigin, 1).closed);
}

TEST(ForceClosure, RejectsNonsense) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(evaluate_force_closure(opposite_fingers(1, 1, 1), kOrigin, 0),
               std::invalid_argument);
  EXPECT_THROW(evaluate_force_closure(opposite_fingers(nan, 1, 1), kOrigin, 1),
               std::invalid_argument);
  EXPECT_THROW(evaluate_force_closure(opposite_fingers(1, -1, 1), kOrigin, 1),
               std::invalid_argument);
  EXPECT_THROW(evaluate_force_closure({{{0, 0, 0}, {0, 0, 2}, 1, 1}}, kOrigin, 1),
               std::invalid_argument);
  ForceClosureOptions options;
  options.cone_edges = 2;
  EXPECT_THROW(evaluate_force_closure(opposite_fingers(1, 1, 1), kOrigin, 1, options),
               std::invalid_argument);
}

}  // namespace
}  // namespace prehend::grasp
