#include "drivers/wire/can/slcan.h"

#include <array>
#include <charconv>

#include "prehend/geometry/errors.h"

namespace prehend::drivers {
namespace {

constexpr auto kWriteTime = std::chrono::milliseconds(20);
constexpr std::size_t kLongestLine = 64;
constexpr char kDigits[] = "0123456789ABCDEF";

std::optional<unsigned> number(std::string_view digits) {
  unsigned value = 0;
  const auto [end, error] =
      std::from_chars(digits.data(), digits.data() + digits.size(), value, 16);
  if (error != std::errc{} || end != digits.data() + digits.size()) return std::nullopt;
  return value;
}

IoResult write_text(ByteStream& stream, std::string_view text) {
  return stream.write({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()},
                      kWriteTime);
}

}  // namespace

std::string to_slcan(const CanFrame& frame) {
  std::string line = "t";
  line += kDigits[frame.identifier >> 8 & 7];
  line += kDigits[frame.identifier >> 4 & 15];
  line += kDigits[frame.identifier & 15];
  line += kDigits[frame.size & 15];
  for (const std::uint8_t byte : frame.bytes()) {
    line += kDigits[byte >> 4];
    line += kDigits[byte & 15];
  }
  return line + '\r';
}

std::optional<CanFrame> from_slcan(std::string_view line) {
  constexpr std::size_t kHeader = 5, kStamp = 4;
  if (line.size() < kHeader || line[0] != 't') return std::nullopt;
  const auto identifier = number(line.substr(1, 3));
  const auto size = number(line.substr(4, 1));
  if (!identifier || !size || *identifier > 0x7FF || *size > 8) return std::nullopt;
  const std::size_t length = kHeader + 2 * *size;
  if (line.size() != length && line.size() != length + kStamp) return std::nullopt;
  CanFrame frame{.identifier = static_cast<std::uint16_t>(*identifier),
                 .size = static_cast<std::uint8_t>(*size)};
  for (unsigned i = 0; i < *size; ++i) {
    const auto byte = number(line.substr(kHeader + 2 * i, 2));
    if (!byte) return std::nullopt;
    frame.data[i] = static_cast<std::uint8_t>(*byte);
  }
  return frame;
}

std::optional<char> slcan_rate(unsigned bit_rate) {
  constexpr std::array kRates = {10000u,  20000u,  50000u,  100000u, 125000u,
                                 250000u, 500000u, 800000u, 1000000u};
  for (std::size_t i = 0; i < kRates.size(); ++i) {
    if (kRates[i] == bit_rate) return static_cast<char>('0' + i);
  }
  return std::nullopt;
}

Slcan::Slcan(std::unique_ptr<ByteStream> stream, unsigned bit_rate,
             std::vector<std::uint16_t> identifiers)
    : stream_(std::move(stream)),
      identifiers_(std::move(identifiers)),
      name_("slcan:" + stream_->name()) {
  std::string commands = "C\r";
  if (bit_rate > 0) {
    const auto digit = slcan_rate(bit_rate);
    if (!digit) {
      throw geometry::InputError(name_ + " offers no bit rate of " + std::to_string(bit_rate),
                                 "Use 10, 20, 50, 100, 125, 250, 500, 800 or 1000 kbit/s");
    }
    commands += std::string("S") + *digit + '\r';
  }
  const IoResult result = write_text(*stream_, commands + "O\r");
  if (result.status != IoStatus::kOk) {
    throw geometry::InputError(name_ + " does not take commands: " + result.problem,
                               "Check that this is a CAN adapter with Lawicel's protocol");
  }
}

Slcan::~Slcan() { write_text(*stream_, "C\r"); }

void Slcan::take_lines() {
  std::size_t begin = 0;
  for (std::size_t i = 0; i < partial_.size(); ++i) {
    if (partial_[i] == '\a') {  // the adapter refuses a command or could not send
      inputs_.push_back(CanEvent{CanEvent::Kind::kDisturbed, name_ + " refuses a frame"});
      begin = i + 1;
    }
    if (partial_[i] != '\r') continue;
    const auto frame = from_slcan(std::string_view(partial_).substr(begin, i - begin));
    begin = i + 1;
    if (!frame) continue;
    const bool is_wanted = identifiers_.empty() ||
                           std::ranges::find(identifiers_, frame->identifier) != identifiers_.end();
    if (is_wanted) inputs_.push_back(*frame);
  }
  partial_.erase(0, begin);
  if (partial_.size() > kLongestLine) partial_.clear();  // garbage without an end
}

std::optional<CanInput> Slcan::receive(std::chrono::nanoseconds timeout) {
  // A line may come in pieces, and an answer to a command is no frame: both are read on from.
  const auto deadline = std::chrono::steady_clock::now() + timeout;
  while (inputs_.empty()) {
    std::array<std::uint8_t, 512> buffer;
    const IoResult result = stream_->read(buffer, timeout);
    if (result.status == IoStatus::kClosed) {
      return CanEvent{CanEvent::Kind::kClosed, name_ + " is gone: " + result.problem};
    }
    partial_.append(reinterpret_cast<const char*>(buffer.data()), result.count);
    take_lines();
    timeout = deadline - std::chrono::steady_clock::now();
    if (timeout <= timeout.zero()) break;
  }
  if (inputs_.empty()) return std::nullopt;
  CanInput input = std::move(inputs_.front());
  inputs_.pop_front();
  return input;
}

std::string Slcan::send(const CanFrame& frame) {
  const IoResult result = write_text(*stream_, to_slcan(frame));
  return result.status == IoStatus::kOk ? std::string() : name_ + ": " + result.problem;
}

}  // namespace prehend::drivers
