#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "drivers/wire/encoding/byte_order.h"

/// What the emulated depth camera (depth_camera_emulator) and its driver plug-in of OpenNI2 say to
/// each other. A question is 8 bytes, "PDQ1" and the number of the picture that the asker has (0:
/// none). The answer is a header of 44 bytes, "PDA1", the picture's number, width and height (16
/// bits each), focal lengths and principal point [pixels] (64 bits each) - or, when there is no
/// newer one, the same number and zeros; then the picture: width x height depths in 0.1 mm (16
/// bits, 0 unknown), then as many red-green-blue. Little-endian. A codec: no input or output.
namespace prehend::drivers::camera {

inline constexpr std::size_t kQuestionSize = 8;
inline constexpr std::size_t kAnswerHeaderSize = 44;
inline constexpr int kLargestWireSide = 4096;  // pixels

struct DepthPicture {
  std::uint32_t number = 0;  // counts pictures, from 1
  int width = 0;             // pixels; 0: no picture, the asker has the newest
  int height = 0;
  double fx = 0, fy = 0, cx = 0, cy = 0;  // pixels
  std::vector<std::uint16_t> depth;       // width * height, 0.1 mm
  std::vector<std::uint8_t> color;        // width * height * 3
};

std::vector<std::uint8_t> encode_question(std::uint32_t number);
/// @param bytes of kQuestionSize; nothing when they are no question.
std::optional<std::uint32_t> decode_question(Bytes bytes);

/// @pre depth and color have the picture's size.
std::vector<std::uint8_t> encode_answer(const DepthPicture& picture);
std::vector<std::uint8_t> encode_nothing_new(std::uint32_t number);
/// The header without its picture; nothing when it is none: another magic, sides over
/// kLargestWireSide, focal lengths that are not positive.
/// @param bytes of kAnswerHeaderSize.
std::optional<DepthPicture> decode_answer_header(Bytes bytes);
/// Bytes of the picture that follow a header.
std::size_t picture_size(const DepthPicture& header);
/// Fills in depth and color. @pre `bytes` has picture_size().
void decode_picture(Bytes bytes, DepthPicture& picture);

/// Depth as a camera sees it that stands `baseline` [m] to the left: each point moves to the right
/// by fx * baseline / z, the nearest wins, and what nobody saw is 0. This is what an unregistered
/// depth sensor beside its colour camera gives.
std::vector<std::uint16_t> depth_from_the_left(const DepthPicture& picture, double baseline);

}  // namespace prehend::drivers::camera
