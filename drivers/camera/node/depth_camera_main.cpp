#include <optional>
#include <string>
#include <utility>

#include "drivers/camera/driver/depth_device.h"
#include "drivers/camera/node/camera_place.h"
#include "drivers/camera/node/camera_report.h"
#include "msgs/camera.pb.h"
#include "msgs/convert/camera_images.h"
#include "msgs/convert/geometry.h"
#include "msgs/convert/images.h"
#include "msgs/sensors.pb.h"
#include "prehend/geometry/errors.h"
#include "prehend/graph/node_program.h"
#include "prehend/perception/camera_calibration.h"
#include "prehend/perception/rectification.h"
#include "prehend/perception/stereo.h"

namespace {

using namespace prehend;
using namespace prehend::drivers;
using namespace prehend::drivers::camera;

struct DepthSettings {
  OpenniOptions openni;
  DepthDeviceOptions device;
  ViewSettings view;
  std::string calibration;
};

DepthSettings declare_settings(graph::Node& node) {
  DepthSettings s;
  s.openni.uri = node.declare_parameter<std::string>(
      {.name = "device",
       .description = "URI of OpenNI2, a recording .oni, prehend://HOST:PORT of the emulated "
                      "camera; empty: the only one that is plugged in",
       .read_only = true});
  const auto declare_pixels = [&](const char* name) {
    return node.declare_parameter<int>({.name = name,
                                        .default_value = 0,
                                        .unit = "px",
                                        .minimum = 0,
                                        .maximum = 16384,
                                        .description = "of the images asked for; 0: as they are",
                                        .read_only = true});
  };
  s.openni.width = declare_pixels("width");
  s.openni.height = declare_pixels("height");
  s.openni.rate = node.declare_parameter<double>({.name = "frame_rate",
                                                  .default_value = 0.0,
                                                  .unit = "1/s",
                                                  .minimum = 0.0,
                                                  .maximum = 1000.0,
                                                  .description = "asked for; 0: its own",
                                                  .read_only = true});
  s.openni.color = node.declare_parameter<bool>(
      {.name = "color",
       .default_value = true,
       .description = "also colour, to which the device registers its depth",
       .read_only = true});
  s.openni.loop = node.declare_parameter<bool>({.name = "loop",
                                                .default_value = false,
                                                .description = "a recording begins anew at its end",
                                                .read_only = true});
  s.openni.exposure = node.declare_parameter<double>(
      {.name = "exposure",
       .default_value = -1.0,
       .unit = "s",
       .minimum = -1.0,
       .maximum = 10.0,
       .description = "of the colour camera; 0: by itself, -1: as it is",
       .read_only = true});
  s.openni.gain = node.declare_parameter<double>(
      {.name = "gain",
       .default_value = -1.0,
       .minimum = -1.0,
       .maximum = 1e6,
       .description = "of the colour camera, in its own unit; 0: by itself, -1: as it is",
       .read_only = true});
  s.calibration = node.declare_parameter<std::string>(
      {.name = "calibration",
       .description = "camera_info YAML of the images (colour's where there is colour), without "
                      "rotation; empty: by the angle of view that the device tells",
       .read_only = true,
       .reads_file = true});
  s.view = declare_view_settings(node);
  s.device.most_rate = s.view.rate;
  s.device.stale_time = s.view.stale_time;
  const bool is_recording = s.openni.uri.ends_with(".oni");
  if (s.openni.loop && !is_recording) {
    throw geometry::InputError("Parameter loop is of recordings (.oni)", "Leave it away");
  }
  if (is_recording && (s.openni.exposure >= 0 || s.openni.gain >= 0)) {
    throw geometry::InputError("Parameters exposure and gain do nothing to a recording",
                               "Leave them away");
  }
  if (is_recording && (s.openni.width > 0 || s.openni.height > 0 || s.openni.rate > 0)) {
    throw geometry::InputError(
        "Parameters width, height and frame_rate are asked of devices; a recording has the mode it "
        "was recorded with",
        "Leave them away");
  }
  if (!s.openni.color && (s.openni.exposure >= 0 || s.openni.gain >= 0)) {
    throw geometry::InputError("Parameters exposure and gain are of colour, and color is false",
                               "Leave them away");
  }
  return s;
}

/// Publishes what a depth camera sees.
class DepthPublisher {
 public:
  DepthPublisher(graph::Node& node, const DepthSettings& settings) : node_(node), place_(node) {
    if (!settings.calibration.empty()) {
      calibration_ = perception::read_camera_calibration(settings.calibration);
      if (!calibration_->R.isIdentity(1e-6)) {
        throw geometry::InputError(
            "Calibration '" + settings.calibration + "' turns the images, which depth cannot be",
            "Pass a camera_info whose rectification_matrix is the identity");
      }
      rectifier_.emplace(calibration_->K, calibration_->distortion, calibration_->R,
                         perception::rectified_camera(*calibration_));
    }
    info_ = node.advertise<msgs::CameraInfo>("/camera/info", graph::QoS::latched());
    depth_ = node.advertise<msgs::DepthImage>("/camera/depth", graph::QoS::latched());
    cloud_ = node.advertise<msgs::PointCloud>("/camera/cloud", graph::QoS::latched());
  }

