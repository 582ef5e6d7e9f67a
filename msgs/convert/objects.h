#pragma once

#include <optional>

#include "msgs/objects.pb.h"
#include "msgs/sensors.pb.h"
#include "prehend/geometry/camera_model.h"
#include "prehend/geometry/image.h"
#include "prehend/perception/segmented_scene.h"
#include "prehend/shape/completed_shape.h"
#include "prehend/surface/object_model.h"

namespace prehend::convert {

/// Fills everything but the header. `X_WC` absent: not calibrated.
msgs::CameraInfo to_message(const geometry::StereoCamera& camera,
                            const std::optional<geometry::RigidTransform>& X_WC);
/// Intrinsics and baseline. @throws InputError for sizes, focal lengths or a baseline that cannot
/// be.
geometry::StereoCamera from_message(const msgs::CameraInfo& message);
/// The camera's pose, if the message has one.
std::optional<geometry::RigidTransform> camera_pose(const msgs::CameraInfo& message);

struct StereoImages {
  geometry::ColorImage left;
  geometry::ColorImage right;
};
/// Fills everything but header and generation; red-green-blue. @pre both images have one size.
msgs::StereoPair to_message(const StereoImages& images);
/// Grey images become red = green = blue. @throws InputError when `data` has another size.
StereoImages from_message(const msgs::StereoPair& message);

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
