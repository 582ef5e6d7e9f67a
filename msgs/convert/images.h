#pragma once

#include <optional>
#include <string>

#include "msgs/sensors.pb.h"
#include "prehend/geometry/camera_model.h"
#include "prehend/geometry/image.h"
#include "prehend/geometry/rigid_transform.h"

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

/// Depth [m] as uint16 in 0.1 mm, little endian, row-major; 0 where it is unknown or beyond 6.5 m.
std::string pack_depth(const geometry::DepthImage& depth);
/// NaN where unknown; empty for no bytes. @throws InputError when they are not of that size.
geometry::DepthImage unpack_depth(const std::string& bytes, int width, int height);

}  // namespace prehend::convert
