#pragma once

/// What driver and guardian say to each other, a byte each; besides the values of Watch.
namespace prehend::drivers::guardian_words {

inline constexpr char kAllIsWell = 'w';  // driver: it ends, and has stopped the device itself
inline constexpr char kHeard = 'a';      // guardian: to what came
inline constexpr char kStopped = 'x';    // guardian: the driver made no progress; it uses the wire

}  // namespace prehend::drivers::guardian_words
