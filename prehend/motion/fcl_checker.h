#pragma once

#include "prehend/motion/collision_checker.h"

namespace prehend::motion {

/// The Flexible Collision Library (J. Pan, S. Chitta, D. Manocha, "FCL: A general purpose library
/// for collision and proximity queries", ICRA 2012): its GJK in double precision, libccd's and its
/// own. What it finds apart is proven.
class FclChecker final : public CollisionChecker {
 public:
  std::string name() const override { return "fcl"; }
  std::string about() const override;
  std::unique_ptr<CheckedBody> body(const ConvexBody& body) const override;
  bool are_nearer(const CheckedBody& a, const geometry::RigidTransform& X_BA, const CheckedBody& b,
                  const geometry::RigidTransform& X_BB, double gap) const override;
};

}  // namespace prehend::motion
