#pragma once

#include <string>

#include "bench/graph/channel.h"
#include "bench/graph/job.h"

namespace prehend::bench {

inline constexpr double kDefaultSoakSeconds = 600.0;
inline constexpr double kSoakRate = 1e6 / kDefaultSoakSeconds;  ///< messages/s

/// Runs mixed traffic between two processes, 100 B to 4 MB, with one subscriber that is too slow,
/// and watches both processes' resident memory. Prints, and writes to `json` unless empty, whether
/// the memory stays flat and what became of every message. 0: flat, and every message accounted
/// for; 1 otherwise.
int run_soak(const std::string& program, double seconds, const std::string& json);

/// The two sides.
void run_soak_sender(const Job& job, Channel& channel);
void run_soak_receiver(const Job& job, Channel& channel);

/// How a soak topic's messages are published.
enum class SoakWay { kCopy, kVector, kLoaned };

struct SoakTopic {
  const char* name;
  std::size_t bytes;
  int share;  ///< of all messages, in thousandths
  SoakWay way;
  bool has_slow_subscriber;
};

inline constexpr SoakTopic kSoakTopics[] = {
    {"/soak/state", 100, 700, SoakWay::kCopy, false},
    {"/soak/scan", 4096, 200, SoakWay::kCopy, true},
    {"/soak/image", 65536, 60, SoakWay::kVector, true},
    {"/soak/depth", 655360, 30, SoakWay::kCopy, true},
    {"/soak/cloud", 4194304, 5, SoakWay::kCopy, false},
    {"/soak/mesh", 4194304, 5, SoakWay::kLoaned, false},
};

}  // namespace prehend::bench
