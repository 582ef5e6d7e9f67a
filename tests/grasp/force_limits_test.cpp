#include "prehend/grasp/wrench/force_limits.h"

#include <cmath>
#include <limits>
#include <stdexcept>

#include <gtest/gtest.h>

#include "prehend/grasp/wrench/dense_programme.h"
#include "tests/grasp/hand_scene.h"

namespace prehend::grasp {
namespace {

using Eigen::Vector3d;
using geometry::RigidTransform;

TEST(DenseProgramme, SolvesWhatHasASolution) {
  // max x + y subject to x + 2 y <= 4, 3 x + y <= 6: corner (1.6, 1.2).
  DenseProgramme programme;
  programme.objective = Eigen::Vector2d(1, 1);
  programme.equal.resize(0, 2);
  programme.right.resize(0);
  programme.below = (Eigen::Matrix2d() << 1, 2, 3, 1).finished();
  programme.most = Eigen::Vector2d(4, 6);
  ASSERT_TRUE(programme.maximise());
  EXPECT_TRUE(programme.maximise()->isApprox(Eigen::Vector2d(1.6, 1.2), 1e-12));
  programme.equal = Eigen::RowVector2d(1, 1);
  programme.right = Eigen::VectorXd::Constant(1, 50);
  EXPECT_FALSE(programme.maximise());  // out of reach
  programme.right[0] = 1;
  EXPECT_NEAR(programme.maximise()->sum(), 1, 1e-12);
  programme.equal(0, 0) = std::nan("");
  EXPECT_THROW(programme.maximise(), std::invalid_argument);
  programme.equal.resize(1, 3);
  EXPECT_THROW(programme.maximise(), std::invalid_argument);
}

/// Two opposite contacts along y with friction 0.5, a motor for each normal force.
HandForces jaws(double limit, double torsion_radius = 0.01) {
  const std::vector<Contact> contacts{{{0, 0.03, 0}, -Vector3d::UnitY(), 0.5, torsion_radius},
                                      {{0, -0.03, 0}, Vector3d::UnitY(), 0.5, torsion_radius}};
  HandForces forces;
  forces.wrenches = primitive_wrenches(contacts, Vector3d::Zero(), 0.03, 8);
  forces.torques.setZero(2, forces.wrenches.cols());
  for (Eigen::Index i = 0; i < forces.wrenches.cols(); ++i) {
    const double y = forces.wrenches(1, i);
    forces.torques(y < 0 ? 0 : 1, i) = std::abs(y);
  }
  forces.limits = Eigen::Vector2d(limit, limit);
  return forces;
}

/// A force along an edge of the linearised cones, so that their being polygons costs nothing.
Vector6 along_edge(const HandForces& forces, double newton) {
  Vector6 load = Vector6::Zero();
  load.head<3>() = forces.wrenches.col(0).head<3>();
  load[1] = 0;
  load.head<3>() *= newton / load.head<3>().norm();
  return load;
}

TEST(Hold, NeedsTheNormalForceThatFrictionAsksFor) {
  for (const double weight : {1.0, 7.0, 40.0}) {
    const HandForces forces = jaws(20);
    const Holding holding = hold(forces, along_edge(forces, weight));
    ASSERT_TRUE(holding.possible);
    // Each of two contacts carries half: normal force weight / (2 x friction).
    EXPECT_NEAR(holding.share, weight / (2 * 0.5) / 20, 1e-9);
    EXPECT_NEAR(holding.torques.maxCoeff(), weight, 1e-7);
  }
  // Along the closing direction one jaw pushes alone.
  const HandForces forces = jaws(20);
  EXPECT_NEAR(hold(forces, 5 * Vector6::Unit(1)).share, 0.25, 1e-9);
  EXPECT_EQ(hold(forces, Vector6::Zero()).share, 0);
  // No friction: nothing holds a weight across.
  HandForces smooth = jaws(20);
  smooth.wrenches.topRows<1>().setZero();
  smooth.wrenches.row(2).setZero();
  const Holding none = hold(smooth, Vector6::Unit(0));
  EXPECT_FALSE(none.possible);
  EXPECT_EQ(none.share, std::numeric_limits<double>::infinity());
  EXPECT_FALSE(hold(HandForces{Wrenches(6, 0), Eigen::MatrixXd(2, 0), Eigen::Vector2d(1, 1)},
                    Vector6::Unit(0))
                   .possible);
}

TEST(DisturbanceMargin, OfAWristOfTwelveRodsIsItsWeakestLeft) {
  // One rod pushes along each direction of the wrench space, each with its own motor.
  HandForces forces;
  forces.wrenches.resize(6, 12);
  forces.torques = Eigen::MatrixXd::Identity(12, 12);
  forces.limits.resize(12);
  for (int k = 0; k < 12; ++k) {
    forces.wrenches.col(k) = (k % 2 == 0 ? 1 : -1) * Vector6::Unit(k / 2);
    forces.limits[k] = 10 + k;
  }
  EXPECT_NEAR(disturbance_margin(forces, Vector6::Zero()), 10, 1e-9);
  Vector6 load = Vector6::Zero();
  load[3] = -4;  // rod 6 carries 4 of its 16
  EXPECT_NEAR(disturbance_margin(forces, load), 10, 1e-9);
  load[3] = -9;  // 7 left
  EXPECT_NEAR(disturbance_margin(forces, load), 7, 1e-9);
  load[3] = -17;
  EXPECT_EQ(disturbance_margin(forces, load), 0);
}

TEST(DisturbanceMargin, GrowsWithTheMotorsAndShrinksWithTheLoad) {
  const HandForces weak = jaws(20), strong = jaws(40);
  const Vector6 load = along_edge(weak, 4);
  const double margin = disturbance_margin(weak, load);
  EXPECT_GT(margin, 0.5);
  EXPECT_GT(disturbance_margin(strong, load), margin);
  EXPECT_LT(disturbance_margin(weak, 2 * load), margin);
  EXPECT_EQ(disturbance_margin(weak, along_edge(weak, 20.1)), 0);
  // Scaled together.
  EXPECT_NEAR(disturbance_margin(strong, 2 * load), 2 * margin, 1e-7);
  // Point contacts do not hold a torque about their line.
  EXPECT_NEAR(disturbance_margin(jaws(20, 0), load), 0, 1e-9);
  HandForces bad = jaws(20);
  bad.limits[0] = 0;
  EXPECT_THROW(disturbance_margin(bad, load), std::invalid_argument);
  EXPECT_THROW(hold(bad, load), std::invalid_argument);
}

TEST(HandForces, DoTheWorkOfTheirMotors) {
  for (const char* name : {"sdh2", "bh8", "sensorhand", "pg70"}) {
    const TestHand hand(name);
    const robot::HandModel& model = hand.model;
    std::mt19937_64 random(5);
    RigidTransform X_WH = random_turn(random);
    X_WH.translation() = Vector3d(0.1, -0.2, 0.3);
    for (const robot::Preshape& preshape : model.preshapes) {
      const Vector3d center(0.05, -0.1, 0.35);
      ClosedFingers closed;
      closed.all = model.all_positions(preshape.open);
      closed.broken_away.assign(model.breakaways.size(), 0);
      std::vector<RigidTransform> poses;
      model.link_poses(closed.all, poses);
      for (const robot::Finger& finger : model.fingers) {
        GraspContact contact;
        contact.link = finger.links.back();
        contact.contact_W.point =
            X_WH * (poses[static_cast<std::size_t>(contact.link)] * Vector3d(0.01, 0.004, 0.03));
        contact.contact_W.normal = random_turn(random).linear() * Vector3d::UnitX();
        contact.contact_W.friction = 0.4;
        contact.contact_W.torsion_radius = 0.005;
        closed.contacts.push_back(contact);
      }
      const HandForces forces = hand_forces(model, X_WH, closed, center, 0.07, 5);
      const Eigen::Index each = 7;  // five edges and two of torsion
      ASSERT_EQ(forces.wrenches.cols(), each * static_cast<Eigen::Index>(model.fingers.size()));
      // A motor's work is the contact's: small turns of each, central differences.
      constexpr double kStep = 1e-6;
      for (int m = 0; m < model.size(); ++m) {
        std::vector<RigidTransform> up, down;
        model.link_poses(
            model.all_positions(preshape.open + kStep * Eigen::VectorXd::Unit(model.size(), m)),
            up);
        model.link_poses(
            model.all_positions(preshape.open - kStep * Eigen::VectorXd::Unit(model.size(), m)),
            down);
        for (std::size_t f = 0; f < model.fingers.size(); ++f) {
          const auto link = static_cast<std::size_t>(closed.contacts[f].link);
          // Of the link's point at the centre of torques.
          const Vector3d p_L = (X_WH * poses[link]).inverse() * center;
          const Vector3d moved = X_WH * (up[link] * p_L) - X_WH * (down[link] * p_L);
          const Eigen::AngleAxisd turned(X_WH.linear() * up[link].linear() *
                                         down[link].linear().transpose() *
                                         X_WH.linear().transpose());
          for (Eigen::Index i = 0; i < each; ++i) {
            const Vector6 w = forces.wrenches.col(static_cast<Eigen::Index>(f) * each + i);
            const double work =
                w.head<3>().dot(moved) + 0.07 * turned.angle() * w.tail<3>().dot(turned.axis());
            EXPECT_NEAR(forces.torques(m, static_cast<Eigen::Index>(f) * each + i),
                        work / (2 * kStep), 1e-6)
                << name << " " << preshape.name;
          }
        }
      }
    }
  }
}

TEST(HandForces, BrokenAwayOuterJointIsAloneOnItsMotor) {
  const TestHand hand("bh8");
  const robot::HandModel& model = hand.model;
  ClosedFingers closed;
  closed.all = model.all_positions(model.preshape("spread_0").open);
  closed.broken_away.assign(3, 0);
  GraspContact contact;
  contact.link = model.model.link_index("finger_3_inner_link");
  contact.contact_W = {Vector3d(-0.08, 0, 0.12), Vector3d::UnitX(), 0.5, 0};
  closed.contacts = {contact};
  const auto loads = [&] {
    return hand_forces(model, RigidTransform::Identity(), closed, Vector3d::Zero(), 1, 8)
        .torques.cwiseAbs()
        .maxCoeff();
  };
  EXPECT_GT(loads(), 0.01);
  closed.broken_away[2] = 0.2;
  EXPECT_EQ(loads(), 0);  // the inner link is held by its gear
}

}  // namespace
}  // namespace prehend::grasp
