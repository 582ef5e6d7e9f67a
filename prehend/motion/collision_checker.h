#pragma once

#include <memory>
#include <string>

#include "prehend/motion/convex_body.h"

namespace prehend::motion {

/// A body as a checker keeps it.
class CheckedBody {
 public:
  virtual ~CheckedBody() = default;
};

/// Tells whether two convex bodies are near each other: what a RobotInWorld asks where it looks at
/// the robot's real shapes instead of the balls that hold them. Which bodies are asked for,
/// margins, planes, sweeps and words are the RobotInWorld's concern (ShapesInWorld). Recipe for
/// another one: README.md beside this file. Pure virtual, so that checkers in shared libraries need
/// nothing of prehend linked to them.
class CollisionChecker {
 public:
  virtual ~CollisionChecker() = default;

  virtual std::string name() const = 0;   // by which it is chosen: "fcl"
  virtual std::string about() const = 0;  // one line for who chooses: the method, how near it is
  virtual std::unique_ptr<CheckedBody> body(const ConvexBody& body) const = 0;
  /// Whether `a`, at X_BA, and `b` overlap or come nearer than `gap` [m, >= 0]. True where it is in
  /// doubt: separation() along a direction that a library found proves that they are not.
  /// Reentrant. Both bodies are of this checker.
  virtual bool are_nearer(const CheckedBody& a, const geometry::RigidTransform& X_BA,
                          const CheckedBody& b, const geometry::RigidTransform& X_BB,
                          double gap) const = 0;
};

/// Of CollisionChecker and ConvexBody: a plug-in that was built for another one is not loaded.
constexpr int kCheckerInterface = 1;

}  // namespace prehend::motion
