// The SDH-2's language: what the vendor's library was seen to send, and what it parses.

#include <gtest/gtest.h>

#include <limits>

#include "drivers/sdh/codec/firmware.h"
#include "drivers/sdh/codec/stream.h"
#include "tests/drivers/hex.h"

namespace prehend::drivers::sdh {
namespace {

using Block = std::vector<std::uint8_t>;

Block bytes_of(std::string_view text) { return {text.begin(), text.end()}; }

Block zeros(std::size_t count) { return Block(count, 0); }

Block joined(std::initializer_list<Block> parts) {
  Block all;
  for (const Block& part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

BinaryRequest asks(Command command) { return {static_cast<std::uint8_t>(command)}; }
BinaryRequest sets(Command command, const AxisValues& values) {
  return {static_cast<std::uint8_t>(command), values};
}

// Requests observed from SDHLibrary-CPP 0.0.2.10, replies that it accepted.
TEST(SdhBinary, VectorsOfTheVendorsLibrary) {
  AxisValues forty{}, target{}, limits{};
  forty.fill(40);
  target[0] = 10;
  target[1] = -30;
  limits.fill(0.5);
  limits[0] = 1;
  EXPECT_EQ(encode(asks(Command::kActualPosition), true), hex("83 03 00 DC 1E"));
  EXPECT_EQ(encode(asks(Command::kSpeed), true), hex("80 03 00 3A A1"));
  EXPECT_EQ(encode(asks(Command::kState), true), hex("84 03 00 A3 28"));
  EXPECT_EQ(encode(asks(Command::kPower), true), hex("A4 03 00 A3 F1"));
  EXPECT_EQ(encode(asks(Command::kCurrentLimit), true), hex("A3 03 00 DC C7"));
  EXPECT_EQ(encode(asks(Command::kSpeedActual), true), hex("8C 03 00 83 28"));
  EXPECT_EQ(encode(asks(Command::kTarget), true), hex("85 03 00 01 42"));
  Block forties;
  for (int i = 0; i < 7; ++i) forties = joined({forties, hex("00 00 20 42")});
  EXPECT_EQ(encode(sets(Command::kSpeed, forty), true),
            joined({hex("80 1F 07"), forties, hex("6B 62")}));
  EXPECT_EQ(encode(sets(Command::kTarget, target), true),
            joined({hex("85 1F 07 00 00 20 41 00 00 F0 C1"), zeros(20), hex("FC C1")}));
  EXPECT_EQ(encode(sets(Command::kPower, {}), true),
            joined({hex("A4 1F 07"), zeros(28), hex("FA 6E")}));
  const auto reply = [](Command command, const AxisValues& values, std::uint8_t status = 0) {
    return encode(BinaryReply{static_cast<std::uint8_t>(command), 7, status, values}, true);
  };
  EXPECT_EQ(reply(Command::kActualPosition, {}),
            joined({hex("83 20 07 00"), zeros(28), hex("BE 97")}));
  EXPECT_EQ(reply(Command::kSpeed, forty), joined({hex("80 20 07 00"), forties, hex("3C 22")}));
  EXPECT_EQ(reply(Command::kTarget, target),
            joined({hex("85 20 07 00 00 00 20 41 00 00 F0 C1"), zeros(20), hex("D8 68")}));
  EXPECT_EQ(reply(Command::kPower, {}, 28), joined({hex("A4 20 07 1C"), zeros(28), hex("28 A9")}));
  const auto read = decode_binary_reply(reply(Command::kCurrentLimit, limits), true);
  ASSERT_TRUE(read);
  EXPECT_EQ(read->values, limits);
  EXPECT_TRUE(read->has_values());
}

TEST(SdhBinary, WithoutChecksumOnTcp) {
  EXPECT_EQ(encode(asks(Command::kActualPosition), false), hex("83 01 00"));
  const Block reply = encode(BinaryReply{.command = 0x83}, false);
  EXPECT_EQ(reply.size(), 32u);
  EXPECT_EQ(Block(reply.begin(), reply.begin() + 4), hex("83 1E 07 00"));
  EXPECT_TRUE(decode_binary_reply(reply, false));
  EXPECT_FALSE(decode_binary_reply(reply, true));
}

TEST(SdhBinary, EveryDamagedBitIsSeen) {
  AxisValues values{};
  values.fill(12.5);
  const Block good = encode(BinaryReply{.command = 0x83, .values = values}, true);
  for (std::size_t bit = 0; bit < 8 * good.size(); ++bit) {
    Block bad = good;
    bad[bit / 8] ^= static_cast<std::uint8_t>(1 << bit % 8);
    EXPECT_FALSE(decode_binary_reply(bad, true)) << bit;
  }
}

TEST(SdhLine, RequestsOfTheVendorsLibraryAreRead) {
  const auto read = [](std::string_view line) { return decode_line_request(line); };
  EXPECT_EQ(read("ver"), (LineRequest{.name = "ver"}));
  EXPECT_EQ(read("ref(2)=       1.000"), (LineRequest{.name = "ref", .axis = 2, .values = {1}}));
  EXPECT_EQ(read("v(2)=      12.500"), (LineRequest{.name = "v", .axis = 2, .values = {12.5}}));
  EXPECT_EQ(read("ilim(2)"), (LineRequest{.name = "ilim", .axis = 2}));
  EXPECT_EQ(read("p=10.000000,-30.000000,0.000000,0.000000,0.000000,0.000000,0.000000"),
            (LineRequest{.name = "p", .values = {10, -30, 0, 0, 0, 0, 0}}));
  for (const std::string_view bad :
       {"", "=", "p=", "p=1,", "p=nan", "p=inf", "p(=1", "p(1=1", "p()=1", "P=1", "p 1", "9p",
        "p=1 2", "p=1,,2", "p(-1)=2", "p(100)=2", "p=1e999", "p=1,2,3,4,5,6,7,8,9,10"}) {
    EXPECT_FALSE(read(bad)) << bad;
  }
}

TEST(SdhLine, RepliesOfBothFirmwareGenerations) {
  const auto read = [](std::string_view line) { return decode_line_reply(line); };
  EXPECT_EQ(read("E13")->error, 13);
  EXPECT_EQ(read("STOP"), (LineReply{.name = "STOP"}));
  EXPECT_EQ(read("POS(3)=12.34"), (LineReply{.name = "POS", .axis = 3, .text = "12.34"}));
  EXPECT_EQ(numbers_of(*read("M=4.51s")->text), std::vector<double>{4.51});
  EXPECT_EQ(numbers_of(*read("SELGRIP=0.0,1")->text), (std::vector<double>{0, 1}));
  EXPECT_EQ(numbers_of("1, -2.5 ,3x,4"), (std::vector<double>{1, -2.5, 3}));
  EXPECT_TRUE(numbers_of("nan").empty());
  EXPECT_TRUE(numbers_of("1,2,3,4,5,6,7,8,9,10").empty());
  for (const std::string_view bad :
       {"", "E", "E1x", "E999", "E013", "pos=1", "=1", "POS(=1", "POS 1"}) {
    const auto reply = read(bad);
    EXPECT_TRUE(!reply || !reply->error) << bad;
    if (bad != "E") {
      EXPECT_FALSE(reply) << bad;
    }
  }
}

TEST(SdhStream, LinesAndMessagesMixedSplitAtAnyByte) {
  AxisValues values{};
  values[3] = 7;
  const Block stream =
      joined({bytes_of("@max distance=45.06, T=4.51s\r\nM=4.51\r\n"),
              encode(BinaryReply{.command = 0x83, .values = values}, true), bytes_of("E28\r\n"),
              encode(BinaryReply{.command = 0x84}, true), bytes_of("\r\nSTOP\r\n")});
  for (std::size_t step = 1; step <= stream.size(); ++step) {
    ReplyDecoder decoder(true);
    std::vector<ReplyDecoder::Reply> replies;
    for (std::size_t at = 0; at < stream.size(); at += step) {
      decoder.add(Bytes(stream).subspan(at, std::min(step, stream.size() - at)));
      while (auto reply = decoder.next()) replies.push_back(*reply);
    }
    ASSERT_EQ(replies.size(), 5u) << step;
    EXPECT_EQ(std::get<LineReply>(replies[0]).text, "4.51");
    EXPECT_EQ(std::get<BinaryReply>(replies[1]).values, values);
    EXPECT_EQ(std::get<LineReply>(replies[2]).error, 28);
    EXPECT_EQ(std::get<BinaryReply>(replies[3]).command, 0x84);
    EXPECT_EQ(std::get<LineReply>(replies[4]).name, "STOP");
    EXPECT_EQ(decoder.damaged(), 0u);
  }
}

TEST(SdhStream, GoesOnBehindWhatIsDamaged) {
  Block bad = encode(BinaryReply{.command = 0x83}, true);
  bad[10] ^= 4;
  ReplyDecoder decoder(true);
  decoder.add(joined({bad, bytes_of("POS=1,2\r\n")}));
  const auto reply = decoder.next();
  ASSERT_TRUE(reply);
  EXPECT_EQ(std::get<LineReply>(*reply).name, "POS");
  EXPECT_GT(decoder.damaged(), 0u);
  // A line without end, run into by a message.
  decoder.add(joined({bytes_of("STATE=0,0"), encode(BinaryReply{.command = 0x84}, true)}));
  ASSERT_TRUE(std::holds_alternative<BinaryReply>(*decoder.next()));
  // Nothing that never ends is kept.
  for (int i = 0; i < 1000; ++i) {
    decoder.add(bytes_of("AAAAAAAAAAAAAAAA"));
    EXPECT_FALSE(decoder.next());
  }
  EXPECT_GT(decoder.discarded(), 15000u);
}

TEST(SdhStream, RequestsAreAnsweredWithWhatIsWrongOfThem) {
  RequestDecoder decoder(true);
  decoder.add(joined({bytes_of(" \r\nver\r\nnope nope\r\n"), encode(asks(Command::kState), true),
                      bytes_of(std::string(300, 'a') + "\r\nstop\r\n")}));
  EXPECT_EQ(std::get<LineRequest>(*decoder.next()).name, "ver");
  EXPECT_EQ(std::get<ReturnCode>(*decoder.next()), ReturnCode::kCommandFormat);
  EXPECT_EQ(std::get<BinaryRequest>(*decoder.next()), asks(Command::kState));
  std::optional<RequestDecoder::Request> request = decoder.next();
  ASSERT_TRUE(request);
  EXPECT_TRUE(std::holds_alternative<ReturnCode>(*request));
  while ((request = decoder.next()) && !std::holds_alternative<LineRequest>(*request)) {
  }
  ASSERT_TRUE(request);
  EXPECT_EQ(std::get<LineRequest>(*request).name, "stop");
}

TEST(SdhFirmware, VersionsAreComparedByTheirNumbers) {
  EXPECT_EQ(firmware_of("0.0.3.3")->text(), "0.0.3.3");
  EXPECT_LT(*firmware_of("0.0.2.9"), *firmware_of("0.0.2.16"));
  EXPECT_FALSE(firmware_of("0.0.2.6")->has_smooth_ramp());
  EXPECT_TRUE(firmware_of("0.0.2.6")->has_controllers());
  EXPECT_TRUE(firmware_of("0.0.2.15")->has_binary());
  EXPECT_FALSE(firmware_of("0.0.2.16")->is_terse());
  for (const char* bad : {"", "1", "1.2.3", "1.2.3.4.5", "1.2.3.x", "-1.2.3.4", "99999.0.0.0"}) {
    EXPECT_FALSE(firmware_of(bad)) << bad;
  }
}

TEST(SdhCodes, CommandsByNameInAnyCase) {
  EXPECT_EQ(command_named("POS"), Command::kActualPosition);
  EXPECT_EQ(command_named("get_duration"), Command::kDuration);
  EXPECT_FALSE(command_named("position"));
  EXPECT_FALSE(command_named(""));
  EXPECT_EQ(describe_code(29), "E29 over-temperature");
  EXPECT_EQ(describe_code(200), "E200 unknown");
}

}  // namespace
}  // namespace prehend::drivers::sdh
