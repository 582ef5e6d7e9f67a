#include "drivers/ros/driver/frame_tree.h"

#include <utility>
#include <vector>

namespace prehend::drivers::ros_link {
namespace {

constexpr std::size_t kDeepest = 256;  // frames above one another: more is a ring

/// ROS 1 has names with and without a slash before them.
std::string plain(const std::string& name) {
  return !name.empty() && name.front() == '/' ? name.substr(1) : name;
}

}  // namespace

void FrameTree::set(const std::string& parent, const std::string& child,
                    const geometry::RigidTransform& X_parent_child) {
  const std::lock_guard lock(mutex_);
  frames_[plain(child)] = {plain(parent), X_parent_child};
}

std::optional<geometry::RigidTransform> FrameTree::find(const std::string& from,
                                                        const std::string& to) const {
  const std::lock_guard lock(mutex_);
  // Every frame above `to`, with the pose of `to` in it.
  std::vector<std::pair<std::string, geometry::RigidTransform>> above{
      {plain(to), geometry::RigidTransform::Identity()}};
  while (above.size() < kDeepest) {
    const auto found = frames_.find(above.back().first);
    if (found == frames_.end()) break;
    above.emplace_back(found->second.parent, found->second.X * above.back().second);
  }
  geometry::RigidTransform X_frame_from = geometry::RigidTransform::Identity();
  std::string frame = plain(from);
  for (std::size_t depth = 0; depth < kDeepest; ++depth) {
    for (const auto& [name, X_name_to] : above) {
      if (name == frame) return X_frame_from.inverse() * X_name_to;
    }
    const auto found = frames_.find(frame);
    if (found == frames_.end()) break;
    X_frame_from = found->second.X * X_frame_from;
    frame = found->second.parent;
  }
  return std::nullopt;
}

}  // namespace prehend::drivers::ros_link
