#pragma once

#include <vector>

#include <Eigen/Core>

#include "prehend/geometry/camera_model.h"
#include "prehend/geometry/mesh_query.h"
#include "prehend/geometry/rigid_transform.h"
#include "prehend/surface/object_model.h"
#include "prehend/text/knob.h"

// What of an object's surface a camera sees from where.
namespace prehend::planning {

/// A camera that stands still.
struct ViewingCamera {
  geometry::PinholeCamera camera;
  geometry::RigidTransform X_WC = geometry::RigidTransform::Identity();  // optical frame
};

/// A piece of an object's surface, in the frame that who uses it says.
struct SurfacePatch {
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal_W = Eigen::Vector3d::UnitZ();  // unit, outward
  bool seen = false;                                    // by a look before
};

/// `count` patches of the same area each, spread evenly; of another shape that the object may have,
/// none is seen. @throws std::invalid_argument for a mesh without area.
std::vector<SurfacePatch> surface_patches(const surface::ObjectModel& object, int count = 400);
std::vector<SurfacePatch> surface_patches(const geometry::TriangleMesh& mesh_W, int count = 400);

/// Of views that arms bring about, be it that they turn what they hold or that they carry the
/// camera.
struct ViewOptions {
  double least_gain = 0.03;
  double steepest = 1.2;  // rad
  double image_margin = 0.04;
  double nearest = 0.37;  // m
  double speed_factor = 0.5;
  double budget = 1;

  /// See text/knob.h.
  template <class Self, class Visit>
  static void knobs(Self& self, Visit&& visit) {
    using text::Knob;
    visit(Knob{"least_gain", self.least_gain, "", 0.001, 1,
               "share of the surface that a view has to show anew"});
    visit(Knob{"steepest", self.steepest, "rad", 0.1, 1.5,
               "between surface and line of sight: what is seen flatter counts as not seen"});
    visit(Knob{"image_margin", self.image_margin, "", 0, 0.4,
               "of the picture, that the object keeps from its border"});
    visit(Knob{"nearest", self.nearest, "m", 0.01, 10,
               "of any of it to the camera: nearer than it measures depth, what it says is wrong"});
    visit(Knob{"speed_factor", self.speed_factor, "", 0.01, 1,
               "of the joints' speed on the way to a view"});
    visit(Knob{"budget", self.budget, "s", 0, 3600,
               "for the views of one object; 0: as long as it takes"});
  }
};

/// `count` unit vectors, spread evenly (on a spiral of equal areas).
std::vector<Eigen::Vector3d> even_directions(int count);

/// Which patches are seen along `direction`, unit, towards a camera far away: not steeper than
/// `steepest` [rad], and hidden by none of `hiding`.
std::vector<char> seen_along(const std::vector<SurfacePatch>& patches,
                             const Eigen::Vector3d& direction, double steepest,
                             const std::vector<const geometry::MeshQuery*>& hiding);

/// A ball round `p_W`, and a margin, is all within the picture and not too near.
bool is_in_picture(const ViewingCamera& camera, const Eigen::Vector3d& p_W, double radius,
                   const ViewOptions& options);

}  // namespace prehend::planning
