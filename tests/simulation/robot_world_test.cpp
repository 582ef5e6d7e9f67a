// Arm and hand in the simulated world: what they hold through a lift, and what their sensors say.

#include <cmath>
#include <filesystem>
#include <limits>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "prehend/geometry/errors.h"
#include "prehend/simulation/robot_world.h"
#include "prehend/simulation/shapes.h"
#include "tests/grasp/hand_scene.h"
#include "tests/simulation/closed_hand.h"
#include "tests/simulation/grasping.h"

namespace prehend::simulation {
namespace {

using geometry::RigidTransform;

/// H above `p_W`, its z straight down, so that the tool of `preshape` is at `p_W`.
RigidTransform above(const robot::HandModel& hand, const std::string& preshape,
                     const Eigen::Vector3d& p_W) {
  RigidTransform X_WG = RigidTransform::Identity();
  X_WG.linear() = Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX()).toRotationMatrix();
  X_WG.translation() = p_W;
  return X_WG * (hand.X_HP * hand.preshape(preshape).X_PG).inverse();
}

void run(RobotWorld& world, double seconds) {
  for (long i = std::lround(seconds / world.options().step); i > 0; --i) world.step();
}

struct Held {
  double slip = 0;  // m, between hand and object from the lift's start to its end
  double height = 0;
  double force = 0;  // N, on the hand at the end, vertical
  double creep = 0;  // m, in the last half second
};

Held lift(RobotWorld& world, const std::string& object, double way, const Eigen::VectorXd& target,
          double effort_share) {
  HandCommand close;
  close.position = target;
  close.speed = 0.3;
  close.until_contact = true;
  close.effort.resize(target.size());
  for (int i = 0; i < close.effort.size(); ++i) {
    const robot::HandModel& hand = world.hand_model();
    close.effort[i] =
        effort_share *
        hand.model.joints[static_cast<std::size_t>(hand.actuated[static_cast<std::size_t>(i)])]
            .max_effort;
  }
  world.move_hand(close);
  for (int i = 0; i < 8000 && world.hand().moving(); ++i) world.step();
  EXPECT_TRUE(world.hand().blocked());
  run(world, 0.3);
  const RigidTransform X_HB = world.X_WH().inverse() * world.body(object).X_WB;
  RigidTransform up = world.X_WH();
  up.translation().z() += way;
  world.carry(up, 1.0);
  run(world, 1.5);
  EXPECT_TRUE(world.carried());
  const RigidTransform before = world.X_WH().inverse() * world.body(object).X_WB;
  run(world, 0.5);
  const RigidTransform now = world.X_WH().inverse() * world.body(object).X_WB;
  Held held;
  held.slip = (now.translation() - X_HB.translation()).norm();
  held.creep = (now.translation() - before.translation()).norm();
  held.height = world.body(object).height;
  held.force = (world.X_WH().linear() * world.wrist_wrench().force).z();
  return held;
}

geometry::TriangleMesh at(const geometry::TriangleMesh& mesh, const Eigen::Vector3d& p) {
  RigidTransform X = RigidTransform::Identity();
  X.translation() = p;
  return geometry::transformed(mesh, X);
}

class Holds : public ::testing::TestWithParam<std::tuple<const char*, const char*, double>> {};

TEST_P(Holds, ABoxThroughALift) {
  const auto [file, preshape, mass] = GetParam();
  const robot::HandModel hand = robot::read_hand_model(std::string("config/robots/") + file);
  RobotWorld world(hand, above(hand, preshape, {0, 0, 0.07}), preshape);
  world.add_object("box", at(make_standing_box({0.06, 0.06, 0.12}), {0, 0, 0}), mass);
  const Held held = lift(world, "box", 0.12, closed(hand, preshape, 1.6), 0.5);
  EXPECT_GT(held.height, 0.115);
  EXPECT_LT(held.slip, 0.005) << "what the fingers give way to the weight";
  EXPECT_LT(held.creep, 2e-5);
  EXPECT_NEAR(held.force, -mass * 9.81, 0.05 * mass * 9.81) << "the wrist bears the weight";
  EXPECT_TRUE(world.body("box").touches_robot);
  EXPECT_FALSE(world.body("box").touches_table);
}

INSTANTIATE_TEST_SUITE_P(Hands, Holds,
                         ::testing::Values(std::tuple("sdh2.yaml", "parallel", 0.2),
                                           std::tuple("sdh2.yaml", "parallel", 1.0),
                                           std::tuple("sdh2.yaml", "cylindrical", 0.5),
                                           std::tuple("bh8.yaml", "spread_0", 0.2),
                                           std::tuple("bh8.yaml", "spread_0", 1.0)));

// Regression: a point beside a sharp edge was taken to be inside where the face that happened to be
// the nearest turned its back to it, as deep as it was away: predicted meshes were pushed and
// fingers jammed by what did not touch.
TEST(RobotWorld, WhatIsBesideASharpEdgeTouchesNothing) {
  const robot::HandModel hand = robot::read_hand_model("config/robots/sdh2.yaml");
  RobotWorld world(hand, above(hand, "parallel", {0, 0, 0.3}), "parallel");
  Eigen::Vector3d tip{0, 0, 1};  // the hand's lowest
  for (const VisibleBody& body : world.visible_bodies()) {
    for (const Eigen::Vector3d& p_B : body.mesh_B->vertices) {
      const Eigen::Vector3d p_W = body.X_WB * p_B;
      if (p_W.z() < tip.z()) tip = p_W;
    }
  }
  // Blades along x under the tips, 4 mm below, in the box of a post that stands beside the hand.
  std::vector<geometry::TriangleMesh> parts{at(make_standing_box({0.02, 0.02, 0.4}), {0.3, 0, 0})};
  const double top = tip.z() - 0.004;
  for (double y = -0.1; y <= 0.1; y += 0.003) {
    std::vector<Eigen::Vector3d> corners;
    for (const double x : {-0.08, 0.08}) {
      corners.insert(corners.end(), {{x, y, top}, {x, y - 0.001, 0}, {x, y + 0.001, 0}});
    }
    parts.push_back(geometry::convex_hull(corners));
  }
  world.add_object("comb", geometry::concatenated(parts), 0.5, true);
  run(world, 0.05);
  EXPECT_FALSE(world.body("comb").touches_robot);
  for (const LinkContact& contact : world.link_contacts()) {
    ADD_FAILURE() << contact.link << " " << contact.normal_force << " N";
  }
  // It is there all the same.
  world.carry(above(hand, "parallel", {0, 0, 0.3 - 0.006}), 0.1);
  run(world, 0.1);
  EXPECT_TRUE(world.body("comb").touches_robot);
}

// Regression: rubber gave way by more than half of a cup's wall; then the wall's other side was the
// nearer one and drew the finger in. A plate is lowered onto the tips of fingers that point up.
TEST(RobotWorld, AThinWallIsMetFromTheSideThatTheFingerCameFrom) {
  const double thickness = 0.0018;
  const auto push = [&](double depth) {
    RigidTransform X_WH = RigidTransform::Identity();
    X_WH.translation().z() = 0.5;
    RobotWorld world(robot::read_hand_model("config/robots/bh8.yaml"), X_WH);
    world.set_hand(Eigen::Vector4d(0, 1.2, 1.2, 1.2));
    double tip = 0;  // m, of the fingers
    for (const VisibleBody& body : world.visible_bodies()) {
      for (const Eigen::Vector3d& p_B : body.mesh_B->vertices) {
        tip = std::max(tip, (body.X_WB * p_B).z());
      }
    }
    geometry::TriangleMesh plate = geometry::make_box({0.3, 0.3, thickness});
    for (Eigen::Vector3d& p : plate.vertices) p.z() += tip + thickness / 2 - depth;
    world.add_object("plate", plate, 1, true);
    world.step();
    double force = 0;
    for (const auto& touch : world.object_touches("plate")) force += touch.force.z();
    return force;
  };
  for (const double depth : {0.3, 0.6, 0.95, 1.5}) {
    SCOPED_TRACE(depth);
    EXPECT_GT(push(depth * thickness), 0);
  }
}

TEST(RobotWorld, AHandIsSetElsewhereAtOnceAndAtRest) {
  const robot::HandModel hand = robot::read_hand_model("config/robots/sdh2.yaml");
  const RigidTransform here = above(hand, "parallel", {0, 0, 0.3});
  RigidTransform there = above(hand, "parallel", {0.5, 0.2, 0.4});
  there.rotate(Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitX()));
  RobotWorld moved(hand, here, "parallel"), made(hand, there, "parallel");
  moved.carry(there, 1.0);
  run(moved, 0.3);
  moved.set_carrier(there);
  EXPECT_TRUE(moved.carried());
  EXPECT_EQ(moved.X_WH().matrix(), there.matrix());
  moved.set_hand(hand.preshape("parallel").open);
  for (RobotWorld* world : {&moved, &made}) run(*world, 0.2);
  EXPECT_LT((moved.X_WH().matrix() - made.X_WH().matrix()).norm(), 1e-12);
  EXPECT_LT((moved.hand_positions() - made.hand_positions()).norm(), 1e-4);
  for (const JointReading& joint : moved.joints()) EXPECT_LT(std::abs(joint.velocity), 1e-3);
  RobotWorld with_arm(robot::read_platform("config/robots/kr5_sdh.yaml"), Scene());
  EXPECT_THROW(with_arm.set_carrier(here), std::logic_error);
}

