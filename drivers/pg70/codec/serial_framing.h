#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "drivers/pg70/codec/message.h"

namespace prehend::drivers::pg70 {

/// A message as it travels on RS-232.
struct SerialMessage {
  Direction direction = Direction::kCommand;
  std::uint8_t module = 1;  // 1..255
  Content content;
  friend bool operator==(const SerialMessage&, const SerialMessage&) = default;
};

/// [0x05 master | 0x07 module | 0x03 error][module][D-Len][content][CRC low][CRC high]; the CRC is
/// CRC-16/ARC over all before it (manual V1.41, page 304). Messages are never fragmented.
std::vector<std::uint8_t> encode_serial(const SerialMessage& message);

/// Finds messages in a stream of bytes that may begin anywhere and may hold garbage. After a wrong
/// checksum it looks for the next message from the byte behind the false beginning on.
class SerialDecoder {
 public:
  /// Takes bytes in. At most one message's bytes are kept beyond what next() has taken.
  void add(Bytes bytes);
  /// The next whole message, or nothing until more bytes come.
  std::optional<SerialMessage> next();
  /// Bytes that belonged to no message.
  std::uint64_t discarded() const { return discarded_; }
  /// A message has begun but its end is missing.
  bool is_partial() const { return !buffer_.empty(); }
  /// Gives up the message begun, e.g. after a silence: looks for another behind its first byte.
  void give_up();

 private:
  void discard(std::size_t count);

  std::vector<std::uint8_t> buffer_;
  std::uint64_t discarded_ = 0;
};

}  // namespace prehend::drivers::pg70
