#include "nodes/task_source/task_source.h"

#include <string>
#include <utility>

#include <Eigen/Geometry>

#include "prehend/geometry/errors.h"
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

planning::PlaceOptions places_of(const control::Task& task,
                                 const std::vector<Eigen::Vector3d>& object_W,
                                 planning::PlaceOptions options) {
  if (task.places.empty()) return options;
  if (options.given_W) {
    throw geometry::InputError(
        "Parameter place does not apply: the task '" + task.name + "' has its own places",
        "Leave it out, or take another task");
  }
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& p : object_W) box.extend(p);
  const control::TaskPlace* place = task.place_for(box.sizes().maxCoeff());
  options.region_W.emplace();
  options.region_W->name = place->name;
  options.region_W->center = place->center;
  options.region_W->size = place->size;
  return options;
}

}  // namespace prehend::nodes
