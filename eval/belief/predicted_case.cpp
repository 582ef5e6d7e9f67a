#include "eval/belief/predicted_case.h"

#include <utility>

#include "eval/belief/rendered_hold.h"
#include "eval/grasp/seen_object.h"
#include "prehend/shape/scene_completion.h"

namespace prehend::eval {

PredictedCase predict_case(const Case& one, const std::optional<CarriedView>& view) {
  RenderedScene rendered = scene_of(one);
  if (view) {
    rendered.scene.camera.carried = view->X_WC;
    add_links(view->links_W, &rendered);
  }
  const geometry::RigidTransform X_said = view ? view->X_said : rendered.scene.camera.X_WC();
  const SeenObject seen = see_object(std::move(rendered), X_said, view ? view->look : 0);
  shape::CompletionOptions completion;
  completion.alternatives = 4;
  completion.other_methods = true;
  const auto shapes = shape::complete_scene(seen.scene, completion, {}, seen.index);
  return {shapes[seen.index].get(),
          perception::support_of(seen.scene, seen.scene.objects[seen.index]),
          seen.scene.X_WC.translation()};
}

}  // namespace prehend::eval
