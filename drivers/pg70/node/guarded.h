#pragma once

#include <memory>
#include <mutex>
#include <string>

#include "drivers/pg70/driver/driver.h"
#include "drivers/pg70/node/guardian.h"

namespace prehend::drivers::pg70 {

/// What a gripper with this reading may do when nobody looks after it.
Watch watch_of(const Reading& reading);

/// A device's guardian, as its thread sees it. `note` takes what becomes of the guardian.
class Guarded {
 public:
  /// @throws std::runtime_error as Guardian.
  Guarded(const LinkAddress& address, double patience, Driver::Note note)
      : guardian_(std::make_unique<Guardian>(address, patience)), note_(std::move(note)) {}
  /// A gripper without a guardian.
  Guarded() = default;

  /// Device::OnRound. True when the guardian has used the wire because this process made no
  /// progress: the device has to begin anew.
  bool progress(const Reading& reading);
  /// "" while there is a guardian, or none is wanted. Any thread.
  std::string problem() const;

 private:
  std::unique_ptr<Guardian> guardian_;
  Driver::Note note_;
  mutable std::mutex mutex_;  // guards problem_
  std::string problem_;
};

}  // namespace prehend::drivers::pg70