TEST(RobotWorld, ContinuesBitwiseFromASavedState) {
  const robot::Platform platform = robot::read_platform("config/robots/kr5_sdh.yaml");
  Scene scene;
  scene.objects.resize(1);
  scene.objects[0].name = "box";
  scene.objects[0].x = 0.1;
  scene.wrench.emplace().force_noise = 0.1;
  scene.tactile.sensor.noise = 3;
  RobotWorld world(platform, scene);
  HandCommand close;
  close.position = closed(platform.hand, platform.hand.preshapes.front().name, 0.4);
  world.move_hand(close);
  run(world, 0.2);
  const auto saved = world.save();
  run(world, 0.2);
  const Eigen::VectorXd hand = world.hand_positions();
  const RigidTransform box = world.body("box").X_WB;
  const Eigen::Vector3d wrist = world.wrist_wrench().force;
  const std::vector<std::uint16_t> frame = world.pads().front().counts;
  world.restore(*saved);
  run(world, 0.2);
  EXPECT_EQ(world.wrist_wrench().force, wrist);
  EXPECT_EQ(world.pads().front().counts, frame);
  EXPECT_EQ(world.hand_positions(), hand);
  EXPECT_EQ(world.body("box").X_WB.matrix(), box.matrix());
  world.add_object("other", at(make_ball(0.03), {0.3, 0.3, 0}), 0.1);
  EXPECT_THROW(world.restore(*saved), std::invalid_argument);
  EXPECT_THROW(world.body("nobody"), std::invalid_argument);
  EXPECT_TRUE(world.remove_object("other"));
  EXPECT_FALSE(world.remove_object("other"));
}

