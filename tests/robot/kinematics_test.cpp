// Robots from URDF, and the kinematics of their chains.

#include <cmath>
#include <numbers>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "prehend/geometry/errors.h"
#include "tests/robot/arms.h"

namespace prehend::robot {
namespace {

using geometry::InputError;
using geometry::RigidTransform;
using ::testing::HasSubstr;

constexpr double kHalfTurn = std::numbers::pi;

std::string with_joint(const std::string& joint) {
  return "<robot name=\"r\"><link name=\"a\"/><link name=\"b\"/>" + joint + "</robot>";
}

std::string refusal(const std::string& text) {
  try {
    parse_urdf(text, "robot.urdf");
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(RobotModel, ReadsLinksJointsShapesLimitsAndMimics) {
  const RobotModel model = parse_urdf(
      "<robot name=\"hand\">"
      "<link name=\"palm\"><inertial><mass value=\"1.5\"/><inertia ixx=\"1\" iyy=\"1\" izz=\"1\" "
      "ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial><collision><origin xyz=\"0 0 1\"/><geometry>"
      "<box size=\"1 2 3\"/></geometry></collision><collision><geometry>"
      "<cylinder radius=\"1\" length=\"2\"/></geometry></collision></link>"
      "<link name=\"left\"/><link name=\"right\"/>"
      "<joint name=\"jl\" type=\"prismatic\"><parent link=\"palm\"/><child link=\"left\"/>"
      "<origin xyz=\"0 0.1 0\" rpy=\"0 0 1.5707963267948966\"/><axis xyz=\"0 2 0\"/>"
      "<limit lower=\"0\" upper=\"0.03\" velocity=\"0.04\" effort=\"200\"/></joint>"
      "<joint name=\"jr\" type=\"prismatic\"><parent link=\"palm\"/><child link=\"right\"/>"
      "<axis xyz=\"0 -1 0\"/><limit lower=\"0\" upper=\"0.03\" velocity=\"0.04\" effort=\"200\"/>"
      "<mimic joint=\"jl\" multiplier=\"2\" offset=\"0.5\"/></joint></robot>",
      "hand.urdf");
  ASSERT_EQ(model.links.size(), 3u);
  EXPECT_EQ(model.links[0].name, "palm");
  EXPECT_EQ(model.links[0].mass, 1.5);
  ASSERT_EQ(model.links[0].shapes.size(), 2u);
  EXPECT_EQ(model.links[0].shapes[0].size, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(model.links[0].shapes[0].X_LS.translation().z(), 1);
  EXPECT_EQ(model.links[0].shapes[1].kind, CollisionShape::Kind::kCylinder);
  EXPECT_EQ(model.links[0].shapes[1].length, 2);
  const Joint& left = model.joints[static_cast<std::size_t>(model.joint_index("jl"))];
  EXPECT_EQ(left.axis_J, Eigen::Vector3d::UnitY());  // made unit
  EXPECT_EQ(left.upper, 0.03);
  EXPECT_EQ(left.max_effort, 200);
  // 20 mm along the turned y axis.
  EXPECT_TRUE(left.pose_at(0.02).translation().isApprox(Eigen::Vector3d(-0.02, 0.1, 0), 1e-12));
  const Joint& right = model.joints[static_cast<std::size_t>(model.joint_index("jr"))];
  ASSERT_TRUE(right.mimic.has_value());
  EXPECT_EQ(right.mimic->joint, model.joint_index("jl"));
  EXPECT_EQ(right.mimic->multiplier, 2);
  EXPECT_EQ(right.mimic->offset, 0.5);
}

TEST(RobotModel, SaysWhatCannotBe) {
  EXPECT_THAT(refusal("not xml"), HasSubstr("robot.urdf"));
  EXPECT_THAT(refusal("<robot name=\"r\"/>"), HasSubstr("robot.urdf"));
  EXPECT_THAT(refusal(with_joint("<joint name=\"j\" type=\"floating\"><parent link=\"a\"/><child "
                                 "link=\"b\"/></joint>")),
              HasSubstr("joint 'j' is neither fixed"));
  EXPECT_THAT(refusal(with_joint("<joint name=\"j\" type=\"revolute\"><parent link=\"a\"/><child "
                                 "link=\"b\"/><axis xyz=\"0 0 0\"/><limit lower=\"-1\" upper=\"1\" "
                                 "velocity=\"1\" effort=\"1\"/></joint>")),
              HasSubstr("axis without length"));
  EXPECT_THAT(refusal(with_joint("<joint name=\"j\" type=\"revolute\"><parent link=\"a\"/><child "
                                 "link=\"b\"/><limit lower=\"2\" upper=\"1\" velocity=\"1\" "
                                 "effort=\"1\"/></joint>")),
              HasSubstr("lower limit above"));
  EXPECT_THAT(refusal(with_joint("<joint name=\"j\" type=\"continuous\"><parent link=\"a\"/><child "
                                 "link=\"b\"/><mimic joint=\"k\"/></joint>")),
              HasSubstr("mimics 'k'"));
  EXPECT_THAT(refusal(with_joint("<joint name=\"j\" type=\"continuous\"><parent link=\"a\"/><child "
                                 "link=\"b\"/><mimic joint=\"j\"/></joint>")),
              HasSubstr("mimics itself"));
  EXPECT_THROW(read_urdf("no/such.urdf"), InputError);
}

TEST(RobotModel, NamesTheNearestLink) {
  const RobotModel model = read_urdf("config/robots/pa10_7c.urdf");
  try {
    KinematicChain(model, "base_lnik", "tool0");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("The nearest is 'base_link'"));
  }
  EXPECT_THROW(KinematicChain(model, "tool0", "base_link"), InputError);
  EXPECT_THROW(KinematicChain(model, "link_7", "tool0"), InputError);  // fixed
}

TEST(KinematicChain, StandsAsPublishedAtPositionZero) {
  // KR 5: 75 + 365 + 405 + 80 mm forward, 335 + 90 mm up, flange forward.
  const KinematicChain arm = kr5();
  const RigidTransform X = arm.forward(Eigen::VectorXd::Zero(6));
  EXPECT_TRUE(X.translation().isApprox(Eigen::Vector3d(0.925, 0, 0.425), 1e-12));
  EXPECT_TRUE(X.linear().col(2).isApprox(Eigen::Vector3d::UnitX(), 1e-12));
  // PA10: 315 + 450 + 500 + 80 mm up.
  EXPECT_TRUE(pa10()
                  .forward(Eigen::VectorXd::Zero(7))
                  .translation()
                  .isApprox(Eigen::Vector3d(0, 0, 1.345), 1e-12));
  // The KR 5's first axis turns clockwise, seen from above.
  Eigen::VectorXd q = Eigen::VectorXd::Zero(6);
  q[0] = kHalfTurn / 2;
  EXPECT_TRUE(arm.forward(q).translation().isApprox(Eigen::Vector3d(0, -0.925, 0.425), 1e-12));
}

// The table of modified Denavit-Hartenberg parameters, link by link, as an independent reference.
RigidTransform kr5_by_table(const Eigen::VectorXd& q) {
  struct Row {
    double alpha, a, d, offset, sign;
  };
  const Row rows[] = {{0, 0, 0.335, 0, -1},      {-90, 0.075, 0, 0, 1}, {0, 0.365, 0, -90, 1},
                      {-90, 0.09, 0.405, 0, -1}, {90, 0, 0, 0, 1},      {-90, 0, 0.08, 180, -1}};
  RigidTransform X = RigidTransform::Identity();
  for (int i = 0; i < 6; ++i) {
    const Row& row = rows[i];
    X.rotate(Eigen::AngleAxisd(row.alpha * kHalfTurn / 180, Eigen::Vector3d::UnitX()));
    X.translate(Eigen::Vector3d(row.a, 0, 0));
    X.rotate(Eigen::AngleAxisd(row.sign * q[i] + row.offset * kHalfTurn / 180,
                               Eigen::Vector3d::UnitZ()));
    X.translate(Eigen::Vector3d(0, 0, row.d));
  }
  return X;
}

TEST(KinematicChain, AgreesWithThePublishedTable) {
  const KinematicChain arm = kr5();
  std::mt19937_64 random(1);
  for (int i = 0; i < 1000; ++i) {
    const Positions q = random_positions(arm, random);
    EXPECT_LT(difference(arm.forward(q), kr5_by_table(q)), 1e-12);
  }
}

TEST(KinematicChain, JacobianIsTheDerivative) {
  std::mt19937_64 random(2);
  for (const KinematicChain& arm : {kr5(), pa10()}) {
    for (int n = 0; n < 50; ++n) {
      const Positions q = random_positions(arm, random);
      const auto J = arm.jacobian(q);
      const double h = 1e-6;
      for (int i = 0; i < arm.size(); ++i) {
        Positions more = q, less = q;
        more[i] += h;
        less[i] -= h;
        const RigidTransform a = arm.forward(less), b = arm.forward(more);
        const Eigen::Vector3d linear = (b.translation() - a.translation()) / (2 * h);
        const Eigen::AngleAxisd turned(Eigen::Matrix3d(b.linear() * a.linear().transpose()));
        EXPECT_LT((J.col(i).head<3>() - linear).norm(), 1e-8);
        EXPECT_LT((J.col(i).tail<3>() - turned.angle() * turned.axis() / (2 * h)).norm(), 1e-8);
      }
    }
  }
}

TEST(KinematicChain, LimitsAreNamed) {
  const KinematicChain arm = kr5();
  Eigen::VectorXd q = arm.middle();
  EXPECT_TRUE(arm.within_limits(q));
  EXPECT_EQ(arm.limit_problem(q), "");
  q[4] = 2.2;
  EXPECT_FALSE(arm.within_limits(q));
  EXPECT_THAT(arm.limit_problem(q), HasSubstr("joint 'axis_5' at 126.1 deg is beyond 120.0 deg"));
  q[4] = std::nan("");
  EXPECT_FALSE(arm.within_limits(q));
  EXPECT_NE(arm.limit_problem(q), "");
}

}  // namespace
}  // namespace prehend::robot
