#pragma once

#include <string>

#include "prehend/control/task.h"
#include "prehend/fidelity/front.h"

// What the chain from images to ranked grasps is asked for, by the parameters of a node or by the
// task of the graph, the same for all of its nodes.
namespace prehend::nodes {

struct AskedFidelity {
  double budget = 0;     // s of processor; 0: none asked for
  double tolerance = 0;  // m, mean error of the meshes; 0: none asked for
  std::string task_at;   // where in the task's file it stands; empty: the parameters ask, or nobody

  bool is_asked() const { return budget > 0 || tolerance > 0; }
};

/// @param budget @param tolerance the node's parameters [s, m]; 0: not given.
/// @throws geometry::InputError naming the task's line when both it and a parameter ask.
AskedFidelity asked_fidelity(const control::Task& task, double budget, double tolerance);

/// Reads the front to choose from. @throws geometry::InputError when it cannot be read, when none
/// is named, and when a task asks, which speaks of whole chains, and it is of something else.
fidelity::Front read_asked_front(const std::string& file, const AskedFidelity& asked);

/// As fidelity::choose_for_stage(). @throws as that does; where a task asks in vain, an error that
/// names its line and what to write there.
const fidelity::Setting& choose_asked(const fidelity::Front& front, const AskedFidelity& asked);

}  // namespace prehend::nodes
