#pragma once

#include <map>
#include <mutex>
#include <optional>
#include <string>

#include "prehend/geometry/rigid_transform.h"

namespace prehend::drivers::ros_link {

/// The newest pose of each frame in its parent's, as /tf and /tf_static tell it. Any thread.
class FrameTree {
 public:
  void set(const std::string& parent, const std::string& child,
           const geometry::RigidTransform& X_parent_child);
  /// Pose of frame `to` in frame `from`; nothing when no chain of parents joins the two.
  std::optional<geometry::RigidTransform> find(const std::string& from,
                                               const std::string& to) const;

 private:
  struct Frame {
    std::string parent;
    geometry::RigidTransform X = geometry::RigidTransform::Identity();  // in the parent's
  };
  mutable std::mutex mutex_;
  std::map<std::string, Frame> frames_;  // by their names
};

}  // namespace prehend::drivers::ros_link
