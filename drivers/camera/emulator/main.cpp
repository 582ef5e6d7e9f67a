#include <cmath>
#include <cstring>
#include <optional>
#include <string>
#include <utility>

#include "drivers/camera/emulator/depth_server.h"
#include "drivers/wire/node/fault_parameters.h"
#include "drivers/wire/node/linger.h"
#include "msgs/camera.pb.h"
#include "msgs/convert/camera_images.h"
#include "msgs/convert/images.h"
#include "msgs/sensors.pb.h"
#include "prehend/geometry/errors.h"
#include "prehend/graph/node_program.h"

namespace {

using namespace prehend;
using namespace prehend::drivers;
using namespace prehend::drivers::camera;

DepthPicture picture_of(const msgs::CameraInfo& info, const msgs::DepthImage& message) {
  const geometry::PinholeCamera camera = convert::from_message(info).left;
  const convert::ColoredDepth image = convert::from_message(message);
  if (camera.width != image.depth.width || camera.height != image.depth.height ||
      camera.width > kLargestWireSide || camera.height > kLargestWireSide || image.color.empty()) {
    throw geometry::InputError("The world's depth image is not its camera's, or without colour",
                               "Start simulation with depth:=true");
  }
  DepthPicture picture{
      0, camera.width, camera.height, camera.fx, camera.fy, camera.cx, camera.cy, {}, {}};
  picture.depth.reserve(image.depth.data.size());
  constexpr double kCount = 1e-4, kMost = 65535;
  for (const float z : image.depth.data) {
    const double counts = static_cast<double>(z) / kCount;
    picture.depth.push_back(counts >= 1 && counts <= kMost
                                ? static_cast<std::uint16_t>(std::lround(counts))
                                : std::uint16_t{0});
  }
  picture.color.resize(image.color.data.size() * 3);
  std::memcpy(picture.color.data(), image.color.data.data(), picture.color.size());
  return picture;
}

void run(graph::Node& node) {
  const int port = node.declare_parameter<int>(
      {.name = "port",
       .default_value = 11430,
       .minimum = 0,
       .maximum = 65535,
       .description = "of this host's loopback, on which the driver plug-in of OpenNI2 finds it as "
                      "prehend://127.0.0.1:PORT; 0: any free one",
       .read_only = true});
  Switch unplugged(node, "unplugged", "the cable is out");
  Switch silent(node, "silent", "it answers nothing");
  DepthServer server(static_cast<std::uint16_t>(port));
  std::shared_ptr<const msgs::CameraInfo> info;
  std::shared_ptr<const msgs::DepthImage> depth;
  const auto show = [&] {
    if (info && depth) server.show(picture_of(*info, *depth));
  };
  const auto camera = node.subscribe<msgs::CameraInfo>(
      "/world/camera/info", graph::QoS::queue(1), [&](const graph::Received<msgs::CameraInfo>& m) {
        info = m.shared();
        show();
      });
  const auto images = node.subscribe<msgs::DepthImage>(
      "/world/camera/depth", graph::QoS::latest(), [&](const graph::Received<msgs::DepthImage>& m) {
        depth = m.shared();
        show();
      });
  unplugged.connect([&](bool on) { server.set_unplugged(on); });
  silent.connect([&](bool on) { server.set_silent(on); });
  node.log_info("prehend://{}", server.address());
  node.spin();
  linger();
}

const graph::RegisteredNodeProgram registered(
    {"depth_camera_emulator",
     "Stands in for a depth camera behind OpenNI2: serves what the simulated camera sees, "
     "/world/camera/depth and /world/camera/info, to the driver plug-in of OpenNI2 that comes with "
     "it. Its faults are parameters that may be set while it runs."},
    run);

}  // namespace
