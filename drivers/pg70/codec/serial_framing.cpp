#include "drivers/pg70/codec/serial_framing.h"

#include "drivers/wire/encoding/checksum.h"

namespace prehend::drivers::pg70 {
namespace {

constexpr std::size_t kHeader = 3, kChecksum = 2;

std::uint8_t first_byte(Direction direction) {
  switch (direction) {
    case Direction::kCommand:
      return 0x05;
    case Direction::kResponse:
      return 0x07;
    default:
      return 0x03;
  }
}

std::optional<Direction> direction_of(std::uint8_t first) {
  switch (first) {
    case 0x05:
      return Direction::kCommand;
    case 0x07:
      return Direction::kResponse;
    case 0x03:
      return Direction::kError;
    default:
      return std::nullopt;
  }
}

}  // namespace

std::vector<std::uint8_t> encode_serial(const SerialMessage& message) {
  std::vector<std::uint8_t> bytes{first_byte(message.direction), message.module,
                                  static_cast<std::uint8_t>(message.content.size())};
  append_bytes(bytes, message.content.bytes());
  append_little(bytes, crc16_reflected_8005(bytes, 0x0000));
  return bytes;
}

void SerialDecoder::add(Bytes bytes) { append_bytes(buffer_, bytes); }

void SerialDecoder::discard(std::size_t count) {
  buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(count));
  discarded_ += count;
}

void SerialDecoder::give_up() {
  if (!buffer_.empty()) discard(1);
}

std::optional<SerialMessage> SerialDecoder::next() {
  while (true) {
    std::size_t skipped = 0;
    while (skipped < buffer_.size() &&
           !(direction_of(buffer_[skipped]) &&
             (skipped + 1 >= buffer_.size() || buffer_[skipped + 1] != 0) &&
             (skipped + 2 >= buffer_.size() || buffer_[skipped + 2] != 0))) {
      ++skipped;
    }
    discard(skipped);
    if (buffer_.size() < kHeader) return std::nullopt;
    const std::size_t length = buffer_[2];
    const std::size_t end = kHeader + length;
    if (buffer_.size() < end + kChecksum) return std::nullopt;
    const std::uint16_t wanted = crc16_reflected_8005(Bytes(buffer_).first(end), 0x0000);
    if (wanted != load_little<std::uint16_t>(&buffer_[end])) {
      discard(1);
      continue;
    }
    SerialMessage message;
    message.direction = *direction_of(buffer_[0]);
    message.module = buffer_[1];
    message.content.append(Bytes(buffer_).subspan(kHeader, length));
    buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(end + kChecksum));
    return message;
  }
}

}  // namespace prehend::drivers::pg70
