// Lines and RealTime blocks of the BH8-262. Vectors are from the manual of firmware 4.3
// (MAN43, 6.4), YARP's BarrettHand826X and handif; what is constructed says so.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "drivers/barrett/codec/gcl/line.h"
#include "drivers/barrett/codec/gcl/real_time.h"

namespace prehend::drivers::barrett::gcl {
namespace {

using ::testing::ElementsAre;
using Block = std::vector<std::uint8_t>;

Layout layout_of(Firmware firmware) {
  Layout layout;
  layout.firmware = firmware;
  return layout;
}
const MotorLayout kNothing{.velocity = false,
                           .gain = false,
                           .speed = false,
                           .strain = false,
                           .position = false,
                           .delta = false};

TEST(GclLine, RequestsAreWrittenAsInTheManual) {
  Request request{.command = "FSET", .words = {"LCV", "1", "LCVC", "1"}};
  request.motors = {true, true, false, false};
  EXPECT_EQ(encode(request), "12FSET LCV 1 LCVC 1");
  EXPECT_EQ(decode_request("12fset lcv 1 lcvc 1"), request);
  EXPECT_EQ(decode_request("GHOME")->motors, (std::array<bool, kAxes>{true, true, true, false}));
  EXPECT_EQ(decode_request("SHOME")->motors, (std::array<bool, kAxes>{false, false, false, true}));
  EXPECT_EQ(decode_request("FGET P"), (Request{.motors = {}, .command = "FGET", .words = {"P"}}));
  EXPECT_EQ(decode_request("")->command, "");
  EXPECT_FALSE(decode_request("FGET \x80"));
  EXPECT_FALSE(decode_request(std::string(kLongestLine + 1, 'A')));
}

// YARP: positions without a prefix are four numbers, F1 F2 F3 spread.
TEST(GclLine, ValuesComeBetweenEchoAndPrompt) {
  const std::string received = "FGET P\n\r0 0 0 0\n\r=> ";
  for (std::size_t size = 0; size < received.size(); ++size) {
    EXPECT_EQ(parse_reply(received.substr(0, size), "FGET P").kind, Reply::Kind::kPending) << size;
  }
  const Reply reply = parse_reply(received, "FGET P");
  EXPECT_TRUE(reply.is_good());
  ASSERT_THAT(reply.lines, ElementsAre("0 0 0 0"));
  EXPECT_THAT(integers_of(reply.lines[0]), ElementsAre(0, 0, 0, 0));
  // MAN43 writes CRLF without saying in which order.
  EXPECT_TRUE(parse_reply("FGET P\r\n0 0 0 0\r\n=> ", "FGET P").is_good());
}

TEST(GclLine, ErrorsAreSums) {
  const std::string received{0x46, 0x4F, 0x4F, 0x0A, 0x0D, 0x45, 0x52, 0x52,
                             0x20, 0x33, 0x32, 0x0A, 0x0D, 0x3D, 0x3E, 0x20};
  const Reply reply = parse_reply(received, "FOO");
  EXPECT_EQ(reply.kind, Reply::Kind::kDone);
  EXPECT_EQ(reply.error, kUnknownCommand);
  EXPECT_FALSE(reply.is_good());
  EXPECT_EQ(describe_status(16 + 16384), "ERR 16400 it could not reach its position, Ctrl-C");
  EXPECT_EQ(describe_status(0), "ERR 0");
}

TEST(GclLine, NoResultIsAPromptAlone) {
  EXPECT_TRUE(parse_reply("1234FSET LCV 1\n\r=> ", "1234FSET LCV 1").is_good());
  EXPECT_TRUE(parse_reply("\n\r=> ", "").is_good());
}

TEST(GclLine, LoopBeginsWithAStarInsteadOfALineEnd) {
  EXPECT_EQ(parse_reply("124LOOP*", "124LOOP").kind, Reply::Kind::kLoops);
  EXPECT_EQ(parse_reply("124LOOP", "124LOOP").kind, Reply::Kind::kPending);
  EXPECT_EQ(parse_reply("124LOOP\n\rERR 4\n\r=> ", "124LOOP").error, kNotInitialised);
}

TEST(GclLine, LostByteOfAnEchoIsSeen) {
  EXPECT_EQ(parse_reply("FGE P\n\r0 0 0 0\n\r=> ", "FGET P").kind, Reply::Kind::kDamaged);
  EXPECT_EQ(parse_reply("FGET PX\n\r=> ", "FGET P").kind, Reply::Kind::kDamaged);
  EXPECT_EQ(parse_reply(std::string(kLongestReply + 1, 'F'), "F").kind, Reply::Kind::kDamaged);
}

TEST(GclLine, NumbersAreWhole) {
  EXPECT_THAT(integers_of(" 17500  -3 "), ElementsAre(17500, -3));
  EXPECT_TRUE(integers_of("1 2x").empty());
  EXPECT_TRUE(integers_of("99999999999").empty());
}

TEST(GclLine, PromptIsOneAtTheBeginningOfALine) {
  EXPECT_TRUE(ends_in_prompt("\n\rERR 16384\n\r=> "));
  EXPECT_TRUE(ends_in_prompt("=> "));
  EXPECT_FALSE(ends_in_prompt("x=> "));
  EXPECT_FALSE(ends_in_prompt("\n\r=> x"));
  EXPECT_EQ(errors_in("\n\rERR 16384\n\rERR 2\n\r=> "), 16386);
}

TEST(GclRealTime, FirmwareIsFoundInItsText) {
  EXPECT_EQ(firmware_of("BarrettHand Firmware 4.31"), Firmware::k4_3);
  EXPECT_EQ(firmware_of("version 4.40 of 2010"), Firmware::k4_4);
  EXPECT_FALSE(firmware_of("3.9"));
}

// MAN43, 6.4: fingers 1 and 2 and the spread; LFT has two bytes in 4.3, one in 4.4.
TEST(GclRealTime, ExampleOfTheManual) {
  for (const Firmware firmware : {Firmware::k4_3, Firmware::k4_4}) {
    Layout layout = layout_of(firmware);
    layout.temperature = true;
    for (auto& motor : layout.motors) motor = kNothing;
    for (const std::size_t i : {0, 1}) {
      layout.motors[i].loops = layout.motors[i].velocity = true;
      layout.motors[i].strain = layout.motors[i].delta = true;
    }
    layout.motors[kSpread].loops = layout.motors[kSpread].delta = true;
    const bool is_old = firmware == Firmware::k4_3;
    EXPECT_EQ(layout.control_size(), 2u);
    EXPECT_EQ(layout.feedback_size(), is_old ? 8u : 7u);
    Controls controls{};
    controls[0].velocity = 30;
    controls[1].velocity = -30;
    EXPECT_THAT(encode_control(Header::kControl, controls, layout), ElementsAre(0x43, 0x1E, 0xE2));
    Block block{0x2A, 100, 5, 101, 0xFB, 7};
    if (is_old) block.push_back(0x01);
    block.push_back(0x2C);
    const auto feedback = decode_feedback(block, layout);
    ASSERT_TRUE(feedback);
    EXPECT_EQ(feedback->motors[0].strain, 100);
    EXPECT_EQ(feedback->motors[1].delta, -5);
    EXPECT_EQ(feedback->motors[kSpread].delta, 7);
    EXPECT_EQ(feedback->temperature, is_old ? 300 : 44);
    EXPECT_EQ(encode(*feedback, layout), block);
    block.pop_back();
    EXPECT_FALSE(decode_feedback(block, layout));
  }
}

// handif: velocities and gains out, strains and positions back.
TEST(GclRealTime, ExampleOfHandif) {
  Layout layout = layout_of(Firmware::k4_3);
  for (std::size_t i = 0; i < kSpread; ++i) {
    layout.motors[i] = {.loops = true, .speed = false, .delta = false};
  }
  layout.motors[kSpread] = kNothing;
  Controls controls{};
  for (std::size_t i = 0; i < kSpread; ++i)
    controls[i] = {.velocity = i < 2 ? 30 : -30, .gain = 100};
  const Block out{0x43, 0x1E, 0x64, 0x1E, 0x64, 0xE2, 0x64};
  EXPECT_EQ(encode_control(Header::kControl, controls, layout), out);
  const auto again = decode_control(Bytes(out).subspan(1), layout);
  ASSERT_TRUE(again);
  EXPECT_EQ((*again)[2].velocity, -30);
  EXPECT_EQ((*again)[2].gain, 100);
  const Block back{0x2A, 0x80, 0x13, 0x88, 0x80, 0x13, 0x88, 0x80, 0x00, 0x00};
  const auto feedback = decode_feedback(back, layout);
  ASSERT_TRUE(feedback);
  EXPECT_EQ(feedback->motors[0].position, 5000);
  EXPECT_EQ(feedback->motors[2].position, 0);
  EXPECT_EQ(feedback->motors[1].strain, 128);
  EXPECT_EQ(encode(*feedback, layout), back);
}

TEST(GclRealTime, HeadersWithoutDataHaveNone) {
  const Layout layout = layout_of(Firmware::k4_3);
  EXPECT_THAT(encode_control(Header::kFeedback, {}, layout), ElementsAre(0x41));
  EXPECT_THAT(encode_control(Header::kAcknowledgement, {}, layout), ElementsAre(0x61));
}

// MAN43's example of LFDP: LFDPC 2, a step of 500 counts.
TEST(GclRealTime, BigStepTakesSeveralDeltas) {
  int told = 1500;
  std::vector<int> deltas;
  for (int i = 0; i < 3; ++i) {
    deltas.push_back(delta_of(2000 - told, 2));
    told += 2 * deltas.back();
  }
  EXPECT_THAT(deltas, ElementsAre(127, 123, 0));
}

TEST(GclRealTime, ValuesAreCutToTheirRange) {
  Layout layout = layout_of(Firmware::k4_4);
  layout.motors[0].loops = true;
  Controls controls{};
  controls[0] = {.velocity = 900, .gain = -4};
  EXPECT_THAT(encode_control(Header::kControl, controls, layout), ElementsAre(0x43, 127, 0));
  controls[0] = {.velocity = -900, .gain = 999};
  EXPECT_THAT(encode_control(Header::kControl, controls, layout), ElementsAre(0x43, 0x81, 255));
}

TEST(GclRealTime, LayoutsThatNoHandTakesAreNamed) {
  Layout layout = layout_of(Firmware::k4_4);
  layout.motors[1].torque = true;
  EXPECT_EQ(layout.problem(), "LCT goes with neither LCV nor LCPG");
  layout.motors[1].velocity = layout.motors[1].gain = false;
  EXPECT_EQ(layout.problem(), "");
  layout.firmware = Firmware::k4_3;
  EXPECT_EQ(layout.problem(), "firmware 4.3 has no LCT, LFBP and LFAIN");
}

// Whatever is enabled: sizes, and values there and back.
TEST(GclRealTime, AnyLayoutThereAndBack) {
  std::mt19937_64 random(262);
  const auto coin = [&] { return random() % 2 == 0; };
  const auto number = [&](int least, int most) {
    return least + static_cast<int>(random() % static_cast<std::uint64_t>(most - least + 1));
  };
  for (int k = 0; k < 20000; ++k) {
    Layout layout = layout_of(coin() ? Firmware::k4_3 : Firmware::k4_4);
    layout.temperature = coin();
    const bool is_late = layout.firmware == Firmware::k4_4;
    Controls controls{};
    Feedback feedback;
    for (std::size_t i = 0; i < kAxes; ++i) {
      MotorLayout& of = layout.motors[i];
      of = {coin(), coin(), coin(), false, coin(), coin(), coin(), coin()};
      of.torque = is_late && !of.velocity && !of.gain && coin();
      of.breakaway = is_late && coin();
      of.analog = is_late && coin();
      if (!of.loops) continue;
      if (of.velocity) controls[i].velocity = number(-127, 127);
      if (of.gain) controls[i].gain = number(0, 255);
      if (of.torque) controls[i].torque = number(-32768, 32767);
      MotorFeedback& told = feedback.motors[i];
      if (of.speed) told.speed = number(-128, 127);
      if (of.strain) told.strain = number(0, 255);
      if (of.position) told.position = number(-300, 18000);
      if (of.delta) told.delta = number(-128, 127);
      if (of.breakaway) told.breakaway = number(0, 20000);
      if (of.analog) told.analog = number(0, 255);
    }
    if (layout.temperature) feedback.temperature = is_late ? number(-55, 125) : number(-550, 1250);
    ASSERT_EQ(layout.problem(), "");
    const Block out = encode_control(Header::kControl, controls, layout);
    ASSERT_EQ(out.size(), 1 + layout.control_size());
    const auto controls_again = decode_control(Bytes(out).subspan(1), layout);
    ASSERT_TRUE(controls_again);
    ASSERT_EQ(encode_control(Header::kControl, *controls_again, layout), out);
    const Block back = encode(feedback, layout);
    ASSERT_EQ(back.size(), layout.feedback_size());
    const auto again = decode_feedback(back, layout);
    ASSERT_TRUE(again);
    ASSERT_EQ(again->temperature, feedback.temperature);
    for (std::size_t i = 0; i < kAxes; ++i) {
      ASSERT_EQ((*controls_again)[i].velocity, controls[i].velocity);
      ASSERT_EQ((*controls_again)[i].torque, controls[i].torque);
      ASSERT_EQ(again->motors[i].position, feedback.motors[i].position);
      ASSERT_EQ(again->motors[i].breakaway, feedback.motors[i].breakaway);
    }
  }
}

}  // namespace
}  // namespace prehend::drivers::barrett::gcl
