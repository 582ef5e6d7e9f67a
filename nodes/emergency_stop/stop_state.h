#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <string>

#include "msgs/safety.pb.h"

namespace prehend::nodes {

/// Whether all motion is stopped, by whom, and what of the causes goes on. Not thread-safe.
class StopState {
 public:
  using Time = std::chrono::steady_clock::time_point;
  /// After the last time that a cause that persists was told.
  static constexpr std::chrono::milliseconds kPersistence{500};
  static constexpr std::size_t kLongestText = 400;  // bytes; what is beyond is left away

  /// Who asks first is named until reset(). True: there is something new to tell, a stop that was
  /// not, or one that was asked for again; what persists is new once. `stamp` [ns] is of the
  /// message.
  bool stop(const msgs::EmergencyStopRequest& request, Time now, std::int64_t stamp);
  /// Ends the stop. Returns "", or what persists, and the stop stays.
  std::string reset(Time now);

  const msgs::EmergencyStop& message() const { return message_; }

 private:
  struct Cause {
    std::string reason;
    Time told;
  };
  void forget_old(Time now);

  msgs::EmergencyStop message_;
  std::map<std::string, Cause> persisting_;  // by source
};

}  // namespace prehend::nodes
