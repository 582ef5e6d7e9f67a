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
  EXPECT_EQ(InverseKinematics(stage()).method(), InverseMethod::kThreeSlides);
  // Two slides along one line span no space.
  RobotModel flat = read_urdf("config/robots/stage_pg70.urdf");
  flat.joints[static_cast<std::size_t>(flat.joint_index("y"))].axis_J = Eigen::Vector3d::UnitX();
  EXPECT_EQ(InverseKinematics(KinematicChain(flat, "base_link", "tool0")).method(),
            InverseMethod::kNumeric);
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

TEST(InverseKinematics, BranchesInStepAreThoseOneByOne) {
  std::mt19937_64 random(9);
  RobotModel mounted = read_urdf("config/robots/kr5_sixx_r850.urdf");
  mounted.joints[0].X_PJ =
      geometry::make_transform({0.3, 0.5, -0.4, 0.7}, {1, -2, 0.5}) * mounted.joints[0].X_PJ;
  for (const KinematicChain& arm : {kr5(), unlimited("config/robots/kr5_sixx_r850.urdf"),
                                    KinematicChain(mounted, "base_link", "tool0")}) {
    const InverseKinematics in_step(arm), one_by_one(arm, {.vectorized = false});
    int none = 0;
    for (int n = 0; n < 3000; ++n) {
      Positions q(6), seed(6);
      for (int i = 0; i < 6; ++i) q[i] = kPi * (2 * uniform(random) - 1);
      for (int i = 0; i < 6; ++i) seed[i] = 3 * kPi * (2 * uniform(random) - 1);
      if (n % 5 == 0) q[4] = 0.1 * uniform(random) * uniform(random);  // nearly singular
      RigidTransform X = arm.forward(q);
      if (n % 7 == 0) X.translation() *= 1.5;  // mostly out of reach
      const InverseAnswer a = in_step.solve(X, seed), b = one_by_one.solve(X, seed);
      ASSERT_EQ(a.solutions.size(), b.solutions.size()) << n;
      EXPECT_EQ(a.failure, b.failure);
      EXPECT_EQ(a.reason, b.reason);
      none += a.solutions.empty();
      double last = 0;
      for (const Positions& s : a.solutions) {
        ASSERT_TRUE(arm.within_limits(s));
        // At a double root half of the digits are lost, and both ways are one.
        const bool singular = std::abs(std::sin(s[4])) < 1e-4;
        ASSERT_LT(difference(arm.forward(s), X), singular ? 1e-6 : 1e-7);
        // The same one, whole turns included.
        double least = 1e9;
        for (const Positions& t : b.solutions) {
          least = std::min(least, (s - t).cwiseAbs().maxCoeff());
        }
        ASSERT_LT(least, 1e-6) << n;
        EXPECT_GE((s - seed).norm(), last - 1e-9);
        last = (s - seed).norm();
      }
    }
    EXPECT_GT(none, 50);
    EXPECT_LT(none, 2500);
  }
}

TEST(InverseKinematics, BatchesAnswerAsOneAtATime) {
  std::mt19937_64 random(10);
  RobotModel bent = read_urdf("config/robots/kr5_sixx_r850.urdf");
  bent.joints[static_cast<std::size_t>(bent.joint_index("axis_6"))].X_PJ.translation().z() = 0.03;
  for (const KinematicChain& arm : {kr5(), pa10(), KinematicChain(bent, "base_link", "tool0")}) {
    const InverseKinematics inverse(arm, {.elbow_angles = 4, .restarts = 3});
    std::vector<RigidTransform> targets;
    for (int n = 0; n < 40; ++n) targets.push_back(arm.forward(random_positions(arm, random)));
    targets[3].translation().x() = 9;                                   // out of reach
    targets.push_back(arm.forward(Eigen::VectorXd::Zero(arm.size())));  // singular
    std::vector<InverseSolutions> answers(7);
    const Positions seed = arm.middle();
    for (int again = 0; again < 2; ++again) {
      inverse.solve_batch(targets, seed, answers);
      ASSERT_EQ(answers.size(), targets.size());
      for (std::size_t i = 0; i < targets.size(); ++i) {
        const InverseAnswer one = inverse.solve(targets[i], seed);
        ASSERT_EQ(answers[i].count, std::min<int>(8, static_cast<int>(one.solutions.size())));
        for (int k = 0; k < answers[i].count; ++k) {
          const auto at = static_cast<std::size_t>(k);
          EXPECT_EQ(answers[i].q[at], one.solutions[at]);
        }
        EXPECT_EQ(answers[i].failure, one.failure);
        EXPECT_EQ(answers[i].miss, one.miss);
        EXPECT_EQ(answers[i].singular, one.singular);
      }
      EXPECT_EQ(answers[3].count, 0);
      EXPECT_GT(answers[3].miss, 5);
    }
    inverse.solve_batch({}, seed, answers);
    EXPECT_TRUE(answers.empty());
    targets[0].translation().x() = std::nan("");
    EXPECT_THROW(inverse.solve_batch(targets, seed, answers), std::invalid_argument);
  }
}

