#include "nodes/viewer/views.h"

#include "msgs/camera.pb.h"
#include "msgs/convert/foxglove_images.h"
#include "msgs/convert/foxglove_objects.h"
#include "msgs/convert/foxglove_robot.h"
#include "msgs/graph.pb.h"
#include "msgs/objects.pb.h"
#include "msgs/sensors.pb.h"
#include "nodes/viewer/view_makers.h"

namespace prehend::nodes {
namespace {

View stereo_view(const char* topic, convert::Eye eye) {
  return simple_view<msgs::StereoPair>(
      view_channel<::foxglove::RawImage>(topic, 1, true), "/camera/stereo",
      [eye](const msgs::StereoPair& pair) { return convert::stereo_image(pair, eye); });
}

}  // namespace

std::vector<View> standard_views(std::shared_ptr<const robot::Platform> platform) {
  std::vector<View> views{
      frames_view(platform),
      objects_view(),
      grasps_view(),
      table_view(),
      truth_view(),
      simple_view<msgs::ObjectHypotheses>(
          view_channel<::foxglove::PointCloud>("/viewer/cloud", 1, true), "/objects",
          [](const msgs::ObjectHypotheses& objects) { return convert::objects_cloud(objects); }),
      stereo_view("/viewer/image/left", convert::Eye::kLeft),
      stereo_view("/viewer/image/right", convert::Eye::kRight),
      simple_view<msgs::DepthImage>(
          view_channel<::foxglove::RawImage>("/viewer/image/depth", 1, true), "/camera/depth",
          [](const msgs::DepthImage& image) { return convert::depth_image(image); }),
      simple_view<msgs::CameraInfo>(
          view_channel<::foxglove::CameraCalibration>("/viewer/camera", 1, false), "/camera/info",
          [](const msgs::CameraInfo& info) { return convert::camera_calibration(info); }),
      simple_view<msgs::graph::LogLine>(
          view_channel<::foxglove::Log>("/viewer/log", 0, true), "/log",
          [](const msgs::graph::LogLine& line) { return convert::log_line(line); })};
  if (platform) views.push_back(robot_view(std::move(platform)));
  return views;
}

std::optional<View> pad_view(const std::string& topic, const OfferedTopic& offered) {
  const std::string before = "/tactile/";
  if (topic.rfind(before, 0) != 0 ||
      offered.schema_name != msgs::TactileFrame::descriptor()->full_name()) {
    return std::nullopt;
  }
  return simple_view<msgs::TactileFrame>(
      view_channel<::foxglove::RawImage>("/viewer/pad/" + topic.substr(before.size()), 1, true),
      topic, [](const msgs::TactileFrame& frame) { return convert::tactile_image(frame); });
}

}  // namespace prehend::nodes
