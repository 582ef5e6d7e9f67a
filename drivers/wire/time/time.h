#pragma once

#include <chrono>
#include <cstdint>

namespace prehend::drivers {

/// Time of a driver or an emulator: since any fixed moment, so that tests can make their own.
using Time = std::chrono::nanoseconds;

/// Now, by a clock that never jumps.
inline Time steady_now() { return std::chrono::steady_clock::now().time_since_epoch(); }

inline Time to_time(double seconds) { return Time(static_cast<std::int64_t>(seconds * 1e9)); }
inline double to_seconds(Time time) { return static_cast<double>(time.count()) * 1e-9; }

}  // namespace prehend::drivers
