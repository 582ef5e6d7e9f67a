#include "nodes/grasp_planning/placed_objects.h"

#include <algorithm>
#include <cstddef>

#include "msgs/convert/geometry.h"
#include "prehend/geometry/triangle_mesh.h"

namespace prehend::nodes {
namespace {

constexpr std::size_t kMost = 64;
constexpr double kFragment = 0.4;  // of the box's volume: what is smaller may be a part that shows

}  // namespace

planning::Neighbours neighbour_of(const msgs::ObjectModel& model) {
  planning::Neighbours own;
  own.meshes_W.push_back(convert::from_message(model.mesh()));
  for (const auto& piece : model.convex_pieces()) {
    own.pieces_W.push_back(convert::from_message(piece));
  }
  return own;
}

bool PlacedObjects::Placed::is_seen_as(const planning::Neighbours& other) const {
  const Eigen::AlignedBox3d seen_W = geometry::bounds(other.meshes_W.front());
  if (seen_W.volume() < kFragment * box_W.volume()) return false;
  const Eigen::Vector3d middle_W = box_W.center();
  return box_W.contains(seen_W.center().eval()) ||
         std::any_of(other.pieces_W.begin(), other.pieces_W.end(),
                     [&middle_W](const geometry::TriangleMesh& piece) {
                       return geometry::bounds(piece).contains(middle_W);
                     });
}

void PlacedObjects::add(const msgs::ObjectModel& model, const planning::Neighbours* picked) {
  if (picked) {
    std::erase_if(placed_, [picked](const Placed& one) { return one.is_seen_as(*picked); });
  }
  Placed one{neighbour_of(model), {}};
  one.box_W = geometry::bounds(one.shape.meshes_W.front());
  placed_.push_back(std::move(one));
  if (placed_.size() > kMost) placed_.pop_front();
}

planning::Neighbours PlacedObjects::unseen(
    const std::map<std::uint32_t, planning::Neighbours>& seen) const {
  planning::Neighbours all;
  for (const Placed& one : placed_) {
    const bool is_seen = std::any_of(seen.begin(), seen.end(), [&one](const auto& entry) {
      return one.is_seen_as(entry.second);
    });
    if (is_seen) continue;
    all.meshes_W.insert(all.meshes_W.end(), one.shape.meshes_W.begin(), one.shape.meshes_W.end());
    all.pieces_W.insert(all.pieces_W.end(), one.shape.pieces_W.begin(), one.shape.pieces_W.end());
  }
  return all;
}

}  // namespace prehend::nodes
