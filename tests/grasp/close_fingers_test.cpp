#include "prehend/grasp/closing/close_fingers.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include <gtest/gtest.h>

#include "prehend/grasp/closing/finger_closing.h"
#include "prehend/grasp/closing/widest_opening.h"
#include "tests/grasp/hand_scene.h"

namespace prehend::grasp {
namespace {

using Eigen::Vector3d;
using geometry::RigidTransform;

const RigidTransform kHere = RigidTransform::Identity();
// Faces of links are true to a quarter of a millimetre, 86.5 mm from the joint.
constexpr double kAngle = 0.0003 / 0.0865 / 0.9;

TEST(HandBalls, FacesAreTrueToTheTolerance) {
  const TestHand sdh("sdh2");
  const int link = sdh.model.model.link_index("thumb_distal_link");
  const LinkBalls& balls = sdh.ready.balls.links[static_cast<std::size_t>(link)];
  const robot::CollisionShape& box =
      sdh.model.model.links[static_cast<std::size_t>(link)].shapes[0];
  std::mt19937_64 random(1);
  for (int i = 0; i < 300; ++i) {
    // On each face, off the rounded edges.
    Vector3d p;
    const int face = i % 3;
    for (int k = 0; k < 3; ++k) p[k] = random_unit(random) * (box.size[k] / 2 - 0.006);
    p[face] = (i % 2 ? 1 : -1) * box.size[face] / 2;
    double height = -std::numeric_limits<double>::infinity();
    for (std::size_t b = 0; b < balls.centers.size(); ++b) {
      // Height of the ball's surface over the face, where the face's normal through p meets it.
      Vector3d across = box.X_LS.inverse() * balls.centers[b] - p;
      const double depth = (i % 2 ? 1 : -1) * across[face];
      across[face] = 0;
      const double left = balls.radii[b] * balls.radii[b] - across.squaredNorm();
      if (left > 0) height = std::max(height, depth + std::sqrt(left));
    }
    EXPECT_NEAR(height, 0, 0.00026) << i;
  }
  // The tree's nodes hold their balls.
  for (const LinkBalls& one : sdh.ready.balls.links) {
    if (one.nodes.empty()) continue;
    for (std::size_t b = 0; b < one.centers.size(); ++b) {
      EXPECT_LE((one.centers[b] - one.nodes[0].center).norm() + one.radii[b],
                one.nodes[0].radius + 1e-12);
    }
  }
}

TEST(HandBalls, CylindersAreCoveredToo) {
  const TestHand barrett("bh8");
  const LinkBalls& palm = barrett.ready.balls.links[0];
  std::mt19937_64 random(2);
  for (int i = 0; i < 200; ++i) {
    const double angle = std::numbers::pi * random_unit(random);
    const Vector3d out(std::cos(angle), std::sin(angle), 0);
    const Vector3d p = 0.045 * out + Vector3d(0, 0, 0.0425 + 0.030 * random_unit(random));
    double distance = std::numeric_limits<double>::infinity();
    for (std::size_t b = 0; b < palm.centers.size(); ++b) {
      distance = std::min(distance, (p - palm.centers[b]).norm() - palm.radii[b]);
    }
    EXPECT_NEAR(distance, 0, 0.0004);
  }
}

TEST(CloseFingers, ParallelFingersStopAtTheBoxFaces) {
  const TestHand sdh("sdh2");
  for (const double width : {0.02, 0.04, 0.06}) {
    for (const double offset : {-0.005, 0.0, 0.01}) {
      const double middle = -0.0095 + offset;
      const TouchedMesh box(moved(geometry::make_box({width, 0.12, 0.06}), {middle, 0, 0.23}));
      const ClosedFingers closed = sdh.close("parallel", kHere, box.scene);
      // From base to face: 86.5 mm times the sine, and the link's half thickness.
      const double finger = std::asin((0.01905 - 0.0148 - (middle + width / 2)) / 0.0865);
      const double thumb = std::asin((0.0381 - 0.0148 + (middle - width / 2)) / 0.0865);
      EXPECT_NEAR(sdh.position(closed, "finger_1_proximal"), finger, kAngle) << width;
      EXPECT_NEAR(sdh.position(closed, "finger_2_proximal"), finger, kAngle) << width;
      EXPECT_NEAR(sdh.position(closed, "thumb_proximal"), thumb, kAngle) << width;
      // Distal links stay upright, and each pad lies on its face.
      EXPECT_NEAR(sdh.position(closed, "thumb_proximal") + sdh.position(closed, "thumb_distal"), 0,
                  1e-9);
      ASSERT_EQ(closed.contacts.size(), 3u);
      for (const GraspContact& contact : closed.contacts) {
        const bool is_thumb = contact.finger == 2;
        EXPECT_NEAR(contact.contact_W.point.x(), middle + (is_thumb ? -1 : 1) * width / 2, 1e-5);
        EXPECT_NEAR(contact.contact_W.normal.x(), is_thumb ? 1 : -1, 1e-3);
        EXPECT_GE(contact.pad, 0);
        EXPECT_GT(contact.contact_W.torsion_radius, 0.006);
        EXPECT_LT(contact.contact_W.torsion_radius, 0.03);
        EXPECT_EQ(contact.contact_W.friction, sdh.model.friction);
      }
      EXPECT_EQ(closed.other, Touched::kNothing);
      EXPECT_EQ(closed.finger_touches, std::vector<bool>({true, true, true}));
    }
  }
}

TEST(CloseFingers, BallBetweenThreeFingersIsMetAlikeByAll) {
  const TestHand sdh("sdh2");
  for (const double radius : {0.02, 0.03, 0.045}) {
    const TouchedMesh ball(moved(geometry::make_sphere(radius, 200), {0, 0, 0.22}));
    const ClosedFingers closed = sdh.close("tripod", kHere, ball.scene);
    // Bases stand 38.1 mm from the middle.
    const double expected = std::asin((0.0381 - 0.0148 - radius) / 0.0865);
    ASSERT_EQ(closed.contacts.size(), 3u);
    Vector3d sum = Vector3d::Zero();
    for (const char* joint : {"finger_1_proximal", "finger_2_proximal", "thumb_proximal"}) {
      EXPECT_NEAR(sdh.position(closed, joint), expected, kAngle) << radius;
    }
    for (const GraspContact& contact : closed.contacts) {
      sum += contact.contact_W.normal;
      // Towards the middle of the ball.
      EXPECT_GT(contact.contact_W.normal.dot(
                    (Vector3d(0, 0, 0.22) - contact.contact_W.point).normalized()),
                0.999);
    }
    EXPECT_LT(sum.norm(), 0.1);  // each within 2 degrees, as balls stand 3 mm apart
  }
}

TEST(CloseFingers, OneMotorForTwoFingersStopsBoth) {
  const TestHand pg70("pg70");
  const robot::Preshape& open = pg70.model.preshape("open");
  const RigidTransform X_GH = (pg70.model.X_HP * open.X_PG).inverse();
  for (const double width : {0.0, 0.01, 0.05}) {
    const TouchedMesh box(
        moved(geometry::make_box({0.1, 0.02, 0.1}), Vector3d(0, 0.01 + width / 2, 0)));
    HandClosingOptions held;  // the object, which nothing pushes
    held.farthest_push = 0;
    const ClosedFingers closed = close_fingers(pg70.ready, X_GH, open, open.open, box.scene, held);
    // The left finger meets the far face or starts within; the right one meets the near face.
    const double expected = std::max(0.0, width / 2);
    if (width >= 0.02) continue;
    EXPECT_NEAR(pg70.position(closed, "opening"), std::max(expected, 0.02 + width / 2), 3e-4);
    EXPECT_NEAR(pg70.position(closed, "opening_right"), pg70.position(closed, "opening"), 1e-12);
    EXPECT_EQ(closed.finger_touches, std::vector<bool>({true, false}));
  }
}

TEST(CloseFingers, BarrettOuterLinkGoesOnWhenTheInnerOneIsHeld) {
  const TestHand hand("bh8");
  // A bar across finger 3, near its inner joint: only the inner link can meet it.
  const TouchedMesh bar(
      moved(geometry::make_box({0.02, 0.2, 0.02}), Vector3d(-0.06, 0, 0.08 + 0.045)));
  const ClosedFingers closed = hand.close("spread_0", kHere, bar.scene);
  const double inner = hand.position(closed, "finger_3_inner");
  const double outer = hand.position(closed, "finger_3_outer");
  EXPECT_GT(inner, 0.5);
  EXPECT_LT(inner, 1.6);
  EXPECT_GT(outer, inner / 3 + 0.05);
  EXPECT_NEAR(closed.broken_away[2], outer - inner / 3, 1e-9);
  // The others pass above the bar and close as they are coupled, or break away too.
  for (const char* finger : {"finger_1", "finger_2"}) {
    const double i = hand.position(closed, std::string(finger) + "_inner");
    const double o = hand.position(closed, std::string(finger) + "_outer");
    EXPECT_GE(o, i / 3 - 1e-9) << finger;
  }
  // Nothing there: to the limits, coupled.
  const TouchedMesh far(moved(geometry::make_box({0.01, 0.01, 0.01}), Vector3d(1, 0, 0)));
  const ClosedFingers empty = hand.close("spread_0", kHere, far.scene);
  for (const char* finger : {"finger_1", "finger_2", "finger_3"}) {
    const double i = hand.position(empty, std::string(finger) + "_inner");
    EXPECT_NEAR(i, 140 * std::numbers::pi / 180, 1e-5);
    EXPECT_NEAR(hand.position(empty, std::string(finger) + "_outer"), i / 3, 1e-9);
  }
  EXPECT_TRUE(empty.contacts.empty());
}

TEST(CloseFingers, TableStopsFingersAndIsTold) {
  const TestHand sdh("sdh2");
  TouchedMesh box(moved(geometry::make_box({0.01, 0.01, 0.01}), Vector3d(1, 0, 0)));
  box.scene.table_W = geometry::Plane{Vector3d(0, 0, -1), -0.23};  // a ceiling: solid above 0.23
  const ClosedFingers closed = sdh.close("cylindrical", kHere, box.scene);
  EXPECT_EQ(closed.other, Touched::kTable);
  TouchedMesh other(moved(geometry::make_box({0.01, 0.3, 0.3}), Vector3d(-0.0095, 0, 0.2)));
  box.scene.table_W.reset();
  box.scene.obstacles_W = &other.grid;
  EXPECT_EQ(sdh.close("cylindrical", kHere, box.scene).other, Touched::kObstacle);
  EXPECT_TRUE(sdh.close("cylindrical", kHere, box.scene).contacts.empty());
}

TEST(AdvanceHand, StopsAtTheMarginBeforeTheFirstThing) {
  const TestHand sdh("sdh2");
  const Eigen::VectorXd all = sdh.model.all_positions(sdh.model.preshape("parallel").open);
  const TouchedMesh box(moved(geometry::make_box({0.008, 0.02, 0.06}), {-0.0075, 0, 0.43}));
  // The box's bottom (z = 0.4) comes down on the palm (z = 0.0745) between the fingers.
  const Advance on = advance_hand(sdh.ready, kHere, all, Vector3d::UnitZ(), 0.5, 0.002, box.scene);
  EXPECT_NEAR(on.distance, 0.4 - 0.0745 - 0.002, 3e-4);
  EXPECT_EQ(on.what, Touched::kObject);
  EXPECT_EQ(on.link, 0);
  const Advance free =
      advance_hand(sdh.ready, kHere, all, Vector3d::UnitZ(), 0.2, 0.002, box.scene);
  EXPECT_EQ(free.distance, 0.2);
  EXPECT_EQ(free.what, Touched::kNothing);
}

TEST(CloseFingers, OptionsAndPositionsAreChecked) {
  const TestHand sdh("sdh2");
  const TouchedMesh box(geometry::make_box({0.02, 0.02, 0.06}));
  const robot::Preshape& shape = sdh.model.preshape("parallel");
  EXPECT_THROW(close_fingers(sdh.ready, kHere, shape, Eigen::VectorXd::Zero(3), box.scene),
               std::invalid_argument);
  EXPECT_THROW(close_fingers(sdh.ready, kHere, shape, shape.open, box.scene, {.tolerance = 0}),
               std::invalid_argument);
  EXPECT_THROW(make_hand_balls(sdh.model, -1), std::invalid_argument);
}

// ---- the oracle: small equal steps, exact distances, one finger at a time

double exact_clearance(const LinkBalls& link, const RigidTransform& X_WL,
                       const geometry::MeshQuery& mesh, double least, int node = 0) {
  const LinkBalls::Node& here = link.nodes[static_cast<std::size_t>(node)];
  if (mesh.nearest(X_WL * here.center)->distance - here.radius >= least) return least;
  if (!here.leaf()) {
    least = exact_clearance(link, X_WL, mesh, least, here.first);
    return exact_clearance(link, X_WL, mesh, least, here.right);
  }
  for (int i = here.first; i < here.last; ++i) {
    const auto b = static_cast<std::size_t>(i);
    least = std::min(least, mesh.nearest(X_WL * link.centers[b])->distance - link.radii[b]);
  }
  return least;
}

/// Closes by equal steps of `step` [rad]. `joints` are the finger's, from the palm on, each with
/// its link; `rates` theirs; a held leader frees its breakaway.
struct StepOracle {
  const TestHand& hand;
  const geometry::MeshQuery& mesh;
  double thicker = 0;  // m, of the links' surface
  double step = 2e-3;

