// prehend's own engine on several bodies that touch: invariants, stacks, heaps, rolling, pads.

#include <cmath>
#include <random>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "prehend/simulation/engines/native_engine.h"
#include "tests/simulation/engine_scenes.h"

namespace prehend::simulation::engines {
namespace {

TEST(Multibody, AFreelySpinningBodyKeepsItsMomenta) {
  for (const char* solver : {"first_order", "second_order"}) {
    EngineScene scene;
    scene.step = 5e-3;
    scene.solver = solver;
    scene.gravity.setZero();
    scene.bodies = {box(0.5, {0.1, 0.06, 0.02}, {0, 0, 0})};
    scene.bodies[0].velocity = {1, 2, 3};
    scene.bodies[0].angular_velocity = {3, 8, 1};  // near the unstable axis
    const auto engine = loaded(scene);
    const Vector6 before = engine->state().momenta[0];
    const double energy = engine->energy();
    run(*engine, scene, 2);
    EXPECT_LT((engine->state().momenta[0] - before).norm(), 1e-10 * before.norm());
    EXPECT_LE(engine->energy(), energy * (1 + 1e-9));
  }
}

TEST(Multibody, CollidingBodiesKeepMomentumAndGainNoEnergy) {
  for (const double step : {1e-2, 1e-3, 1e-4}) {
    EngineScene scene;
    scene.step = step;
    scene.gravity.setZero();
    // Boxes, corner first, with friction; a capsule and a cylinder beside them.
    scene.bodies = {box(0.5, {0.05, 0.05, 0.05}, {-0.08, 0, 0}),
                    box(0.1, {0.05, 0.05, 0.05}, {0.05, 0.01, 0.005}),
                    body_of(EngineShape::Kind::kCapsule, 0.2, {0.2, 0, 0}),
                    body_of(EngineShape::Kind::kCylinder, 0.3, {0.3, 0.02, 0.01})};
    scene.bodies[0].X_WB.linear() =
        Eigen::AngleAxisd(0.6, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
    scene.bodies[0].velocity.x() = 1;
    scene.bodies[2].velocity.x() = -0.4;
    scene.bodies[3].velocity.x() = -1;
    const auto engine = loaded(scene);
    const auto momentum = [&] {
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      for (const Vector6& p : engine->state().momenta) sum += p.head<3>();
      return sum;
    };
    const Eigen::Vector3d before = momentum();
    const double at_first = engine->energy();
    double energy = at_first;
    bool touched = false;
    for (int i = 0; i < std::lround(0.5 / step); ++i) {
      engine->step();
      touched = touched || engine->body(1).velocity.norm() > 0.01;
      // 0.88 kg m/s go to and fro.
      EXPECT_LT((momentum() - before).norm(), 1e-12 * 0.88);
      // What springs took for a moment they give back; critically damped, e^-2 of an impact's.
      EXPECT_LE(engine->energy(), energy + 0.135 * at_first) << "step " << step << ", " << i;
      energy = std::min(energy, engine->energy());
    }
    EXPECT_TRUE(touched);
  }
}

// The design's claim for direct solvers: any ratio of masses, steps of 10 ms.
TEST(Multibody, HeavyBodiesStandOnLightOnes) {
  for (const double step : {1e-2, 1e-3}) {
    for (const char* solver : {"first_order", "second_order"}) {
      EngineScene scene;
      scene.step = step;
      scene.solver = solver;
      scene.ground = true;
      scene.bodies = {box(0.001, {0.05, 0.05, 0.05}, {0, 0, 0.025}),
                      box(0.1, {0.05, 0.05, 0.05}, {0.005, 0, 0.075}),
                      box(10, {0.05, 0.05, 0.05}, {0, 0.005, 0.125})};
      const auto engine = loaded(scene);
      run(*engine, scene, 1);
      const Eigen::Vector3d before = engine->body(2).X_WB.translation();
      run(*engine, scene, 1);
      for (int b = 0; b < 3; ++b) {
        const BodyMotion motion = engine->body(b);
        EXPECT_NEAR(motion.X_WB.translation().z(), 0.025 + 0.05 * b, 1e-4) << step << solver << b;
        EXPECT_LT(motion.velocity.norm(), 1e-5) << step << solver << b;
        EXPECT_GT(motion.X_WB.linear()(2, 2), 0.9999);
      }
      EXPECT_LT((engine->body(2).X_WB.translation() - before).norm(), 1e-6) << "no creep";
    }
  }
}

// Boxes, balls, rods and pills of 10 g to 1 kg thrown on a heap with steps of 10 ms: none sinks
// into the ground or into another, and energy falls only.
TEST(Multibody, AHeapOfMixedBodiesGainsNoEnergy) {
  for (const char* solver : {"first_order", "second_order"}) {
    for (const double step : {1e-2, 2e-3}) {
      EngineScene scene;
      scene.step = step;
      scene.solver = solver;
      scene.ground = true;
      std::mt19937 random(3);
      std::uniform_real_distribution<double> uniform;
      for (int i = 0; i < 10; ++i) {
        EngineBody body =
            body_of(static_cast<EngineShape::Kind>(i % 4), std::pow(10.0, -2 + 2 * uniform(random)),
                    {0.03 * uniform(random), 0.03 * uniform(random), 0.1 + 0.14 * i});
        for (int k = 0; k < 3; ++k) body.shape.size[k] = 0.03 + 0.04 * uniform(random);
        body.shape.radius = 0.015 + 0.02 * uniform(random);
        body.shape.length = 0.03 + 0.05 * uniform(random);
        const double x = uniform(random), y = uniform(random), z = uniform(random);
        body.X_WB.linear() = Eigen::Quaterniond(0.5, x, y, z).normalized().toRotationMatrix();
        body.velocity.z() = -uniform(random);
        scene.bodies.push_back(body);
      }
      const auto engine = loaded(scene);
      const double at_first = engine->energy();
      double before = at_first, deepest = 0;
      for (int i = 0; i < std::lround(1.5 / step); ++i) {
        engine->step();
        EXPECT_LT(engine->energy(), before + 0.01 * at_first) << solver << step << ' ' << i;
        before = engine->energy();
        for (const TouchPoint& touch : engine->state().touches) {
          deepest = std::max(deepest, touch.at.depth);
        }
      }
      EXPECT_LT(before, 0.3 * at_first) << "they have fallen";
      // What turns fast is met late: by a share of the way that its corners go in a step.
      EXPECT_LT(deepest, step > 5e-3 ? 0.025 : 0.015) << solver << step;
      for (int b = 0; b < 10; ++b) {
        EXPECT_GT(engine->body(b).X_WB.translation().z(), 0.01) << solver << step << ' ' << b;
      }
    }
  }
}

// What stands in one another at the start parts slowly.
TEST(Multibody, DeepOverlapsPartWithoutABang) {
  for (const double step : {1e-2, 1e-3}) {
    EngineScene scene;
    scene.step = step;
    scene.gravity.setZero();
    scene.bodies = {box(0.2, {0.05, 0.05, 0.05}, {0, 0, 0}),
                    box(0.1, {0.05, 0.05, 0.05}, {0.03, 0, 0})};
    const auto engine = loaded(scene);
    double fastest = 0;
    for (int i = 0; i < std::lround(2 / step); ++i) {
      engine->step();
      fastest = std::max(fastest, engine->body(1).velocity.norm());
    }
    EXPECT_LT(fastest, 0.2);
    const double apart =
        (engine->body(1).X_WB.translation() - engine->body(0).X_WB.translation()).norm();
    EXPECT_GT(apart, 0.0499);
  }
}

// Without slip at last: v = 5/7 v0 on a ball that slides at first.
TEST(Multibody, ASlidingBallComesToRoll) {
  for (const double step : {1e-2, 1e-3}) {
    EngineScene scene;
    scene.step = step;
    scene.ground = true;
    scene.bodies = {body_of(EngineShape::Kind::kSphere, 0.1, {0, 0, 0.025})};
    scene.bodies[0].velocity.x() = 0.7;
    const auto engine = loaded(scene);
    run(*engine, scene, 0.5);
    const BodyMotion motion = engine->body(0);
    EXPECT_NEAR(motion.velocity.x(), 0.5, 0.002);
    EXPECT_NEAR(motion.angular_velocity.y(), 0.5 / 0.025, 0.1);
    EXPECT_NEAR(motion.X_WB.translation().z(), 0.025, 2e-5);
  }
}

TEST(Multibody, RigidPlatesHoldACube) {
  for (const double mass : {0.01, 10.0}) {
    for (const double step : {1e-2, 1e-3}) {
      EngineScene scene = pressed_cube(false);
      scene.step = step;
      scene.bodies[0].mass = mass;
      const auto engine = loaded(scene);
      const double weight = mass * 9.81;
      for (const int joint : {0, 1}) engine->set_joint_force(joint, 1.2 * weight / 1.6);
      Vector6 lift = Vector6::Zero();
      lift[2] = weight;
      engine->set_body_wrench(0, lift);
      run(*engine, scene, 0.2);
      engine->set_body_wrench(0, Vector6::Zero());
      run(*engine, scene, 0.5);
      const double before = engine->body(0).X_WB.translation().z();
      run(*engine, scene, 1);
      const double after = engine->body(0).X_WB.translation().z();
      EXPECT_GT(after, -1e-4) << mass << ' ' << step;
      EXPECT_LT(std::abs(after - before), 1e-7) << mass << ' ' << step;
    }
  }
}

TEST(Multibody, PadsAgreeWithTheGraspSystem) {
  EngineScene scene = pressed_cube(true);
  for (EnginePad& pad : scene.pads) pad.law.bristle_law = contact::BristleLaw::kElastoPlastic;
  for (const char* solver : {"first_order", "second_order"}) {
    scene.solver = solver;
    NativeEngine grasp;
    grasp.load(scene);
    EXPECT_NE(grasp.version(), "prehend, multibody");
    const auto engine = loaded(scene);
    for (Engine* each : {static_cast<Engine*>(&grasp), static_cast<Engine*>(engine.get())}) {
      for (const int joint : {0, 1}) each->set_joint_force(joint, 2 + joint);
      run(*each, scene, 0.05);
    }
    const Eigen::Vector3d a = grasp.body(0).X_WB.translation(),
                          b = engine->body(0).X_WB.translation();
    EXPECT_GT(a.norm(), 1e-3) << "uneven forces move it";
    EXPECT_LT((a - b).norm(), 1e-7) << a.transpose() << ", " << b.transpose();
    const auto felt = grasp.pad_forces(0), also = engine->pad_forces(0);
    for (std::size_t i = 0; i < felt.size(); ++i) EXPECT_NEAR(felt[i], also[i], 1e-5);
  }
}

// Jaws with pads on a wrist that moves, a cube on the ground and another one on top of it: beyond
// what the grasp system knows.
TEST(Multibody, AGripperOnAWristLiftsTwoCubes) {
  for (const double step : {1e-2, 1e-3}) {
    EngineScene scene = pressed_cube(true);
    scene.step = step;
    scene.ground = true;
    scene.bodies[0].mass = 0.2;
    // The wrist stands before its jaws.
    scene.bodies.insert(scene.bodies.begin() + 1, box(1, {0.1, 0.1, 0.02}, {0, 0, 0.1}));
    scene.bodies[1].collides = false;
    for (EngineJoint& joint : scene.joints) {
      ++joint.body;
      joint.parent = 1;
    }
    EngineJoint wrist;
    wrist.body = 1;
    wrist.axis_W = Eigen::Vector3d::UnitZ();
    scene.joints.push_back(wrist);
    for (EnginePad& pad : scene.pads) {
      ++pad.body;
      pad.law.bristle_law = contact::BristleLaw::kElastoPlastic;
      pad.law.return_map = true;
    }
    scene.bodies.push_back(box(0.05, {0.03, 0.03, 0.03}, {0.003, 0.002, 0.04}));
    for (EngineBody& body : scene.bodies) body.X_WB.translation().z() += 0.025;
    const auto engine = loaded(scene);
    const auto jaws = [&](double force) {
      for (const int joint : {0, 1}) engine->set_joint_force(joint, force);
    };
    engine->set_joint_force(2, 1.1 * 9.81);  // bears wrist and jaws
    jaws(10);
    run(*engine, scene, 0.2);
    // Up with 0.5 m/s^2: all of 1.35 kg.
    engine->set_joint_force(2, 1.35 * (9.81 + 0.5));
    run(*engine, scene, 0.6);
    const double lifted = 0.25 * 0.36;
    EXPECT_NEAR(engine->joint_position(2), lifted, 0.005);
    EXPECT_NEAR(engine->body(0).X_WB.translation().z(), 0.025 + lifted, 0.005);
    EXPECT_NEAR(engine->body(4).X_WB.translation().z(), 0.065 + lifted, 0.005) << "on top";
    double sum = 0;
    for (const double force : engine->pad_forces(0)) sum += force;
    EXPECT_NEAR(sum, 10, 0.05);
    // Let go: the cubes fall, the wrist goes up.
    jaws(-1);
    run(*engine, scene, 0.3);
    EXPECT_NEAR(engine->body(0).X_WB.translation().z(), 0.025, 1e-3);
    EXPECT_GT(engine->joint_position(2), 0.15);
  }
}

TEST(Multibody, ContinuesBitwiseFromASavedState) {
  for (const char* solver : {"first_order", "second_order"}) {
    EngineScene scene;
    scene.solver = solver;
    scene.ground = true;
    scene.bodies = {box(0.2, {0.05, 0.05, 0.05}, {0, 0, 0.03}),
                    body_of(EngineShape::Kind::kCylinder, 0.1, {0.01, 0, 0.11}),
                    body_of(EngineShape::Kind::kCapsule, 0.1, {-0.02, 0.01, 0.2})};
    scene.bodies[0].velocity.x() = 0.5;
    const auto engine = loaded(scene);
    run(*engine, scene, 0.1);
    const auto saved = engine->save();
    run(*engine, scene, 0.2);
    const auto went_on = engine->save();
    engine->restore(saved);
    run(*engine, scene, 0.2);
    EXPECT_EQ(engine->save(), went_on);
  }
}

TEST(Multibody, RefusesForcesThatAreNoNumbers) {
  EngineScene scene = pressed_cube(false);
  const auto engine = loaded(scene);
  EXPECT_THROW(engine->set_joint_force(0, std::nan("")), std::invalid_argument);
  EXPECT_THROW(engine->set_joint_force(7, 1), std::out_of_range);
  EXPECT_THROW(engine->set_body_wrench(0, Vector6::Constant(1 / 0.0)), std::invalid_argument);
}

// Sizes from 1 mm to 1 m, masses from 1 mg to 1 t.
TEST(Multibody, TinyAndHugeBodiesComeToRest) {
  for (const auto& [size, mass] : {std::pair{1e-3, 1e-6}, {1.0, 1e3}}) {
    EngineScene scene;
    scene.ground = true;
    scene.bodies = {box(mass, {size, size, size}, {0, 0, 0.6 * size}),
                    box(0.1 * mass, {0.5 * size, size, size}, {0, 0, 1.7 * size})};
    const auto engine = loaded(scene);
    run(*engine, scene, 2);
    for (const int body : {0, 1}) {
      EXPECT_NEAR(engine->body(body).X_WB.translation().z(), (0.5 + body) * size, 0.02 * size);
      EXPECT_LT(engine->body(body).velocity.norm(), 1e-6);
    }
  }
}

TEST(NativeEngine, ChoosesTheGraspSystemOnlyForWhatItKnows) {
  EngineScene scene;
  scene.bodies = {box(0.1, {0.05, 0.05, 0.05}, {0, 0, 1})};
  NativeEngine engine;
  engine.load(scene);
  EXPECT_NE(engine.version(), "prehend, multibody");
  scene.bodies.push_back(box(0.1, {0.05, 0.05, 0.05}, {0, 0, 2}));
  engine.load(scene);
  EXPECT_EQ(engine.version(), "prehend, multibody");
  scene.solver = "magic";
  EXPECT_THROW(engine.load(scene), UnsupportedScene);
}

}  // namespace
}  // namespace prehend::simulation::engines
