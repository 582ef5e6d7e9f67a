#pragma once

#include "prehend/perception/segmented_scene.h"

namespace prehend::shape {

/// Log odds that an object of `scene` is one body of the shape that complete_by_symmetry() gives
/// it, by confidence.h: what the view says against the shape, for it, and how hollow it is. What is
/// hidden, cut by the image or stands on another counts for nothing, as that is no sign of a second
/// body. What cannot be completed is as unlikely as one odd in twenty. With a coarse search: 5-15
/// ms. It is what perception::split_into_bodies() asks for.
double log_odds_of_one_body(const perception::SegmentedScene& scene,
                            const perception::ObjectHypothesis& object);

}  // namespace prehend::shape
