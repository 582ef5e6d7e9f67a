#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace prehend::drivers::camera {

/// A V4L2 device of this host.
struct VideoDevice {
  std::string file;       // "/dev/video0"
  std::string name;       // as the kernel calls it: "HD Webcam C525"
  bool may_open = false;  // by this user
  bool captures = true;   // false: it gives no images (metadata); unknown counts as true
};

/// Where the kernel keeps them; another folder in tests.
struct VideoFolders {
  std::filesystem::path devices = "/dev";
  std::filesystem::path names = "/sys/class/video4linux";
};

/// All V4L2 devices, by number. Opens each for reading and asks what it can do; sets nothing.
std::vector<VideoDevice> video_devices(const VideoFolders& folders = {});

/// True for "/dev/..." and what links there: a device, no file with images.
bool is_device_address(const std::string& address);

/// Throws what is wrong with a device that is about to be opened: not there (with those that are),
/// no device, no permission (with the group), none that gives images.
/// @throws geometry::InputError
void check_video_device(const std::string& file, const VideoFolders& folders = {});

}  // namespace prehend::drivers::camera
