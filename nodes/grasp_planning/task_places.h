#pragma once

#include <vector>

#include <Eigen/Core>

#include "prehend/control/task.h"
#include "prehend/planning/free_places.h"

// Where the planner puts what the task moves.
namespace prehend::nodes {

/// Where the task puts an object of these points [m]: `options` with the region of its place, as
/// they are when it has none. @throws geometry::InputError when all its places are for smaller
/// things, or a place was given as well.
planning::PlaceOptions places_of(const control::Task& task,
                                 const std::vector<Eigen::Vector3d>& object_W,
                                 planning::PlaceOptions options);

}  // namespace prehend::nodes
