#include "msgs/convert/camera_images.h"

#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string>

#include "msgs/convert/mend.h"
#include "prehend/geometry/errors.h"

namespace prehend::convert {
namespace {

using geometry::InputError;

constexpr std::uint32_t kLongestSide = 16384;  // pixels

bool is_size(std::uint32_t width, std::uint32_t height) {
  return width > 0 && height > 0 && width <= kLongestSide && height <= kLongestSide;
}

std::string size_text(std::uint32_t width, std::uint32_t height) {
  return std::to_string(width) + "x" + std::to_string(height);
}

}  // namespace

msgs::Image to_message(const geometry::ColorImage& image) {
  msgs::Image message;
  message.set_width(static_cast<std::uint32_t>(image.width));
  message.set_height(static_cast<std::uint32_t>(image.height));
  message.set_channels(3);
  message.mutable_data()->assign(reinterpret_cast<const char*>(image.data.data()),
                                 image.data.size() * 3);
  return message;
}

geometry::ColorImage from_message(const msgs::Image& message) {
  const std::uint64_t pixels = std::uint64_t{message.width()} * message.height();
  const std::uint32_t channels = message.channels();
  if (!is_size(message.width(), message.height()) || (channels != 1 && channels != 3) ||
      message.data().size() != pixels * channels) {
    throw InputError("An image of " + size_text(message.width(), message.height()) + "x" +
                         std::to_string(channels) + " has " +
                         std::to_string(message.data().size()) + " bytes of data",
                     kSenderMend);
  }
  geometry::ColorImage image(static_cast<int>(message.width()), static_cast<int>(message.height()));
  const char* in = message.data().data();
  for (geometry::Rgb& pixel : image.data) {
    for (std::uint32_t k = 0; k < 3; ++k) {
      pixel[k] = static_cast<std::uint8_t>(in[channels == 3 ? k : 0]);
    }
    in += channels;
  }
  return image;
}

msgs::DepthImage to_message(const ColoredDepth& image, double unit) {
  constexpr double kMost = std::numeric_limits<std::uint16_t>::max();
  const std::size_t pixels = image.depth.data.size();
  msgs::DepthImage message;
  message.set_width(static_cast<std::uint32_t>(image.depth.width));
  message.set_height(static_cast<std::uint32_t>(image.depth.height));
  message.set_unit(unit);
  message.set_has_color(!image.color.empty());
  std::string& data = *message.mutable_data();
  data.resize(pixels * (image.color.empty() ? 2 : 5));
  for (std::size_t i = 0; i < pixels; ++i) {
    const double counts = static_cast<double>(image.depth.data[i]) / unit;
    const auto value =
        static_cast<std::uint16_t>(counts >= 0.5 && counts <= kMost ? std::lround(counts) : 0);
    std::memcpy(&data[2 * i], &value, 2);
  }
  if (!image.color.empty()) std::memcpy(&data[2 * pixels], image.color.data.data(), 3 * pixels);
  return message;
}

ColoredDepth from_message(const msgs::DepthImage& message) {
  const std::uint64_t pixels = std::uint64_t{message.width()} * message.height();
  if (!is_size(message.width(), message.height()) ||
      message.data().size() != pixels * (message.has_color() ? 5 : 2)) {
    throw InputError("A depth image of " + size_text(message.width(), message.height()) +
                         (message.has_color() ? " with colour has " : " has ") +
                         std::to_string(message.data().size()) + " bytes of data",
                     kSenderMend);
  }
  if (!(message.unit() > 0) || !std::isfinite(message.unit())) {
    throw InputError("A depth image's unit is no positive length", kSenderMend);
  }
  const int width = static_cast<int>(message.width()), height = static_cast<int>(message.height());
  ColoredDepth image;
  image.depth = geometry::DepthImage(width, height, std::numeric_limits<float>::quiet_NaN());
  const char* data = message.data().data();
  for (std::size_t i = 0; i < pixels; ++i) {
    std::uint16_t value;
    std::memcpy(&value, data + 2 * i, 2);
    if (value != 0) image.depth.data[i] = static_cast<float>(value * message.unit());
  }
  if (message.has_color()) {
    image.color = geometry::ColorImage(width, height);
    std::memcpy(image.color.data.data(), data + 2 * pixels, 3 * pixels);
  }
  return image;
}

}  // namespace prehend::convert
