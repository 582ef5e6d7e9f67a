#pragma once

#include <string>

#include "drivers/kuka_rsi/driver/driver.h"
#include "drivers/wire/health/health.h"

namespace prehend::drivers::kuka_rsi {

/// What `prehend doctor` says: the driver's state, and what of it needs a hand. `peer`: who is
/// answered; `trouble`: of the network (LinkQuality).
Health health_of(const Snapshot& now, const std::string& peer, const std::string& trouble,
                 const std::string& missing_real_time, int port);

}  // namespace prehend::drivers::kuka_rsi
