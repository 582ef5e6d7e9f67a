#include "msgs/convert/foxglove_images.h"

#include <cstdint>
#include <cstring>
#include <limits>
#include <string>
#include <utility>

#include "msgs/convert/foxglove_geometry.h"
#include "msgs/convert/mend.h"
#include "prehend/geometry/errors.h"

namespace prehend::convert {
namespace {

constexpr std::uint64_t kMostPixels = std::uint64_t{1} << 28;

[[noreturn]] void does_not_fit(const char* what) {
  throw geometry::InputError(std::string(what) + "'s data does not fit its size", kSenderMend);
}

::foxglove::RawImage image_of(const msgs::Header& header, std::uint32_t width, std::uint32_t height,
                              const char* encoding, std::uint32_t bytes_of_pixel) {
  ::foxglove::RawImage image;
  *image.mutable_timestamp() = foxglove_time(header.stamp());
  image.set_frame_id(header.frame_id());
  image.set_width(width);
  image.set_height(height);
  image.set_encoding(encoding);
  image.set_step(width * bytes_of_pixel);
  return image;
}

}  // namespace

::foxglove::RawImage stereo_image(const msgs::StereoPair& pair, Eye eye) {
  const std::uint64_t pixels = std::uint64_t{pair.width()} * pair.height();
  const std::uint32_t channels = pair.channels();
  if ((channels != 1 && channels != 3) || pixels > kMostPixels ||
      pair.data().size() != 2 * channels * pixels) {
    does_not_fit("A stereo pair");
  }
  const std::size_t bytes = channels * pixels;
  auto image = image_of(pair.header(), pair.width(), pair.height(),
                        channels == 1 ? "mono8" : "rgb8", channels);
  image.set_data(pair.data().data() + (eye == Eye::kRight ? bytes : 0), bytes);
  return image;
}

::foxglove::RawImage depth_image(const msgs::DepthImage& depth) {
  const std::uint64_t pixels = std::uint64_t{depth.width()} * depth.height();
  if (pixels > kMostPixels || depth.data().size() < 2 * pixels) does_not_fit("A depth image");
  auto image = image_of(depth.header(), depth.width(), depth.height(), "32FC1", 4);
  std::string data(4 * pixels, '\0');
  for (std::uint64_t i = 0; i < pixels; ++i) {
    std::uint16_t count = 0;
    std::memcpy(&count, depth.data().data() + 2 * i, sizeof count);
    const float z = count == 0 ? std::numeric_limits<float>::quiet_NaN()
                               : static_cast<float>(count * depth.unit());
    std::memcpy(&data[4 * i], &z, sizeof z);
  }
  image.set_data(std::move(data));
  return image;
}

::foxglove::RawImage tactile_image(const msgs::TactileFrame& frame) {
  const std::uint64_t texels = std::uint64_t{frame.rows()} * frame.columns();
  if (static_cast<std::uint64_t>(frame.intensity_size()) != texels) does_not_fit("A tactile frame");
  auto image = image_of(frame.header(), frame.columns(), frame.rows(), "32FC1", 4);
  std::string data(4 * texels, '\0');
  for (std::uint64_t i = 0; i < texels; ++i) {
    const auto newton =
        static_cast<float>(frame.intensity(static_cast<int>(i)) * frame.newton_per_count());
    std::memcpy(&data[4 * i], &newton, sizeof newton);
  }
  image.set_data(std::move(data));
  return image;
}

::foxglove::CameraCalibration camera_calibration(const msgs::CameraInfo& info) {
  ::foxglove::CameraCalibration result;
  *result.mutable_timestamp() = foxglove_time(info.header().stamp());
  result.set_frame_id(info.header().frame_id());
  result.set_width(info.width());
  result.set_height(info.height());
  result.set_distortion_model("plumb_bob");
  for (int i = 0; i < 5; ++i) result.add_d(0);
  const double k[9] = {info.fx(), 0, info.cx(), 0, info.fy(), info.cy(), 0, 0, 1};
  for (int i = 0; i < 9; ++i) {
    result.add_k(k[i]);
    result.add_r(i % 4 == 0 ? 1 : 0);
    result.add_p(k[i]);
    if (i % 3 == 2) result.add_p(0);
  }
  return result;
}

::foxglove::Log log_line(const msgs::graph::LogLine& line) {
  ::foxglove::Log result;
  *result.mutable_timestamp() = foxglove_time(line.stamp());
  result.set_name(line.node());
  result.set_message(line.text());
  switch (line.level()) {
    case msgs::graph::DEBUG:
      result.set_level(::foxglove::Log::DEBUG);
      break;
    case msgs::graph::WARNING:
      result.set_level(::foxglove::Log::WARNING);
      break;
    case msgs::graph::ERROR:
      result.set_level(::foxglove::Log::ERROR);
      break;
    default:
      result.set_level(::foxglove::Log::INFO);
  }
  return result;
}

}  // namespace prehend::convert
