#pragma once

#include "msgs/objects.pb.h"
#include "prehend/perception/segmented_scene.h"
#include "prehend/shape/completed_shape.h"
#include "prehend/surface/object_model.h"

namespace prehend::convert {

/// Fills everything but header and times. Masks are cut to their bounding windows.
msgs::ObjectHypotheses to_message(const perception::SegmentedScene& scene);
/// Masks are whole images again. @throws InputError for windows outside the image, or no X_WC.
perception::SegmentedScene from_message(const msgs::ObjectHypotheses& message);

/// Fills cloud, what is known of each point, planes, viewpoints, method, evidence, confidence and
/// alternatives.
msgs::CompletedShape to_message(const shape::CompletedShape& shape);
/// Without `support`, predicted points count as unseen and as not sure at all.
/// @throws InputError when `origin`, or a `support` or `point_confidence` that is there, does not
/// have one byte for each point, or an alternative has alternatives.
shape::CompletedShape from_message(const msgs::CompletedShape& message);

/// Fills mesh, pieces, mass properties, deviation, defects, what the vertices rest on and
/// alternatives.
msgs::ObjectModel to_message(const surface::ObjectModel& model);
/// @throws InputError when the inertia or what is said of the vertices does not have its size.
surface::ObjectModel from_message(const msgs::ObjectModel& message);

}  // namespace prehend::convert
