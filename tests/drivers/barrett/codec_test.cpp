// Frames of the pucks: the vectors of Barrett's manual and libraries, and what is no frame of
// theirs.

#include <gtest/gtest.h>

#include <random>

#include "drivers/barrett/codec/gearing.h"
#include "drivers/barrett/codec/message.h"
#include "drivers/barrett/codec/tactile.h"
#include "tests/drivers/hex.h"

namespace prehend::drivers::barrett {
namespace {

CanFrame frame_of(std::uint16_t identifier, const std::string& text) {
  const auto bytes = hex(text);
  CanFrame frame;
  frame.identifier = identifier;
  frame.size = static_cast<std::uint8_t>(bytes.size());
  std::ranges::copy(bytes, frame.data.begin());
  return frame;
}
std::uint8_t number(Property property) { return static_cast<std::uint8_t>(property); }
Request set(std::size_t axis, Property property, std::int32_t value) {
  return {axis, number(property), value};
}

TEST(BarrettCodec, IdentifiersAreThoseOfTheNodes) {
  const std::uint16_t requests[] = {0x00B, 0x00C, 0x00D, 0x00E};
  const std::uint16_t replies[] = {0x566, 0x586, 0x5A6, 0x5C6};
  const std::uint16_t positions[] = {0x563, 0x583, 0x5A3, 0x5C3};
  const std::uint16_t images[] = {0x569, 0x589, 0x5A9, 0x5C9};
  for (std::size_t i = 0; i < kAxes; ++i) {
    EXPECT_EQ(request_identifier(i), requests[i]);
    EXPECT_EQ(reply_identifier(i, Group::kReply), replies[i]);
    EXPECT_EQ(reply_identifier(i, Group::kPosition), positions[i]);
    EXPECT_EQ(reply_identifier(i, Group::kTactileAll), images[i]);
  }
}

// MAN44 gives the payloads of the orders; the others are put together by libbarrett's rules.
TEST(BarrettCodec, OrdersAreTheVectors) {
  const struct {
    Request request;
    std::string bytes;
  } vectors[] = {
      {set(0, Property::kStatus, 2), "85 00 02 00"},
      {set(0, Property::kCommand, static_cast<int>(Command::kInitialise)), "9D 00 0D 00"},
      {set(0, Property::kCommand, static_cast<int>(Command::kClose)), "9D 00 12 00"},
      {set(0, Property::kCommand, static_cast<int>(Command::kMove)), "9D 00 13 00"},
      {set(0, Property::kCommand, static_cast<int>(Command::kOff)), "9D 00 15 00"},
      {{0, number(Property::kPosition)}, "30"},
      {{0, number(Property::kTemperature)}, "09"},
      {set(0, Property::kMode, 4), "88 00 04 00"},
      {set(0, Property::kVelocity, 100), "AC 00 64 00"},
      {set(0, Property::kMove, 100000), "BA 00 A0 86 01 00"},
      {set(0, Property::kTactile, kTactileFull), "EA 00 02 00"},
  };
  for (const auto& [request, bytes] : vectors) {
    const CanFrame frame = encode(request);
    EXPECT_EQ(frame, frame_of(0x00B, bytes)) << to_hex(frame.bytes());
    EXPECT_EQ(decode_request(frame), request) << bytes;
  }
  // libbarrett sends 16 bits as 32, too.
  EXPECT_EQ(decode_request(frame_of(0x00C, "88 00 04 00 00 00")), set(1, Property::kMode, 4));
}

TEST(BarrettCodec, RepliesAreTheVectors) {
  EXPECT_EQ(decode_reply(frame_of(0x563, "81 86 A0")), Reply(Position{0, 100000}));
  EXPECT_EQ(decode_reply(frame_of(0x563, "BF FC 18")), Reply(Position{0, -1000}));
  EXPECT_EQ(decode_reply(frame_of(0x563, "81 86 A0 80 9C 40")), Reply(Position{0, 100000, 40000}));
  EXPECT_EQ(decode_reply(frame_of(0x566, "89 00 22 00")),
            Reply(Value{0, number(Property::kTemperature), 34}));
  EXPECT_EQ(decode_reply(frame_of(0x5C6, "88 00 FF FF")),
            Reply(Value{3, number(Property::kMode), -1}));
  EXPECT_EQ(decode_reply(frame_of(0x586, "B2 00 18 FC FF FF")),
            Reply(Value{1, number(Property::kDefaultPosition), -1000}));
}

TEST(BarrettCodec, ImageIsTheVectors) {
  const auto first = decode_reply(frame_of(0x569, "01 00 08 00 00 00 00 40"));
  ASSERT_TRUE(first && std::holds_alternative<TactilePart>(*first));
  // 1.0, 0.5, 0, 0 and 0.25 N/cm^2
  EXPECT_EQ(std::get<TactilePart>(*first), (TactilePart{0, 0, {256, 128, 0, 0, 64}}));
  const auto last = decode_reply(frame_of(0x569, "40 02 00 30 04 FF F0 00"));
  ASSERT_TRUE(last && std::holds_alternative<TactilePart>(*last));
  EXPECT_EQ(std::get<TactilePart>(*last), (TactilePart{0, 4, {2, 3, 4, 4095, 0}}));
}

TEST(BarrettCodec, WhatIsSentIsWhatIsRead) {
  std::mt19937 random(3);
  for (int i = 0; i < 2000; ++i) {
    const std::size_t axis = random() % kAxes;
    const auto property = static_cast<std::uint8_t>(random() % kProperties);
    const auto wide = static_cast<std::int32_t>(random());
    const auto value = is_wide(property) ? wide : static_cast<std::int16_t>(wide);
    const Request request{axis, property, value};
    EXPECT_EQ(decode_request(encode(request)), request);
    const Value answer{axis, property, value};
    EXPECT_EQ(decode_reply(encode(answer)), Reply(answer));
    Position position{axis, kLeastPosition + static_cast<std::int32_t>(random() % (1U << 22))};
    if (random() % 2 == 0) position.joint = -position.motor - 1;
    EXPECT_EQ(decode_reply(encode(position)), Reply(position));
  }
  EXPECT_EQ(decode_reply(encode(Position{1, kMostPosition})), Reply(Position{1, kMostPosition}));
  EXPECT_EQ(decode_reply(encode(Position{1, kLeastPosition})), Reply(Position{1, kLeastPosition}));
}

TEST(BarrettCodec, WhatIsNoFrameOfTheHandIsNothing) {
  const struct {
    std::uint16_t identifier;
    const char* bytes;
  } frames[] = {
      {0x566, ""},                      // empty
      {0x566, "89 00 22"},              // cut off
      {0x566, "09 00 22 00"},           // no answer
      {0x566, "89 01 22 00"},           // second byte
      {0x566, "89 00 22 00 00"},        // five bytes
      {0x563, "81 86"},                 // cut off
      {0x563, "01 86 A0"},              // first bit
      {0x563, "C1 86 A0"},              // second bit
      {0x563, "81 86 A0 00 9C 40"},     // of the encoder
      {0x569, "01 00 08 00 00 00 00"},  // cut off
      {0x546, "89 00 22 00"},           // node 10
      {0x5E6, "89 00 22 00"},           // node 15
      {0x50A, "80 01 00 FE 00 0A"},     // the wrist's
      {0x568, "00 00 00"},              // top ten, which nobody asks for
      {0x00B, "85 00 02 00"},           // the host's
      {0x166, "89 00 22 00"},           // to no group
  };
  for (const auto& one : frames) {
    EXPECT_FALSE(decode_reply(frame_of(one.identifier, one.bytes)))
        << one.identifier << " " << one.bytes;
  }
  for (const auto& one :
       {frame_of(0x00A, "30"), frame_of(0x00F, "30"), frame_of(0x00B, ""), frame_of(0x00B, "B0"),
        frame_of(0x00B, "88 00 04"), frame_of(0x00B, "88 01 04 00"), frame_of(0x566, "30")}) {
    EXPECT_FALSE(decode_request(one)) << to_hex(one.bytes());
  }
}

TEST(BarrettTactile, ImagesAreWholeOrNone) {
  Cells cells{};
  for (std::size_t i = 0; i < kCells; ++i) cells[i] = static_cast<std::uint16_t>(100 * i);
  const auto parts = split(2, cells);
  TactileAssembler pad;
  const auto add = [&](std::initializer_list<int> order) {
    std::optional<Cells> image;
    for (const int i : order) image = pad.add(parts[static_cast<std::size_t>(i)]);
    return image;
  };
  EXPECT_EQ(add({0, 1, 2, 3, 4}), cells);
  EXPECT_EQ(add({0, 1, 2, 3, 4}), cells);
  EXPECT_EQ(pad.broken(), 0u);
  EXPECT_FALSE(add({0, 1, 3, 4}));  // one is lost
  EXPECT_EQ(pad.broken(), 4u);
  EXPECT_FALSE(add({0, 2, 1, 3, 4}));  // out of order
  EXPECT_EQ(add({1, 0, 1, 2, 3, 4}), cells);
  EXPECT_FALSE(add({0, 1, 1}));  // twice
  EXPECT_EQ(add({0, 0, 1, 2, 3, 4}), cells);
  TactilePart strange = parts[0];
  strange.sequence = 9;
  EXPECT_FALSE(pad.add(strange));
}

TEST(BarrettGearing, CountsAreLibbarretts) {
  const Gearing gearing;
  EXPECT_NEAR(gearing.counts_per_radian(0) * M_PI / 180, 1422.2, 0.1);
  EXPECT_NEAR(gearing.counts_per_radian(kSpread) * M_PI / 180, 199.1, 0.1);
  EXPECT_NEAR(gearing.counts_per_radian(0) / gearing.joint_counts_per_radian(), 2.5, 1e-9);
}

TEST(BarrettProperties, HaveTheirNames) {
  int named = 0;
  for (int i = 0; i < 256; ++i) {
    const auto property = static_cast<Property>(i);
    if (to_string(property) == nullptr) continue;
    ++named;
    EXPECT_EQ(property_named(to_string(property)), property);
  }
  EXPECT_EQ(named, 27);
  EXPECT_FALSE(property_named("mode"));
  for (const std::uint8_t wide : {48, 50, 52, 54, 56, 58, 66, 68, 74, 88, 96, 98}) {
    EXPECT_TRUE(is_wide(wide));
  }
  EXPECT_FALSE(is_wide(number(Property::kMostTorque)));
}

}  // namespace
}  // namespace prehend::drivers::barrett
