// Bodies of convex pieces on every engine that is installed. `native` has them between pads alone.

#include <cmath>

#include <gtest/gtest.h>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include "prehend/simulation/engines/registry.h"
#include "prehend/surface/convex_pieces.h"
#include "tests/simulation/engine_scenes.h"
#include "tests/surface/sampled_solid.h"

namespace prehend::simulation::engines {
namespace {

using geometry::RigidTransform;
using geometry::TriangleMesh;

constexpr double kGravity = 9.81;  // m/s^2

EngineShape in_pieces(std::vector<TriangleMesh> pieces) {
  EngineShape shape;
  shape.kind = EngineShape::Kind::kConvexPieces;
  shape.pieces = std::make_shared<const std::vector<TriangleMesh>>(std::move(pieces));
  return shape;
}

// `box` as a mesh whose frame S stands askew to the body, with the box's own moments.
EngineBody as_mesh(EngineBody box) {
  RigidTransform X_SB = RigidTransform::Identity();
  X_SB.linear() = Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  X_SB.translation() = Eigen::Vector3d(0.02, -0.01, 0.03);
  const Eigen::Vector3d s = box.shape.size.cwiseAbs2();
  box.moments = box.mass / 12 * Eigen::Vector3d(s.y() + s.z(), s.x() + s.z(), s.x() + s.y());
  box.shape = in_pieces({geometry::transformed(geometry::make_box(box.shape.size), X_SB)});
  box.X_BS = X_SB.inverse(Eigen::Isometry);
  return box;
}

// An L of three cubes of `side`, made by the decomposition; its profile in x and z, its centre of
// mass 5/6 sides over and right of its corner.
constexpr double kSide = 0.04;  // m
EngineBody l_body(const RigidTransform& X_WCorner) {
  RigidTransform X_CornerMesh = RigidTransform::Identity();
  X_CornerMesh.linear() = Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitX()).toRotationMatrix();
  X_CornerMesh.translation().y() = kSide / 2;
  const TriangleMesh mesh = geometry::transformed(surface::make_l_shape(kSide), X_CornerMesh);
  const geometry::MassProperties solid = geometry::mass_properties(mesh);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(solid.unit_density_inertia);
  RigidTransform X_CornerB = RigidTransform::Identity();
  X_CornerB.linear() = axes.eigenvectors();
  if (X_CornerB.linear().determinant() < 0) X_CornerB.linear().col(0) *= -1;
  X_CornerB.translation() = solid.center_of_mass;
  EngineBody body;
  body.name = "L";
  body.mass = 0.2;
  body.moments = body.mass / solid.volume * axes.eigenvalues();
  body.shape = in_pieces(surface::convex_pieces(mesh).pieces);
  body.X_BS = X_CornerB.inverse(Eigen::Isometry);
  body.X_WB = X_WCorner * X_CornerB;
  return body;
}

class PiecesOn : public ::testing::TestWithParam<std::string> {
 protected:
  // False for `native`, which says so.
  bool load(const EngineScene& scene) {
    validate(scene);
    engine_ = EngineRegistry().create(GetParam());
    step_ = scene.step;
    if (GetParam() != "native") {
      engine_->load(scene);
      return true;
    }
    try {
      engine_->load(scene);
      ADD_FAILURE() << "native took pieces";
    } catch (const UnsupportedScene& reason) {
      EXPECT_NE(std::string(reason.what()).find("convex pieces"), std::string::npos)
          << reason.what();
    }
    return false;
  }
  void run(double seconds) {
    for (long i = 0; i < std::lround(seconds / step_); ++i) engine_->step();
  }
  // Height over the ground of what started with its centre of mass at the body's origin.
  double height(int body = 0) const { return engine_->body(body).X_WB.translation().z(); }

