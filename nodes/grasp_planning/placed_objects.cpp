#include "nodes/grasp_planning/placed_objects.h"

#include <algorithm>
#include <cstddef>

#include "msgs/convert/geometry.h"
#include "prehend/geometry/triangle_mesh.h"

namespace prehend::nodes {
namespace {

constexpr std::size_t kMost = 64;

}  // namespace

planning::Neighbours neighbour_of(const msgs::ObjectModel& model) {
  planning::Neighbours own;
  own.meshes_W.push_back(convert::from_message(model.mesh()));
  for (const auto& piece : model.convex_pieces()) {
    own.pieces_W.push_back(convert::from_message(piece));
  }
  return own;
}

void PlacedObjects::add(const msgs::ObjectModel& model) {
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
      return std::any_of(entry.second.meshes_W.begin(), entry.second.meshes_W.end(),
                         [&one](const geometry::TriangleMesh& mesh) {
                           return geometry::bounds(mesh).intersects(one.box_W);
                         });
    });
    if (is_seen) continue;
    all.meshes_W.insert(all.meshes_W.end(), one.shape.meshes_W.begin(), one.shape.meshes_W.end());
    all.pieces_W.insert(all.pieces_W.end(), one.shape.pieces_W.begin(), one.shape.pieces_W.end());
  }
  return all;
}

}  // namespace prehend::nodes
