#include "prehend/motion/bullet_checker.h"

#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <BulletCollision/CollisionShapes/btConvexHullShape.h>
#include <BulletCollision/CollisionShapes/btCylinderShape.h>
#include <BulletCollision/CollisionShapes/btSphereShape.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkEpa2.h>

namespace prehend::motion {
namespace {

struct BulletBody final : CheckedBody {
  std::unique_ptr<btConvexInternalShape> shape;  // without margin: of a ball the middle
  ConvexBody body;
};

btVector3 bullet_vector(const Eigen::Vector3d& v) {
  return {static_cast<btScalar>(v.x()), static_cast<btScalar>(v.y()), static_cast<btScalar>(v.z())};
}

btTransform bullet_transform(const geometry::RigidTransform& X) {
  const Eigen::Matrix<btScalar, 3, 3> R = X.linear().cast<btScalar>();
  return btTransform(
      btMatrix3x3(R(0, 0), R(0, 1), R(0, 2), R(1, 0), R(1, 1), R(1, 2), R(2, 0), R(2, 1), R(2, 2)),
      bullet_vector(X.translation()));
}

std::unique_ptr<btConvexInternalShape> bullet_shape(const ConvexBody& body) {
  switch (body.kind) {
    case ConvexBody::Kind::kSphere:
      return std::make_unique<btSphereShape>(static_cast<btScalar>(body.radius));
    case ConvexBody::Kind::kCylinder:
      return std::make_unique<btCylinderShapeZ>(
          bullet_vector({body.radius, body.radius, body.length / 2}));
    case ConvexBody::Kind::kPoints: {
      auto hull = std::make_unique<btConvexHullShape>();
      for (const Eigen::Vector3d& p : *body.points) hull->addPoint(bullet_vector(p), false);
      hull->recalcLocalAabb();
      return hull;
    }
    case ConvexBody::Kind::kBox:
      break;
  }
  return std::make_unique<btBoxShape>(bullet_vector(body.size / 2));
}

}  // namespace

std::string BulletChecker::about() const {
  return "the links' shapes by Bullet's GJK: what is within 0.1 mm may count as touching";
}

std::unique_ptr<CheckedBody> BulletChecker::body(const ConvexBody& body) const {
  auto result = std::make_unique<BulletBody>();
  result->shape = bullet_shape(body);
  if (body.kind != ConvexBody::Kind::kSphere) result->shape->setMargin(0);
  result->body = body;
  return result;
}

bool BulletChecker::are_nearer(const CheckedBody& a, const geometry::RigidTransform& X_BA,
                               const CheckedBody& b, const geometry::RigidTransform& X_BB,
                               double gap) const {
  const auto& of_a = static_cast<const BulletBody&>(a);
  const auto& of_b = static_cast<const BulletBody&>(b);
  // From `a`, where single precision loses least.
  const geometry::RigidTransform X_AB = X_BA.inverse() * X_BB;
  const btTransform at = bullet_transform(X_AB);
  const btVector3 towards = bullet_vector(-X_AB.translation());
  // The points that it ends at are not always the nearest; from another direction they are. One
  // proof is enough.
  for (const btVector3& guess :
       {towards, btVector3(1, 0, 0), btVector3(0, 1, 0), btVector3(0, 0, 1), -towards}) {
    btGjkEpaSolver2::sResults result;
    if (!btGjkEpaSolver2::Distance(of_a.shape.get(), btTransform::getIdentity(), of_b.shape.get(),
                                   at, guess, result)) {
      return true;  // they overlap
    }
    const btVector3 way = result.witnesses[1] - result.witnesses[0];
    const Eigen::Vector3d way_A = Eigen::Vector3d(way.x(), way.y(), way.z()).normalized();
    if (separation(of_a.body, geometry::RigidTransform::Identity(), of_b.body, X_AB, way_A) > gap) {
      return false;
    }
  }
  return true;
}

}  // namespace prehend::motion
