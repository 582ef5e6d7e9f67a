#pragma once

#include "prehend/perception/segmented_scene.h"
#include "prehend/shape/completed_shape.h"

namespace prehend::shape {

/// What completion needs of `object`, one of `scene`'s. Both must outlive the view.
inline ObjectView view_of(const perception::SegmentedScene& scene,
                          const perception::ObjectHypothesis& object) {
  return {object.cloud_W,
          object.mask,
          scene.camera,
          scene.X_WC,
          perception::support_of(scene, object),
          &object.nearer,
          object.support_W.has_value(),
          &scene.depth,
          object.may_be_several,
          object.touches_image_border};
}

}  // namespace prehend::shape
