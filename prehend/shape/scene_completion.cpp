#include "prehend/shape/scene_completion.h"

#include <chrono>

#include "prehend/shape/neighbors.h"
#include "prehend/shape/object_view.h"
#include "prehend/shape/symmetry.h"

namespace prehend::shape {

std::vector<SceneShape> complete_scene(const perception::SegmentedScene& scene,
                                       const CompletionOptions& options,
                                       const ConfidenceModel& model,
                                       std::optional<std::size_t> alternatives_of) {
  CompletionOptions plain = options;
  plain.alternatives = 0;
  plain.other_methods = false;
  std::vector<SceneShape> result(scene.objects.size());
  std::vector<CompletedShape*> completed;
  for (std::size_t i = 0; i < result.size(); ++i) {
    const auto start = std::chrono::steady_clock::now();
    try {
      const bool gets_all = !alternatives_of || *alternatives_of == i;
      result[i].shape =
          complete_by_symmetry(view_of(scene, scene.objects[i]), gets_all ? options : plain, model);
      completed.push_back(&result[i].shape);
    } catch (const std::exception&) {
      result[i].error = std::current_exception();
    }
    const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - start;
    result[i].seconds = spent.count();
  }
  keep_apart(completed, scene.table_W);
  return result;
}

}  // namespace prehend::shape
