#pragma once

#include <vector>

#include <Eigen/Core>

#include "prehend/geometry/mesh_query.h"
#include "prehend/geometry/rigid_transform.h"
#include "prehend/robot/gripper_model.h"

namespace prehend::grasp {

struct ClosingOptions {
  double touch_force = 0.3;     // N, > 0, sum of a pad's texels that counts as first touch
  double largest_turn = 0.105;  // rad, >= 0, the object may be turned by the closing pads
  int touch_counts = 10;        // counts, >= 0, above which a texel counts as touched

  void validate() const;  ///< @throws std::invalid_argument naming the field.
};

/// Where one pad presses on the object, in the gripper frame G.
struct ContactPatch {
  std::vector<Eigen::Vector3d> points_G;   // n, centres of the pressed texels on the surface [m]
  std::vector<Eigen::Vector3d> normals_G;  // n, unit, outward of the object
  std::vector<double> forces;              // n, of the texels [N]
  Eigen::Vector3d center_G = Eigen::Vector3d::Zero();   // of pressure [m]
  Eigen::Vector3d normal_G = Eigen::Vector3d::UnitY();  // unit, force-weighted mean
  double force = 0;                                     // N, sum of the texels
  double area = 0;            // m^2, of the texels above the touch threshold
  double depth = 0;           // m, deepest penetration
  double torsion_radius = 0;  // m, force-weighted mean distance to the centre of pressure
};

enum class ClosingOutcome {
  kClosed,         // both pads press with the wanted force
  kTooWide,        // the open pads would start inside the object
  kMissed,         // at least one pad meets nothing
  kBottomsOut,     // a pad's foam is used up before the force is reached
  kTurns,          // the object would turn more than allowed, or out of the pads
  kTouchesFinger,  // a finger would meet the object beyond its pad and keep the pad from pressing
};

/// The hand closed on a rigid object.
struct ClosedHand {
  ClosingOutcome outcome = ClosingOutcome::kMissed;
  double opening_at_touch = 0;  // m, when both pads feel the touch force
  double opening = 0;           // m, at the grasp force
  double offset = 0;   // m, along +y of G from G's origin to the middle of the grasped section
  double turn = 0;     // rad, by which closing turns the object
  ContactPatch left;   // at +y
  ContactPatch right;  // at -y
};

/// The object's surface over one texel of a pad, seen from far outside.
struct SurfaceOverTexel {
  double x = 0, z = 0;  // m, the texel's centre in G
  int side = 1;         // +1 the left pad, -1 the right one
  double height = 0;    // m, of the surface along the side's outward direction, from G's xz plane
  Eigen::Vector3d normal_G = Eigen::Vector3d::UnitY();  // unit, outward of the object
};

/// Extent of the object along G's y axis where rays through the pads' area meet it, however wide.
struct SectionExtent {
  bool met = false;
  double lower = 0;  // m, in G
  double upper = 0;  // m, in G
  std::vector<SurfaceOverTexel> surface;

  /// As seen from a hand that is moved by `offset` [m] along its y axis.
  void shift_hand(double offset);
};
SectionExtent measure_section(const geometry::SurfaceQuery& object_W,
                              const geometry::RigidTransform& X_WG,
                              const robot::GripperModel& gripper);
/// A lower bound of the width [m] that measure_section() finds, at a tenth of its rays: that of
/// eight texels, spread over the pads. Below 0 when these meet nothing.
double least_section_width(const geometry::SurfaceQuery& object_W,
                           const geometry::RigidTransform& X_WG,
                           const robot::GripperModel& gripper);

/// Closes the two synchronised fingers on the object until each pad presses with `force` [N].
///
/// Rays from every texel of both open pads (`opening` [m]) along -+y of G give the height of the
/// surface over each texel. The pads are beds of springs with the texels' stiffness k, the object
/// is rigid and free to shift along y and to turn about G's x and z axes by small angles q; it
/// comes to rest where the elastic energy
///   E(q, s) = k/2 sum_i max(0, h_i + J_i q - s/2)^2
/// is smallest (convex in q; Newton's method), and the opening s is the one at which the pads' sum
/// is the wanted force. Friction, gravity and the table are left out of this equilibrium.
/// E(q, s) + F s is convex and piecewise quadratic in q and s together: Newton's method with a line
/// search ends after some ten passes over the texels.
///
/// `section`, when it was measured at this pose and fits into the opening, saves the rays: what is
/// met from far outside is then what the open pads meet.
/// Cost: 2 x rows x columns rays and about 15 us.
/// @throws std::invalid_argument when `opening` or `force` is not positive.
ClosedHand close_hand(const geometry::SurfaceQuery& object_W, const geometry::RigidTransform& X_WG,
                      double opening, double force, const robot::GripperModel& gripper,
                      const ClosingOptions& options = {}, const SectionExtent* section = nullptr);

}  // namespace prehend::grasp
