#include "eval/belief/predicted_case.h"

#include "eval/grasp/seen_object.h"
#include "prehend/shape/scene_completion.h"

namespace prehend::eval {

PredictedCase predict_case(const Case& one) {
  const SeenObject seen = see_object(one, one.X_WB(), 0);
  shape::CompletionOptions completion;
  completion.alternatives = 4;
  completion.other_methods = true;
  const auto shapes = shape::complete_scene(seen.scene, completion, {}, seen.index);
  return {shapes[seen.index].get(),
          perception::support_of(seen.scene, seen.scene.objects[seen.index]),
          seen.scene.X_WC.translation()};
}

}  // namespace prehend::eval
