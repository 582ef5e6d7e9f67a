#pragma once

#include <vector>

#include "prehend/belief/percepts.h"
#include "prehend/geometry/camera_model.h"
#include "prehend/geometry/image.h"
#include "prehend/geometry/plane.h"
#include "prehend/geometry/point_cloud.h"
#include "prehend/geometry/rigid_transform.h"
#include "prehend/geometry/triangle_mesh.h"

// What a camera is to show, and shows, of an object that a hand has lifted.
namespace prehend::belief {

/// A camera before which a hand has lifted something.
struct LiftedView {
  geometry::PinholeCamera camera;
  geometry::RigidTransform X_WC = geometry::RigidTransform::Identity();  // optical frame
  geometry::Plane table_W;
  geometry::RigidTransform X_WH = geometry::RigidTransform::Identity();  // the hand's root
  std::vector<geometry::TriangleMesh> robot_W;  // its links, which may hide what it holds
  /// The object's surface, where the hand has brought it if it does not move in it: what is far
  /// from it is not taken for the object.
  geometry::PointCloud thought_W;
};

/// The surface of a mesh as LiftedView::thought_W has it; the same for the same mesh.
/// @throws geometry::InputError for a mesh without area.
geometry::PointCloud thought_surface(const geometry::TriangleMesh& mesh);

/// What the measured depth shows of it: held_pixels() of the picture, of which every second row and
/// column are taken when it is wider than 320 pixels, and so on. Fewer than 15 pixels are none.
/// @param depth of the camera's size [m], NaN where unknown. @throws std::invalid_argument for a
/// depth of another size or nothing that it is thought to be.
PerceivedView perceived_view(const geometry::DepthImage& depth, const LiftedView& view);

/// The same of what the camera measures without noise when an object, the robot and the table are
/// there, and nothing else. @throws as perceived_view(), geometry::InputError for an object without
/// triangles.
PerceivedView predicted_view(const geometry::TriangleMesh& object_W, const LiftedView& view);

}  // namespace prehend::belief
