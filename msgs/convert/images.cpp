#include "msgs/convert/images.h"

#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>

#include "msgs/convert/geometry.h"
#include "msgs/convert/mend.h"
#include "prehend/geometry/errors.h"

namespace prehend::convert {
namespace {

using geometry::InputError;

constexpr std::uint32_t kLargestSide = 16384;  // pixels
constexpr double kDepthUnit = 1e-4;            // m per count

void copy_image(const char* in, std::uint32_t channels, geometry::ColorImage& image) {
  for (auto& pixel : image.data) {
    for (std::uint32_t k = 0; k < 3; ++k) {
      pixel[k] = static_cast<std::uint8_t>(in[channels == 3 ? k : 0]);
    }
    in += channels;
  }
}

}  // namespace

msgs::CameraInfo to_message(const geometry::StereoCamera& camera,
                            const std::optional<geometry::RigidTransform>& X_WC) {
  msgs::CameraInfo message;
  message.set_width(static_cast<std::uint32_t>(camera.left.width));
  message.set_height(static_cast<std::uint32_t>(camera.left.height));
  message.set_fx(camera.left.fx);
  message.set_fy(camera.left.fy);
  message.set_cx(camera.left.cx);
  message.set_cy(camera.left.cy);
  message.set_baseline(camera.baseline);
  if (X_WC) *message.mutable_x_wc() = to_message(*X_WC);
  return message;
}

geometry::StereoCamera from_message(const msgs::CameraInfo& message) {
  const bool sizes = message.width() > 0 && message.height() > 0 &&
                     message.width() <= kLargestSide && message.height() <= kLargestSide;
  if (!sizes || !(message.fx() > 0) || !(message.fy() > 0) || !std::isfinite(message.fx()) ||
      !std::isfinite(message.fy()) || !std::isfinite(message.cx()) ||
      !std::isfinite(message.cy()) || !(message.baseline() >= 0)) {
    throw InputError("A camera without positive size, focal lengths or with a negative baseline",
                     "Check the calibration that the camera's node was given");
  }
  geometry::StereoCamera camera;
  camera.left = {static_cast<int>(message.width()),
                 static_cast<int>(message.height()),
                 message.fx(),
                 message.fy(),
                 message.cx(),
                 message.cy()};
  camera.baseline = message.baseline();
  return camera;
}

std::optional<geometry::RigidTransform> camera_pose(const msgs::CameraInfo& message) {
  if (!message.has_x_wc()) return std::nullopt;
  return from_message(message.x_wc());
}

msgs::StereoPair to_message(const StereoImages& images) {
  msgs::StereoPair message;
  message.set_width(static_cast<std::uint32_t>(images.left.width));
  message.set_height(static_cast<std::uint32_t>(images.left.height));
  message.set_channels(3);
  const std::size_t bytes = images.left.data.size() * 3;
  std::string& data = *message.mutable_data();
  data.resize(2 * bytes);
  std::memcpy(data.data(), images.left.data.data(), bytes);
  std::memcpy(data.data() + bytes, images.right.data.data(), bytes);
  return message;
}

StereoImages from_message(const msgs::StereoPair& message) {
  const std::uint64_t bytes =
      std::uint64_t{message.width()} * message.height() * message.channels();
  if (bytes == 0 || message.width() > kLargestSide || message.height() > kLargestSide ||
      (message.channels() != 1 && message.channels() != 3) || message.data().size() != 2 * bytes) {
    throw InputError("A stereo pair of " + std::to_string(message.width()) + "x" +
                         std::to_string(message.height()) + "x" +
                         std::to_string(message.channels()) + " has " +
                         std::to_string(message.data().size()) + " bytes of data",
                     "The sender must fill sizes and data as msgs/sensors.proto says");
  }
  const int width = static_cast<int>(message.width());
  const int height = static_cast<int>(message.height());
  StereoImages images{geometry::ColorImage(width, height), geometry::ColorImage(width, height)};
  copy_image(message.data().data(), message.channels(), images.left);
  copy_image(message.data().data() + bytes, message.channels(), images.right);
  return images;
}

std::string pack_depth(const geometry::DepthImage& depth) {
  std::string bytes(depth.data.size() * 2, '\0');
  for (std::size_t i = 0; i < depth.data.size(); ++i) {
    const double counts = depth.data[i] / kDepthUnit;
    const auto value =
        static_cast<std::uint16_t>(counts >= 1 && counts <= 65535 ? std::lround(counts) : 0);
    std::memcpy(&bytes[2 * i], &value, 2);
  }
  return bytes;
}

geometry::DepthImage unpack_depth(const std::string& bytes, int width, int height) {
  geometry::DepthImage depth;
  if (bytes.empty()) return depth;
  depth = geometry::DepthImage(width, height, std::numeric_limits<float>::quiet_NaN());
  if (bytes.size() != depth.data.size() * 2) {
    throw InputError("A depth image does not have its camera's size", kSenderMend);
  }
  for (std::size_t i = 0; i < depth.data.size(); ++i) {
    std::uint16_t value;
    std::memcpy(&value, &bytes[2 * i], 2);
    if (value != 0) depth.data[i] = static_cast<float>(value * kDepthUnit);
  }
  return depth;
}

}  // namespace prehend::convert
