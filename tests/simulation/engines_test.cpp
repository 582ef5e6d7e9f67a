// One suite for every engine that is installed. A case that an engine cannot do must be refused by
// UnsupportedScene and stand in kCannotDo.

#include <cmath>
#include <map>
#include <numeric>
#include <set>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "prehend/simulation/engines/native_engine.h"
#include "prehend/simulation/engines/registry.h"
#include "prehend/simulation/engines/substepped_pads.h"
#include "tests/simulation/engine_scenes.h"

namespace prehend::simulation::engines {
namespace {

const std::map<std::string, std::set<std::string>> kCannotDo{
    {"native", {"own_contacts"}},
    {"bullet", {"follow", "own_contacts"}},
    {"dart", {"follow", "own_contacts"}},
    {"ode", {"follow", "own_contacts"}},
};

// Rounding of positions and speeds of the order of 1; Debian's Bullet is built for single
// precision.
double precision(const std::string& engine) { return engine == "bullet" ? 2e-4 : 1e-6; }

// What a pair may lose of its momentum [kg m/s]: 1e-12 of 0.1, which goes to and fro.
double momentum_precision(const std::string& engine) { return engine == "bullet" ? 1e-7 : 1e-13; }

class EachEngine : public ::testing::TestWithParam<std::string> {
 protected:
  // False when the engine says that it cannot do the scene and that is known.
  bool load(const EngineScene& scene, const std::string& what) {
    validate(scene);
    engine_ = EngineRegistry().create(GetParam());
    const auto known = kCannotDo.find(GetParam());
    const bool expected = known != kCannotDo.end() && known->second.count(what) > 0;
    try {
      engine_->load(scene);
    } catch (const UnsupportedScene& reason) {
      EXPECT_TRUE(expected) << reason.what();
      RecordProperty("cannot_do_" + what, reason.what());
      return false;
    }
    EXPECT_FALSE(expected) << what << " is said to be impossible";
    step_ = scene.step;
    return true;
  }
  void run(double seconds) {
    const int steps = static_cast<int>(std::lround(seconds / step_));
    for (int i = 0; i < steps; ++i) engine_->step();
  }

