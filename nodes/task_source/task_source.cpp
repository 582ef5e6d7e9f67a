#include "nodes/task_source/task_source.h"

#include <string>

#include "prehend/text/tree_file.h"

namespace prehend::nodes {

control::Task declare_task(graph::Node& node) {
  const auto name = node.declare_parameter<std::string>(
      {.name = "task",
       .default_value = "pick_and_place",
       .description = "what is done: pick_and_place, decide_and_pick, probe_and_pick, "
                      "look_and_pick, work_cycle, sort, clear_table, shake_test, inspect, or "
                      "another of config/tasks",
       .read_only = true});
  const auto folder =
      node.declare_parameter<std::string>({.name = "tasks",
                                           .default_value = text::tree_file("config/tasks"),
                                           .description = "folder of the task's file, TASK.yaml",
                                           .read_only = true});
  return control::read_task(control::task_file(folder, name));
}

}  // namespace prehend::nodes
