#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "prehend/geometry/camera_model.h"
#include "prehend/geometry/image.h"
#include "prehend/geometry/plane.h"
#include "prehend/geometry/point_cloud.h"
#include "prehend/geometry/rigid_transform.h"

namespace prehend::perception {

/// One object as seen from one view.
struct ObjectHypothesis {
  int id = 0;
  geometry::PointCloud cloud_W;  // seen points, world frame, finite only
  geometry::MaskImage mask;      // of the whole camera image; 255 where the object is seen
  /// The image's border cuts it, or SegmentationOptions::max_height does: it goes on where nobody
  /// looked.
  bool touches_image_border = false;
  /// Share of the mask's outline along which another object stands right before this one, 0..1: it
  /// goes on behind that.
  double occluded_share = 0;
  /// It has a level ledge beside something that rises, as two things have that stand on or beside
  /// each other, in colours that do not tell (ledges.h).
  bool may_be_several = false;
  /// What it stands on where that is not the table but the top of another object; world.
  std::optional<geometry::Plane> support_W;
  /// Depth [m] of the objects that stand right before this one, 0 elsewhere: what they hide nobody
  /// saw. Empty without any.
  geometry::DepthImage nearer;
};

/// Points of a view that were not clustered, and why: the first that applies.
struct PointsLeftOut {
  std::size_t not_finite = 0;
  std::size_t low = 0;              // of the table, or under its plane
  std::size_t over_max_height = 0;  // SegmentationOptions::max_height
  std::size_t too_far = 0;          // max_distance
  std::size_t beside_table = 0;     // hull_margin beyond its outline
  std::size_t flying = 0;           // of organized clouds, without_flying_points()
  double least_height = 0;          // m: lower ones are the table's, at 1 m and nearer
};

/// What segmentation makes of one view: a table and the objects on it.
struct SegmentedScene {
  geometry::PinholeCamera camera;         // real, or virtual for unorganized clouds
  geometry::RigidTransform X_WC;          // pose of its optical frame in the world
  geometry::DepthImage depth;             // of the whole view, for reports
  geometry::Plane table_W;                // normal towards the objects
  std::vector<ObjectHypothesis> objects;  // largest first
  /// What was seen over the table and is no object, largest first: its size, where [m, world], why,
  /// and the option that decides.
  std::vector<std::string> dropped;
  PointsLeftOut left_out;  // all 0 of one object on a table that is made up
};

/// The plane that the object stands on.
inline const geometry::Plane& support_of(const SegmentedScene& scene,
                                         const ObjectHypothesis& object) {
  return object.support_W ? *object.support_W : scene.table_W;
}

/// What to say of a scene without objects: that, and what was dropped.
std::string why_no_objects(const SegmentedScene& scene);

}  // namespace prehend::perception
