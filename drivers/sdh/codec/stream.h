#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "drivers/sdh/codec/binary.h"
#include "drivers/sdh/codec/line.h"

namespace prehend::drivers::sdh {

/// Cuts the hand's stream into replies; lines and binary messages may follow one another in any
/// order, split at any byte. Lines that begin with @ are debug text and are skipped.
class ReplyDecoder {
 public:
  using Reply = std::variant<LineReply, BinaryReply>;
  /// `has_checksum`: of binary messages, on RS-232.
  explicit ReplyDecoder(bool has_checksum) : has_checksum_(has_checksum) {}

  void add(Bytes bytes);
  std::optional<Reply> next();
  /// Forgets what has begun.
  void clear() { buffer_.clear(); }
  /// Bytes that belonged to no reply.
  std::uint64_t discarded() const { return discarded_; }
  /// Lines and messages that came to harm.
  std::uint64_t damaged() const { return damaged_; }

 private:
  void drop(std::size_t count);
  std::optional<Reply> take_binary(bool& waits);
  std::optional<Reply> take_line(bool& waits);

  bool has_checksum_;
  std::vector<std::uint8_t> buffer_;  // what is not decoded yet
  std::uint64_t discarded_ = 0, damaged_ = 0;
};

/// The same of what the computer says.
class RequestDecoder {
 public:
  /// What a line that is no command, or is too long, is answered with.
  using Request = std::variant<LineRequest, BinaryRequest, ReturnCode>;
  explicit RequestDecoder(bool has_checksum) : has_checksum_(has_checksum) {}

  void add(Bytes bytes);
  std::optional<Request> next();
  void clear() { buffer_.clear(); }

 private:
  bool has_checksum_;
  bool is_too_long_ = false;  // the line that is being read
  std::vector<std::uint8_t> buffer_;
};

}  // namespace prehend::drivers::sdh