// All objects but a scene's last once stood in the robot's base.
TEST(RobotWorld, EachObjectStandsWhereTheSceneHasIt) {
  const robot::Platform platform = robot::read_platform("config/robots/kr5_sdh.yaml");
  Scene scene;
  scene.objects.resize(3);
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    scene.objects[i].name = "box " + std::to_string(i);
    scene.objects[i].y = 0.2 * static_cast<double>(i) - 0.2;
  }
  RobotWorld world(platform, scene);
  const auto expect_in_place = [&] {
    for (const SceneObject& object : scene.objects) {
      const Eigen::Vector3d p = world.body(object.name).X_WB.translation();
      EXPECT_NEAR((p - Eigen::Vector3d(object.x, object.y, 0)).norm(), 0, 1e-3) << object.name;
    }
  };
  expect_in_place();
  run(world, 0.3);
  world.add_object("another", at(make_standing_box({0.03, 0.03, 0.03}), {0.3, 0.3, 0}), 0.1);
  expect_in_place();
}

TEST(RobotWorld, PadsFeelWhatTheFingersPressWith) {
  const robot::HandModel hand = robot::read_hand_model("config/robots/sdh2.yaml");
  RobotWorld world(hand, above(hand, "parallel", {0, 0, 0.11}), "parallel");
  world.add_object("box", at(make_standing_box({0.06, 0.06, 0.12}), {0, 0, 0}), 0.3);
  const Held held = lift(world, "box", 0.12, closed(hand, "parallel", 1.6), 0.4);
  EXPECT_GT(held.height, 0.1);
  // The second pivot follows the first, though the file has it first.
  double pivot = 1, follower = 2;
  for (const JointReading& joint : world.joints()) {
    if (joint.name == "pivot") pivot = joint.position;
    if (joint.name == "finger_2_pivot") follower = joint.position;
  }
  EXPECT_EQ(pivot, follower);
  double pads = 0, links = 0;
  for (const HandPadReading& pad : world.pads()) {
    double texels = 0;
    for (const double force : pad.force) texels += force;
    EXPECT_NEAR(texels, pad.sum, 1e-9) << pad.name;
    pads += pad.sum;
  }
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  for (const LinkContact& contact : world.link_contacts()) {
    links += contact.normal_force;
    force += contact.force;
  }
  EXPECT_GT(pads, 5.0);
  EXPECT_NEAR(pads, links, 1e-9) << "the box lies on the pads alone";
  EXPECT_NEAR((world.X_WH().linear().transpose() * force - world.wrist_wrench().force).norm(), 0,
              1e-9);
}

