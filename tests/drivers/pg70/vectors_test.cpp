// Every message that the manual (Schunk Motion Control V1.41) and public clients print, both ways.

#include <gtest/gtest.h>

#include "drivers/pg70/codec/can_framing.h"
#include "drivers/pg70/codec/request.h"
#include "drivers/pg70/codec/response.h"
#include "drivers/pg70/codec/serial_framing.h"
#include "tests/drivers/hex.h"

namespace prehend::drivers::pg70 {
namespace {

std::string frame_text(const CanFrame& frame) {
  char identifier[8];
  std::snprintf(identifier, sizeof identifier, "%03X", frame.identifier);
  return std::string(identifier) + "#" + to_hex(frame.bytes());
}

CanFrame frame_of(const std::string& text) {
  CanFrame frame;
  frame.identifier = static_cast<std::uint16_t>(std::stoul(text.substr(0, 3), nullptr, 16));
  const auto bytes = hex(text.substr(4));
  std::copy(bytes.begin(), bytes.end(), frame.data.begin());
  frame.size = static_cast<std::uint8_t>(bytes.size());
  return frame;
}

std::vector<std::string> frames_of(Direction direction, std::uint8_t module, const Content& c) {
  std::vector<std::string> texts;
  split_into_frames(can_identifier(direction, module), c,
                    [&](const CanFrame& frame) { texts.push_back(frame_text(frame)); });
  return texts;
}

Content assembled(const std::vector<std::string>& frames) {
  FrameAssembler assembler;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const auto content = assembler.add(frame_of(frames[i]));
    EXPECT_EQ(content.has_value(), i + 1 == frames.size()) << frames[i];
    if (content) return *content;
  }
  return {};
}

struct RequestVector {
  std::uint8_t module;
  std::vector<std::string> frames;
  Request request;
};

Move move(Command command, std::initializer_list<float> values) {
  Move result{.command = command, .count = static_cast<std::uint8_t>(values.size())};
  std::copy(values.begin(), values.end(), result.values.begin());
  return result;
}

const RequestVector kRequests[] = {
    {1, {"501#06 95 00 00 80 3F 01"}, GetState{GetState::Cycle{1.0F, kWithPosition}}},
    {1, {"501#01 95"}, GetState{}},
    {1, {"501#01 8B"}, PlainRequest{Command::kAcknowledge}},
    {1, {"501#05 B0 00 00 20 41"}, move(Command::kMovePosition, {10})},
    {1, {"501#05 B5 9A 99 31 41"}, move(Command::kMoveVelocity, {11.1F})},
    {1, {"501#05 B7 00 00 60 40"}, move(Command::kMoveGrip, {3.5F})},
    {12,
     {"50C#09 84 B5 00 00 F0 41 00", "50C#03 86 00 80 3F"},
     move(Command::kMoveVelocity, {30, 1})},
    {12,
     {"50C#11 84 B0 00 00 08 42 00", "50C#0B 85 00 A0 41 00 00 A0", "50C#05 86 43 00 00 C0 3F"},
     move(Command::kMovePosition, {34, 20, 320, 1.5F})},
    {12, {"50C#06 95 0A D7 23 3D 07"}, GetState{GetState::Cycle{0.04F, kWithAll}}},
    {1, {"501#02 80 0B"}, GetConfig{0x0B}},
    {1, {"501#01 80"}, GetConfig{}},
    {1, {"501#05 A0 00 00 A0 41"}, SetTarget{Command::kSetTargetVelocity, 20}},
};

TEST(Pg70Vectors, RequestsBothWays) {
  for (const RequestVector& vector : kRequests) {
    const Content content = encode(vector.request);
    EXPECT_EQ(frames_of(Direction::kCommand, vector.module, content), vector.frames);
    const Content received = assembled(vector.frames);
    EXPECT_EQ(received, content) << vector.frames[0];
    EXPECT_EQ(decode_request(received), vector.request) << vector.frames[0];
  }
}

struct ResponseVector {
  std::uint8_t module;
  std::vector<std::string> frames;
  std::uint8_t mode;
  Response response;
};

float float_of(const std::string& text) { return load_little<float>(hex(text).data()); }

const ResponseVector kResponses[] = {
    {1,
     {"701#07 95 36 89 81 3F 02 00"},
     kWithPosition,
     State{float_of("36 89 81 3F"), {}, {}, kMoving, 0}},
    {1, {"301#02 88 74"}, 0, Fault{Command::kError, ErrorCode::kMotorVoltageLow}},
    {1, {"301#02 88 D9"}, 0, Fault{Command::kError, ErrorCode::kFastStop}},
    {1, {"701#03 8B 4F 4B"}, 0, Confirmation{Command::kAcknowledge}},
    {1, {"701#03 91 4F 4B"}, 0, Confirmation{Command::kStop}},
    {1, {"701#03 92 4F 4B"}, 0, Confirmation{Command::kReference}},
    {1, {"701#03 8A 08 00"}, 0, Info{8}},
    {1, {"701#05 B0 EE EE 56 40"}, 0, MoveStarted{Command::kMovePosition, float_of("EE EE 56 40")}},
    {1,
     {"701#05 94 B6 F3 1F 41"},
     0,
     MotionEnd{Command::kPositionReached, float_of("B6 F3 1F 41")}},
    {1, {"701#05 94 CD CC 2C 40"}, 0, MotionEnd{Command::kPositionReached, 2.7F}},
    {1, {"701#05 93 A4 70 9D 3F"}, 0, MotionEnd{Command::kMoveBlocked, 1.23F}},
    {1,
     {"701#0F 84 95 D6 A3 70 41 56", "701#09 85 C9 41 40 3C 41 EB", "701#03 86 3E 03 00"},
     kWithAll,
     State{float_of("D6 A3 70 41"), float_of("56 C9 41 40"), float_of("3C 41 EB 3E"),
           kReferenced | kMoving, 0}},
    {12, {"70C#02 B0 06"}, 0, Refusal{Command::kMovePosition, InfoCode::kNotReferenced}},
    {1, {"701#03 E7 4F 4E"}, 0, ImpulseMessages{true}},
    {1, {"701#04 E7 4F 46 46"}, 0, ImpulseMessages{false}},
    {1, {"701#04 81 4F 4B 07"}, 0, ConfigSet{7}},
    {1, {"701#03 80 01 0C"}, 0, ConfigValue{1, {0x0C}}},
};

TEST(Pg70Vectors, ResponsesBothWays) {
  for (const ResponseVector& vector : kResponses) {
    const Content content = encode(vector.response);
    EXPECT_EQ(frames_of(direction_of(vector.response), vector.module, content), vector.frames);
    const Content received = assembled(vector.frames);
    EXPECT_EQ(received, content) << vector.frames[0];
    EXPECT_EQ(decode_response(received, vector.mode), vector.response) << vector.frames[0];
  }
  EXPECT_NEAR(float_of("EE EE 56 40"), 3.358, 1e-3);   // s, as the manual says
  EXPECT_NEAR(float_of("36 89 81 3F"), 1.011, 1e-3);   // mm, printed 1.011
  EXPECT_NEAR(float_of("B6 F3 1F 41"), 9.9969, 1e-3);  // mm
}

TEST(Pg70Vectors, PaddedAndEmptyLastFragmentsOfRealSenders) {
  FrameAssembler assembler;
  EXPECT_FALSE(assembler.add(frame_of("50C#09 84 B5 00 00 F0 41 00")));
  const auto content = assembler.add(frame_of("50C#03 86 00 80 3F 00 00"));  // 7 bytes, as EGL
  ASSERT_TRUE(content);
  EXPECT_EQ(decode_request(*content), Request(move(Command::kMoveVelocity, {30, 1})));
  EXPECT_FALSE(assembler.add(frame_of("50C#00 86 00 00 00 00 00 00")));
  EXPECT_EQ(assembler.broken(), 0u);
}

TEST(Pg70Vectors, SerialBothWays) {
  const struct {
    const char* bytes;
    Direction direction;
    Content content;
  } vectors[] = {
      {"05 01 01 92 D1 31", Direction::kCommand, encode(PlainRequest{Command::kReference})},
      {"05 01 05 B0 00 00 20 41 48 80", Direction::kCommand,
       encode(Request(move(Command::kMovePosition, {10})))},
      {"03 01 02 88 74 82 1B", Direction::kError,
       encode(Fault{Command::kError, ErrorCode::kMotorVoltageLow})},
      {"07 01 03 8A 08 00 1A 19", Direction::kResponse, encode(Info{8})}};
  for (const auto& vector : vectors) {
    const SerialMessage message{vector.direction, 1, vector.content};
    EXPECT_EQ(to_hex(encode_serial(message)), vector.bytes);
    SerialDecoder decoder;
    decoder.add(hex(vector.bytes));
    EXPECT_EQ(decoder.next(), message) << vector.bytes;
    EXPECT_EQ(decoder.discarded(), 0u);
  }
}

TEST(Pg70Vectors, IdentifiersOfAllModules) {
  for (int module = 1; module <= 255; ++module) {
    const auto id = static_cast<std::uint8_t>(module);
    EXPECT_EQ(can_identifier(Direction::kCommand, id), 0x500 + module);
    EXPECT_EQ(can_identifier(Direction::kResponse, id), 0x700 + module);
    EXPECT_EQ(can_identifier(Direction::kError, id), 0x300 + module);
    for (const auto d : {Direction::kCommand, Direction::kResponse, Direction::kError}) {
      EXPECT_EQ(can_direction(can_identifier(d, id)), d);
    }
  }
  EXPECT_FALSE(can_direction(0x401));  // a group command
  EXPECT_FALSE(can_direction(0x500));  // module 0 does not exist
}

}  // namespace
}  // namespace prehend::drivers::pg70
