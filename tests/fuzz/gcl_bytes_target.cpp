// What a BarrettHand BH8-262, or what is at the end of its line, sends: `kind byte | bytes`. Kind
// 0: an answer to the line before the first CR; 1: lines and blocks to a hand; 2: blocks of a
// layout of the next five bytes; 3: to a driver, a few at a time, which must not move by what it
// hears.

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/barrett/codec/gcl/line.h"
#include "drivers/barrett/codec/gcl/real_time.h"
#include "drivers/barrett/driver/gcl/driver.h"
#include "drivers/barrett/emulator/gcl/hand.h"
#include "tests/fuzz/fuzz_input.h"

namespace {

using namespace prehend::drivers;
using namespace prehend::drivers::barrett;
using namespace prehend::drivers::barrett::gcl;
using prehend::fuzz::FuzzInput;

Bytes bytes_of(std::string_view text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

void fuzz_answer(std::string_view text) {
  const std::string_view sent = text.substr(0, text.find('\r'));
  const std::string_view received = text.substr(std::min(text.size(), sent.size() + 1));
  const Reply reply = parse_reply(received, sent);
  FUZZ_CHECK(reply.kind != Reply::Kind::kDone || received.size() <= kLongestReply);
  for (const std::string& line : reply.lines) {
    for (const int value : integers_of(line)) FUZZ_CHECK(!std::to_string(value).empty());
  }
  FUZZ_CHECK(!describe_status(errors_in(received)).empty());
  // What is said, is read as it was meant.
  if (const auto request = decode_request(sent); request && !request->command.empty()) {
    const auto again = decode_request(encode(*request));
    FUZZ_CHECK(again && again->motors == request->motors && again->words == request->words);
  }
}

void fuzz_hand(std::string_view text) {
  ClutchHand plant;
  HandOptions options;
  options.plant = &plant;
  options.boot_time = 0.001;
  options.is_initialised = true;
  Hand hand(options, [](Bytes) {});
  Time now = std::chrono::seconds(1);
  constexpr std::size_t kMostBlocks = 200;
  const std::size_t step = std::max<std::size_t>(1, text.size() / kMostBlocks);
  for (std::size_t i = 0; i < text.size(); i += step) {
    now += std::chrono::milliseconds(5);
    hand.update(now);
    hand.receive(bytes_of(text.substr(i, step)), now);
    for (const double position : hand.motion().position) FUZZ_CHECK(std::isfinite(position));
  }
}

void fuzz_blocks(FuzzInput& input) {
  Layout layout;
  const std::uint8_t of_all = input.byte();
  layout.temperature = (of_all & 1) != 0;
  layout.firmware = (of_all & 2) != 0 ? Firmware::k4_4 : Firmware::k4_3;
  for (MotorLayout& motor : layout.motors) {
    const std::uint8_t flags = input.byte();
    motor = {(flags & 1) != 0, (flags & 2) != 0,  (flags & 4) != 0,  false,
             (flags & 8) != 0, (flags & 16) != 0, (flags & 32) != 0, (flags & 64) != 0};
    motor.breakaway = motor.analog = (flags & 128) != 0;
  }
  const std::string_view rest = input.rest();
  if (const auto feedback = decode_feedback(bytes_of(rest), layout)) {
    const auto again = encode(*feedback, layout);
    FUZZ_CHECK(again.size() == rest.size() && std::ranges::equal(again, bytes_of(rest)));
  }
  if (const auto controls = decode_control(bytes_of(rest), layout)) {
    FUZZ_CHECK(encode_control(Header::kControl, *controls, layout).size() == 1 + rest.size());
  }
}

void fuzz_driver(std::string_view text) {
  bool moved = false;
  DriverOptions options;
  options.fast_baud = 38400;
  Driver driver(
      options,
      [&](Bytes sent) {
        const std::string_view line(reinterpret_cast<const char*>(sent.data()), sent.size());
        moved = moved || line.starts_with("HI") || line.find("LOOP") != std::string_view::npos ||
                line.starts_with("C");
        return std::string();
      },
      [](unsigned) { return std::string(); }, [](bool, const std::string&) {});
  Time now = std::chrono::seconds(1);
  driver.connected(now);
  constexpr std::size_t kMostBlocks = 300;
  const std::size_t step = std::max<std::size_t>(1, text.size() / kMostBlocks);
  for (std::size_t i = 0; i < text.size(); i += step) {
    now += std::chrono::milliseconds(30);
    driver.update(now);
    driver.receive(bytes_of(text.substr(i, step)), now);
    FUZZ_CHECK(!moved);
    for (std::size_t axis = 0; axis < kAxes; ++axis) {
      FUZZ_CHECK(std::isfinite(driver.reading().position[axis]));
      FUZZ_CHECK(std::isfinite(driver.reading().velocity[axis]));
      FUZZ_CHECK(std::isfinite(driver.reading().effort[axis]));
    }
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  FuzzInput input(data, size);
  switch (input.byte() % 4) {
    case 0:
      fuzz_answer(input.rest());
      break;
    case 1:
      fuzz_hand(input.rest());
      break;
    case 2:
      fuzz_blocks(input);
      break;
    default:
      fuzz_driver(input.rest());
      break;
  }
  return 0;
}