// The parallel gripper's own World is the oracle: the same texels bear the same share.
TEST(RobotWorld, PadsShowTheImageThatTheGrippersWorldShows) {
  const robot::HandModel hand = robot::read_hand_model("config/robots/pg70.yaml");
  constexpr double kAside = 0.0301;  // m, so that the box's edge lies within the pads
  Scene scene = testing::grasp_scene(0.3);
  scene.gripper = *hand.gripper;
  scene.objects.front().x = kAside;
  World gripper(scene);
  testing::grasp(gripper, 1.0);
  RobotWorld world(hand, above(hand, "open", {0, 0, testing::kGraspHeight}), "open");
  world.add_object("box", at(make_standing_box({0.07, 0.048, 0.1}), {kAside, 0, 0}), 0.3);
  HandCommand close;
  close.position = Eigen::VectorXd::Zero(1);
  close.until_contact = true;
  close.effort = Eigen::VectorXd::Constant(1, 22);
  world.move_hand(close);
  run(world, 2);
  const std::vector<HandPadReading> pads = world.pads();
  ASSERT_EQ(pads.size(), 2u);
  for (const PadSide side : {PadSide::kLeft, PadSide::kRight}) {
    const TactileImage image = gripper.tactile_image(side);
    const HandPadReading& pad = pads[side == PadSide::kLeft ? 0 : 1];
    ASSERT_GT(image.sum, 10);
    ASSERT_GT(pad.sum, 10);
    ASSERT_EQ(pad.counts.size(), image.counts.size());
    // Columns of a hand's pad run along x of its own frame, those of the gripper along its x.
    double differing = 0;
    int dark = 0;
    for (int row = 0; row < image.rows; ++row) {
      for (int column = 0; column < image.columns; ++column) {
        const int mirrored = side == PadSide::kLeft ? column : image.columns - 1 - column;
        const double felt = pad.force[static_cast<std::size_t>(row * image.columns + mirrored)];
        const double oracle = image.counts[static_cast<std::size_t>(row * image.columns + column)] *
                              hand.gripper->pad.newton_per_count;
        differing += std::abs(felt / pad.sum - oracle / image.sum);
        dark += felt == 0;
      }
    }
    EXPECT_EQ(dark, 2 * image.rows) << "beside the box";
    EXPECT_LT(differing, 0.02) << pad.name;
  }
}

