#pragma once

#include <functional>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>

#include "drivers/wire/time/time.h"

namespace prehend::drivers {

/// Opens a line again and again until it is there, with a pause between the tries, and notes what
/// is wrong when that changes. For one thread.
class Reopening {
 public:
  using Note = std::function<void(bool is_problem, const std::string& words)>;
  Reopening(double pause_seconds, Note note)
      : pause_(to_time(pause_seconds)), note_(std::move(note)) {}

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
      last_problem_.clear();
      note_(false, "connected by " + line->name());
      return line;
    } catch (const std::runtime_error& error) {
      if (last_problem_ != error.what()) note_(true, error.what());
      last_problem_ = error.what();
      return nullptr;
    }
  }

 private:
  Time pause_;
  Note note_;
  Time last_try_ = Time::min();
  std::string last_problem_;
};

}  // namespace prehend::drivers
