#include <optional>
#include <string>
#include <utility>

#include "drivers/camera/driver/camera_device.h"
#include "drivers/camera/node/camera_place.h"
#include "drivers/camera/node/camera_report.h"
#include "drivers/camera/transport/video_devices.h"
#include "drivers/camera/transport/video_source.h"
#include "drivers/wire/node/late_parameter.h"
#include "msgs/camera.pb.h"
#include "msgs/convert/camera_images.h"
#include "msgs/convert/geometry.h"
#include "msgs/convert/images.h"
#include "msgs/sensors.pb.h"
#include "prehend/geometry/errors.h"
#include "prehend/graph/node_program.h"
#include "prehend/perception/calibration.h"
#include "prehend/perception/camera_calibration.h"
#include "prehend/perception/rectification.h"

namespace {

using namespace prehend;
using namespace prehend::drivers;
using namespace prehend::drivers::camera;

struct CameraSettings {
  VideoOptions video;  // of the (left) source
  std::string right;   // address of the right one, or none
  CameraOptions device;
  ViewSettings view;
  std::string calibration, calibration_right;
};

std::string declare_text(graph::Node& node, const char* name, const char* description,
                         bool reads_file = false) {
  return node.declare_parameter<std::string>(
      {.name = name, .description = description, .read_only = true, .reads_file = reads_file});
}

void declare_video(graph::Node& node, CameraSettings& s) {
  s.video.address = node.declare_parameter<std::string>(
      {.name = "source",
       .default_value = "/dev/video0",
       .description = "a V4L2 device, a video, a sequence of images (left_%04d.png) or a stream "
                      "(rtsp://, http://); of the left camera where there are two",
       .read_only = true});
  s.right = declare_text(node, "right_source", "of kind stereo: the right camera's, as source");
  const auto kind = node.declare_parameter<std::string>(
      {.name = "kind",
       .default_value = "mono",
       .choices = {"mono", "stereo", "side_by_side"},
       .description =
           "one camera; two, of source and right_source; or a stereo camera whose images "
           "are the left one beside the right one",
       .read_only = true});
  s.device.kind = kind == "stereo"         ? CameraKind::kTwo
                  : kind == "side_by_side" ? CameraKind::kSideBySide
                                           : CameraKind::kMono;
  if (s.right.empty() == (s.device.kind == CameraKind::kTwo)) {
    throw geometry::InputError(
        s.right.empty() ? "Parameter right_source is empty, and kind is stereo"
                        : "Parameter right_source is of two cameras, and kind is " + kind,
        s.right.empty() ? "Name the right camera" : "Leave it away, or choose kind stereo");
  }
  const auto declare_pixels = [&](const char* name) {
    return node.declare_parameter<int>({.name = name,
                                        .default_value = 0,
                                        .unit = "px",
                                        .minimum = 0,
                                        .maximum = 16384,
                                        .description = "of images that a device is asked for; 0: "
                                                       "as it is",
                                        .read_only = true});
  };
  s.video.width = declare_pixels("width");
  s.video.height = declare_pixels("height");
  s.video.rate = node.declare_parameter<double>(
      {.name = "frame_rate",
       .default_value = 0.0,
       .unit = "1/s",
       .minimum = 0.0,
       .maximum = 1000.0,
       .description = "that a device is asked for, or a file is played with; 0: its own",
       .read_only = true});
  s.video.format = declare_text(node, "format",
                                "four letters that a device is asked for: MJPG, YUYV; empty: as "
                                "it is");
}

// What the sources, as they are named, cannot do. (Whether they are there may change while it
// runs.)
void check_sources(const CameraSettings& s, double exposure, double gain) {
  using geometry::InputError;
  if (s.video.address.empty()) {
    throw InputError("Parameter source is empty", "Name /dev/video0, a video, or a stream");
  }
  if (!s.video.format.empty() && s.video.format.size() != 4) {
    throw InputError("Parameter format: '" + s.video.format + "' is not four letters",
                     "Write MJPG, YUYV or another one");
  }
  const bool all_devices =
      is_device_address(s.video.address) && (s.right.empty() || is_device_address(s.right));
  const bool no_device = !is_device_address(s.video.address) && !is_device_address(s.right);
  if (!all_devices && (s.video.width > 0 || s.video.height > 0 || !s.video.format.empty())) {
    throw InputError("Parameters width, height and format are asked of devices (/dev/...)",
                     "Leave them away for videos and streams");
  }
  if (no_device && (exposure >= 0 || gain >= 0)) {
    throw InputError("Parameters exposure and gain are of devices (/dev/...)",
                     "Leave them away for videos and streams");
  }
  if (s.device.loop && all_devices) {
    throw InputError("Parameter loop is of files, and a device has no end", "Leave it away");
  }
}

CameraSettings declare_settings(graph::Node& node) {
  CameraSettings s;
  declare_video(node, s);
  s.device.pair_tolerance = node.declare_parameter<double>(
      {.name = "pair_tolerance",
       .default_value = 0.0,
       .unit = "s",
       .minimum = 0.0,
       .maximum = 0.5,
       .description = "between the two frames of a pair, of two sources; 0: half a frame",
       .read_only = true});
  s.device.loop = node.declare_parameter<bool>({.name = "loop",
                                                .default_value = false,
                                                .description = "files begin anew at their end",
                                                .read_only = true});
  s.calibration = declare_text(
      node, "calibration",
      "of a pair: the folder of left.yaml and right.yaml, the left camera's camera_info YAML, or "
      "what stereo_source takes; of one camera: its camera_info YAML. Empty: of one camera, whose "
      "images are then published as they come",
      true);
  s.calibration_right =
      declare_text(node, "calibration_right",
                   "right camera's camera_info YAML, where calibration is the left one's", true);
  s.view = declare_view_settings(node);
  s.device.most_rate = s.view.rate;
  s.device.stale_time = s.view.stale_time;
  if (s.device.pair_tolerance > 0 && s.device.kind != CameraKind::kTwo) {
    throw geometry::InputError("Parameter pair_tolerance is of two sources, and there is one",
                               "Leave it away, or choose kind stereo");
  }
  if (s.device.kind == CameraKind::kMono && !s.calibration_right.empty()) {
    throw geometry::InputError("Parameter calibration_right is of a pair, and there is one camera",
                               "Leave it away, or choose kind stereo");
  }
  if (s.device.kind != CameraKind::kMono && s.calibration.empty()) {
    throw geometry::InputError("Parameter calibration is empty",
                               "A pair is rectified by its calibration: name the folder that has "
                               "left.yaml and right.yaml");
  }
  return s;
}

/// Publishes what a camera sees, rectified.
class CameraPublisher {
 public:
  CameraPublisher(graph::Node& node, const CameraSettings& settings) : node_(node), place_(node) {
    if (settings.device.kind == CameraKind::kMono && place_.is_carried()) {
      throw geometry::InputError(
          "Parameter platform is of a camera that measures depth, and one image does not",
          "Leave it away, or choose kind stereo or side_by_side");
    }
    if (settings.device.kind == CameraKind::kMono) {
      image_ = node.advertise<msgs::Image>("/camera/image", graph::QoS::latched());
      if (settings.calibration.empty()) return;
      mono_ = perception::read_camera_calibration(settings.calibration);
      mono_rectifier_.emplace(mono_->K, mono_->distortion, mono_->R,
                              perception::rectified_camera(*mono_));
    } else {
      stereo_calibration_ =
          perception::read_stereo_calibration(settings.calibration, settings.calibration_right);
      stereo_ = node.advertise<msgs::StereoPair>("/camera/stereo", graph::QoS::latched());
    }
    info_ = node.advertise<msgs::CameraInfo>("/camera/info", graph::QoS::latched());
  }