  /// @throws geometry::InputError when the view is not of the calibration's size.
  void publish(DepthView view) {
    if (rectifier_) {
      view.depth = (*rectifier_)(view.depth);
      if (!view.color.empty()) view.color = (*rectifier_)(view.color);
      view.camera = perception::rectified_camera(*calibration_);
    }
    msgs::Header header;
    header.set_stamp(graph_stamp(node_, view.stamp));
    header.set_frame_id("camera");
    const auto X_WC = place_.at(header.stamp());
    publish_info(view.camera, header);
    cloud_.publish(
        convert::to_message(perception::cloud_from_depth(view.depth, view.camera, view.color)));
    msgs::DepthImage message = convert::to_message(
        convert::ColoredDepth{std::move(view.depth), std::move(view.color)}, view.unit);
    *message.mutable_header() = header;
    if (X_WC) *message.mutable_x_wc() = convert::to_message(*X_WC);
    depth_.publish(std::move(message));
  }

 private:
  void publish_info(const geometry::PinholeCamera& camera, const msgs::Header& header) {
    msgs::CameraInfo message =
        convert::to_message(geometry::StereoCamera{camera, 0.0}, place_.fixed());
    const std::string content = message.SerializeAsString();
    if (content == info_content_) return;  // latched
    info_content_ = content;
    *message.mutable_header() = header;
    info_.publish(message);
    node_.log_info("{} x {} pixels, fx {:.1f} px", camera.width, camera.height, camera.fx);
  }

  graph::Node& node_;
  CameraPlace place_;
  std::optional<perception::CameraCalibration> calibration_;
  std::optional<perception::ImageRectifier> rectifier_;
  std::string info_content_;
  graph::Publisher<msgs::CameraInfo> info_;
  graph::Publisher<msgs::DepthImage> depth_;
  graph::Publisher<msgs::PointCloud> cloud_;
};

void run(graph::Node& node) {
  const DepthSettings settings = declare_settings(node);
  DeviceReport notes(node);
  DepthPublisher publisher(node, settings);
  ViewProblem problem;
  DepthDevice device(
      settings.device, [&] { return open_openni_source(settings.openni); },
      [&](DepthView view) { problem.shield([&] { publisher.publish(std::move(view)); }); },
      notes.taker());
  const CameraReport watcher(node, [&] {
    const DepthStatistics s = device.statistics();
    return CameraReport::State{.trouble = device.trouble(),
                               .view_problem = problem.words(),
                               .remark = device.remark(),
                               .is_at_end = device.is_at_end(),
                               .views = s.views,
                               .unpaired = s.unpaired,
                               .connections = s.connections};
  });
  node.spin();
}

const graph::RegisteredNodeProgram registered(
    {"depth_camera",
     "Reads a depth camera, or a recording .oni of one, through OpenNI2, and publishes its depth "
     "with colour on /camera/depth, the organized cloud in metres on /camera/cloud, and the camera "
     "on /camera/info. A camera that is unplugged is opened again when it is back; /camera/device "
     "tells how many images came."},
    run);

}  // namespace
