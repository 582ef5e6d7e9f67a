#include "nodes/report/true_bodies.h"

#include <algorithm>

#include "msgs/convert/geometry.h"
#include "prehend/graph/clock.h"

namespace prehend::nodes {
namespace {

constexpr double kSameBody = 0.08;  // m, from an object's middle to the body that it is

}  // namespace

std::optional<TrueBody> true_body(const Collected& collected, const msgs::ObjectModel& message,
                                  const surface::ObjectModel& model) {
  const Eigen::Vector3d middle_W = geometry::bounds(model.mesh_W).center();
  const double seen = graph::seconds(message.header().stamp());
  std::optional<TrueBody> nearest;
  double distance = kSameBody;
  for (const auto& [name, body] : collected.bodies) {
    if (body.poses.empty()) continue;
    const geometry::RigidTransform& X_WB = value_at(body.poses, seen);
    const auto mesh_B = true_mesh(collected, name);
    const Eigen::Vector3d here_W =
        mesh_B ? X_WB * geometry::bounds(*mesh_B).center() : Eigen::Vector3d(X_WB.translation());
    const double beside = (here_W - middle_W).head<2>().norm();
    if (beside >= distance) continue;
    nearest = TrueBody{name, &body, X_WB};
    distance = beside;
  }
  return nearest;
}

std::optional<geometry::TriangleMesh> true_mesh(const Collected& collected,
                                                const std::string& name) {
  if (collected.on_prediction) return std::nullopt;
  const auto found =
      std::find_if(collected.true_shapes.shapes().begin(), collected.true_shapes.shapes().end(),
                   [&name](const auto& shape) { return shape.name() == name; });
  if (found == collected.true_shapes.shapes().end()) return std::nullopt;
  return convert::from_message(found->mesh());
}

}  // namespace prehend::nodes
