#pragma once

#include <chrono>
#include <memory>
#include <string>
#include <utility>

#include "prehend/sweep/workers/case_process.h"
#include "prehend/sweep/workers/mpi_messages.h"

namespace prehend::sweep {

/// A rank that runs what rank 0 hands out, one case at a time.
class MpiServant {
 public:
  /// `post` lives as long. A case's process does `body`. Signals have to be held, hold_signals().
  MpiServant(MpiPost& post, CaseBody body)
      : post_(post), body_(std::move(body)), where_(this_worker()) {}

  /// Until rank 0 tells it to end, which it does also after a signal that this rank got and after
  /// an error here, both of which it is told. The exit code: 1 after an error. @throws
  /// std::runtime_error when nothing is heard of rank 0 any more.
  int serve();

 private:
  using Clock = std::chrono::steady_clock;

  void listen();
  void look_after_case();
  void say_alive();
  void leave();

  MpiPost& post_;
  const CaseBody body_;
  const std::string where_;
  std::unique_ptr<CaseProcess> running_;
  Clock::time_point heard_ = Clock::now(), said_{};
  bool is_leaving_ = false;  // and has told so
  bool is_to_end_ = false;
};

}  // namespace prehend::sweep