  std::unique_ptr<Engine> engine_;
  double step_ = 0;
};

TEST_P(PiecesOn, AMeshBoxFallsAndRestsAsTheBoxThatItIs) {
  EngineScene scene;
  scene.ground = true;
  scene.bodies = {as_mesh(box(0.4, {0.06, 0.08, 0.04}, {0.1, -0.2, 0.03}))};
  if (!load(scene)) return;
  run(0.03);
  EXPECT_NEAR(height(), 0.03 - 0.5 * kGravity * 0.03 * 0.03, 0.5 * step_ * kGravity * 0.03 + 2e-5);
  run(1);
  const RigidTransform settled = engine_->body(0).X_WB;
  EXPECT_NEAR(height(), 0.02, 5e-4);
  EXPECT_GT(settled.linear()(2, 2), 0.9999) << "flat";
  run(2);
  const RigidTransform later = engine_->body(0).X_WB;
  // In single precision Bullet's primitive box creeps by 0.6 mm in the same time.
  EXPECT_LT((later.translation() - settled.translation()).norm(),
            GetParam() == "bullet" ? 1e-3 : 1e-4)
      << "no drift";
  EXPECT_LT((later.linear() - settled.linear()).norm(), 1e-3) << "no turning";
}

TEST_P(PiecesOn, MeshBoxesStandOnOneAnother) {
  EngineScene scene;
  scene.ground = true;
  scene.bodies = {as_mesh(box(0.4, {0.08, 0.08, 0.04}, {0, 0, 0.02})),
                  as_mesh(box(0.2, {0.05, 0.06, 0.03}, {0.005, 0, 0.055})),
                  box(0.1, {0.03, 0.03, 0.03}, {0.005, 0, 0.085})};
  if (!load(scene)) return;
  run(2);
  EXPECT_NEAR(height(0), 0.02, 5e-4);
  EXPECT_NEAR(height(1), 0.055, 1e-3);
  EXPECT_NEAR(height(2), 0.085, 1.5e-3);
  for (int b = 0; b < 3; ++b) {
    EXPECT_GT(engine_->body(b).X_WB.linear()(2, 2), 0.999) << b;
    EXPECT_LT(engine_->body(b).velocity.norm(), 5e-3) << b;
  }
}

// Gravity is tilted instead of the ground.
TEST_P(PiecesOn, AMeshBoxSlidesBeyondTheFrictionAngle) {
  for (const double angle : {0.35, 0.65}) {
    EngineScene scene;
    scene.ground = true;
    scene.ground_friction = 0.5;
    scene.gravity = kGravity * Eigen::Vector3d(std::sin(angle), 0, -std::cos(angle));
    scene.bodies = {as_mesh(box(0.4, {0.1, 0.1, 0.02}, {0, 0, 0.01}))};
    if (!load(scene)) return;
    run(0.2);
    const double before = engine_->body(0).velocity.x();
    run(0.3);
    const double gained = (engine_->body(0).velocity.x() - before) / 0.3;
    const double slope = kGravity * (std::sin(angle) - 0.5 * std::cos(angle));
    EXPECT_NEAR(gained, std::max(0.0, slope), angle > std::atan(0.5) ? 0.15 : 0.02);
  }
}

// Jaws of 3 N with friction 0.8 bear up to 4.8 N.
TEST_P(PiecesOn, AMeshBoxIsHeldWhileItsWeightIsWithinFriction) {
  EngineScene scene = pressed_cube(false);
  scene.bodies[0] = as_mesh(scene.bodies[0]);
  const double friction = 2 * 0.8 * 3;
  for (const double mass : {0.05, 1.0}) {
    scene.bodies[0].mass = mass;
    scene.bodies[0].moments.setConstant(mass / 6 * 0.05 * 0.05);
    if (!load(scene)) return;
    for (const int joint : {0, 1}) engine_->set_joint_force(joint, 3);
    run(0.02);
    const double z = height(), before = engine_->body(0).velocity.z();
    run(0.05);
    const double gained = (engine_->body(0).velocity.z() - before) / 0.05;
    if (mass * kGravity < friction) {
      EXPECT_NEAR(height(), z, 1e-3) << "held";
    } else {
      EXPECT_NEAR(gained, -(kGravity - friction / mass), 0.1 * kGravity) << "slides";
    }
  }
}

// Standing on the end of one leg, the L's centre of mass is 1/6 side within the edge and 7/6 over
// it: it falls over beyond atan(1/7). Were the dent filled it would fall beyond 5.0 degrees.
TEST_P(PiecesOn, AnLFallsWhereItsCentreOfMassTakesIt) {
  const double critical = std::atan(1.0 / 7);
  for (const double tilt : {0.8 * critical, 1.2 * critical}) {
    // Upside down, tilted about the edge of the leg's end on the side of the other leg.
    RigidTransform X_WCorner = RigidTransform::Identity();
    X_WCorner.linear() = (Eigen::AngleAxisd(tilt, Eigen::Vector3d::UnitY()) *
                          Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX()))
                             .toRotationMatrix();
    const Eigen::Vector3d edge(kSide, 0, 2 * kSide);
    X_WCorner.translation() = Eigen::Vector3d(0, 0, 1e-5) - X_WCorner.linear() * edge;
    EngineScene scene;
    scene.ground = true;
    scene.bodies = {l_body(X_WCorner)};
    if (!load(scene)) return;
    run(3);
    const double stands = 7.0 / 6 * kSide, lies = 4 / (3 * std::sqrt(2.0)) * kSide;
    EXPECT_NEAR(height(), tilt < critical ? stands : lies, 1e-3) << tilt;
    EXPECT_LT(engine_->body(0).velocity.norm(), 0.01);
  }
}

// Pieces may fill 4 mm of it; the hull would carry the box 2 cm higher, and not for long.
TEST_P(PiecesOn, ABoxComesToRestInTheDentOfAnL) {
  EngineScene scene;
  scene.ground = true;
  scene.bodies = {l_body(RigidTransform::Identity()),
                  box(0.05, {0.02, 0.02, 0.02}, {1.5 * kSide, 0, 1.6 * kSide})};
  scene.bodies[0].is_fixed = true;
  if (!load(scene)) return;
  run(1);
  EXPECT_NEAR(height(1), kSide + 0.01, 0.005);
  EXPECT_NEAR(engine_->body(1).X_WB.translation().x(), 1.5 * kSide, 0.005);
}

