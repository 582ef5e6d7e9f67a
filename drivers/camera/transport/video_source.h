#pragma once

#include <memory>
#include <string>

#include "drivers/camera/transport/frame_source.h"

namespace prehend::drivers::camera {

struct VideoOptions {
  /// "/dev/video0", "/dev/v4l/by-id/...": a V4L2 device. "http://...", "rtsp://...": a stream. Else
  /// a video file, or a sequence of images "left_%04d.png".
  std::string address = {};
  int width = 0;  // pixels to ask a device for; 0: as it is
  int height = 0;
  double rate = 0;  // 1/s: to ask a device for; how a sequence of images is played. 0: as it is
  std::string format = {};  // four letters to ask a device for: "MJPG", "YUYV"; "": as it is
  Time start{};             // of a file: when its first frame is due
};

/// Opens it by OpenCV's videoio. A device that does not offer what is asked of it is refused; of
/// exposure and gain the source itself says later what it would not do.
/// @throws geometry::InputError naming the address, what is wrong, and the mend.
std::unique_ptr<FrameSource> open_video_source(const VideoOptions& options);

}  // namespace prehend::drivers::camera
