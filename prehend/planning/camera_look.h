#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "prehend/geometry/camera_model.h"
#include "prehend/motion/blended_trajectory.h"
#include "prehend/planning/platform_pick.h"
#include "prehend/planning/surface_views.h"
#include "prehend/surface/object_model.h"

// How the camera that an arm carries sees another side of what stands on the table.
namespace prehend::planning {

struct PlannedLook {
  std::vector<robot::Positions> way;  // from where the arm stands, and back the same way
  std::optional<motion::BlendedTrajectory> trajectory;                   // along it
  geometry::RigidTransform X_WC = geometry::RigidTransform::Identity();  // at its end
  double gain = 0;   // share of the surface that it shows and no look has shown
  std::string from;  // "the left", as seen from where the camera stands before
  /// m, of each two shapes that the object may have, root mean square: what the look shows of the
  /// row's, from the surface of the column's. That is what it tells them apart by.
  Eigen::MatrixXd apart;
  std::string problem;  // why there is none, in words; empty: there is one

  bool found() const { return trajectory.has_value(); }
};

/// Plans a look with the camera that the platform's arm carries: from the direction above the table
/// from which most of the object's surface is seen that was not - not too steeply, hidden by
/// neither the object nor its neighbours - where the arm can bring the camera on a free path, all
/// of the object within the picture, and as little of it as can be behind the hand, for both eyes.
/// @param camera a baseline of 0: of one eye.
/// @param start of the arm's joints; the object was seen from there.
/// @param scene in which the object and its neighbours stand. @param arm of its motions.
/// @throws std::invalid_argument for options out of range, a start of another size, a camera that
/// is none, or a platform without one; geometry::InputError for an object without a surface.
PlannedLook plan_look(const robot::Platform& platform, const robot::Positions& start,
                      const geometry::StereoCamera& camera, const surface::ObjectModel& object,
                      const PlatformScene& scene, const PlatformPickOptions& arm,
                      const ViewOptions& options = {});

}  // namespace prehend::planning
