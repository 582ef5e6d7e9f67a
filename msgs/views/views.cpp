#include "msgs/views/views.h"

#include "msgs/camera.pb.h"
#include "msgs/convert/foxglove_images.h"
#include "msgs/convert/foxglove_objects.h"
#include "msgs/convert/foxglove_robot.h"
#include "msgs/graph.pb.h"
#include "msgs/objects.pb.h"
#include "msgs/sensors.pb.h"
#include "msgs/views/view_makers.h"

namespace prehend::views {
namespace {

/// `picture` makes a RawImage of a message of the topic.
template <class Message, class Picture>
View image_view(const char* name, const char* topic, const ImageViews& images, Picture picture) {
  if (!images.compress) {
    return simple_view<Message>(view_channel<::foxglove::RawImage>(name, 1, true), topic, picture);
  }
  return simple_view<Message>(view_channel<::foxglove::CompressedImage>(name, 1, true), topic,
                              [picture, compress = images.compress](const Message& message) {
                                return compress(picture(message));
                              });
}

void add_images(const ImageViews& images, std::vector<View>* views) {
  const auto add_eye = [&](const char* name, convert::Eye eye) {
    views->push_back(image_view<msgs::StereoPair>(
        name, "/camera/stereo", images,
        [eye](const msgs::StereoPair& pair) { return convert::stereo_image(pair, eye); }));
  };
  add_eye("/viewer/image/left", convert::Eye::kLeft);
  add_eye("/viewer/image/right", convert::Eye::kRight);
  views->push_back(simple_view<msgs::DepthImage>(
      view_channel<::foxglove::RawImage>("/viewer/image/depth", 1, true), "/camera/depth",
      [](const msgs::DepthImage& image) { return convert::depth_image(image); }));
}

}  // namespace

std::vector<View> standard_views(std::shared_ptr<const robot::Platform> platform,
                                 const ImageViews& images) {
  std::vector<View> views{
      frames_view(platform),
      objects_view(),
      grasps_view(),
      table_view(),
      truth_view(),
      simple_view<msgs::ObjectHypotheses>(
          view_channel<::foxglove::PointCloud>("/viewer/cloud", 1, true), "/objects",
          [](const msgs::ObjectHypotheses& objects) { return convert::objects_cloud(objects); }),
      simple_view<msgs::CameraInfo>(
          view_channel<::foxglove::CameraCalibration>("/viewer/camera", 1, false), "/camera/info",
          [](const msgs::CameraInfo& info) { return convert::camera_calibration(info); }),
      simple_view<msgs::graph::LogLine>(
          view_channel<::foxglove::Log>("/viewer/log", 0, true), "/log",
          [](const msgs::graph::LogLine& line) { return convert::log_line(line); })};
  if (images.shown) add_images(images, &views);
  if (platform) views.push_back(robot_view(std::move(platform)));
  return views;
}

std::optional<View> pad_view(const std::string& topic, std::string_view schema_name) {
  const std::string before = "/tactile/";
  if (topic.rfind(before, 0) != 0 || schema_name != msgs::TactileFrame::descriptor()->full_name()) {
    return std::nullopt;
  }
  return simple_view<msgs::TactileFrame>(
      view_channel<::foxglove::RawImage>("/viewer/pad/" + topic.substr(before.size()), 1, true),
      topic, [](const msgs::TactileFrame& frame) { return convert::tactile_image(frame); });
}

}  // namespace prehend::views
