#pragma once

#include <time.h>

#include <csignal>
#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

namespace prehend::bench {

/// What one pair of worker processes measures.
struct Job {
  std::string peer;       ///< which transport: the part of a row's name before '/'
  std::size_t bytes = 0;  ///< payload of each message
  double seconds = 0.0;   ///< how long messages are sent
  int message_limit = 0;  ///< ends earlier after so many; 0: none
};

/// What a worker could not do; main prints it as one line.
struct BenchError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// CLOCK_MONOTONIC [ns]: the same clock in all processes of a host.
inline std::int64_t monotonic_now() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

/// Set by SIGINT and SIGTERM once `catch_interrupts` was called; every loop looks at it.
inline volatile std::sig_atomic_t interrupted = 0;

inline void catch_interrupts() {
  struct sigaction action = {};
  action.sa_handler = [](int) { interrupted = 1; };  // no SA_RESTART: poll and sleep end at once
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

inline constexpr std::uint8_t kPayloadMark = 0x5a;  ///< every byte of every payload

/// Reads a payload's first and last byte. What is wrong with it, or nullptr.
inline const char* check_payload(const std::uint8_t* data, std::size_t size, std::size_t expected) {
  if (size != expected) return "a message came with a payload of another size";
  const volatile std::uint8_t* bytes = data;
  if (size > 0 && (bytes[0] != kPayloadMark || bytes[size - 1] != kPayloadMark)) {
    return "a message came with a damaged payload";
  }
  return nullptr;
}

}  // namespace prehend::bench
