#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <utility>

#include "drivers/wire/guardian/guardian.h"

namespace prehend::drivers {

/// A device's guardian, as its thread sees it. `note` takes what becomes of the guardian.
class Guarded {
 public:
  using Note = std::function<void(bool is_problem, const std::string& words)>;
  /// @throws std::runtime_error as Guardian.
  Guarded(const GuardianProgram& program, double patience, Note note)
      : guardian_(std::make_unique<Guardian>(program, patience)),
        note_(std::move(note)),
        device_(program.device) {}
  /// A device without a guardian.
  Guarded() = default;

  /// At each round of the device's thread. True when the guardian has used the wire because this
  /// process made no progress: the device has to begin anew.
  bool progress(Watch watch);
  /// "" while there is a guardian, or none is wanted. Any thread.
  std::string problem() const;

 private:
  std::unique_ptr<Guardian> guardian_;
  Note note_;
  std::string device_;
  mutable std::mutex mutex_;  // guards problem_
  std::string problem_;
};

}  // namespace prehend::drivers
