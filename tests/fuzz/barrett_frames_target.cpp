// What the pucks of a BarrettHand, or what else is on its bus, send: `kind byte | frames`. Bit 0 of
// the kind: the frames go to a puck's decoder, not from one; bit 1: they go to a driver, among
// answers to what it asks whose values are the input's. It must not move anything by what it hears.

#include <cmath>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <variant>

#include "drivers/barrett/codec/message.h"
#include "drivers/barrett/codec/tactile.h"
#include "drivers/barrett/driver/driver.h"
#include "tests/fuzz/fuzz_input.h"

namespace {

using namespace prehend::drivers;
using namespace prehend::drivers::barrett;
using prehend::fuzz::FuzzInput;

CanFrame take_frame(FuzzInput& input) {
  CanFrame frame;
  const unsigned low = input.byte();
  frame.identifier =
      static_cast<std::uint16_t>((low | static_cast<unsigned>(input.byte()) << 8) & 0x7FF);
  frame.size = input.byte() % 9;
  for (std::size_t i = 0; i < frame.size; ++i) frame.data[i] = input.byte();
  return frame;
}

std::int32_t take_number(FuzzInput& input) {
  std::uint32_t number = 0;
  for (int i = 0; i < 4; ++i) number = number << 8 | input.byte();
  return static_cast<std::int32_t>(number);
}

void fuzz_requests(FuzzInput& input) {
  while (!input.is_empty()) {
    const auto request = decode_request(take_frame(input));
    if (!request) continue;
    FUZZ_CHECK(request->axis < kAxes && request->property < kProperties);
    // A value of 16 bits may have come with 32.
    if (!request->value || is_wide(request->property)) {
      FUZZ_CHECK(decode_request(encode(*request)) == request);
    }
  }
}

void fuzz_replies(FuzzInput& input) {
  TactileAssembler pad;
  std::uint64_t parts = 0, images = 0;
  while (!input.is_empty()) {
    const CanFrame frame = take_frame(input);
    const auto reply = decode_reply(frame);
    if (!reply) continue;
    if (const auto* position = std::get_if<Position>(&*reply)) {
      FUZZ_CHECK(position->motor >= kLeastPosition && position->motor <= kMostPosition);
      FUZZ_CHECK(encode(*position) == frame);
    } else if (const auto* part = std::get_if<TactilePart>(&*reply)) {
      FUZZ_CHECK(encode(*part) == frame);
      for (const std::uint16_t cell : part->cells) FUZZ_CHECK(cell <= kMostCellCount);
      ++parts;
      if (pad.add(*part)) ++images;
    } else {
      const auto& value = std::get<Value>(*reply);
      FUZZ_CHECK(value.axis < kAxes && value.property < kProperties);
      if (is_wide(value.property) == (frame.size == 6)) FUZZ_CHECK(encode(value) == frame);
    }
  }
  FUZZ_CHECK(images * kTactileFrames <= parts && pad.broken() <= parts);
}

bool moves_something(const Request& request) {
  if (!request.value) return false;
  switch (static_cast<Property>(request.property)) {
    case Property::kMode:
      return *request.value != static_cast<int>(Mode::kIdle);
    case Property::kCommand:
      return *request.value != static_cast<int>(Command::kOff);
    case Property::kMove:
    case Property::kEnd:
    case Property::kVelocity:
    case Property::kTorque:
      return true;
    default:
      return false;
  }
}

void fuzz_driver(FuzzInput& input) {
  bool moved = false;
  std::deque<Request> asked;
  DriverOptions options;
  options.initialisation = Initialisation::kDone;
  Driver driver(
      options,
      [&](const CanFrame& frame) {
        const auto request = decode_request(frame);
        FUZZ_CHECK(request.has_value());
        moved = moved || moves_something(*request);
        if (!request->value) asked.push_back(*request);
        return std::string();
      },
      [](bool, const std::string&) {});
  Time now = std::chrono::seconds(1);
  driver.connected(now);
  constexpr int kMostSteps = 400;
  for (int i = 0; i < kMostSteps && !input.is_empty(); ++i) {
    const std::uint8_t what = input.byte();
    now += std::chrono::milliseconds(what & 15);
    driver.update(now);
    if ((what & 0x80) != 0) {
      driver.receive(take_frame(input), now);
    }
    // Answers: as a hand that stands at its zero, or with the input's numbers.
    for (; !asked.empty() && (what & 0x40) == 0; asked.pop_front()) {
      const Request request = asked.front();
      const auto property = static_cast<Property>(request.property);
      const bool is_fuzzed = (what & 0x20) != 0;
      const std::int32_t fuzzed = is_fuzzed ? take_number(input) : 0;
      if (property == Property::kPosition) {
        Position position{request.axis, fuzzed};
        if (request.axis != kSpread) position.joint = fuzzed;
        driver.receive(encode(position), now);
        continue;
      }
      std::int32_t value = fuzzed;
      if (!is_fuzzed) {
        value = property == Property::kStatus      ? static_cast<int>(Status::kReady)
                : property == Property::kStallTime ? 250
                : property == Property::kHold      ? request.axis == kSpread
                : property == Property::kStrain    ? 2048
                                                   : 0;
      }
      driver.receive(encode(Value{request.axis, request.property, value}), now);
    }
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
  const std::uint8_t kind = input.byte();
  if ((kind & 2) != 0) {
    fuzz_driver(input);
  } else if ((kind & 1) != 0) {
    fuzz_requests(input);
  } else {
    fuzz_replies(input);
  }
  return 0;
}