TEST_P(PiecesOn, ASavedStateContinues) {
  EngineScene scene;
  scene.ground = true;
  scene.bodies = {as_mesh(box(0.4, {0.06, 0.08, 0.04}, {0, 0, 0.0205}))};
  if (!load(scene)) return;
  run(0.3);
  const std::vector<double> saved = engine_->save();
  run(0.2);
  const Eigen::Matrix4d first = engine_->body(0).X_WB.matrix();
  engine_->restore(saved);
  run(0.2);
  EXPECT_LT((engine_->body(0).X_WB.matrix() - first).norm(), GetParam() == "bullet" ? 1e-3 : 1e-9);
}

// Pads feel a mesh's faces on every engine, by the texel law.
TEST_P(PiecesOn, PadsFeelAMeshBoxAsTheBox) {
  EngineScene scene = pressed_cube(true);
  scene.gravity.setZero();
  std::vector<double> sums[2];
  for (const bool mesh : {false, true}) {
    if (mesh) scene.bodies[0] = as_mesh(scene.bodies[0]);
    validate(scene);
    const auto engine = EngineRegistry().create(GetParam());
    engine->load(scene);
    for (const int joint : {0, 1}) engine->set_joint_force(joint, 3);
    for (int i = 0; i < 200; ++i) engine->step();
    sums[mesh ? 1 : 0] = engine->pad_forces(0);
  }
  for (std::size_t t = 0; t < sums[0].size(); ++t) EXPECT_NEAR(sums[1][t], sums[0][t], 1e-3) << t;
}

INSTANTIATE_TEST_SUITE_P(Engines, PiecesOn, ::testing::ValuesIn(EngineRegistry().names()),
                         [](const auto& engine) { return engine.param; });

TEST(EnginePieces, HostileOnesAreRefusedByName) {
  const TriangleMesh good = geometry::make_box({0.05, 0.05, 0.05});
  const auto refused = [&](std::vector<TriangleMesh> pieces, const std::string& rule) {
    EngineScene scene;
    scene.bodies = {as_mesh(box(0.1, {0.05, 0.05, 0.05}, {0, 0, 0}))};
    scene.bodies[0].shape = in_pieces(std::move(pieces));
    try {
      validate(scene);
      FAIL() << rule;
    } catch (const std::invalid_argument& error) {
      const std::string what = error.what();
      EXPECT_NE(what.find("body 'body'.pieces"), std::string::npos) << what;
      EXPECT_NE(what.find(rule), std::string::npos) << what;
    }
  };
  refused({}, "at least one");
  refused({good, TriangleMesh{}}, "pieces[1] must be a closed mesh");
  TriangleMesh open = good;
  open.triangles.pop_back();
  refused({open}, "closed");
  TriangleMesh wild = good;
  wild.triangles[0].x() = 99;
  refused({wild}, "closed");
  TriangleMesh nan = good;
  nan.vertices[3].y() = std::nan("");
  refused({nan}, "finite");
  TriangleMesh inside_out = good;
  for (Eigen::Vector3i& t : inside_out.triangles) std::swap(t.x(), t.y());
  refused({inside_out}, "outward");
  refused({geometry::make_box({0.05, 0.05, 1e-12})}, "solid");
  refused({surface::make_l_shape(0.05)}, "convex");
  EngineScene scene;
  scene.bodies = {as_mesh(box(0.1, {0.05, 0.05, 0.05}, {0, 0, 0}))};
  scene.bodies[0].moments.setZero();
  EXPECT_THROW(validate(scene), std::invalid_argument) << "pieces do not tell the moments";
  scene.bodies[0].moments.setOnes();
  scene.bodies[0].shape.pieces.reset();
  EXPECT_THROW(validate(scene), std::invalid_argument);
}

// Thin as they may be, pieces are taken or refused in words.
TEST_P(PiecesOn, ThinPiecesAreTakenOrRefused) {
  for (const double thickness : {1e-3, 1e-5, 2e-7}) {
    EngineScene scene;
    scene.ground = true;
    EngineBody plate = as_mesh(box(0.1, {0.05, 0.05, thickness}, {0, 0, 0.01}));
    plate.moments.setConstant(plate.mass / 12 * 0.05 * 0.05);
    scene.bodies = {plate};
    validate(scene);
    const auto engine = EngineRegistry().create(GetParam());
    try {
      engine->load(scene);
      for (int i = 0; i < 50; ++i) engine->step();
      EXPECT_TRUE(engine->body(0).X_WB.matrix().allFinite());
    } catch (const UnsupportedScene& reason) {
      EXPECT_EQ(std::string(reason.what()).find(GetParam()), 0u) << reason.what();
    }
  }
}

}  // namespace
}  // namespace prehend::simulation::engines
