#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <string>

#include "drivers/wire/time/time.h"

namespace prehend::drivers {

/// How a guardian stops a device (Guarding::stop_device): `say(tries)` says it, false when the wire
/// is gone; then for `reply_time` `hear(wait)` returns what was answered, "" when that is nothing
/// yet, nothing when the wire is gone. Again until `end`, or until `is_back`.
template <class Say, class Hear>
std::string insist(Time end, const std::function<bool()>& is_back,
                   std::chrono::nanoseconds reply_time, const Say& say, const Hear& hear) {
  for (int tries = 1; steady_now() < end; ++tries) {
    if (is_back() || !say(tries)) return {};
    const Time again = steady_now() + reply_time;
    for (Time now = steady_now(); now < again; now = steady_now()) {
      const std::optional<std::string> answer = hear(again - now);
      if (!answer) return {};
      if (!answer->empty()) return *answer;
    }
  }
  return {};
}

}  // namespace prehend::drivers
