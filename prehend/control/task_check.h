#pragma once

#include <string>

#include "prehend/control/task.h"

namespace prehend::control {

/// What keeps a task from being done.
struct TaskProblem {
  int state = -1;    // where
  std::string what;  // "cannot be reached from the start"; empty: nothing
  std::string mend;
};

/// The first problem of a task whose states name one another as they should.
TaskProblem problem_of(const Task& task);

}  // namespace prehend::control
