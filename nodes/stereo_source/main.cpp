#include <optional>
#include <string>
#include <utility>

#include "msgs/convert/images.h"
#include "msgs/sensors.pb.h"
#include "prehend/geometry/errors.h"
#include "prehend/graph/node_program.h"
#include "prehend/perception/calibration.h"
#include "prehend/perception/image_files.h"
#include "prehend/perception/rectification.h"

namespace {

using namespace prehend;

std::string declare_file(graph::Node& node, const char* name, const char* description) {
  return node.declare_parameter<std::string>(
      {.name = name, .description = description, .read_only = true, .reads_file = true});
}

void run(graph::Node& node) {
  const std::string left = declare_file(node, "left", "left image, PNG or JPEG");
  const std::string right = declare_file(node, "right", "right image of the same size");
  const std::string calibration_file =
      declare_file(node, "calibration",
                   "left camera's ROS camera_info YAML, or the folder that has left.yaml and "
                   "right.yaml; OpenCV YAML (M1 D1 M2 D2 R T, or K and baseline), plain YAML "
                   "{width, height, fx, fy, cx, cy, baseline}, or text with the nine numbers of K "
                   "and the baseline");
  const std::string right_calibration_file =
      declare_file(node, "calibration_right",
                   "right camera's camera_info YAML; empty where calibration says all");
  for (const auto& [name, value] : {std::pair{"left", left}, std::pair{"right", right},
                                    std::pair{"calibration", calibration_file}}) {
    if (value.empty()) {
      throw geometry::InputError(std::string("Parameter ") + name + " is empty", "Name a file");
    }
  }
  const perception::StereoCalibration calibration =
      perception::read_stereo_calibration(calibration_file, right_calibration_file);
  perception::RectifiedPair pair = perception::rectify(
      perception::read_color_image(left), perception::read_color_image(right), calibration);
  node.log_info("{} x {} pixels, fx {:.1f} px, baseline {:.4f} m{}", pair.camera.left.width,
                pair.camera.left.height, pair.camera.left.fx, pair.camera.baseline,
                calibration.is_rectified() ? "" : ", rectified");

  const auto info = node.advertise<msgs::CameraInfo>("/camera/info", graph::QoS::latched());
  const auto stereo = node.advertise<msgs::StereoPair>("/camera/stereo", graph::QoS::latched());
  msgs::Header header;
  header.set_stamp(node.clock().now());
  header.set_frame_id("camera");
  msgs::CameraInfo info_message = convert::to_message(pair.camera, std::nullopt);
  *info_message.mutable_header() = header;
  info.publish(info_message);
  msgs::StereoPair stereo_message =
      convert::to_message(convert::StereoImages{std::move(pair.left), std::move(pair.right)});
  *stereo_message.mutable_header() = header;
  stereo.publish(std::move(stereo_message));
  node.spin();
}

const prehend::graph::RegisteredNodeProgram registered(
    {"stereo_source",
     "Publishes a recorded stereo pair on /camera/stereo and its camera on /camera/info (both "
     "latched), rectified when the calibration says that it needs it. A file that cannot be used "
     "ends the node with the reason."},
    run);

}  // namespace
