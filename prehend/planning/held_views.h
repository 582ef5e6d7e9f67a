#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "prehend/geometry/mesh_query.h"
#include "prehend/geometry/plane.h"
#include "prehend/geometry/rigid_transform.h"
#include "prehend/geometry/triangle_mesh.h"
#include "prehend/motion/blended_trajectory.h"
#include "prehend/motion/path_planner.h"
#include "prehend/motion/robot_in_world.h"
#include "prehend/planning/surface_views.h"
#include "prehend/robot/inverse_kinematics.h"

// How an arm turns what its hand holds before a camera, to see what nobody has seen of it.
namespace prehend::planning {

struct HeldViewOptions : ViewOptions {
  int views = 4;

  /// See text/knob.h.
  template <class Self, class Visit>
  static void knobs(Self& self, Visit&& visit) {
    visit(text::Knob{"views", self.views, "", 1, 32, "that it is turned to at most"});
    ViewOptions::knobs(self, visit);
  }
  void validate() const;  ///< @throws std::invalid_argument naming the field.
};

/// What is to be seen of an object while it is held.
struct HeldInspection {
  ViewingCamera camera;
  std::vector<SurfacePatch> patches_W;   // of the object where it stands
  geometry::TriangleMesh object_mesh_W;  // the same surface
  HeldViewOptions options;
};

/// A place to look at what is held from.
struct HeldView {
  std::vector<robot::Positions> way;  // from the lift's end, and back the same way
  std::optional<motion::BlendedTrajectory> trajectory;  // along it; none: it stays where it is
  double gain = 0;  // share of the surface that it shows and neither a look nor a view before it
};

struct HeldViews {
  std::vector<HeldView> views;  // in their order
  double seen = 0;              // share of the surface that was seen before
  double shown = 0;             // the same after all views, as far as the prediction is right
  std::string problem;          // why there are none, in words; empty: there are
};

/// What is held, and by what it is hidden. Frame T: the arm's tip.
struct HeldThing {
  std::vector<SurfacePatch> patches_T;  // their p_W and normal_W in T
  const geometry::MeshQuery* object_T = nullptr;
  const geometry::MeshQuery* hand_T = nullptr;  // null: nothing of the hand hides it
};

/// Views by which most of the surface is seen that was not: each time the direction from which most
/// new patches are seen - not too steeply, hidden by neither the object nor the hand - while enough
/// of what is known is seen, too, to lay the look onto it; then a pose of the arm that turns that
/// side to the camera, within the picture, and a free path to it. Once none shows enough anew,
/// those that show most from another side: looks that overlap put each other right. The first view
/// is where the lift ends, if the object is within the picture there.
/// @param carrying with the object held by the hand. @param X_WB of the arm's base.
/// @param lifted of the arm, at the lift's end. @param table_W over which it stays.
/// @throws std::invalid_argument for options out of range.
HeldViews plan_held_views(const motion::RobotInWorld& carrying,
                          const robot::InverseKinematics& inverse,
                          const geometry::RigidTransform& X_WB, const robot::Positions& lifted,
                          const HeldThing& thing, const ViewingCamera& camera,
                          const geometry::Plane& table_W, const motion::PathPlanner& planner,
                          const motion::PathOptions& path, const Eigen::VectorXd& acceleration,
                          const HeldViewOptions& options);

}  // namespace prehend::planning
