#pragma once

#include <vector>

#include <Eigen/Core>

#include "prehend/control/task.h"
#include "prehend/graph/node.h"
#include "prehend/planning/free_places.h"

// The task of a graph: what its cycle does, and where its planner puts things.
namespace prehend::nodes {

/// Declares the parameters `task` and `tasks`, and reads the task.
/// @throws geometry::InputError for one that is not there, or that cannot be done.
control::Task declare_task(graph::Node& node);

/// Where the task puts an object of these points [m]: `options` with the region of its place, as
/// they are when it has none. @throws geometry::InputError when all its places are for smaller
/// things, or a place was given as well.
planning::PlaceOptions places_of(const control::Task& task,
                                 const std::vector<Eigen::Vector3d>& object_W,
                                 planning::PlaceOptions options);

}  // namespace prehend::nodes