  /// @throws geometry::InputError when the view is not of the calibration's size.
  void publish(CameraView view) {
    msgs::Header header;
    header.set_stamp(graph_stamp(node_, view.stamp));
    header.set_frame_id("camera");
    if (view.right) {
      publish_pair(view, header);
      return;
    }
    msgs::Image message =
        convert::to_message(mono_rectifier_ ? (*mono_rectifier_)(view.left) : view.left);
    if (mono_) publish_info({perception::rectified_camera(*mono_), 0.0}, header);
    *message.mutable_header() = header;
    image_.publish(std::move(message));
  }

 private:
  void publish_pair(const CameraView& view, const msgs::Header& header) {
    const auto X_WC = place_.at(header.stamp());
    if (!pair_rectifier_) {
      pair_rectifier_.emplace(stereo_calibration_, view.left.width, view.left.height);
    }
    perception::RectifiedPair pair = (*pair_rectifier_)(view.left, *view.right);
    publish_info(pair.camera, header);
    msgs::StereoPair message =
        convert::to_message(convert::StereoImages{std::move(pair.left), std::move(pair.right)});
    *message.mutable_header() = header;
    if (X_WC) *message.mutable_x_wc() = convert::to_message(*X_WC);
    stereo_.publish(std::move(message));
  }
  void publish_info(const geometry::StereoCamera& camera, const msgs::Header& header) {
    if (is_info_published_) return;  // latched
    is_info_published_ = true;
    msgs::CameraInfo message = convert::to_message(camera, place_.fixed());
    *message.mutable_header() = header;
    info_.publish(message);
    node_.log_info("{} x {} pixels, fx {:.1f} px{}", camera.left.width, camera.left.height,
                   camera.left.fx,
                   camera.baseline > 0 ? fmt::format(", baseline {:.4f} m", camera.baseline) : "");
  }

