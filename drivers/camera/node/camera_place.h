#pragma once

#include <cstdint>
#include <mutex>
#include <optional>

#include "msgs/geometry.pb.h"
#include "msgs/joints.pb.h"
#include "prehend/geometry/rigid_transform.h"
#include "prehend/graph/node.h"
#include "prehend/robot/platform.h"
#include "prehend/robot/position_history.h"

namespace prehend::drivers::camera {

/// Where a camera is: at one place, on an arm that moves, or nobody has said.
class CameraPlace {
 public:
  /// Declares `pose`, `platform` and `platforms`. @throws geometry::InputError for a pose that is
  /// none, both, or a platform whose arm carries no camera.
  explicit CameraPlace(graph::Node& node);

  /// For /camera/info; none: each picture says it, or nobody has.
  const std::optional<geometry::RigidTransform>& fixed() const { return X_WC_; }
  bool is_carried() const { return platform_.has_value(); }
  /// For a picture: where the camera was on its arm at `stamp` [ns]; none: it is not carried.
  /// @throws geometry::InputError when it is not known where the arm was (/joint_states).
  std::optional<geometry::RigidTransform> at(std::int64_t stamp) const;

 private:
  void hear(const msgs::JointState& joints);

  std::optional<geometry::RigidTransform> X_WC_;
  std::optional<robot::Platform> platform_;
  mutable std::mutex mutex_;
  robot::PositionHistory history_;
  graph::Subscription joints_;
};

}  // namespace prehend::drivers::camera
