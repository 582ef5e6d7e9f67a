#include "drivers/camera/driver/probe.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "drivers/camera/transport/depth_source.h"
#include "drivers/camera/transport/video_devices.h"
#include "prehend/geometry/errors.h"

namespace prehend::drivers::camera {
namespace {

using Result = Probe::Result;

constexpr Time kPatience = std::chrono::seconds(2);

// Errors that name a mend are "what. mend."
Probe silent(const std::exception& error) {
  const auto* input = dynamic_cast<const geometry::InputError*>(&error);
  if (!input) return {Result::kSilent, error.what(), "Look at plug and supply"};
  std::string mend = std::string(error.what()).substr(input->problem().size() + 2);
  if (mend.ends_with('.')) mend.pop_back();
  return {Result::kSilent, input->problem(), mend};
}

}  // namespace

std::vector<Probe> find_cameras() {
  std::vector<Probe> found;
  for (const VideoDevice& device : video_devices()) {
    if (!device.captures) continue;
    const std::string what = fmt::format("{} ({})", device.file, device.name);
    if (device.may_open) {
      found.push_back({Result::kAnswers, what, ""});
      continue;
    }
    try {
      check_video_device(device.file);
    } catch (const geometry::InputError& error) {
      Probe probe = silent(error);
      probe.what = what + ": " + probe.what;
      found.push_back(probe);
    }
  }
  try {
    for (const std::string& device : openni_devices()) {
      found.push_back({Result::kAnswers, "depth camera " + device, ""});
    }
  } catch (const geometry::InputError& error) {
    found.push_back(silent(error));
  }
  if (found.empty()) {
    found.push_back({Result::kWarns, "this kernel shows no camera, and OpenNI2 no depth camera",
                     "Look at the cable and at `sudo dmesg`; in a container, pass /dev/video0 in"});
  }
  return found;
}

Probe probe_camera(const std::string& device) {
  try {
    check_video_device(device);
  } catch (const std::exception& error) {
    return silent(error);
  }
  std::error_code error;
  if (!std::filesystem::is_character_file(device, error)) {
    return {Result::kSilent, device + " is no camera", "Name a device as /dev/video0"};
  }
  const auto same = [&](const VideoDevice& one) {
    return std::filesystem::equivalent(one.file, device, error);
  };
  const std::vector<VideoDevice> all = video_devices();
  const auto known = std::find_if(all.begin(), all.end(), same);
  const std::string name = known == all.end() ? "" : " (" + known->name + ")";
  return {Result::kAnswers, device + name + " can be opened", ""};
}

Probe probe_depth_camera(const std::string& uri) {
  try {
    const auto source = open_openni_source({.uri = uri, .color = false});
    const Time end = steady_now() + kPatience;
    while (steady_now() < end) {
      const auto view = source->next(std::chrono::milliseconds(100));
      if (!view) continue;
      return {Result::kAnswers,
              fmt::format("{}: {} x {}, {:.3g}/s", source->name(), view->depth.width,
                          view->depth.height, source->rate()),
              ""};
    }
    return {Result::kSilent, source->name() + " sends no depth image",
            "Plug it in anew; a USB 2 line may be too slow"};
  } catch (const std::exception& error) {
    return silent(error);
  }
}

}  // namespace prehend::drivers::camera
