#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "foxglove/CompressedImage.pb.h"
#include "foxglove/RawImage.pb.h"
#include "msgs/views/view.h"
#include "prehend/robot/platform.h"

namespace prehend::views {

/// How pictures of cameras travel.
struct ImageViews {
  bool shown = true;  // false: none do
  /// What makes them smaller; null: as they are.
  std::function<::foxglove::CompressedImage(const ::foxglove::RawImage&)> compress;
};

/// Those that there always are: /viewer/frames, /viewer/robot (with a platform), cloud, objects,
/// grasps, table, image/left and right, depth, camera and log. docs/viewer.md has their content.
std::vector<View> standard_views(std::shared_ptr<const robot::Platform> platform,
                                 const ImageViews& images = {});

/// /viewer/pad/NAME of a topic /tactile/NAME with tactile frames; nothing for another one.
std::optional<View> pad_view(const std::string& topic, std::string_view schema_name);

}  // namespace prehend::views
