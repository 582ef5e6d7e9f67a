#include "drivers/dsa/codec/frame.h"

#include <stdexcept>
#include <string>

namespace prehend::drivers::dsa {
namespace {

constexpr std::size_t kFrameHeader = 5;
constexpr std::uint8_t kRunLength = 0x01;
constexpr unsigned kLongestRun = 15;

bool decode_raw(Bytes data, std::size_t texels, Frame& frame) {
  if (data.size() != 2 * texels) return false;
  std::uint16_t all = 0;
  for (std::size_t i = 0; i < texels; ++i) {
    const auto value = load_little<std::uint16_t>(&data[2 * i]);
    all |= value;
    frame.texels.push_back(value);
  }
  return all <= kFullScale;
}

bool decode_runs(Bytes data, std::size_t texels, Frame& frame) {
  if (data.size() % 2 != 0) return false;
  for (std::size_t i = 0; i < data.size(); i += 2) {
    const auto unit = load_little<std::uint16_t>(&data[i]);
    const std::size_t run = unit >> 12;
    if (run == 0 || run > texels - frame.texels.size()) return false;
    frame.texels.insert(frame.texels.end(), run, unit & kFullScale);
  }
  return frame.texels.size() == texels;
}

}  // namespace

std::vector<std::uint8_t> encode_frame(const Frame& frame, bool run_length) {
  std::vector<std::uint8_t> payload(kFrameHeader + 2 * frame.texels.size());
  store_little(payload.data(), frame.timestamp);
  payload[4] = run_length ? kRunLength : std::uint8_t{0};
  std::size_t end = kFrameHeader;
  for (std::size_t i = 0; i < frame.texels.size();) {
    const std::uint16_t value = frame.texels[i];
    if (value > kFullScale) {
      throw std::invalid_argument("texel " + std::to_string(i) + " is " + std::to_string(value) +
                                  ", beyond 12 bits");
    }
    unsigned run = 1;
    while (run_length && run < kLongestRun && i + run < frame.texels.size() &&
           frame.texels[i + run] == value) {
      ++run;
    }
    store_little(&payload[end], static_cast<std::uint16_t>(run_length ? value | run << 12 : value));
    end += 2;
    i += run;
  }
  payload.resize(end);
  return payload;
}

bool decode_frame(Bytes payload, std::size_t texels, Frame& frame) {
  if (payload.size() < kFrameHeader) return false;
  frame.timestamp = load_little<std::uint32_t>(payload.data());
  frame.texels.clear();
  frame.texels.reserve(texels);
  const Bytes data = payload.subspan(kFrameHeader);
  return payload[4] & kRunLength ? decode_runs(data, texels, frame)
                                 : decode_raw(data, texels, frame);
}

}  // namespace prehend::drivers::dsa
