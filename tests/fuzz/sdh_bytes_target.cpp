// What an SDH-2, or what is at the end of its line, sends: `kind byte | bytes`. Bit 0 of the kind:
// to a hand, not from one; bit 1: binary messages have a checksum; bit 2: the bytes go to a driver,
// a few at a time, which asks, and must not move by what it hears.

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "drivers/sdh/codec/stream.h"
#include "drivers/sdh/driver/driver.h"
#include "tests/fuzz/fuzz_input.h"

namespace {

using namespace prehend::drivers;
using namespace prehend::drivers::sdh;
using prehend::fuzz::FuzzInput;

Bytes bytes_of(std::string_view text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

void check(const LineReply& reply) {
  FUZZ_CHECK(reply.error.has_value() != !reply.name.empty());
  const std::string text = encode(reply);
  FUZZ_CHECK(text.size() <= kLongestLine + 2);
  FUZZ_CHECK(decode_line_reply(std::string_view(text).substr(0, text.size() - 2)) == reply);
  const std::vector<double> values = numbers_of(reply.text.value_or(""));
  FUZZ_CHECK(values.size() <= kMostValues);
  for (const double value : values) FUZZ_CHECK(std::isfinite(value));
}
void check(const BinaryReply& reply, bool has_checksum) {
  FUZZ_CHECK(reply.command >= kFirstBinary);
  const auto bytes = encode(reply, has_checksum);
  const auto again = decode_binary_reply(bytes, has_checksum);
  FUZZ_CHECK(again && encode(*again, has_checksum) == bytes);
}

void fuzz_replies(Bytes bytes, bool has_checksum) {
  ReplyDecoder decoder(has_checksum);
  decoder.add(bytes);
  std::size_t replies = 0;
  while (const auto reply = decoder.next()) {
    ++replies;
    if (const auto* line = std::get_if<LineReply>(&*reply)) {
      check(*line);
    } else {
      check(std::get<BinaryReply>(*reply), has_checksum);
    }
  }
  FUZZ_CHECK(2 * replies + decoder.discarded() <= bytes.size());
}

void fuzz_requests(Bytes bytes, bool has_checksum) {
  RequestDecoder decoder(has_checksum);
  decoder.add(bytes);
  std::size_t requests = 0;
  while (const auto request = decoder.next()) {
    FUZZ_CHECK(++requests <= bytes.size());
    if (const auto* line = std::get_if<LineRequest>(&*request)) {
      FUZZ_CHECK(line->values.size() <= kMostValues);
      for (const double value : line->values) FUZZ_CHECK(std::isfinite(value));
    } else if (const auto* binary = std::get_if<BinaryRequest>(&*request)) {
      const auto again = decode_binary_request(encode(*binary, has_checksum), has_checksum);
      FUZZ_CHECK(again.has_value() && again->command == binary->command);
    }
  }
}

void fuzz_driver(FuzzInput& input, bool has_checksum) {
  DriverOptions options;
  options.has_checksum = has_checksum;
  options.binary = has_checksum;
  bool moved = false;
  Driver driver(
      options,
      [&](Bytes sent) {
        const std::string_view text(reinterpret_cast<const char*>(sent.data()), sent.size());
        moved = moved || text.starts_with("m\r") || text.starts_with("grip") ||
                (!sent.empty() && sent[0] == static_cast<std::uint8_t>(Command::kMove));
        return std::string();
      },
      [](bool, const std::string&) {});
  Time now = std::chrono::seconds(1);
  driver.connected(now);
  const std::string_view rest = input.rest();
  constexpr std::size_t kMostBlocks = 200;
  const std::size_t step = std::max<std::size_t>(1, rest.size() / kMostBlocks);
  for (std::size_t i = 0; i < rest.size(); i += step) {
    now += std::chrono::milliseconds(7);
    driver.update(now);
    driver.receive(bytes_of(rest.substr(i, step)), now);
    FUZZ_CHECK(!moved);
    for (std::size_t axis = 0; axis < kAxes; ++axis) {
      FUZZ_CHECK(std::isfinite(driver.reading().position[axis]));
      FUZZ_CHECK(std::isfinite(driver.reading().velocity[axis]));
    }
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  FuzzInput input(data, size);
  const std::uint8_t kind = input.byte();
  const bool has_checksum = (kind & 2) != 0;
  if ((kind & 4) != 0) {
    fuzz_driver(input, has_checksum);
  } else if ((kind & 1) != 0) {
    fuzz_requests(bytes_of(input.rest()), has_checksum);
  } else {
    fuzz_replies(bytes_of(input.rest()), has_checksum);
  }
  return 0;
}