TEST(InverseKinematics, SaysByHowMuchAPoseIsMissed) {
  const KinematicChain arm = kr5();
  const InverseKinematics inverse(arm);
  // Straight ahead the wrist reaches 0.075 + 0.365 + hypot(0.405, 0.09) m, the flange 80 mm more.
  const double farthest = 0.075 + 0.365 + std::hypot(0.405, 0.09) + 0.08;
  RigidTransform X = arm.forward(Eigen::VectorXd::Zero(6));
  X.translation() = Eigen::Vector3d(farthest + 0.25, 0, 0.335);
  const InverseAnswer far = inverse.solve(X);
  EXPECT_EQ(far.failure, InverseFailure::kOutOfReach);
  EXPECT_NEAR(far.miss, 0.25, 1e-9);
  // The second axis 0.2 rad beyond its upper limit is one of the ways; none is nearer than that.
  Positions q = Positions::Zero(6);
  q[1] = arm.joints()[1].upper + 0.2;
  q[2] = 0.4;
  const InverseAnswer beyond = inverse.solve(arm.forward(q));
  if (beyond.solutions.empty()) {
    EXPECT_EQ(beyond.failure, InverseFailure::kBeyondLimits);
    EXPECT_LE(beyond.miss, 0.2 + 1e-9);
    EXPECT_GT(beyond.miss, 0);
  }
  EXPECT_EQ(inverse.solve(arm.forward(arm.middle())).failure, InverseFailure::kNone);
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

/// A stage with slides askew, before (behind) the joint that turns.
KinematicChain askew_stage(bool turns_first) {
  RobotModel model;
  model.links.emplace_back().name = "base_link";
  const auto add = [&model](Joint::Kind kind, const Eigen::Vector3d& axis) {
    Joint joint;
    joint.name = "joint_" + std::to_string(model.joints.size());
    joint.kind = kind;
    joint.parent = static_cast<int>(model.links.size()) - 1;
    joint.child = joint.parent + 1;
    joint.axis_J = axis.normalized();
    joint.lower = -2;
    joint.upper = 2;
    const double size = 0.1 * static_cast<double>(model.joints.size() + 1);
    joint.X_PJ = geometry::make_transform({0.3, size, -0.4, 0.7}, {size, -0.2, 0.5});
    model.joints.push_back(joint);
    model.links.emplace_back().name = "link_" + std::to_string(model.joints.size());
  };
  const Eigen::Vector3d turning(0.3, 1, -0.2);
  if (turns_first) add(Joint::Kind::kRevolute, turning);
  for (const Eigen::Vector3d& along :
       {Eigen::Vector3d(1, 0.2, 0), Eigen::Vector3d(0, 1, 0.5), Eigen::Vector3d(0.1, -0.3, 1)}) {
    add(Joint::Kind::kPrismatic, along);
  }
  if (!turns_first) add(Joint::Kind::kRevolute, turning);
  return KinematicChain(model, "base_link", "link_4");
}

TEST(InverseKinematics, ThreeSlidesReachThePoseOneWay) {
  for (const KinematicChain& arm : {stage(), askew_stage(false), askew_stage(true)}) {
    const InverseKinematics inverse(arm);
    ASSERT_EQ(inverse.method(), InverseMethod::kThreeSlides);
    std::mt19937_64 random(9);
    std::vector<RigidTransform> poses;
    for (int n = 0; n < 1000; ++n) {
      const Positions q = random_positions(arm, random);
      poses.push_back(arm.forward(q));
      const InverseAnswer answer = inverse.solve(poses.back(), q);
      ASSERT_EQ(answer.solutions.size(), 1u) << answer.reason;
      EXPECT_LT((answer.solutions.front() - q).cwiseAbs().maxCoeff(), 1e-9);
    }
    std::vector<InverseSolutions> batch;
    inverse.solve_batch(poses, arm.middle(), batch);
    for (std::size_t i = 0; i < poses.size(); ++i) {
      ASSERT_EQ(batch[i].count, 1);
      EXPECT_LT(difference(arm.forward(batch[i].q[0]), poses[i]), 1e-12);
    }
  }
}

TEST(InverseKinematics, ThreeSlidesRefuseWhatIsTiltedOrBeyondTheirWays) {
  const InverseKinematics inverse(stage());
  const Positions middle = inverse.chain().middle();
  RigidTransform X = inverse.chain().forward(middle);
  X.rotate(Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitX()));
  const InverseAnswer tilted = inverse.solve(X);
  EXPECT_TRUE(tilted.solutions.empty());
  EXPECT_EQ(tilted.failure, InverseFailure::kOutOfReach);
  EXPECT_NEAR(tilted.miss, 0.1, 1e-12);
  EXPECT_THAT(tilted.reason, HasSubstr("tilted by 5.73 deg, and only joint 'yaw' turns the tool"));
  X = inverse.chain().forward(middle);
  X.translation().x() += 0.7;
  const InverseAnswer beyond = inverse.solve(X);
  EXPECT_TRUE(beyond.solutions.empty());
  EXPECT_EQ(beyond.failure, InverseFailure::kBeyondLimits);
  EXPECT_NEAR(beyond.miss, 0.1, 1e-12);
  EXPECT_THAT(beyond.reason, HasSubstr("joint 'x' at 700.0 mm is beyond 600.0 mm"));
  // Half a turn more is another place of the same pose.
  Positions turned = middle;
  turned[3] = 3.1;
  Positions seed = middle;
  seed[3] = -3;
  const InverseAnswer round = inverse.solve(inverse.chain().forward(turned), seed);
  ASSERT_EQ(round.solutions.size(), 1u);
  EXPECT_NEAR(round.solutions.front()[3], 3.1 - 2 * kPi, 1e-9);
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
