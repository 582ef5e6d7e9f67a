#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "prehend/belief/held_registration.h"
#include "prehend/belief/object_belief.h"
#include "prehend/geometry/plane.h"
#include "prehend/geometry/point_cloud.h"
#include "prehend/geometry/rigid_transform.h"
#include "prehend/shape/completed_shape.h"
#include "prehend/shape/seen_space.h"
#include "prehend/surface/model.h"

namespace prehend::belief {

struct HeldObjectOptions {
  BeliefOptions belief;
  surface::ModelOptions model;
  HeldPrior closing{0.006, 0.12};   // of what closing and lifting did to it, before the first look
  HeldPrior holding{0.002, 0.03};   // of what turning it does, from one look to the next
  double seen_deviation = 0.0015;   // m, > 0, standard, of a seen point
  int most_contacts = 48;           // >= 0, of a look's points, that weigh shapes
  double largest_residual = 0.005;  // m, > 0, of the points of a look on those known before
  double most_violated = 0.2;  // share of what is known, in (0, 1], that a look may see through

  void validate() const;  ///< @throws std::invalid_argument naming the field.
};

/// What one look saw of an object that a hand holds.
struct HeldLook {
  geometry::PointCloud seen_W;  // of its surface, the hand's left out; finite, without normals
  shape::SeenSpace space;       // round it
  /// Where the hand has brought it: what was at p when it was first seen is at X_WO p now.
  geometry::RigidTransform X_WO = geometry::RigidTransform::Identity();
};

/// What became of a look.
struct TakenLook {
  std::string problem;  // why it was not taken, in words; empty: it was
  /// Where the object was in this look, in the first one's frame: other than the hand said by what
  /// closing, lifting and turning did to it.
  geometry::RigidTransform X_WO = geometry::RigidTransform::Identity();
  double moved = 0;         // m, of its middle in the hand since it was gripped
  std::size_t points = 0;   // of its surface, that were seen
  std::size_t matched = 0;  // of them, of what was known before
};

/// An object that was predicted from one look, gripped, and is turned before a camera: its model
/// closes look by look. Every look is laid onto what was seen before, beginning where the hand has
/// brought it (held_pose()): by as far as closing may have moved it in the hand at first, then by
/// what turning it may. What was seen becomes its surface, what was looked through is empty, and
/// the shapes that it may have are weighed by it (ObjectBelief).
///
/// Frame O: the world when it was first seen. Same looks, same model. Not thread-safe.
class HeldObject {
 public:
  /// @param shape as it was completed, with its other methods; @param table_W what it stood on.
  /// @throws as ObjectBelief, and HeldObjectOptions::validate().
  HeldObject(const shape::CompletedShape& shape, const geometry::Plane& table_W,
             const HeldObjectOptions& options = {});

  /// Takes a look in, unless it cannot be of this object where the hand holds it: hardly any point
  /// of it was seen, they do not lie on what is known, or it saw through what is known.
  /// @throws std::invalid_argument for points that are not finite.
  TakenLook add(const HeldLook& look);

  int looks() const { return looks_; }  // that were taken
  /// What closing, lifting and turning have done to it in the hand, by the last look: what was at p
  /// when it was first seen is where X_held() p would be, had it not moved in the hand.
  const geometry::RigidTransform& X_held() const { return X_held_; }
  /// As it is known now, in O. Its seen vertices are those that any look saw.
  /// @throws geometry::InputError when no surface comes out.
  surface::ObjectModel model() const;
  /// The looks speak against every shape that was predicted: only what was seen is sure.
  bool contradicted() const { return belief_.contradicted(); }

 private:
  double violated(const shape::SeenSpace& space_O) const;

  HeldObjectOptions options_;
  shape::CompletedShape shape_;
  ObjectBelief belief_;
  geometry::PointCloud known_;  // all that was seen, O, with normals
  geometry::RigidTransform X_held_ = geometry::RigidTransform::Identity();  // in the hand, of O
  Eigen::Vector3d middle_ = Eigen::Vector3d::Zero();                        // of the first look
  int looks_ = 0;
};

/// What a view shows of the object that a hand holds, near where it is thought to be: the points
/// within `reach` [m] of the middle of `thought_W`, its surface as it is thought to be now, that
/// are farther than `clearance` [m] from every link of the robot and from the table.
/// @param depth of the camera's size [m], NaN where unknown.
/// @param robot_W the robot's links as they are now.
HeldLook held_look(const geometry::DepthImage& depth, const geometry::PinholeCamera& camera,
                   const geometry::RigidTransform& X_WC, const geometry::Plane& table_W,
                   const std::vector<geometry::TriangleMesh>& robot_W,
                   const geometry::PointCloud& thought_W, double reach, double clearance = 0.006);

}  // namespace prehend::belief
