#pragma once

#include <functional>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>

#include "drivers/wire/time/time.h"

namespace prehend::drivers {

/// Opens a line again and again until it is there, with a pause between the tries, and notes what
/// is wrong when that changes. Before it was ever open it holds such words back for a while: what
/// is at the other end may be starting, too. For one thread.
class Reopening {
 public:
  using Note = std::function<void(bool is_problem, const std::string& words)>;
  static constexpr double kGrace = 2;  // s
  Reopening(double pause_seconds, Note note, double grace_seconds = kGrace)
      : pause_(to_time(pause_seconds)), grace_(to_time(grace_seconds)), note_(std::move(note)) {}

  /// What `open` returns (a pointer to something with a name()), or null: then `open` threw a
  /// std::runtime_error, or it is too early, for which this waits `tick`.
  template <class Open>
  auto attempt(const Open& open, Time tick) -> decltype(open()) {
    const Time now = steady_now();
    if (last_try_ != Time::min() && now - last_try_ < pause_) {
      std::this_thread::sleep_for(tick);
      return nullptr;
    }
    last_try_ = now;
    try {
      auto line = open();
      problem_.clear();
      was_open_ = true;
      note_(false, "connected by " + line->name());
      return line;
    } catch (const std::runtime_error& error) {
      tell(error.what());
      return nullptr;
    }
  }

  /// Notes what is wrong with the line, unless that is known or the grace lasts.
  void tell(const std::string& words) {
    if (first_problem_ == Time::min()) first_problem_ = steady_now();
    if (!was_open_ && steady_now() - first_problem_ < grace_) return;
    if (problem_ != words) note_(true, words);
    problem_ = words;
  }
  /// What is wrong, as far as it was noted; "" while there is a line.
  const std::string& problem() const { return problem_; }

 private:
  Time pause_, grace_;
  Note note_;
  Time last_try_ = Time::min(), first_problem_ = Time::min();
  bool was_open_ = false;
  std::string problem_;
};

}  // namespace prehend::drivers