  std::unique_ptr<Engine> engine_;
  double step_ = 0;
};

TEST_P(EachEngine, FallsFreely) {
  EngineScene scene;
  scene.bodies = {box(0.3, {0.05, 0.06, 0.07}, {0, 0, 1})};
  scene.bodies[0].velocity = {0.4, 0, 0};
  if (!load(scene, "fall")) return;
  run(0.3);
  const BodyMotion motion = engine_->body(0);
  EXPECT_NEAR(motion.velocity.z(), -9.81 * 0.3, precision(GetParam()));
  EXPECT_NEAR(motion.X_WB.translation().x(), 0.12, precision(GetParam()));
  // First order: half a step of the last speed at most.
  EXPECT_NEAR(motion.X_WB.translation().z(), 1 - 0.5 * 9.81 * 0.09,
              0.5 * step_ * 9.81 * 0.3 + precision(GetParam()));
}

TEST_P(EachEngine, ForceAcceleratesASlidingJoint) {
  EngineScene scene;
  scene.gravity.setZero();
  scene.bodies = {box(0.05, {0.02, 0.02, 0.02}, {0, 0.5, 0}),
                  box(0.3, {0.05, 0.05, 0.05}, {0, 0, 5})};
  EngineJoint slide;
  slide.axis_W = Eigen::Vector3d(1, 2, 2) / 3;
  scene.joints = {slide};
  if (!load(scene, "slide")) return;
  engine_->set_joint_force(0, 0.1);
  run(0.2);
  EXPECT_NEAR(engine_->joint_position(0), 0.5 * 2 * 0.04,
              0.5 * step_ * 0.4 + 10 * precision(GetParam()));
  const Eigen::Vector3d moved = engine_->body(0).X_WB.translation() - Eigen::Vector3d(0, 0.5, 0);
  EXPECT_NEAR(moved.dot(slide.axis_W), engine_->joint_position(0), precision(GetParam()));
  EXPECT_LT(moved.cross(slide.axis_W).norm(), precision(GetParam()));
}

TEST_P(EachEngine, CollidingBallsKeepTheirMomentum) {
  EngineScene scene;
  scene.gravity.setZero();
  for (const int side : {-1, 1}) {
    EngineBody ball;
    ball.name = side > 0 ? "right" : "left";
    ball.shape.kind = EngineShape::Kind::kSphere;
    ball.shape.radius = 0.03;
    ball.mass = side > 0 ? 0.1 : 0.5;
    ball.X_WB.translation().x() = 0.05 * side;
    ball.velocity.x() = side > 0 ? -0.5 : 0.2;
    scene.bodies.push_back(ball);
  }
  if (!load(scene, "pair")) return;
  run(0.3);
  const double left = engine_->body(0).velocity.x(), right = engine_->body(1).velocity.x();
  EXPECT_NEAR(0.5 * left + 0.1 * right, 0.05, momentum_precision(GetParam()));
  EXPECT_GE(right, left - precision(GetParam())) << "they do not pass through one another";
}

TEST_P(EachEngine, PendulumSwings) {
  EngineScene scene;
  EngineBody bob = box(0.2, {0.02, 0.02, 0.02}, {0.5 * std::sin(0.1), 0, -0.5 * std::cos(0.1)});
  scene.bodies = {bob};
  EngineJoint hinge;
  hinge.kind = EngineJoint::Kind::kRevolute;
  hinge.axis_W = Eigen::Vector3d::UnitY();
  scene.joints = {hinge};
  if (!load(scene, "pendulum")) return;
  const double inertia = 0.2 * 0.25 + 0.2 / 6 * 4e-4;
  const double period = 2 * M_PI * std::sqrt(inertia / (0.2 * 9.81 * 0.5)) * (1 + 0.01 / 16);
  run(period);
  const Eigen::Vector3d p = engine_->body(0).X_WB.translation();
  EXPECT_NEAR(p.norm(), 0.5, 1e-3);
  EXPECT_NEAR(p.x(), 0.5 * std::sin(0.1), 0.002);
  run(0.5 * period);
  EXPECT_NEAR(engine_->body(0).X_WB.translation().x(), -0.5 * std::sin(0.1), 0.003);
}

TEST_P(EachEngine, AChainFollowsItsEquations) {
  const EngineScene scene = double_pendulum(1e-3);
  if (!load(scene, "chain")) return;
  run(0.5);
  const Eigen::Vector2d truth = double_pendulum_reference(0.5);
  // First order over a swing of 2 rad; backward Euler is the farthest off.
  for (const int joint : {0, 1}) {
    EXPECT_NEAR(engine_->joint_position(joint), truth[joint], 0.03) << joint;
  }
}

// A link whose geometry overlaps with that of the fixed base it hangs on.
TEST_P(EachEngine, ALinkHangsOnAFixedBody) {
  EngineScene scene;
  scene.bodies = {box(1, {0.1, 0.1, 0.1}, {0, 0, 0}), box(0.2, {0.2, 0.02, 0.02}, {0.1, 0, 0})};
  scene.bodies[0].is_fixed = true;
  scene.joints = {hinge(0, 1, Eigen::Vector3d::Zero())};
  if (!load(scene, "fixed_parent")) return;
  run(0.1);
  // From the horizontal: half g t^2 m a / I, while the angle is small.
  const double inertia = 0.2 / 12 * (0.04 + 4e-4) + 0.2 * 0.01;
  EXPECT_NEAR(engine_->joint_position(0), 0.5 * 0.01 * 0.2 * 9.81 * 0.1 / inertia, 0.015);
  EXPECT_LT(engine_->body(0).X_WB.translation().norm(), 1e-9);
}

TEST_P(EachEngine, JawsMoveTogether) {
  EngineScene scene = pressed_cube(false);
  scene.bodies[0].collides = false;
  scene.joints[1].follows = 0;
  scene.joints[1].ratio = 0.5;
  EngineScene with_pads = pressed_cube(true);
  with_pads.pad_method = PadMethod::kOwnContacts;
  with_pads.joints = scene.joints;
  if (GetParam() != "mujoco") {
    EXPECT_THROW(EngineRegistry().create(GetParam())->load(with_pads), UnsupportedScene);
  }
  if (!load(scene, "follow")) return;
  engine_->set_joint_force(0, 0.1);
  run(0.1);
  EXPECT_GT(engine_->joint_position(0), 0.005);
  EXPECT_NEAR(engine_->joint_position(1), 0.5 * engine_->joint_position(0), precision(GetParam()));
}

TEST_P(EachEngine, ABoxRestsOnTheGround) {
  EngineScene scene;
  scene.ground = true;
  scene.bodies = {box(0.4, {0.06, 0.06, 0.04}, {0, 0, 0.0205})};
  if (!load(scene, "rest")) return;
  run(1);
  const BodyMotion motion = engine_->body(0);
  EXPECT_NEAR(motion.X_WB.translation().z(), 0.02, 1e-3);
  EXPECT_LT(motion.velocity.norm(), 2e-3);
  EXPECT_GT(motion.X_WB.linear()(2, 2), 0.9999);
}

TEST_P(EachEngine, ABallComesToRestOnTheGround) {
  EngineScene scene;
  scene.ground = true;
  scene.bodies = {body_of(EngineShape::Kind::kSphere, 0.2, {0, 0, 0.05})};
  scene.bodies[0].shape.kind = EngineShape::Kind::kSphere;
  scene.bodies[0].shape.radius = 0.03;
  if (!load(scene, "ball")) return;
  run(2);
  EXPECT_NEAR(engine_->body(0).X_WB.translation().z(), 0.03, 1.5e-3);
}

// Gravity is tilted instead of the ground.
TEST_P(EachEngine, SlidesBeyondTheFrictionAngle) {
  for (const double angle : {0.35, 0.65}) {
    EngineScene scene;
    scene.ground = true;
    scene.ground_friction = 0.5;
    scene.gravity = 9.81 * Eigen::Vector3d(std::sin(angle), 0, -std::cos(angle));
    scene.bodies = {box(0.4, {0.1, 0.1, 0.02}, {0, 0, 0.01})};
    if (!load(scene, "slope")) return;
    run(0.2);
    const double before = engine_->body(0).velocity.x();
    run(0.3);
    const double gained = (engine_->body(0).velocity.x() - before) / 0.3;
    if (angle < std::atan(0.5)) {
      EXPECT_NEAR(gained, 0, 0.02);
      EXPECT_LT(engine_->body(0).X_WB.translation().x(), 0.01);
    } else {
      EXPECT_NEAR(gained, 9.81 * (std::sin(angle) - 0.5 * std::cos(angle)),
                  GetParam() == "bullet" ? 0.15 : 0.1);
    }
  }
}

double total(const std::vector<double>& forces) {
  return std::accumulate(forces.begin(), forces.end(), 0.0);
}

TEST_P(EachEngine, PadsFeelThePress) {
  EngineScene scene = pressed_cube(true);
  scene.gravity.setZero();
  if (!load(scene, "pads")) return;
  for (const int joint : {0, 1}) engine_->set_joint_force(joint, 3);
  run(0.2);
  for (const int pad : {0, 1}) {
    const auto forces = engine_->pad_forces(pad);
    ASSERT_EQ(forces.size(), 84u);
    EXPECT_NEAR(total(forces), 3, 0.03);
  }
}

// MuJoCo's own contacts, one for each texel; others refuse them.
TEST_P(EachEngine, OwnContactsFeelThePress) {
  EngineScene scene = pressed_cube(true);
  scene.gravity.setZero();
  scene.pad_method = PadMethod::kOwnContacts;
  if (!load(scene, "own_contacts")) return;
  for (const int joint : {0, 1}) engine_->set_joint_force(joint, 3);
  run(0.2);
  for (const int pad : {0, 1}) EXPECT_NEAR(total(engine_->pad_forces(pad)), 3, 0.03);
}

// Single precision knows positions of centimetres to some nanometres.
TEST_P(EachEngine, PadsBearAStaticLoad) {
  EngineScene scene;
  scene.bodies = {box(0.3, {0.05, 0.05, 0.05}, {0, 0, 0.0249}),
                  box(1, {0.06, 0.06, 0.02}, {0, 0, -0.01})};
  scene.bodies[1].is_fixed = true;
  EnginePad pad;
  pad.body = 1;
  pad.X_BP.translation().z() = 0.01;
  scene.pads = {pad};
  if (!load(scene, "load")) return;
  run(0.5);
  const double weight = 0.3 * 9.81, tolerance = GetParam() == "bullet" ? 1e-3 : 1e-6;
  EXPECT_NEAR(total(engine_->pad_forces(0)), weight, tolerance * weight);
  const double depth = 0.025 - engine_->body(0).X_WB.translation().z();
  EXPECT_NEAR(depth, weight / 84e3, tolerance * weight / 84e3 + 0.1 * tolerance * 1e-4);
}

// A plate of 0.3 kg on a rail sinks onto a fixed half-ball of foam until the integral over the cap,
// pi R k' d^2, bears it (tests/contact/curved_pads_test.cpp).
TEST_P(EachEngine, ARoundPadBearsAStaticLoad) {
  constexpr double kRadius = 0.01;
  geometry::TriangleMesh ball = geometry::make_sphere(kRadius, 128);
  std::erase_if(ball.triangles, [&](const Eigen::Vector3i& t) {
    return ball.vertices[t[0]].z() + ball.vertices[t[1]].z() + ball.vertices[t[2]].z() < 0;
  });
  EngineScene scene;
  scene.bodies = {box(0.3, {0.05, 0.05, 0.02}, {0, 0, 0.0199}),
                  box(1, {0.01, 0.01, 0.01}, {0, 0, -0.02})};
  for (EngineBody& body : scene.bodies) body.friction = 1e-3;
  scene.bodies[1].is_fixed = true;
  EngineJoint rail;
  rail.body = 0;
  rail.axis_W = Eigen::Vector3d::UnitZ();
  scene.joints = {rail};
  EnginePad pad;
  pad.body = 1;
  pad.X_BP.translation().z() = 0.02;
  pad.layout = contact::PadLayout::curved(ball, 0.003);
  scene.pads = {pad};
  if (!load(scene, "load")) return;
  run(0.5);
  const double weight = 0.3 * 9.81;
  const double depth = kRadius + 0.01 - engine_->body(0).X_WB.translation().z();
  const double stiffness = pad.law.stiffness / contact::kReferenceTexelArea;
  EXPECT_NEAR(M_PI * kRadius * stiffness * depth * depth, weight, 0.03 * weight);
  // Texels press along their normals: their sum is a little more than what they bear.
  const double sum = total(engine_->pad_forces(0));
  EXPECT_GT(sum, weight);
  EXPECT_LT(sum, 1.1 * weight);
}

TEST_P(EachEngine, PadsHoldACube) {
  EngineScene scene = pressed_cube(true);
  for (EnginePad& pad : scene.pads) {
    pad.law.bristle_law = contact::BristleLaw::kElastoPlastic;
    pad.law.return_map = true;
  }
  if (!load(scene, "hold")) return;
  for (const int joint : {0, 1}) engine_->set_joint_force(joint, 3);
  run(0.3);
  const BodyMotion before = engine_->body(0);
  // The bristles of 168 texels give way by the weight over their stiffness.
  const double sag = 0.05 * 9.81 / (168 * 200.0);
  EXPECT_NEAR(before.X_WB.translation().z(), -sag, 0.02 * sag);
  EXPECT_NEAR(total(engine_->pad_forces(0)), 3, 1e-3);
  EXPECT_NEAR(total(engine_->pad_forces(1)), 3, 1e-3);
  run(0.1);
  const BodyMotion after = engine_->body(0);
  EXPECT_LT((after.X_WB.translation() - before.X_WB.translation()).norm(), 1e-7) << "no creep";
}

// A ball thrown on a pad comes back slower than it came.
TEST_P(EachEngine, PadsTakeEnergyFromAnImpact) {
  EngineScene scene;
  scene.gravity.setZero();
  scene.bodies = {body_of(EngineShape::Kind::kSphere, 0.1, {0, 0, 0.021}),
                  box(0.05, {0.05, 0.05, 0.02}, {0, 0, -0.01})};
  scene.bodies[0].shape.kind = EngineShape::Kind::kSphere;
  scene.bodies[0].shape.radius = 0.02;
  scene.bodies[0].velocity.z() = -0.3;
  EngineJoint slide;
  slide.body = 1;
  slide.axis_W = Eigen::Vector3d::UnitZ();
  scene.joints = {slide};
  EnginePad pad;
  pad.body = 1;
  pad.X_BP.translation().z() = 0.01;
  scene.pads = {pad};
  if (!load(scene, "impact")) return;
  double most = 0;
  for (int i = 0; i < 100; ++i) {
    engine_->step();
    most = std::max(most, total(engine_->pad_forces(0)));
    const double v1 = engine_->body(0).velocity.z(), v2 = engine_->body(1).velocity.z();
    EXPECT_NEAR(0.1 * v1 + 0.05 * v2, -0.03, momentum_precision(GetParam())) << "momentum";
    EXPECT_LE(0.5 * (0.1 * v1 * v1 + 0.05 * v2 * v2), 0.0045 + precision(GetParam())) << "energy";
  }
  EXPECT_GT(most, 1);
  EXPECT_GT(engine_->body(0).velocity.z(), -0.3);
}

// Light objects between light jaws are within reach of every solver; eval_hold has the hard cases.
TEST_P(EachEngine, SavedStateContinues) {
  EngineScene scene = pressed_cube(false);
  if (!load(scene, "hold_rigid")) return;
  for (const int joint : {0, 1}) engine_->set_joint_force(joint, 3);
  run(0.2);
  const std::vector<double> saved = engine_->save();
  run(0.2);
  const Eigen::Matrix4d first = engine_->body(0).X_WB.matrix();
  engine_->restore(saved);
  run(0.2);
  EXPECT_LT((engine_->body(0).X_WB.matrix() - first).norm(), GetParam() == "bullet" ? 1e-3 : 1e-9)
      << "Bullet does not give away the impulses it starts from";
  EXPECT_LT(engine_->body(0).X_WB.translation().norm(), 0.02) << "held, or nearly";
  EXPECT_THROW(engine_->restore({1, 2, 3}), std::invalid_argument);
}

TEST_P(EachEngine, NothingAndOnlyFixedBodiesStandStill) {
  EngineScene scene;
  if (!load(scene, "empty")) return;
  run(0.01);
  scene.ground = true;
  scene.bodies = {box(1, {0.05, 0.05, 0.05}, {0, 0, 1}), box(1, {0.1, 0.1, 0.1}, {0, 0, 1.02})};
  for (EngineBody& body : scene.bodies) body.is_fixed = true;
  if (!load(scene, "fixed")) return;
  run(0.01);
  EXPECT_LT((engine_->body(0).X_WB.translation() - Eigen::Vector3d(0, 0, 1)).norm(), 1e-9);
  EXPECT_EQ(engine_->body(0).velocity.norm(), 0);
}

TEST_P(EachEngine, RefusesAnUnknownSolver) {
  EngineScene scene = pressed_cube(false);
  scene.solver = "magic";
  const auto engine = EngineRegistry().create(GetParam());
  EXPECT_THROW(engine->load(scene), UnsupportedScene);
}

INSTANTIATE_TEST_SUITE_P(Installed, EachEngine, ::testing::ValuesIn(EngineRegistry().names()),
                         [](const auto& engine) { return engine.param; });

TEST(SubsteppedPads, RefusesWhatNoSubstepKeepsStable) {
  EngineScene scene = pressed_cube(true);
  const double limit = substep_limit(scene);
  // Two whole pads on 50 g, which turns too, and a jaw of 50 g: C = 84 10 (2 2.5 + 1) / 0.05.
  EXPECT_NEAR(limit, 4 / (100800 + std::sqrt(100800.0 * 100800 + 12 * 10080000.0)), 1e-12);
  scene.bodies[0].mass = 1e-6;
  for (const std::string& name : EngineRegistry().names()) {
    const auto engine = EngineRegistry().create(name);
    if (name == "native") {
      EXPECT_NO_THROW(engine->load(scene));
      continue;
    }
    try {
      engine->load(scene);
      FAIL() << name;
    } catch (const UnsupportedScene& reason) {
      EXPECT_NE(std::string(reason.what()).find("native"), std::string::npos) << reason.what();
    }
  }
}

TEST(EngineScene, RefusesBadValuesByName) {
  const auto refused = [](auto change, const std::string& name) {
    EngineScene scene = pressed_cube(true);
    change(scene);
    try {
      validate(scene);
      FAIL() << name << " was accepted";
    } catch (const std::invalid_argument& error) {
      EXPECT_NE(std::string(error.what()).find(name), std::string::npos) << error.what();
    }
  };
  refused([](EngineScene& s) { s.step = 0; }, "step");
  refused([](EngineScene& s) { s.bodies[0].mass = 0; }, "mass");
  refused([](EngineScene& s) { s.bodies[1].friction = -1; }, "friction");
  refused([](EngineScene& s) { s.bodies[1].moments = {1, 0, 1}; }, "moments");
  refused([](EngineScene& s) { s.bodies[0].X_BS.translation().x() = 1; }, "moments");
  refused([](EngineScene& s) { s.joints[0].follows = 0; }, "follows");
  refused([](EngineScene& s) { s.joints[1].ratio = std::nan(""); }, "ratio");
  refused([](EngineScene& s) { s.bodies[1].is_fixed = true; }, "joint 0.body");
  refused([](EngineScene& s) { s.bodies[1].shape.size.x() = std::nan(""); }, "size");
  refused([](EngineScene& s) { s.joints[0].body = 7; }, "joint 0.body");
  refused([](EngineScene& s) { s.joints[1].body = 1; }, "joined once");
  refused([](EngineScene& s) { s.joints[0].axis_W *= 2; }, "axis_W");
  refused([](EngineScene& s) { s.pads[0].law.stiffness = -1; }, "stiffness");
}

}  // namespace
}  // namespace prehend::simulation::engines
