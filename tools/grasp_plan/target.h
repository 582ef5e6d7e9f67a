#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "prehend/geometry/plane.h"
#include "prehend/grasp/known/grasp_memory.h"
#include "prehend/surface/object_model.h"
#include "tools/grasp_plan/choices.h"
#include "tools/grasp_plan/chosen_chain.h"
#include "tools/grasp_plan/progress.h"

namespace prehend::tools {

using StageTimes = std::vector<std::pair<std::string, double>>;  // name, s

/// What grasps are planned on.
struct PlanTarget {
  surface::ObjectModel object;
  std::vector<std::vector<geometry::TriangleMesh>> neighbours_W;  // convex pieces of each
  geometry::Plane table_W;
  std::optional<grasp::PlacedObject> known;    // a mesh that was given or found, not predicted
  std::optional<fidelity::ChosenChain> chain;  // what --budget or --tolerance chose for a cloud
  std::vector<std::string> notes;              // what was assumed, in words
  StageTimes times;
};

/// Reads the mesh, or segments, completes and meshes the cloud; `progress` is told its stages.
/// @throws geometry::InputError naming the file and the mend.
PlanTarget read_target(const PlanChoices& choices, Progress& progress);

}  // namespace prehend::tools
