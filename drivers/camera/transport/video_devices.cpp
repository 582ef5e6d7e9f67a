#include "drivers/camera/transport/video_devices.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <grp.h>
#include <linux/videodev2.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fstream>

#include "prehend/geometry/errors.h"

namespace prehend::drivers::camera {
namespace {

using geometry::InputError;

enum class Captures { kYes, kNo, kIsNoVideo, kUnknown };

// Asks what it can do; one that may not be opened, or is busy, says nothing.
Captures captures(const std::string& file) {
  const int descriptor = ::open(file.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  if (descriptor < 0) return Captures::kUnknown;
  v4l2_capability capability{};
  const bool answered = ::ioctl(descriptor, VIDIOC_QUERYCAP, &capability) == 0;
  const int error = errno;
  ::close(descriptor);
  if (!answered) return error == ENOTTY ? Captures::kIsNoVideo : Captures::kUnknown;
  const bool has_own = (capability.capabilities & V4L2_CAP_DEVICE_CAPS) != 0;
  const auto all = has_own ? capability.device_caps : capability.capabilities;
  const bool has_images = (all & (V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_VIDEO_CAPTURE_MPLANE)) != 0;
  return has_images ? Captures::kYes : Captures::kNo;
}

int number_of(const std::string& file_name) {
  const std::string digits = file_name.substr(std::strlen("video"));
  return digits.size() > 6 ? -1 : std::atoi(digits.c_str());
}

bool is_video_name(const std::string& name) {
  constexpr std::size_t kPrefix = 5;
  return name.starts_with("video") && name.size() > kPrefix &&
         std::all_of(name.begin() + kPrefix, name.end(),
                     [](unsigned char c) { return std::isdigit(c) != 0; });
}

std::string group_of(const std::string& file) {
  struct stat status {};
  if (::stat(file.c_str(), &status) != 0) return "video";
  const group* owner = ::getgrgid(status.st_gid);
  return owner ? owner->gr_name : std::to_string(status.st_gid);
}

std::string those_there(const VideoFolders& folders) {
  std::string all;
  for (const VideoDevice& device : video_devices(folders)) {
    if (!device.captures) continue;
    all += (all.empty() ? "" : ", ") + device.file +
           (device.name.empty() ? "" : " (" + device.name + ")");
  }
  return all;
}

}  // namespace

std::vector<VideoDevice> video_devices(const VideoFolders& folders) {
  std::vector<VideoDevice> devices;
  std::error_code error;  // devices come and go
  for (const auto& entry : std::filesystem::directory_iterator(folders.devices, error)) {
    const std::string name = entry.path().filename();
    if (!is_video_name(name)) continue;
    VideoDevice device;
    device.file = entry.path();
    std::ifstream words(folders.names / name / "name");
    std::getline(words, device.name);
    device.may_open = ::access(device.file.c_str(), R_OK | W_OK) == 0;
    device.captures = !device.may_open || captures(device.file) != Captures::kNo;
    devices.push_back(std::move(device));
  }
  std::sort(devices.begin(), devices.end(), [](const VideoDevice& a, const VideoDevice& b) {
    const auto number = [](const VideoDevice& d) {
      return number_of(std::filesystem::path(d.file).filename());
    };
    return number(a) < number(b);
  });
  return devices;
}

bool is_device_address(const std::string& address) { return address.starts_with("/dev/"); }

void check_video_device(const std::string& file, const VideoFolders& folders) {
  struct stat status {};
  if (::stat(file.c_str(), &status) != 0) {
    const int problem = errno;
    const std::string there = those_there(folders);
    if (problem == EACCES)
      throw InputError("no permission to look for " + file, "Check its folders");
    throw InputError("there is no camera " + file,
                     there.empty() ? "No camera is plugged in that this kernel knows; look at the "
                                     "cable and at `sudo dmesg`"
                                   : "There are " + there);
  }
  if (S_ISDIR(status.st_mode) || (is_device_address(file) && !S_ISCHR(status.st_mode))) {
    throw InputError(file + " is no camera", "Name a device as /dev/video0");
  }
  if (::access(file.c_str(), R_OK | W_OK) != 0) {
    const std::string group = group_of(file);
    throw InputError(
        "no permission to open " + file,
        fmt::format("It belongs to the group {0}: 'sudo usermod -aG {0} $USER', then log in again",
                    group));
  }
  const Captures what = captures(file);
  if (what == Captures::kIsNoVideo && S_ISCHR(status.st_mode)) {
    throw InputError(file + " is no camera", "Name a device as /dev/video0");
  }
  if (what == Captures::kNo) {
    throw InputError(
        file + " gives no images (it is a camera's metadata)",
        "The camera's images come from another one: there are " + those_there(folders));
  }
}

}  // namespace prehend::drivers::camera
