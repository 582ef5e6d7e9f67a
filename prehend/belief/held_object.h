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
  surface::ModelOptions model{0};   // all detail: of several looks more is known than of one
  HeldPrior closing{0.006, 0.12};   // of what closing and lifting did to it, before the first look
  HeldPrior holding{0.001, 0.01};   // of what turning it does, from one look to the next
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
/// closes look by look. Looks are laid onto the first one and onto each other, beginning where the
/// hand has brought the object (held_poses()): with each look all of them anew. What was seen
/// becomes its surface, and what was looked through is empty (ObjectBelief).
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

  int looks() const { return static_cast<int>(looks_.size()); }  // that were taken
  /// What closing, lifting and turning have done to it in the hand, by the looks, when the last one
  /// was taken: what was at p when it was first seen is where X_held() p would be, had it not moved
  /// in the hand.
  const geometry::RigidTransform& X_held() const { return X_held_; }
  /// As it is known now, in O. Its seen vertices are those that any look saw.
  /// @throws geometry::InputError when no surface comes out.
  surface::ObjectModel model() const;

 private:
  /// A look that was taken.
  struct Look {
    geometry::PointCloud seen_S;  // with normals, where the hand alone would have them in O
    shape::SeenSpace space_S;
  };
  double violated(const shape::SeenSpace& space_O) const;
  void believe(const std::vector<HeldPose>& poses);

  HeldObjectOptions options_;
  shape::CompletedShape shape_;
  geometry::Plane table_W_;
  ObjectBelief belief_;
  geometry::PointCloud first_;  // what was seen at first, O, with normals
  geometry::PointCloud known_;  // that, and all looks where they lie
  std::vector<Look> looks_;
  geometry::RigidTransform X_held_ = geometry::RigidTransform::Identity();
  Eigen::Vector3d middle_ = Eigen::Vector3d::Zero();  // of the first look
};

struct HeldLookOptions {
  double room = 0.6;         // >= 0, of the radius of what is thought to be held, round its surface
  double clearance = 0.006;  // m, >= 0, from the robot's links
  double height = 0.03;      // m, >= 0, over the table
  double least_piece = 0.05;  // share of what was seen, in [0, 1), that a piece by itself has
  int edge = 3;               // pixels, >= 0: of an edge in depth nobody knows whose it is
  double step = 0.015;        // m, > 0, of depth, that is an edge

  void validate() const;  ///< @throws std::invalid_argument naming the field.
};

/// Where a picture shows the object that a hand holds (255): the pixels whose points are within
/// some room about `thought_W`, its surface as it is thought to be now, and keep clear of every
/// link of the robot, of the table, and of edges in depth, in pieces that are not small.
/// @param depth of the camera's size [m], NaN where unknown.
/// @param robot_W the robot's links as they are now. @throws std::invalid_argument for options out
/// of range, or a depth of another size.
geometry::MaskImage held_pixels(const geometry::DepthImage& depth,
                                const geometry::PinholeCamera& camera,
                                const geometry::RigidTransform& X_WC,
                                const geometry::Plane& table_W,
                                const std::vector<geometry::TriangleMesh>& robot_W,
                                const geometry::PointCloud& thought_W,
                                const HeldLookOptions& options = {});

/// What a view shows of the object that a hand holds: its points by held_pixels(), which takes the
/// same arguments, and what else was seen round it.
HeldLook held_look(const geometry::DepthImage& depth, const geometry::PinholeCamera& camera,
                   const geometry::RigidTransform& X_WC, const geometry::Plane& table_W,
                   const std::vector<geometry::TriangleMesh>& robot_W,
                   const geometry::PointCloud& thought_W, const HeldLookOptions& options = {});

}  // namespace prehend::belief
