#pragma once

#include <string>
#include <vector>

#include "drivers/wire/probe/probe.h"

namespace prehend::drivers::camera {

/// The cameras of this host, a line each: V4L2 devices with what hinders their use, and depth
/// cameras that OpenNI2 lists. Nothing is set or started.
std::vector<Probe> find_cameras();

/// Whether a V4L2 device is there and may be opened; no image is taken.
Probe probe_camera(const std::string& device);

/// Opens a depth camera as node depth_camera would (a URI of OpenNI2, a recording; "": the only
/// one) and takes a depth image.
Probe probe_depth_camera(const std::string& uri);

}  // namespace prehend::drivers::camera
