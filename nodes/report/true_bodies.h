#pragma once

#include <optional>
#include <string>

#include "msgs/objects.pb.h"
#include "nodes/report/collected.h"
#include "prehend/geometry/triangle_mesh.h"
#include "prehend/surface/object_model.h"

namespace prehend::nodes {

/// What a simulation says of what an object is.
struct TrueBody {
  std::string name;
  const BodyHistory* history = nullptr;
  geometry::RigidTransform X_WB = geometry::RigidTransform::Identity();  // when it was seen
};

/// The body that stood nearest to a predicted object when it was seen, within 8 cm on the table;
/// none where nobody says where bodies are.
std::optional<TrueBody> true_body(const Collected& collected, const msgs::ObjectModel& message,
                                  const surface::ObjectModel& model);

/// Its surface in its own frame; none where nobody says it, or what is simulated are the predicted
/// meshes.
std::optional<geometry::TriangleMesh> true_mesh(const Collected& collected,
                                                const std::string& name);

}  // namespace prehend::nodes
