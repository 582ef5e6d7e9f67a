#pragma once

#include <string>

#include "drivers/kuka_rsi/driver/driver.h"
#include "drivers/wire/health/health.h"

namespace prehend::drivers::kuka_rsi {

/// What `prehend doctor` says: the driver's state, and what of it needs a hand. `peer`: who is
/// answered; `trouble`: of the network (LinkQuality).
Health health_of(const Snapshot& now, const std::string& peer, const std::string& trouble,
                 const std::string& missing_real_time, int port);

/// What the controller did by itself, so that everything else is to stop.
class OwnStops {
 public:
  /// In words, of a controller that had begun RSI; "": nothing, or nothing new. That RSI has ended,
  /// be it by the emergency stop of its panel, is told for as long as it has; that it ended and
  /// began again, and that the arm left its path, as one does whose drives are off, once.
  std::string look(const Snapshot& now, const std::string& peer);

 private:
  std::uint64_t sessions_ = 0, ticket_ = 0;
};

}  // namespace prehend::drivers::kuka_rsi