  Eigen::VectorXd close(const robot::Preshape& shape, const RigidTransform& X_WH,
                        const std::vector<std::string>& joints) const {
    Eigen::VectorXd all = hand.model.all_positions(shape.open);
    std::vector<int> index;
    std::vector<double> rate;
    for (const std::string& name : joints) {
      index.push_back(hand.model.model.joint_index(name));
      const robot::Joint& joint = hand.model.model.joints[static_cast<std::size_t>(index.back())];
      rate.push_back(
          joint.mimic
              ? joint.mimic->multiplier * rate.front()
              : shape.closing[static_cast<std::size_t>(hand.model.actuated_index(name))].rate);
    }
    const bool coupled =
        joints.size() == 2 &&
        hand.model.model.joints[static_cast<std::size_t>(index[1])].mimic.has_value();
    const bool together = joints.size() == 2 && rate[1] < 0;  // distal link kept upright
    std::vector<RigidTransform> poses;
    for (int n = 0; n < 4000 && (rate[0] != 0 || rate[1] != 0); ++n) {
      hand.model.link_poses(all, poses);
      for (std::size_t k = joints.size(); k-- > 0;) {
        const int link = hand.model.model.joints[static_cast<std::size_t>(index[k])].child;
        const auto l = static_cast<std::size_t>(link);
        if (exact_clearance(hand.ready.balls.links[l], X_WH * poses[l], mesh, 1e-3) > thicker)
          continue;
        if (rate[0] != 0 && k == 0 && coupled) rate[1] = rate[0] * 4 / 3;
        if (k == 1 || together) rate[1] = 0;
        rate[0] = 0;
      }
      for (std::size_t k = 0; k < joints.size(); ++k) {
        const robot::Joint& joint = hand.model.model.joints[static_cast<std::size_t>(index[k])];
        double& q = all[index[k]];
        q += step * rate[k];
        if (q < joint.upper && q > joint.lower) continue;
        q = std::clamp(q, joint.lower, joint.upper);
        rate[k] = 0;
        if (coupled && k == 0) rate[1] = 0;
        if (together) rate[0] = rate[1] = 0;
      }
    }
    return all;
  }
};

void compare_with_steps(const std::string& name, const std::vector<std::string>& preshapes,
                        const std::vector<std::vector<std::string>>& fingers, int cases) {
  const TestHand hand(name);
  std::mt19937_64 random(7);
  int touching = 0, exact = 0, all = 0;
  for (int i = 0; i < cases; ++i) {
    const robot::Preshape& shape =
        hand.model.preshape(preshapes[static_cast<std::size_t>(i) % preshapes.size()]);
    RigidTransform X = random_turn(random);
    X.translation() = (hand.model.X_HP * shape.X_PG).translation() +
                      0.01 * Vector3d(random_unit(random), random_unit(random), 1);
    const geometry::TriangleMesh kinds[] = {geometry::make_box({0.05, 0.03, 0.08}),
                                            geometry::make_sphere(0.03, 40),
                                            make_torus(0.03, 0.01, 40, 16)};
    const TouchedMesh object(moved(kinds[i % 3], X));
    // Only from where the open hand is free.
    if (hand_clearance(hand.ready, kHere, hand.model.all_positions(shape.open), object.scene)
            .clearance < 0.001) {
      continue;
    }
    const ClosedFingers closed = hand.close(shape.name, kHere, object.scene);
    // Of a hand a little thicker and a little thinner: a finger that grazes something may stop
    // there or go by.
    const StepOracle thick{hand, object.query, 2e-4}, thin{hand, object.query, -2e-4};
    for (const auto& joints : fingers) {
      const Eigen::VectorXd early = thick.close(shape, kHere, joints);
      const Eigen::VectorXd late = thin.close(shape, kHere, joints);
      for (const std::string& joint : joints) {
        const int j = hand.model.model.joint_index(joint);
        EXPECT_GT(closed.all[j], std::min(early[j], late[j]) - 0.004)
            << name << " case " << i << " " << joint;
        EXPECT_LT(closed.all[j], std::max(early[j], late[j]) + 0.004)
            << name << " case " << i << " " << joint;
        exact += static_cast<int>(std::abs(early[j] - late[j]) < 0.02);
        ++all;
      }
    }
    // Nothing is entered.
    std::vector<RigidTransform> poses;
    hand.model.link_poses(closed.all, poses);
    for (std::size_t l = 0; l < poses.size(); ++l) {
      if (hand.ready.balls.links[l].nodes.empty()) continue;
      EXPECT_GT(exact_clearance(hand.ready.balls.links[l], poses[l], object.query, 1e-3), -3e-4)
          << name << " case " << i << " " << hand.model.model.links[l].name;
    }
    touching += static_cast<int>(closed.contacts.size() >= 2);
  }
  EXPECT_GE(touching, cases / 3) << name;
  EXPECT_GT(exact, 0.8 * all) << name;
}

TEST(CloseFingers, AgreesWithSmallStepsForTheSdh) {
  compare_with_steps("sdh2", {"spherical", "cylindrical", "tripod", "parallel"},
                     {{"finger_1_proximal", "finger_1_distal"},
                      {"finger_2_proximal", "finger_2_distal"},
                      {"thumb_proximal", "thumb_distal"}},
                     24);
}

TEST(CloseFingers, AgreesWithSmallStepsForTheBarrettHand) {
  compare_with_steps("bh8", {"spread_0", "spread_60", "spread_0_narrow"},
                     {{"finger_1_inner", "finger_1_outer"},
                      {"finger_2_inner", "finger_2_outer"},
                      {"finger_3_inner", "finger_3_outer"}},
                     24);
}

TEST(CloseFingers, JawsOfOneMotorPushToTheirMiddle) {
  const TestHand pg70("pg70");
  for (const double aside : {-0.008, 0.0, 0.006}) {
    const TouchedMesh box(moved(geometry::make_box({0.03, 0.04, 0.05}), {0, aside, 0.1642}));
    const ClosedFingers closed = pg70.close("open", kHere, box.scene);
    EXPECT_EQ(closed.finger_touches, (std::vector<bool>{true, true})) << aside;
    EXPECT_NEAR(pg70.position(closed, "opening"), 0.02, 6e-4) << aside;
    EXPECT_LT((closed.push_W - Vector3d(0, aside, 0)).norm(), 8e-4) << aside;
  }
}

TEST(CloseFingers, NothingIsPushedFartherThanSaid) {
  const TestHand pg70("pg70");
  const robot::Preshape& open = pg70.model.preshape("open");
  const TouchedMesh box(moved(geometry::make_box({0.03, 0.02, 0.05}), {0, 0.02, 0.1642}));
  HandClosingOptions options;
  options.farthest_push = 0.005;
  const ClosedFingers closed =
      close_fingers(pg70.ready, kHere, open, open.open, box.scene, options);
  EXPECT_NEAR(closed.push_W.norm(), 0.005, 1e-6);
  EXPECT_EQ(std::count(closed.finger_touches.begin(), closed.finger_touches.end(), true), 1);
  options.farthest_push = -1;
  EXPECT_THROW(close_fingers(pg70.ready, kHere, open, open.open, box.scene, options),
               std::invalid_argument);
}

TEST(CloseFingers, FingersOfTheirOwnMotorsPushNothing) {
  const TestHand sdh("sdh2");
  const TouchedMesh box(moved(geometry::make_box({0.05, 0.05, 0.06}), {0.01, 0, 0.215}));
  const ClosedFingers closed = sdh.close("parallel", kHere, box.scene);
  EXPECT_TRUE(closed.push_W.isZero());
}

// How far apart fingertips are is the hands' data sheets' to say; the pads' own is in their file.
TEST(WidestOpening, IsOfThePreshapeThatOpensWidest) {
  const robot::HandModel pads = robot::parallel_hand({});
  EXPECT_EQ(widest_opening(pads), pads.gripper->max_opening);
  for (const char* name : {"sdh2", "bh8"}) {
    const auto model = robot::read_hand_model(std::string("config/robots/") + name + ".yaml");
    const HandToClose hand(model);
    const double widest = widest_opening(model);
    for (const robot::Preshape& preshape : model.preshapes) {
      EXPECT_GE(widest, hand_reach(hand, preshape).max_opening) << name << preshape.name;
    }
    EXPECT_GT(widest, 0.08) << name;
    EXPECT_LT(widest, 0.35) << name;
  }
}

}  // namespace
}  // namespace prehend::grasp
