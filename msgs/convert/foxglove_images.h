#pragma once

#include "foxglove/CameraCalibration.pb.h"
#include "foxglove/Log.pb.h"
#include "foxglove/RawImage.pb.h"
#include "msgs/camera.pb.h"
#include "msgs/graph.pb.h"
#include "msgs/sensors.pb.h"

namespace prehend::convert {

enum class Eye { kLeft, kRight };

/// mono8 or rgb8. @throws geometry::InputError when `data` does not fit its size.
::foxglove::RawImage stereo_image(const msgs::StereoPair& pair, Eye eye);
/// The depths [m] as 32FC1, NaN where they are unknown. @throws as stereo_image.
::foxglove::RawImage depth_image(const msgs::DepthImage& image);
/// A tactile frame as 32FC1, rows x columns, N of each texel. @throws as stereo_image.
::foxglove::RawImage tactile_image(const msgs::TactileFrame& frame);
/// Without distortion; of the left camera of a stereo one.
::foxglove::CameraCalibration camera_calibration(const msgs::CameraInfo& info);
::foxglove::Log log_line(const msgs::graph::LogLine& line);

}  // namespace prehend::convert
