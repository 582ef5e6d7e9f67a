#pragma once

#include <string>
#include <vector>

#include "prehend/control/arm_cycle.h"
#include "prehend/control/task.h"
#include "tests/control/gripper_cycle_fixture.h"

namespace prehend::control {

inline Task task_named(const std::string& name) {
  return read_task(task_file("config/tasks", name));
}

inline std::vector<std::string> states_of(const Cycle& cycle) {
  std::vector<std::string> names;
  for (const int state : cycle.path()) names.push_back(cycle.task().name_of(state));
  return names;
}

inline ArmCycleOptions doing(const Task& task, ArmCycleOptions options = reacting()) {
  options.task = task;
  options.look_timeout = task.all_objects ? 5 : 0;
  return options;
}

}  // namespace prehend::control
