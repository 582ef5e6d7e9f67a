#pragma once

#include <memory>
#include <optional>
#include <string>

#include "prehend/launch/launch_events.h"
#include "prehend/launch/launch_output.h"
#include "prehend/launch/supervisor.h"

namespace prehend::launch {

/// The registry of a launch: a process of its own, started again when it dies, or that of another
/// host.
class LaunchRegistry {
 public:
  LaunchRegistry(const SupervisorOptions& options, const SignalSource& signals,
                 LaunchOutput& output)
      : options_(options), signals_(signals), output_(output) {}

  /// Returns once a registry listens (or, on another host, answers). A signal that asks to stop is
  /// returned at once; 0 is success. Throws std::runtime_error when there is none in the end.
  int start();
  const std::string& endpoint() const { return endpoint_; }

  /// To be polled; empty when the registry is another host's.
  SupervisedProcess* process() { return process_.get(); }
  /// Notices its death and starts it again when that is due; returns a signal as start does.
  int keep_alive();
  /// Ends it within 3 s; false when it does not: it is killed when this object goes.
  bool stop();

 private:
  int listen(const std::string& endpoint);
  int join(const std::string& endpoint);

  const SupervisorOptions& options_;
  const SignalSource& signals_;
  LaunchOutput& output_;
  std::unique_ptr<SupervisedProcess> process_;
  std::string endpoint_;  // "" until it listens
};

}  // namespace prehend::launch