  graph::Node& node_;
  CameraPlace place_;
  std::optional<perception::CameraCalibration> mono_;
  std::optional<perception::ImageRectifier> mono_rectifier_;
  perception::StereoCalibration stereo_calibration_;
  std::optional<perception::PairRectifier> pair_rectifier_;
  bool is_info_published_ = false;
  graph::Publisher<msgs::Image> image_;
  graph::Publisher<msgs::StereoPair> stereo_;
  graph::Publisher<msgs::CameraInfo> info_;
};

void run(graph::Node& node) {
  LateParameter<double> exposure(
      node, {.name = "exposure",
             .default_value = -1.0,
             .unit = "s",
             .minimum = -1.0,
             .maximum = 10.0,
             .description = "of a device; 0: by itself, -1: as it is. May be set while it runs"});
  LateParameter<double> gain(
      node, {.name = "gain",
             .default_value = -1.0,
             .minimum = -1.0,
             .maximum = 1e6,
             .description = "of a device, in its own unit; 0: by itself, -1: as it is. May be set "
                            "while it runs"});
  const CameraSettings settings = declare_settings(node);
  check_sources(settings, node.parameter<double>("exposure"), node.parameter<double>("gain"));
  DeviceReport notes(node);
  CameraPublisher publisher(node, settings);
  ViewProblem problem;
  CameraDevice device(
      settings.device,
      [&](std::size_t source, Time start) {
        VideoOptions video = settings.video;
        if (source == 1) video.address = settings.right;
        video.start = start;
        return open_video_source(video);
      },
      [&](CameraView view) { problem.shield([&] { publisher.publish(std::move(view)); }); },
      notes.taker());
  exposure.connect([&](double seconds) { device.set_exposure(seconds); });
  gain.connect([&](double value) { device.set_gain(value); });
  const CameraReport watcher(node, [&] {
    const CameraStatistics s = device.statistics();
    return CameraReport::State{.trouble = device.trouble(),
                               .view_problem = problem.words(),
                               .remark = device.remark(),
                               .is_at_end = device.is_at_end(),
                               .views = s.views,
                               .unpaired = s.unpaired[0] + s.unpaired[1],
                               .connections = s.connections};
  });
  node.spin();
}

const graph::RegisteredNodeProgram registered(
    {"camera",
     "Reads one or two V4L2 devices, a side-by-side stereo device, video files, sequences of "
     "images "
     "or streams. Of two it publishes pairs within half a frame on /camera/stereo, rectified, and "
     "the camera on /camera/info; of one /camera/image. A device that is unplugged is opened again "
     "when it is back; /camera/device tells how many frames came and how many had no partner."},
    run);

}  // namespace
