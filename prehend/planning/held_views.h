#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "prehend/geometry/camera_model.h"
#include "prehend/geometry/mesh_query.h"
#include "prehend/geometry/plane.h"
#include "prehend/geometry/rigid_transform.h"
#include "prehend/geometry/triangle_mesh.h"
#include "prehend/motion/blended_trajectory.h"
#include "prehend/motion/path_planner.h"
#include "prehend/motion/robot_in_world.h"
#include "prehend/robot/inverse_kinematics.h"
#include "prehend/surface/object_model.h"
#include "prehend/text/knob.h"

// How an arm turns what its hand holds before a camera, to see what nobody has seen of it.
namespace prehend::planning {

/// A camera that stands still.
struct ViewingCamera {
  geometry::PinholeCamera camera;
  geometry::RigidTransform X_WC = geometry::RigidTransform::Identity();  // optical frame
};

/// A piece of an object's surface.
struct SurfacePatch {
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal_W = Eigen::Vector3d::UnitZ();  // unit, outward
  bool seen = false;                                    // by a look before
};

/// `count` patches of the same area each, spread evenly. @throws std::invalid_argument for a mesh
/// without area.
std::vector<SurfacePatch> surface_patches(const surface::ObjectModel& object, int count = 400);

struct HeldViewOptions {
  int views = 4;
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
    visit(Knob{"views", self.views, "", 1, 32, "that it is turned to at most"});
    visit(Knob{"least_gain", self.least_gain, "", 0.001, 1,
               "share of the surface that a view has to show anew"});
    visit(Knob{"steepest", self.steepest, "rad", 0.1, 1.5,
               "between surface and line of sight: what is seen flatter counts as not seen"});
    visit(Knob{"image_margin", self.image_margin, "", 0, 0.4,
               "of the picture, that the object keeps from its border"});
    visit(Knob{"nearest", self.nearest, "m", 0.01, 10,
               "that any of it is brought to the camera: nearer than it measures depth, what it "
               "says is wrong"});
    visit(Knob{"speed_factor", self.speed_factor, "", 0.01, 1,
               "of the joints' speed while it is turned"});
    visit(Knob{"budget", self.budget, "s", 0, 3600,
               "for the views of one grasp; 0: as long as it takes"});
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
