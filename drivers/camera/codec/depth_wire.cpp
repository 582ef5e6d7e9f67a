#include "drivers/camera/codec/depth_wire.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace prehend::drivers::camera {
namespace {

constexpr std::uint8_t kQuestion[4] = {'P', 'D', 'Q', '1'};
constexpr std::uint8_t kAnswer[4] = {'P', 'D', 'A', '1'};
constexpr double kDepthCount = 1e-4;  // m

bool begins_with(Bytes bytes, const std::uint8_t (&magic)[4]) {
  return bytes.size() >= sizeof magic && std::memcmp(bytes.data(), magic, sizeof magic) == 0;
}

std::vector<std::uint8_t> header_bytes(const DepthPicture& picture) {
  std::vector<std::uint8_t> bytes;
  append_bytes(bytes, kAnswer);
  append_little(bytes, picture.number);
  append_little(bytes, static_cast<std::uint16_t>(picture.width));
  append_little(bytes, static_cast<std::uint16_t>(picture.height));
  for (const double value : {picture.fx, picture.fy, picture.cx, picture.cy}) {
    append_little(bytes, value);
  }
  return bytes;
}

}  // namespace

std::vector<std::uint8_t> encode_question(std::uint32_t number) {
  std::vector<std::uint8_t> bytes;
  append_bytes(bytes, kQuestion);
  append_little(bytes, number);
  return bytes;
}

std::optional<std::uint32_t> decode_question(Bytes bytes) {
  if (bytes.size() != kQuestionSize || !begins_with(bytes, kQuestion)) return std::nullopt;
  return load_little<std::uint32_t>(bytes.data() + sizeof kQuestion);
}

std::vector<std::uint8_t> encode_answer(const DepthPicture& picture) {
  std::vector<std::uint8_t> bytes = header_bytes(picture);
  bytes.reserve(bytes.size() + picture_size(picture));
  append_bytes(bytes, Bytes(reinterpret_cast<const std::uint8_t*>(picture.depth.data()),
                            2 * picture.depth.size()));
  append_bytes(bytes, picture.color);
  return bytes;
}

std::vector<std::uint8_t> encode_nothing_new(std::uint32_t number) {
  DepthPicture none;
  none.number = number;
  return header_bytes(none);
}

std::optional<DepthPicture> decode_answer_header(Bytes bytes) {
  if (bytes.size() != kAnswerHeaderSize || !begins_with(bytes, kAnswer)) return std::nullopt;
  ByteReader reader(bytes.subspan(sizeof kAnswer));
  DepthPicture picture;
  picture.number = reader.take<std::uint32_t>();
  picture.width = reader.take<std::uint16_t>();
  picture.height = reader.take<std::uint16_t>();
  picture.fx = reader.take<double>();
  picture.fy = reader.take<double>();
  picture.cx = reader.take<double>();
  picture.cy = reader.take<double>();
  if (picture.width == 0 && picture.height == 0) return picture;
  const bool good = picture.width > 0 && picture.height > 0 && picture.width <= kLargestWireSide &&
                    picture.height <= kLargestWireSide && std::isfinite(picture.fx) &&
                    picture.fx > 0 && std::isfinite(picture.fy) && picture.fy > 0 &&
                    std::isfinite(picture.cx) && std::isfinite(picture.cy);
  return good ? std::optional(picture) : std::nullopt;
}

std::size_t picture_size(const DepthPicture& header) {
  return std::size_t{5} * static_cast<std::size_t>(header.width) *
         static_cast<std::size_t>(header.height);
}

void decode_picture(Bytes bytes, DepthPicture& picture) {
  const std::size_t pixels = picture_size(picture) / 5;
  picture.depth.resize(pixels);
  // No memcpy, as a picture of no pixels has no memory.
  std::copy_n(bytes.begin(), 2 * pixels, reinterpret_cast<std::uint8_t*>(picture.depth.data()));
  picture.color.assign(bytes.begin() + static_cast<std::ptrdiff_t>(2 * pixels), bytes.end());
}

std::vector<std::uint16_t> depth_from_the_left(const DepthPicture& picture, double baseline) {
  std::vector<std::uint16_t> moved(picture.depth.size(), 0);
  for (int v = 0; v < picture.height; ++v) {
    const std::size_t row = static_cast<std::size_t>(v) * static_cast<std::size_t>(picture.width);
    for (int u = 0; u < picture.width; ++u) {
      const std::uint16_t depth = picture.depth[row + static_cast<std::size_t>(u)];
      if (depth == 0) continue;
      const double to = u + picture.fx * baseline / (depth * kDepthCount);
      if (!(to < picture.width - 0.5)) continue;
      std::uint16_t& place = moved[row + static_cast<std::size_t>(std::lround(to))];
      if (place == 0 || depth < place) place = depth;
    }
  }
  return moved;
}

}  // namespace prehend::drivers::camera
