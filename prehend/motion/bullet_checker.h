#pragma once

#include "prehend/motion/collision_checker.h"

namespace prehend::motion {

/// Bullet's GJK (btGjkEpaSolver2 by N. Presson; G. van den Bergen, "A fast and robust GJK
/// implementation for collision detection of convex objects", JGT 4(2), 1999) in single precision.
/// What it finds apart is proven in double precision; what is nearer than 0.1 mm may count as
/// touching.
class BulletChecker final : public CollisionChecker {
 public:
  std::string name() const override { return "bullet"; }
  std::string about() const override;
  std::unique_ptr<CheckedBody> body(const ConvexBody& body) const override;
  bool are_nearer(const CheckedBody& a, const geometry::RigidTransform& X_BA, const CheckedBody& b,
                  const geometry::RigidTransform& X_BB, double gap) const override;
};

}  // namespace prehend::motion
