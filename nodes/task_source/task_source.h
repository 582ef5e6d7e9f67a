#pragma once

#include "prehend/control/task.h"
#include "prehend/graph/node.h"

// The task of a graph: what its cycle does, where its planner puts things, and how well its stages
// see, predict and plan.
namespace prehend::nodes {

/// Declares the parameters `task` and `tasks`, and reads the task.
/// @throws geometry::InputError for one that is not there, or that cannot be done.
control::Task declare_task(graph::Node& node);

}  // namespace prehend::nodes
