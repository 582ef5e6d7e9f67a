#include "prehend/shape/body_evidence.h"

#include <cmath>

#include "prehend/geometry/errors.h"
#include "prehend/shape/object_view.h"
#include "prehend/shape/symmetry.h"

namespace prehend::shape {

double log_odds_of_one_body(const perception::SegmentedScene& scene,
                            const perception::ObjectHypothesis& object) {
  constexpr double kNoShape = -3;  // log odds
  CompletionOptions coarse;
  coarse.orientations = 31;
  coarse.shifts = 21;
  coarse.thinning = 0.04;
  coarse.planes = 3;
  coarse.second_plane = false;
  ObjectView view = view_of(scene, object);
  view.depth = nullptr;  // nobody reads the seen space
  try {
    Evidence evidence = complete_by_symmetry(view, coarse).evidence;
    evidence.cut_by_image = evidence.on_another = evidence.may_be_several = false;
    evidence.occluded = 0;
    const double probability = confidence(evidence);
    return std::log(probability / (1 - probability));
  } catch (const geometry::InputError&) {
    return kNoShape;
  }
}

}  // namespace prehend::shape
