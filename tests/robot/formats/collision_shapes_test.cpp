// Collision shapes of what is seen of a link.

#include "prehend/robot/formats/collision_shapes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <random>

#include "prehend/geometry/errors.h"

namespace prehend::robot::formats {
namespace {

using geometry::RigidTransform;
using geometry::TriangleMesh;
using ::testing::HasSubstr;

Shape shape_of(TriangleMesh mesh) {
  Shape shape;
  shape.kind = Shape::Kind::kMesh;
  shape.mesh = "seen";
  shape.surface = std::make_shared<const TriangleMesh>(std::move(mesh));
  return shape;
}

RigidTransform somewhere() {
  RigidTransform X = RigidTransform::Identity();
  X.rotate(Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, -1).normalized()));
  X.translation() = Eigen::Vector3d(0.3, -0.2, 0.1);
  return X;
}

LinkDescription link_of(TriangleMesh mesh, const RigidTransform& X_LS = somewhere()) {
  LinkDescription link;
  link.name = "palm";
  link.visuals = {shape_of(std::move(mesh))};
  link.visuals[0].X_LS = X_LS;
  return link;
}

CollisionShapes made(const LinkDescription& link, CollisionKind kind, double concavity = 0.004) {
  ShapeMeshes meshes(".");
  return collision_shapes(link, meshes, kind, concavity);
}

/// How far the farthest vertex that is seen is beyond a shape that is no mesh [m]; inside is below
/// 0.
double beyond(const LinkDescription& link, const Shape& shape) {
  ShapeMeshes meshes(".");
  double worst = -INFINITY;
  for (const Shape& seen : link.visuals) {
    for (const auto& p_L :
         geometry::transformed(meshes.of(seen), shape.X_LS.inverse() * seen.X_LS).vertices) {
      const double across = p_L.head<2>().norm(), along = std::abs(p_L.z()) - shape.length / 2;
      switch (shape.kind) {
        case Shape::Kind::kBox:
          worst = std::max(worst, (p_L.cwiseAbs() - shape.size / 2).maxCoeff());
          break;
        case Shape::Kind::kSphere:
          worst = std::max(worst, p_L.norm() - shape.radius);
          break;
        case Shape::Kind::kCylinder:
          worst = std::max({worst, across - shape.radius, along});
          break;
        default:
          worst = std::max(worst, std::hypot(across, std::max(0.0, along)) - shape.radius);
      }
    }
  }
  return worst;
}

TEST(CollisionShapes, HoldAllThatIsSeenOfAnyShape) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 20; ++i) {
    std::vector<Eigen::Vector3d> cloud(60);
    for (auto& p : cloud) p = {0.05 * normal(random), 0.02 * normal(random), 0.01 * normal(random)};
    const LinkDescription link = link_of(geometry::convex_hull(cloud));
    for (const CollisionKind kind : {CollisionKind::kBox, CollisionKind::kSphere,
                                     CollisionKind::kCylinder, CollisionKind::kCapsule}) {
      const auto shapes = made(link, kind).shapes;
      ASSERT_EQ(shapes.size(), 1U);
      EXPECT_LE(beyond(link, shapes[0]), 1e-9) << collision_kinds()[static_cast<int>(kind)];
      EXPECT_GE(beyond(link, shapes[0]), -1e-3);  // and no more
    }
  }
}

TEST(CollisionShapes, OfABoxIsThatBoxHoweverItStands) {
  const LinkDescription link = link_of(geometry::make_box({0.1, 0.04, 0.02}));
  const Shape box = made(link, CollisionKind::kBox).shapes.at(0);
  Eigen::Vector3d size = box.size;
  std::sort(size.data(), size.data() + 3);
  EXPECT_TRUE(size.isApprox(Eigen::Vector3d(0.02, 0.04, 0.1), 1e-9)) << size.transpose();
  EXPECT_TRUE(box.X_LS.translation().isApprox(somewhere().translation(), 1e-9));
}

TEST(CollisionShapes, OfABallIsThatBall) {
  const LinkDescription link = link_of(geometry::make_sphere(0.05, 48));
  const Shape ball = made(link, CollisionKind::kSphere).shapes.at(0);
  EXPECT_NEAR(ball.radius, 0.05, 0.0005);
  const Shape capsule = made(link, CollisionKind::kCapsule).shapes.at(0);
  EXPECT_NEAR(capsule.radius, 0.05, 0.0005);
  EXPECT_NEAR(capsule.length, 0, 0.0005);
}

TEST(CollisionShapes, PiecesLeaveADentAsDeepAsTheConcavity) {
  // An L of two legs: its hull fills half of what is between them.
  LinkDescription link = link_of(geometry::make_box({0.1, 0.02, 0.02}), RigidTransform::Identity());
  link.visuals.push_back(shape_of(geometry::make_box({0.02, 0.02, 0.1})));
  link.visuals[1].X_LS.translation() = Eigen::Vector3d(-0.04, 0, 0.06);
  const auto volume = [](const CollisionShapes& all) {
    double sum = 0;
    for (const Shape& one : all.shapes) sum += geometry::mass_properties(*one.surface).volume;
    return sum;
  };
  const auto hull = made(link, CollisionKind::kHull),
             pieces = made(link, CollisionKind::kPieces, 0.002);
  EXPECT_EQ(hull.shapes.size(), 1U);
  EXPECT_GT(volume(hull), 1.5 * 8e-5);
  EXPECT_EQ(pieces.shapes.size(), 2U);
  EXPECT_NEAR(volume(pieces), 8e-5, 1e-8);
  EXPECT_EQ(pieces.shapes[1].mesh, "palm_piece_1");
  EXPECT_TRUE(pieces.remarks.empty());
}

TEST(CollisionShapes, SayWhatIsOpenAndRefuseWhatHasNoShape) {
  TriangleMesh open = geometry::make_box({0.1, 0.1, 0.1});
  open.triangles.pop_back();
  const auto pieces = made(link_of(open), CollisionKind::kPieces);
  ASSERT_EQ(pieces.remarks.size(), 1U);
  EXPECT_THAT(pieces.remarks[0], HasSubstr("its mesh 'seen' has 1 holes or cracks: closed"));

  const auto refused = [](const LinkDescription& link, CollisionKind kind) {
    try {
      made(link, kind);
    } catch (const geometry::InputError& error) {
      return std::string(error.what());
    }
    return std::string("taken");
  };
  LinkDescription bare;
  bare.name = "tip";
  EXPECT_THAT(refused(bare, CollisionKind::kBox), HasSubstr("Link 'tip' has nothing that is seen"));
  TriangleMesh flat;
  flat.vertices = {{0, 0, 0}, {0.1, 0, 0}, {0, 0.1, 0}};
  flat.triangles = {{0, 1, 2}};
  EXPECT_EQ(refused(link_of(flat), CollisionKind::kBox), "taken");
  EXPECT_NE(refused(link_of(flat), CollisionKind::kHull), "taken");
  EXPECT_NE(refused(link_of(flat), CollisionKind::kPieces), "taken");
  LinkDescription missing = link_of(flat);
  missing.visuals[0].surface.reset();
  missing.visuals[0].mesh = "no_such.stl";
  EXPECT_THAT(refused(missing, CollisionKind::kBox), HasSubstr("no_such.stl"));
}

}  // namespace
}  // namespace prehend::robot::formats
