#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>

#include "prehend/viewing/types.h"

namespace prehend::viewing {

/// What waits to be sent to one viewer, bounded in bytes. When it is full, the oldest messages of
/// channels that stream give way, and are counted; those of latched channels are superseded by
/// as many newer ones of the same sender as the channel keeps; words (parameters, answers) always
/// wait. Not thread-safe.
class Outbox {
 public:
  using Time = std::chrono::steady_clock::time_point;
  enum class Kind { kWord, kLatched, kStream };
  struct Frame {
    Kind kind = Kind::kWord;
    bool is_text = true;
    std::uint32_t subscription = 0;       // of messages
    std::string sender;                   // of latched messages
    std::size_t latched = 1;              // how many of its sender count, of those
    std::array<std::uint8_t, 13> head{};  // sent before the payload
    std::size_t head_size = 0;
    Payload payload;
    Time since{};  // when it began to wait

    std::size_t bytes() const { return head_size + payload->size() + kOverhead; }
    static constexpr std::size_t kOverhead = 128;  // of what is kept about a frame
  };

  /// A message of a stream that waited this long is not sent when a newer one of its channel waits,
  /// so that a slow line shows what is, not what was.
  static constexpr std::chrono::milliseconds kStale{1000};
  /// Words and latched messages may exceed the limit by this factor; then it has overflowed().
  static constexpr std::size_t kMostWords = 8;

  explicit Outbox(std::size_t limit) : limit_(limit) {}

  void push(Frame frame);
  /// The time to tell next; replaces one that waits.
  void set_time(std::uint64_t time) { time_ = time; }
  /// What is to be sent next: the time first.
  std::optional<Frame> pop(Time now);
  /// Forgets what waits of a subscription that ended.
  void forget(std::uint32_t subscription);

  bool empty() const { return frames_.empty() && !time_; }
  std::size_t bytes() const { return bytes_; }
  /// Messages that were thrown away, in all.
  std::uint64_t dropped() const { return dropped_; }
  /// So much waits that must not be dropped that the viewer has to be given up.
  bool overflowed() const { return bytes_ > kMostWords * limit_; }

 private:
  using Frames = std::deque<Frame>;
  Frames::iterator erase(Frames::iterator frame);
  void make_room(const Frame& frame);

  const std::size_t limit_;
  Frames frames_;
  std::map<std::uint32_t, std::size_t> streaming_;  // frames that wait, by subscription
  std::optional<std::uint64_t> time_;
  std::size_t bytes_ = 0;
  std::uint64_t dropped_ = 0;
};

}  // namespace prehend::viewing
