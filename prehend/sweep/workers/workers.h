#pragma once

#include <memory>
#include <vector>

#include "prehend/sweep/workers/case_process.h"

namespace prehend::sweep {

/// Those who run cases, each one at a time.
class Workers {
 public:
  Workers() = default;
  Workers(const Workers&) = delete;
  Workers& operator=(const Workers&) = delete;
  virtual ~Workers() = default;

  /// How many there are and, of these, lost ones not counted, have nothing to do.
  virtual int count() const = 0;
  virtual int free() const = 0;
  /// @pre free() > 0
  virtual void start(CaseOrder order) = 0;
  /// Waits until a case ends, something is lost, or for a second; sets `is_to_end` when the user
  /// wants an end.
  virtual std::vector<CaseEnd> wait(bool& is_to_end) = 0;
  /// Ends all that runs, without results.
  virtual void stop() = 0;
};

/// So many child processes of this one, each of which does `body`.
std::unique_ptr<Workers> workers_here(int count, CaseBody body);

}  // namespace prehend::sweep
