#pragma once

#include <cstdint>
#include <deque>
#include <string>

#include "drivers/wire/time/time.h"

namespace prehend::drivers {

/// How good a line is, from counters: what part of its messages came to harm over the last seconds,
/// and whether as many came as were asked for. Not thread-safe.
class LinkQuality {
 public:
  static constexpr double kWindow = 5;         // s
  static constexpr double kMostHarmed = 0.01;  // part of the messages; a sound line harms none
  static constexpr double kLeastRate = 0.8;    // part of the rate that was asked for

  /// Counters since whenever: good messages, and such that were damaged, lost or not answered.
  /// `rate` [1/s] of good ones that should come; 0: not known. Call it about twice a second.
  void sample(std::uint64_t good, std::uint64_t harmed, double rate, Time now);
  /// Forgets what was, e.g. when the device was away: that is no fault of the line.
  void restart() { samples_.clear(); }

  /// Of all messages of the window, 0..1.
  double harmed_part() const;
  /// 1/s of good messages over the window; 0 before there are two samples.
  double rate() const;
  /// "" while the line is sound or little is known, else what is wrong.
  std::string problem() const;

 private:
  struct Sample {
    Time time{};
    std::uint64_t good = 0, harmed = 0;
  };
  double span() const;

  std::deque<Sample> samples_;
  double wanted_rate_ = 0;
};

}  // namespace prehend::drivers