// The thumb's knuckle is fixed to the palm, which then pressed 200 N on the other fingers.
TEST(RobotWorld, TheFingersOfAnOpenHandPressOnNothing) {
  for (const char* file : {"sdh2.yaml", "bh8.yaml", "pg70.yaml"}) {
    const robot::HandModel hand =
        robot::read_hand_model(std::filesystem::path("config/robots") / file);
    for (const robot::Preshape& preshape : hand.preshapes) {
      RobotWorld world(hand, above(hand, preshape.name, {0, 0, 0.5}), preshape.name);
      run(world, 0.05);
      EXPECT_TRUE(world.link_contacts().empty()) << file << " " << preshape.name;
    }
  }
}

// 5 N of noise were asked for, and the wrist was exactly zero.
TEST(RobotWorld, TheScenesSensorsAreTheRobots) {
  const robot::Platform platform = robot::read_platform("config/robots/kr5_sdh.yaml");
  Scene scene;
  scene.wrench.emplace().force_noise = 5;
  scene.tactile.sensor.noise = 20;
  scene.tactile.sensor.threshold = 0;
  RobotWorld world(platform, scene);
  double squares = 0;
  int frames = 0, lit = 0;
  std::vector<std::uint16_t> last;
  constexpr int kSteps = 400;
  for (int i = 0; i < kSteps; ++i) {
    world.step();
    squares += world.wrist_wrench().force.squaredNorm();
    const std::vector<std::uint16_t> counts = world.pads().front().counts;
    frames += counts != last ? 1 : 0;
    for (const std::uint16_t count : counts) lit += count > 0 ? 1 : 0;
    last = counts;
  }
  EXPECT_NEAR(std::sqrt(squares / (3 * kSteps)), 5, 0.5);
  EXPECT_NEAR(frames, kSteps * scene.step / scene.tactile.period, 2);
  EXPECT_NEAR(static_cast<double>(lit) / (kSteps * static_cast<double>(last.size())), 0.5, 0.1);
  RobotWorld quiet(platform, Scene{});
  quiet.step();
  EXPECT_TRUE(quiet.wrist_wrench().force.isZero());
}

// The twin without the rule; `prehend explain` tells the bound.
TEST(RobotWorld, WhatSleepsWouldHaveSettledLittle) {
  const robot::Platform platform = robot::read_platform("config/robots/kr5_sdh.yaml");
  Scene scene;
  for (const char* shape : {"box", "can", "mug", "bottle", "spray_bottle"}) {
    SceneObject object;
    object.name = object.shape = shape;
    object.x = 0.2 * static_cast<double>(scene.objects.size()) - 0.3;
    object.y = 0.3;
    object.size = {0.08, 0.05, 0.2};
    scene.objects.push_back(object);
  }
  Scene full = scene;
  full.physics.rules.sleep = false;
  RobotWorld world(platform, scene), twin(platform, full);
  for (RobotWorld* each : {&world, &twin}) run(*each, 3);
  double farthest = 0;
  for (const SceneObject& object : scene.objects) {
    EXPECT_TRUE(world.body(object.name).asleep) << object.name;
    EXPECT_FALSE(twin.body(object.name).asleep) << object.name;
    farthest = std::max(farthest, (world.body(object.name).X_WB.translation() -
                                   twin.body(object.name).X_WB.translation())
                                      .norm());
  }
  EXPECT_LT(farthest, 1e-6);
}

}  // namespace
}  // namespace prehend::simulation
