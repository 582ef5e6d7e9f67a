#include "drivers/camera/codec/depth_wire.h"

#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace prehend::drivers::camera {
namespace {

DepthPicture test_picture() {
  DepthPicture picture{7, 6, 4, 100, 101, 2.5, 1.5, {}, {}};
  for (int i = 0; i < 24; ++i) picture.depth.push_back(static_cast<std::uint16_t>(i * 1000));
  for (int i = 0; i < 72; ++i) picture.color.push_back(static_cast<std::uint8_t>(i));
  return picture;
}

TEST(DepthWire, APictureComesAsItWent) {
  const DepthPicture sent = test_picture();
  const auto bytes = encode_answer(sent);
  auto picture = decode_answer_header(Bytes(bytes).first(kAnswerHeaderSize));
  ASSERT_TRUE(picture);
  ASSERT_EQ(bytes.size(), kAnswerHeaderSize + picture_size(*picture));
  decode_picture(Bytes(bytes).subspan(kAnswerHeaderSize), *picture);
  EXPECT_EQ(picture->number, 7u);
  EXPECT_EQ(picture->fy, 101);
  EXPECT_EQ(picture->depth, sent.depth);
  EXPECT_EQ(picture->color, sent.color);
  EXPECT_EQ(decode_question(encode_question(9)), 9u);
  auto nothing = decode_answer_header(encode_nothing_new(3));
  ASSERT_TRUE(nothing);
  decode_picture({}, *nothing);
  EXPECT_EQ(nothing->width, 0);
  EXPECT_TRUE(nothing->depth.empty() && nothing->color.empty());
}

// Whatever comes: no header asks for more than the largest picture.
TEST(DepthWire, NonsenseIsNoPicture) {
  std::mt19937 random(2);
  const auto good = encode_answer(test_picture());
  for (int trial = 0; trial < 20000; ++trial) {
    std::vector<std::uint8_t> bytes(good.begin(), good.begin() + kAnswerHeaderSize);
    for (int i = 0; i < 1 + trial % 5; ++i) {
      bytes[random() % bytes.size()] = static_cast<std::uint8_t>(random());
    }
    const auto picture = decode_answer_header(bytes);
    if (!picture) continue;
    EXPECT_LE(picture_size(*picture), std::size_t{5} * kLargestWireSide * kLargestWireSide);
    EXPECT_TRUE(picture->width == 0 || (std::isfinite(picture->fx) && picture->fx > 0));
  }
  DepthPicture bad = test_picture();
  bad.fx = std::nan("");
  EXPECT_FALSE(decode_answer_header(Bytes(encode_answer(bad)).first(kAnswerHeaderSize)));
  bad = test_picture();
  bad.height = 0;
  EXPECT_FALSE(decode_answer_header(Bytes(encode_answer(bad)).first(kAnswerHeaderSize)));
  EXPECT_FALSE(decode_answer_header({}));
  EXPECT_FALSE(decode_question(std::vector<std::uint8_t>(8, 0xFF)));
}

// A wall 1 m away before one 2 m away: disparities 100 * 0.04 / 1 = 4 and 2 pixels; the near one
// hides, and what nobody saw is 0.
TEST(DepthWire, FromTheLeftNearThingsMoveFarther) {
  DepthPicture picture{1, 12, 1, 100, 100, 6, 0, {}, {}};
  for (int u = 0; u < 12; ++u) picture.depth.push_back(u >= 3 && u < 6 ? 10000 : 20000);
  const std::vector<std::uint16_t> expected = {0, 0,     20000, 20000, 20000, 0,
                                               0, 10000, 10000, 10000, 20000, 20000};
  EXPECT_EQ(depth_from_the_left(picture, 0.04), expected);
}

}  // namespace
}  // namespace prehend::drivers::camera
