#include "nodes/grasp_planning/task_places.h"

#include <Eigen/Geometry>

#include "prehend/geometry/errors.h"

namespace prehend::nodes {

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
