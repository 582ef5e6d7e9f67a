#pragma once

#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace prehend::control {

struct PutDownOptions {
  double distance = 0.15;           // m, > 0, sideways
  double lift_height = 0.15;        // m, >= 0: what is lower is passed over
  double hand_radius = 0.06;        // m, >= 0, of the hand round the object at the new place
  double enough = 0.05;             // m, >= 0: the first direction with so much room is taken
  int directions = 8;               // > 0, tried from world +y counter-clockwise
  Eigen::AlignedBox3d workspace_W;  // for the gripper frame's origin; empty: no limit

  void validate() const;  ///< @throws std::invalid_argument naming the field.
};

/// Where to carry an object so that there is room for it: the horizontal displacement [m] whose end
/// (and whose way, beside obstacles taller than the lift) keeps furthest from the obstacles'
/// bounds. `object_W`: bounds of the object where it stands; `hand_W`: origin of the gripper frame
/// when it grips [m]. The up direction is world z. Directions that leave the workspace are skipped;
/// when all do, the object is put down where it was (zero).
Eigen::Vector3d choose_move(const Eigen::AlignedBox3d& object_W, const Eigen::Vector3d& hand_W,
                            const std::vector<Eigen::AlignedBox3d>& obstacles_W,
                            const PutDownOptions& options = {});

}  // namespace prehend::control
