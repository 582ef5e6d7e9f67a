#include "drivers/sdh/codec/stream.h"

#include <algorithm>
#include <string_view>

namespace prehend::drivers::sdh {
namespace {

constexpr std::uint8_t kLineFeed = '\n', kReturn = '\r', kBlank = ' ';

bool is_binary(std::uint8_t byte) { return byte >= kFirstBinary; }

std::string_view text_of(const std::vector<std::uint8_t>& buffer, std::size_t size) {
  std::string_view text(reinterpret_cast<const char*>(buffer.data()), size);
  while (!text.empty() && text.back() == '\r') text.remove_suffix(1);
  return text;
}

void erase_front(std::vector<std::uint8_t>& buffer, std::size_t count) {
  buffer.erase(buffer.begin(), buffer.begin() + static_cast<std::ptrdiff_t>(count));
}

}  // namespace

void ReplyDecoder::add(Bytes bytes) { append_bytes(buffer_, bytes); }

void ReplyDecoder::drop(std::size_t count) {
  erase_front(buffer_, count);
  discarded_ += count;
}

std::optional<ReplyDecoder::Reply> ReplyDecoder::next() {
  for (bool waits = false; !waits;) {
    std::size_t blanks = 0;
    while (blanks < buffer_.size() &&
           (buffer_[blanks] == kLineFeed || buffer_[blanks] == kReturn)) {
      ++blanks;
    }
    erase_front(buffer_, blanks);
    if (buffer_.empty()) return std::nullopt;
    auto reply = is_binary(buffer_[0]) ? take_binary(waits) : take_line(waits);
    if (reply) return reply;
  }
  return std::nullopt;
}

std::optional<ReplyDecoder::Reply> ReplyDecoder::take_binary(bool& waits) {
  if (buffer_.size() < 2) {
    waits = true;
    return std::nullopt;
  }
  const std::size_t size = reply_size(buffer_[0], buffer_[1], has_checksum_);
  if (size == 0) {
    ++damaged_;
    drop(1);
    return std::nullopt;
  }
  if (buffer_.size() < size) {
    waits = true;
    return std::nullopt;
  }
  const auto reply = decode_binary_reply(Bytes(buffer_).first(size), has_checksum_);
  if (!reply) {  // the next one may begin within
    ++damaged_;
    drop(1);
    return std::nullopt;
  }
  erase_front(buffer_, size);
  return *reply;
}

std::optional<ReplyDecoder::Reply> ReplyDecoder::take_line(bool& waits) {
  const auto end = std::ranges::find_if(
      buffer_, [](std::uint8_t byte) { return byte == kLineFeed || is_binary(byte); });
  const auto size = static_cast<std::size_t>(end - buffer_.begin());
  if (end == buffer_.end()) {
    waits = size <= kLongestLine;
    if (!waits) {
      ++damaged_;
      drop(size);
    }
    return std::nullopt;
  }
  if (*end != kLineFeed) {  // a binary message runs into it, or a bit is wrong
    ++damaged_;
    drop(size);
    return std::nullopt;
  }
  const std::string_view line = text_of(buffer_, size);
  const bool is_debug = line.starts_with('@');
  const auto reply = is_debug ? std::nullopt : decode_line_reply(line);
  if (reply) {
    erase_front(buffer_, size + 1);
    return *reply;
  }
  if (!is_debug) ++damaged_;
  drop(size + 1);
  return std::nullopt;
}

void RequestDecoder::add(Bytes bytes) { append_bytes(buffer_, bytes); }

std::optional<RequestDecoder::Request> RequestDecoder::next() {
  while (!buffer_.empty()) {
    const std::uint8_t first = buffer_[0];
    if (!is_too_long_ && is_binary(first)) {
      if (buffer_.size() < 2) return std::nullopt;
      const std::size_t size = request_size(first, buffer_[1], has_checksum_);
      if (size == 0) {
        erase_front(buffer_, 1);
        continue;
      }
      if (buffer_.size() < size) return std::nullopt;
      const auto request = decode_binary_request(Bytes(buffer_).first(size), has_checksum_);
      if (request) {
        erase_front(buffer_, size);
        return *request;
      }
      erase_front(buffer_, 1);
      return ReturnCode::kChecksum;
    }
    const auto end = std::ranges::find_if(buffer_, [this](std::uint8_t byte) {
      return byte == kLineFeed || byte == kReturn || (is_binary(byte) && !is_too_long_);
    });
    const auto size = static_cast<std::size_t>(end - buffer_.begin());
    if (end == buffer_.end()) {
      if (size <= kLongestLine) return std::nullopt;
      buffer_.clear();
      is_too_long_ = true;
      return std::nullopt;
    }
    if (is_binary(*end)) {  // the line has no end
      erase_front(buffer_, size);
      return ReturnCode::kCommandFormat;
    }
    const std::string line(text_of(buffer_, size));
    erase_front(buffer_, size + 1);
    if (is_too_long_) {
      is_too_long_ = false;
      return ReturnCode::kLineTooLong;
    }
    if (std::ranges::all_of(line, [](char c) { return c == kBlank; })) continue;
    if (const auto request = decode_line_request(line)) return *request;
    return ReturnCode::kCommandFormat;
  }
  return std::nullopt;
}

}  // namespace prehend::drivers::sdh
