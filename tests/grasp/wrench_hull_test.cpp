#include "prehend/grasp/wrench/wrench_hull.h"

#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>

#include <gtest/gtest.h>
#include <Eigen/Geometry>
#include <Eigen/QR>

#include "prehend/grasp/wrench/force_closure.h"

namespace prehend::grasp {
namespace {

Wrenches octahedron() {
  Wrenches result(6, 12);
  result << Eigen::Matrix<double, 6, 6>::Identity(), -Eigen::Matrix<double, 6, 6>::Identity();
  return result;
}

/// Seven unit vectors of which any two have the same angle.
Wrenches regular_simplex() {
  // Corners of a simplex in seven dimensions, in the axes of the plane across (1, ..., 1).
  Eigen::Matrix<double, 7, 7> corners = Eigen::Matrix<double, 7, 7>::Identity();
  corners.array() -= 1.0 / 7;
  Eigen::Matrix<double, 7, 7> basis = Eigen::Matrix<double, 7, 7>::Identity();
  basis.col(0).setOnes();
  const Eigen::Matrix<double, 7, 7> q =
      Eigen::HouseholderQR<Eigen::Matrix<double, 7, 7>>(basis).householderQ();
  Wrenches result = q.rightCols<6>().transpose() * corners;
  result.colwise().normalize();
  return result;
}

double uniform(std::mt19937_64& random) {
  return 2 * static_cast<double>(random() >> 11) * 0x1.0p-53 - 1;
}

Eigen::Vector3d random_vector(std::mt19937_64& random) {
  return {uniform(random), uniform(random), uniform(random)};
}

/// Contacts on a ball of 40 mm that press inward, askew by up to 0.3.
std::vector<Contact> random_grasp(std::mt19937_64& random, int contacts) {
  std::vector<Contact> grasp;
  for (int i = 0; i < contacts; ++i) {
    const Eigen::Vector3d out = random_vector(random).normalized();
    Contact contact;
    contact.point = 0.04 * out;
    contact.normal = (-out + 0.3 * random_vector(random)).normalized();
    contact.friction = 0.2 + 0.4 * (1 + uniform(random));
    contact.torsion_radius = random() % 2 == 0 ? 0 : 0.01;
    grasp.push_back(contact);
  }
  return grasp;
}

TEST(WrenchHull, ClosedForms) {
  const WrenchHull cross = wrench_hull(octahedron());
  EXPECT_TRUE(cross.closed);
  EXPECT_EQ(cross.rank, 6);
  EXPECT_NEAR(cross.epsilon, 1 / std::sqrt(6.0), 1e-12);
  EXPECT_NEAR(wrench_volume(octahedron()), std::pow(2.0, 6) / 720, 1e-9);
  const WrenchHull simplex = wrench_hull(regular_simplex());
  EXPECT_TRUE(simplex.closed);
  EXPECT_NEAR(simplex.epsilon, 1.0 / 6, 1e-12);
  // Half of a cube's corners and more: the inscribed ball of [-1, 1]^6 has radius 1.
  Wrenches cube(6, 64);
  for (int i = 0; i < 64; ++i) {
    for (int k = 0; k < 6; ++k) cube(k, i) = (i >> k & 1) != 0 ? 1 : -1;
  }
  EXPECT_NEAR(wrench_hull(cube).epsilon, 1, 1e-9);
}

TEST(WrenchHull, NotClosed) {
  // Half of the octahedron: the origin is on a face. Moved away: outside.
  Wrenches half = octahedron();
  half.col(11) *= 0;
  EXPECT_FALSE(wrench_hull(half).closed);
  EXPECT_EQ(wrench_hull(half).epsilon, 0);
  Wrenches moved = octahedron();
  moved.row(2).array() += 1.5;
  const WrenchHull outside = wrench_hull(moved);
  EXPECT_FALSE(outside.closed);
  EXPECT_NEAR(outside.distance, 0.5, 1e-9);
  EXPECT_TRUE(outside.weakest.isApprox(-Vector6::Unit(2), 1e-9));
  EXPECT_FALSE(may_be_closed(moved));
  // Flat, empty, one, all the same.
  Wrenches flat = octahedron();
  flat.row(5).setZero();
  EXPECT_FALSE(wrench_hull(flat).closed);
  EXPECT_EQ(wrench_hull(flat).rank, 5);
  EXPECT_NEAR(std::abs(wrench_hull(flat).weakest[5]), 1, 1e-9);
  EXPECT_EQ(wrench_volume(flat), 0);
  EXPECT_FALSE(wrench_hull(Wrenches(6, 0)).closed);
  EXPECT_FALSE(wrench_hull(Wrenches::Zero(6, 9)).closed);
  EXPECT_FALSE(wrench_hull(Wrenches::Constant(6, 9, 2.0)).closed);
}

TEST(WrenchHull, IsQhullsForRandomGrasps) {
  std::mt19937_64 random(1);
  int closed = 0;
  for (int n = 0; n < 400; ++n) {
    const auto grasp = random_grasp(random, 2 + n % 5);
    const Wrenches w = primitive_wrenches(grasp, Eigen::Vector3d::Zero(), 0.04, 8);
    const WrenchHull fast = wrench_hull(w), reference = reference_wrench_hull(w);
    ASSERT_EQ(fast.closed, reference.closed) << n;
    closed += fast.closed;
    if (!fast.closed) continue;
    ASSERT_NEAR(fast.epsilon, reference.epsilon, 1e-9) << n;
    // The weakest wrench is resisted by epsilon and no more.
    EXPECT_NEAR((-fast.weakest.transpose() * w).maxCoeff(), fast.epsilon, 1e-9);
    EXPECT_TRUE(may_be_closed(w));
    WrenchHullOptions only;
    only.closure_only = true;
    const WrenchHull quick = wrench_hull(w, only);
    EXPECT_TRUE(quick.closed);
    EXPECT_LE(quick.epsilon, fast.epsilon + 1e-12);
    EXPECT_LE(quick.facets, fast.facets);
  }
  EXPECT_GT(closed, 100);
  EXPECT_LT(closed, 390);
}

TEST(WrenchHull, PrecisionBoundsEpsilonFromBelow) {
  std::mt19937_64 random(12);
  int closed = 0, fewer = 0;
  for (int n = 0; n < 200; ++n) {
    const auto grasp = random_grasp(random, 3 + n % 6);
    const Wrenches w = primitive_wrenches(grasp, Eigen::Vector3d::Zero(), 0.04, 8);
    const WrenchHull exact = wrench_hull(w), rough = wrench_hull(w, {.precision = 0.2});
    ASSERT_EQ(rough.closed, exact.closed);
    EXPECT_LE(rough.epsilon, exact.epsilon + 1e-12);
    EXPECT_GE(rough.epsilon * 1.2, exact.epsilon - 1e-9);
    closed += exact.closed;
    fewer += rough.facets < exact.facets;
  }
  EXPECT_GT(closed, 50);
  EXPECT_GT(fewer, closed / 2);
  EXPECT_THROW(wrench_hull(octahedron(), {.precision = 1}), std::invalid_argument);
}

TEST(WrenchHull, AgreesWithTheLinearProgramme) {
  std::mt19937_64 random(2);
  int closed = 0;
  for (int n = 0; n < 500; ++n) {
    const auto grasp = random_grasp(random, 2 + n % 4);
    const ForceClosure by_programme = evaluate_force_closure(grasp, Eigen::Vector3d::Zero(), 0.04);
    const WrenchHull hull =
        wrench_hull(primitive_wrenches(grasp, Eigen::Vector3d::Zero(), 0.04, 8));
    ASSERT_EQ(hull.closed, by_programme.closed) << n;
    closed += hull.closed;
    if (!hull.closed) continue;
    // quality / sqrt(6) <= epsilon <= quality.
    EXPECT_LE(hull.epsilon, by_programme.quality + 1e-9);
    EXPECT_GE(hull.epsilon, by_programme.quality / std::sqrt(6.0) - 1e-9);
  }
  EXPECT_GT(closed, 50);
}

TEST(WrenchHull, PreFilterNeverRefusesAClosedGrasp) {
  std::mt19937_64 random(3);
  int refused = 0;
  for (int n = 0; n < 5000; ++n) {
    const auto grasp = random_grasp(random, 2 + n % 4);
    const Wrenches w = primitive_wrenches(grasp, Eigen::Vector3d::Zero(), 0.04, 8);
    WrenchHullOptions only;
    only.closure_only = true;
    const bool may = may_be_closed(w);
    refused += !may;
    ASSERT_TRUE(may || !wrench_hull(w, only).closed) << n;
  }
  EXPECT_GT(refused, 500);
}

TEST(WrenchHull, ScaleTurnOrderAndCopiesDoNotMatter) {
  std::mt19937_64 random(4);
  const auto grasp = random_grasp(random, 5);
  const Wrenches w = primitive_wrenches(grasp, Eigen::Vector3d::Zero(), 0.04, 8);
  const double epsilon = wrench_hull(w).epsilon;
  ASSERT_GT(epsilon, 0);
  for (const double scale : {1e-6, 1e9}) {
    EXPECT_NEAR(wrench_hull(scale * w).epsilon, scale * epsilon, 1e-9 * scale);
  }
  const Eigen::Matrix3d R = Eigen::Quaterniond(0.3, 0.5, -0.4, 0.7).normalized().matrix();
  Wrenches turned = w;
  turned.topRows<3>() = R * w.topRows<3>();
  turned.bottomRows<3>() = R * w.bottomRows<3>();
  EXPECT_NEAR(wrench_hull(turned).epsilon, epsilon, 1e-9);
  EXPECT_NEAR(wrench_hull(w.rowwise().reverse()).epsilon, epsilon, 1e-9);
  Wrenches twice(6, 2 * w.cols());
  twice << w, w;
  EXPECT_NEAR(wrench_hull(twice).epsilon, epsilon, 1e-9);
}

TEST(WrenchHull, RefusesWhatIsNotFinite) {
  Wrenches w = octahedron();
  w(3, 4) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(wrench_hull(w), std::invalid_argument);
  EXPECT_THROW(reference_wrench_hull(w), std::invalid_argument);
  EXPECT_THROW(wrench_hull(octahedron(), {.tolerance = 0}), std::invalid_argument);
}

}  // namespace
}  // namespace prehend::grasp
