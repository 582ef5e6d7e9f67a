#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <stdexcept>
#include <utility>

#include "drivers/wire/time/time.h"

namespace prehend::drivers::camera {

/// Pairs what two free-running cameras (or sensors) send, by time. The rule: of the oldest frames
/// that wait on either side, those within `tolerance` are a pair; else the older one has no partner
/// any more, since all later ones of the other side are later still, and is dropped and counted.
/// With half a frame as tolerance each frame has at most one partner. Which pairs come depends on
/// the stamps alone, not on the order in which the sides arrive, as long as no side is more than
/// kMost frames behind: then the oldest is dropped, too. For one thread.
template <class Item>
class FramePairing {
 public:
  static constexpr std::size_t kMost =
      8;  // frames that wait on a side; a dead side fills no memory
  struct Stamped {
    Time stamp{};
    Item item{};
  };
  using Pair = std::pair<Stamped, Stamped>;  // sides 0 and 1

  /// @throws std::invalid_argument unless it is positive.
  explicit FramePairing(Time tolerance) : tolerance_(tolerance) {
    if (tolerance <= Time::zero()) {
      throw std::invalid_argument("FramePairing: the tolerance must be positive");
    }
  }

  /// Half the time between frames at `rate` [1/s].
  static Time half_a_frame(double rate) { return to_time(0.5 / rate); }

  /// A frame of side 0 or 1, and the pair that it completes, if any. Frames that are not later than
  /// the one before of their side are dropped and counted.
  std::optional<Pair> add(std::size_t side, Time stamp, Item item) {
    std::deque<Stamped>& own = waiting_.at(side);
    if (last_[side] && stamp <= *last_[side]) {
      ++dropped_[side];
      return std::nullopt;
    }
    last_[side] = stamp;
    own.push_back({stamp, std::move(item)});
    if (own.size() > kMost) drop(side);
    return take();
  }

  /// Forgets what waits of both sides, and the last stamps, as after a side was away. What waited
  /// counts as dropped.
  void restart() {
    for (std::size_t side = 0; side < 2; ++side) {
      while (!waiting_[side].empty()) drop(side);
      last_[side].reset();
    }
  }

  /// Frames of a side that came without a partner.
  std::uint64_t dropped(std::size_t side) const { return dropped_.at(side); }
  /// How far apart the last two were that were compared; nothing before.
  std::optional<Time> last_difference() const { return difference_; }

 private:
  void drop(std::size_t side) {
    waiting_[side].pop_front();
    ++dropped_[side];
  }
  std::optional<Pair> take() {
    while (!waiting_[0].empty() && !waiting_[1].empty()) {
      const Time difference = waiting_[1].front().stamp - waiting_[0].front().stamp;
      difference_ = difference;
      if (difference > tolerance_) {
        drop(0);
      } else if (-difference > tolerance_) {
        drop(1);
      } else {
        Pair pair(std::move(waiting_[0].front()), std::move(waiting_[1].front()));
        waiting_[0].pop_front();
        waiting_[1].pop_front();
        return pair;
      }
    }
    return std::nullopt;
  }

  Time tolerance_;
  std::array<std::deque<Stamped>, 2> waiting_;
  std::array<std::optional<Time>, 2> last_;
  std::array<std::uint64_t, 2> dropped_{};
  std::optional<Time> difference_;
};

}  // namespace prehend::drivers::camera
