#include "prehend/robot/inverse_kinematics.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/robot/arms.h"

namespace prehend::robot {
namespace {

using geometry::RigidTransform;
using ::testing::HasSubstr;

constexpr double kPi = std::numbers::pi;

/// The chain without limits.
KinematicChain unlimited(const std::string& file) {
  RobotModel model = read_urdf(file);
  for (Joint& joint : model.joints) {
    joint.lower = -10 * kPi;
    joint.upper = 10 * kPi;
  }
  return KinematicChain(model, "base_link", "tool0");
}

bool has(const InverseAnswer& answer, const Positions& q, double tolerance) {
  return std::any_of(answer.solutions.begin(), answer.solutions.end(), [&](const Positions& s) {
    double most = 0;
    for (int i = 0; i < q.size(); ++i) {
      most = std::max(most, std::abs(std::remainder(s[i] - q[i], 2 * kPi)));
    }
    return most < tolerance;
  });
}

TEST(InverseKinematics, FindsTheMethodFromTheAxes) {
  EXPECT_EQ(InverseKinematics(kr5()).method(), InverseMethod::kSphericalWrist);
  EXPECT_EQ(InverseKinematics(pa10()).method(), InverseMethod::kSphericalShoulderAndWrist);
  // A bent wrist, and a part of an arm.
  RobotModel bent = read_urdf("config/robots/kr5_sixx_r850.urdf");
  bent.joints[static_cast<std::size_t>(bent.joint_index("axis_6"))].X_PJ.translation().z() = 0.01;
  EXPECT_EQ(InverseKinematics(KinematicChain(bent, "base_link", "tool0")).method(),
            InverseMethod::kNumeric);
  const RobotModel model = read_urdf("config/robots/pa10_7c.urdf");
  EXPECT_EQ(InverseKinematics(KinematicChain(model, "base_link", "link_4")).method(),
            InverseMethod::kNumeric);
}

TEST(InverseKinematics, SixAxesAllBranchesReachThePose) {
  const KinematicChain arm = unlimited("config/robots/kr5_sixx_r850.urdf");
  const InverseKinematics inverse(arm);
  std::mt19937_64 random(3);
  int eight = 0;
  for (int n = 0; n < 5000; ++n) {
    Positions q(6);
    for (int i = 0; i < 6; ++i) q[i] = kPi * (2 * uniform(random) - 1);
    const RigidTransform X = arm.forward(q);
    const InverseAnswer answer = inverse.solve(X);
    ASSERT_FALSE(answer.solutions.empty()) << answer.reason;
    EXPECT_TRUE(answer.solutions.size() == 4 || answer.solutions.size() == 8);
    eight += answer.solutions.size() == 8;
    for (const Positions& s : answer.solutions) ASSERT_LT(difference(arm.forward(s), X), 1e-7);
    EXPECT_TRUE(has(answer, q, 1e-5));
  }
  EXPECT_GT(eight, 1000);
}

TEST(InverseKinematics, SixAxesMissNothingThatNumericSearchFinds) {
  // From many starts the numeric method finds branches by itself; all are among the closed form's.
  const KinematicChain arm = unlimited("config/robots/kr5_sixx_r850.urdf");
  const InverseKinematics closed(arm);
  Positions q(6);
  q << 0.4, -2.0, 1.9, 0.7, -0.8, 0.3;
  const RigidTransform X = arm.forward(q);
  const InverseAnswer all = closed.solve(X);
  ASSERT_EQ(all.solutions.size(), 8u);
  std::mt19937_64 random(4);
  std::vector<Positions> found;
  for (int n = 0; n < 300; ++n) {
    Positions s(6);
    for (int i = 0; i < 6; ++i) s[i] = kPi * (2 * uniform(random) - 1);
    // Newton's method by the pseudo-inverse.
    for (int step = 0; step < 100; ++step) {
      const RigidTransform at = arm.forward(s);
      const Eigen::AngleAxisd turn(Eigen::Matrix3d(X.linear() * at.linear().transpose()));
      Eigen::Matrix<double, 6, 1> error;
      error << X.translation() - at.translation(), turn.angle() * turn.axis();
      if (error.norm() < 1e-10) break;
      s += Eigen::MatrixXd(arm.jacobian(s)).completeOrthogonalDecomposition().solve(0.5 * error);
    }
    if (difference(arm.forward(s), X) > 1e-8) continue;
    EXPECT_TRUE(has(all, s, 1e-6));
    InverseAnswer known;
    known.solutions = found;
    if (!has(known, s, 1e-4)) found.push_back(s);
  }
  EXPECT_EQ(found.size(), 8u);
}

TEST(InverseKinematics, SixAxesKeepLimitsAndStartNearTheSeed) {
  const KinematicChain arm = kr5();
  const InverseKinematics inverse(arm);
  std::mt19937_64 random(5);
  for (int n = 0; n < 2000; ++n) {
    const Positions q = random_positions(arm, random);
    const RigidTransform X = arm.forward(q);
    const InverseAnswer answer = inverse.solve(X, q);
    ASSERT_FALSE(answer.solutions.empty()) << answer.reason;
    EXPECT_LT((answer.solutions.front() - q).norm(), 1e-4);  // with axis 6's whole turns
    double last = 0;
    for (const Positions& s : answer.solutions) {
      EXPECT_TRUE(arm.within_limits(s));
      EXPECT_LT(difference(arm.forward(s), X), 1e-7);
      EXPECT_GE((s - q).norm(), last - 1e-12);
      last = (s - q).norm();
    }
  }
}

TEST(InverseKinematics, SaysWhyThereIsNoSolution) {
  const KinematicChain arm = kr5();
  const InverseKinematics inverse(arm);
  RigidTransform far = RigidTransform::Identity();
  far.translation() = Eigen::Vector3d(2, 0, 0.4);
  EXPECT_THAT(inverse.solve(far).reason, HasSubstr("out of reach"));
  EXPECT_TRUE(inverse.solve(far).solutions.empty());
  // Behind and below the base the second axis would have to turn too far.
  RigidTransform behind = RigidTransform::Identity();
  behind.translation() = Eigen::Vector3d(-0.1, 0, -0.25);
  const InverseAnswer answer = inverse.solve(behind);
  EXPECT_TRUE(answer.solutions.empty());
  EXPECT_THAT(answer.reason, HasSubstr("beyond the limits"));
  EXPECT_THAT(answer.reason, HasSubstr("axis_"));
  RigidTransform nothing = RigidTransform::Identity();
  nothing.translation().x() = std::nan("");
  EXPECT_THROW(inverse.solve(nothing), std::invalid_argument);
  EXPECT_THROW(inverse.solve(far, Eigen::VectorXd::Zero(5)), std::invalid_argument);
  RigidTransform pa10_far = RigidTransform::Identity();
  pa10_far.translation() = Eigen::Vector3d(0, 2, 0.3);
  EXPECT_THAT(InverseKinematics(pa10()).solve(pa10_far).reason, HasSubstr("from the shoulder"));
}

TEST(InverseKinematics, ASingularWristKeepsTheSeedsFirstWristAngle) {
  const KinematicChain arm = kr5();
  Positions q(6);
  q << 0.3, -1.0, 0.8, 0.5, 0, 0.2;  // axes 4 and 6 coincide
  const RigidTransform X = arm.forward(q);
  Positions seed = q;
  seed[3] = -0.4;
  const InverseAnswer answer = InverseKinematics(arm).solve(X, seed);
  EXPECT_TRUE(answer.singular);
  ASSERT_FALSE(answer.solutions.empty());
  EXPECT_NEAR(answer.solutions.front()[3], -0.4, 1e-9);
  for (const Positions& s : answer.solutions) EXPECT_LT(difference(arm.forward(s), X), 1e-7);
}

TEST(InverseKinematics, AStretchedArmIsReached) {
  // At the border of reach both elbows are one.
  const KinematicChain arm = unlimited("config/robots/kr5_sixx_r850.urdf");
  Positions q(6);
  q << 0.3, -0.5, 0, 0.2, 0.4, 0.1;
  q[2] = std::atan2(0.09, 0.405);  // wrist on the line from the second axis through the third
  const RigidTransform X = arm.forward(q);
  const InverseAnswer answer = InverseKinematics(arm).solve(X);
  ASSERT_FALSE(answer.solutions.empty()) << answer.reason;
  for (const Positions& s : answer.solutions) EXPECT_LT(difference(arm.forward(s), X), 1e-6);
}

TEST(InverseKinematics, SevenAxesSweepTheElbow) {
  const KinematicChain arm = pa10();
  const InverseKinematics inverse(arm, {.elbow_angles = 24});
  std::mt19937_64 random(6);
  int found = 0;
  for (int n = 0; n < 500; ++n) {
    const RigidTransform X = arm.forward(random_positions(arm, random));
    const InverseAnswer answer = inverse.solve(X);
    found += !answer.solutions.empty();
    for (const Positions& s : answer.solutions) {
      ASSERT_TRUE(arm.within_limits(s));
      ASSERT_LT(difference(arm.forward(s), X), 1e-7);
    }
  }
  EXPECT_GT(found, 490);  // narrow ranges of the elbow can lie between the angles
}

TEST(InverseKinematics, SevenAxesSwivelWithoutMovingTheTip) {
  const KinematicChain arm = unlimited("config/robots/pa10_7c.urdf");
  Positions q(7);
  q << 0.2, 0.7, -0.3, 1.1, 0.4, -0.6, 0.9;
  const InverseAnswer answer = InverseKinematics(arm, {.elbow_angles = 8}).solve(arm.forward(q));
  EXPECT_EQ(answer.solutions.size(), 2u * 8 * 2 * 2);
}

TEST(InverseKinematics, AnyOtherChainByDampedLeastSquares) {
  RobotModel bent = read_urdf("config/robots/kr5_sixx_r850.urdf");
  bent.joints[static_cast<std::size_t>(bent.joint_index("axis_6"))].X_PJ.translation().z() = 0.03;
  const KinematicChain arm(bent, "base_link", "tool0");
  const InverseKinematics inverse(arm);
  ASSERT_EQ(inverse.method(), InverseMethod::kNumeric);
  std::mt19937_64 random(7);
  int found = 0;
  for (int n = 0; n < 100; ++n) {
    const RigidTransform X = arm.forward(random_positions(arm, random));
    const InverseAnswer answer = inverse.solve(X);
    if (answer.solutions.empty()) continue;
    ++found;
    EXPECT_LT(difference(arm.forward(answer.solutions.front()), X), 1e-7);
    EXPECT_EQ(inverse.solve(X).solutions.front(), answer.solutions.front());  // repeatable
  }
  EXPECT_GE(found, 98);
  RigidTransform far = RigidTransform::Identity();
  far.translation().x() = 3;
  EXPECT_THAT(inverse.solve(far).reason, HasSubstr("31 starts"));
}

TEST(InverseKinematics, FrameOfTheBaseDoesNotMatter) {
  // The same arm mounted askew: the same joint positions.
  RobotModel mounted = read_urdf("config/robots/kr5_sixx_r850.urdf");
  const RigidTransform X = geometry::make_transform({0.3, 0.5, -0.4, 0.7}, {10, -20, 5});
  mounted.joints[0].X_PJ = X * mounted.joints[0].X_PJ;
  const KinematicChain arm = kr5(), askew(mounted, "base_link", "tool0");
  std::mt19937_64 random(8);
  for (int n = 0; n < 100; ++n) {
    const RigidTransform target = arm.forward(random_positions(arm, random));
    const InverseAnswer a = InverseKinematics(arm).solve(target);
    const InverseAnswer b = InverseKinematics(askew).solve(X * target);
    ASSERT_EQ(a.solutions.size(), b.solutions.size());
    for (std::size_t i = 0; i < a.solutions.size(); ++i) EXPECT_TRUE(has(b, a.solutions[i], 1e-5));
  }
}

TEST(InverseKinematics, RefusesBadOptions) {
  EXPECT_THROW(InverseKinematics(kr5(), {.elbow_angles = 0}), std::invalid_argument);
  EXPECT_THROW(InverseKinematics(kr5(), {.iterations = 0}), std::invalid_argument);
  EXPECT_THROW(InverseKinematics(kr5(), {.tolerance = 0}), std::invalid_argument);
}

}  // namespace
}  // namespace prehend::robot
