// Codes, round trips of random messages, damage.

#include <gtest/gtest.h>

#include <random>
#include <set>

#include "drivers/pg70/codec/can_framing.h"
#include "drivers/pg70/codec/codes.h"
#include "drivers/pg70/codec/request.h"
#include "drivers/pg70/codec/response.h"
#include "drivers/pg70/codec/serial_framing.h"

namespace prehend::drivers::pg70 {
namespace {

using Random = std::mt19937_64;

Content random_content(Random& random) {
  Content content;
  // Mostly the lengths and commands that mean something.
  const auto texts = command_texts();
  const auto command =
      random() % 4 == 0 ? static_cast<std::uint8_t>(random()) : texts[random() % texts.size()].code;
  content.append_number(command);
  const std::size_t parameters = random() % 3 == 0 ? random() % 255 : random() % 24;
  for (std::size_t i = 0; i < parameters; ++i) {
    content.append_number(static_cast<std::uint8_t>(random()));
  }
  return content;
}

bool is_fragment_code(std::uint8_t command) { return command >= 0x84 && command <= 0x86; }

TEST(Pg70Codec, EveryCodeHasANameAndWords) {
  std::set<int> seen;
  const std::pair<std::span<const CodeText>, std::size_t> tables[] = {{info_texts(), 23},
                                                                      {error_texts(), 33}};
  for (const auto& [texts, count] : tables) {
    EXPECT_EQ(texts.size(), count);
    for (const CodeText& text : texts) {
      EXPECT_TRUE(seen.insert(text.code).second) << text.name;  // no code means two things
      const std::string described = describe_code(text.code);
      EXPECT_NE(described.find(text.name), std::string::npos);
      EXPECT_GT(std::string(text.words).size(), 8u) << text.name;
    }
  }
  EXPECT_EQ(describe_code(0xDA),
            "ERROR TOW (0xDA): the drive cannot follow its target; look for what jams the jaws");
  EXPECT_EQ(describe_code(0x06), "INFO NOT REFERENCED (0x06): reference the gripper first");
  EXPECT_EQ(describe_code(0x55), "unknown code 0x55");
  EXPECT_EQ(command_name(0xB0), "MOVE POS");
  EXPECT_EQ(command_name(0xFE), "command 0xFE");
}

TEST(Pg70Codec, EveryErrorCodeArrivesAsItself) {
  for (const CodeText& text : error_texts()) {
    for (const Command kind : {Command::kError, Command::kWarning}) {
      const Response fault = Fault{kind, static_cast<ErrorCode>(text.code)};
      EXPECT_EQ(decode_response(encode(fault), kWithAll), fault);
      EXPECT_EQ(direction_of(fault), Direction::kError);
    }
    const Response state = State{1.0F, 2.0F, 3.0F, kErrorPresent, text.code};
    EXPECT_EQ(decode_response(encode(state), kWithAll), state);
  }
  for (const CodeText& text : info_texts()) {
    for (const CodeText& command : command_texts()) {
      if (command.code == 0x88 || command.code == 0x89) continue;
      const Response refusal =
          Refusal{static_cast<Command>(command.code), static_cast<InfoCode>(text.code)};
      EXPECT_EQ(decode_response(encode(refusal), kWithAll), refusal);
    }
  }
}

TEST(Pg70Codec, TypedResponsesBothWays) {
  DeviceFacts facts;
  facts.type = {'P', 'G', '7', '0', '-', '5', '0', 0};
  facts.order_number = 306090;
  facts.firmware = 141;
  facts.undocumented = {1, 2, 3, 4, 5};
  const Response responses[] = {
      facts,        UserChanged{3},        DetailedError{Command::kError, 0xDA, 1.5F},
      ConfigSet{8}, ImpulseMessages{true}, ConfigValue{0x0B, {0, 0, 0xD0, 0x40}}};
  for (const Response& response : responses) {
    EXPECT_EQ(decode_response(encode(response), 0), response) << response.index();
  }
  EXPECT_EQ(encode(Response(facts)).size(), 45u);
}

TEST(Pg70Codec, StateKeepsWhatItsModeSays) {
  for (std::uint8_t mode = 0; mode <= 7; ++mode) {
    State state;
    if (mode & kWithPosition) state.position = 1.5F;
    if (mode & kWithVelocity) state.velocity = -2.5F;
    if (mode & kWithCurrent) state.current = 0.25F;
    state.status = kReferenced;
    const Content content = encode(state);
    EXPECT_EQ(decode_response(content, mode), Response(state)) << int(mode);
  }
}

TEST(Pg70Codec, MillionRandomMessagesDecodeAndEncodeToThemselves) {
  Random random(7);
  for (int i = 0; i < 1000000; ++i) {
    const Content content = random_content(random);
    ASSERT_EQ(encode(decode_request(content)), content) << i;
    ASSERT_EQ(encode(decode_response(content, static_cast<std::uint8_t>(random()))), content) << i;
  }
}

TEST(Pg70Codec, MillionRandomMessagesThroughCanFrames) {
  Random random(8);
  FrameAssembler assembler;
  for (int i = 0; i < 1000000; ++i) {
    const Content content = random_content(random);
    if (is_fragment_code(content.command()) && content.size() <= 7) continue;
    int frames = 0;
    std::optional<Content> whole;
    split_into_frames(0x50C, content, [&](const CanFrame& frame) {
      ++frames;
      ASSERT_FALSE(whole);
      whole = assembler.add(frame);
    });
    ASSERT_TRUE(whole) << i;
    ASSERT_EQ(*whole, content) << i;
    ASSERT_EQ(frames, content.size() <= 7 ? 1 : (int(content.size()) + 5) / 6);
    ASSERT_LE(frames, kMostFrames);
  }
  EXPECT_EQ(assembler.broken(), 0u);
}

TEST(Pg70Codec, SerialStreamWithGarbageBetweenMessagesLosesNone) {
  Random random(9);
  SerialDecoder decoder;
  std::uint64_t garbage = 0;
  for (int i = 0; i < 100000; ++i) {
    const SerialMessage message{static_cast<Direction>(random() % 3),
                                static_cast<std::uint8_t>(1 + random() % 255),
                                random_content(random)};
    for (auto n = random() % 4; n > 0; --n) {
      const std::uint8_t byte[] = {0x1B};  // begins no message
      decoder.add(byte);
      ++garbage;
    }
    const auto bytes = encode_serial(message);
    const std::size_t cut = random() % bytes.size();
    decoder.add(Bytes(bytes).first(cut));
    ASSERT_FALSE(decoder.next());
    decoder.add(Bytes(bytes).subspan(cut));
    ASSERT_EQ(decoder.next(), message) << i;
  }
  EXPECT_EQ(decoder.discarded(), garbage);
}

TEST(Pg70Codec, SerialMessageAfterADamagedOneIsFound) {
  Random random(10);
  for (int i = 0; i < 20000; ++i) {
    const SerialMessage first{Direction::kCommand, 1, random_content(random)};
    const SerialMessage second{Direction::kResponse, 1, encode(Info{8})};
    auto damaged = encode_serial(first);
    damaged[random() % damaged.size()] ^= static_cast<std::uint8_t>(1 + random() % 255);
    SerialDecoder decoder;
    decoder.add(damaged);
    decoder.add(encode_serial(second));
    bool found = false;
    // A damaged length may ask for bytes that never come: a silence ends that.
    for (int silences = 0; silences < 600 && !found; ++silences) {
      while (const auto message = decoder.next()) found |= *message == second;
      if (!found) decoder.give_up();
    }
    ASSERT_TRUE(found) << i;
  }
}

TEST(Pg70Codec, LostDoubledAndSwappedFragmentsGiveNoWrongMessage) {
  Random random(11);
  FrameAssembler assembler;
  std::uint64_t damaged_runs = 0;
  for (int i = 0; i < 50000; ++i) {
    Content content = random_content(random);
    std::vector<CanFrame> frames;
    split_into_frames(0x70C, content, [&](const CanFrame& f) { frames.push_back(f); });
    if (frames.size() < 2) continue;
    const std::size_t victim = random() % frames.size();
    switch (random() % 3) {
      case 0:
        frames.erase(frames.begin() + static_cast<std::ptrdiff_t>(victim));
        break;
      case 1:
        frames.insert(frames.begin() + static_cast<std::ptrdiff_t>(victim), frames[victim]);
        break;
      default:
        std::swap(frames[0], frames[frames.size() - 1]);
    }
    ++damaged_runs;
    for (const CanFrame& frame : frames) {
      const auto whole = assembler.add(frame);
      if (!whole) continue;  // else a doubled start only
      ASSERT_EQ(*whole, content) << i;
    }
    assembler.give_up();
  }
  EXPECT_GT(damaged_runs, 10000u);
  EXPECT_GT(assembler.broken(), damaged_runs / 2);
}

TEST(Pg70Codec, LengthsBeyondTheFormatAreRefused) {
  EXPECT_THROW(encode(Request(SetConfig{1, std::vector<std::uint8_t>(254)})), std::length_error);
  EXPECT_THROW(encode(Request(Move{.command = Command::kMoveGrip, .count = 2})),
               std::invalid_argument);
  EXPECT_THROW(encode(Request(Move{.command = Command::kStop})), std::invalid_argument);
  FrameAssembler assembler;
  CanFrame lying{.identifier = 0x501, .size = 3, .data = {7, 0x91, 0}};  // says 7, has 2
  EXPECT_FALSE(assembler.add(lying));
  EXPECT_EQ(assembler.broken(), 1u);
  EXPECT_FALSE(assembler.add(CanFrame{.identifier = 0x501}));
  EXPECT_EQ(assembler.broken(), 2u);
}

}  // namespace
}  // namespace prehend::drivers::pg70
