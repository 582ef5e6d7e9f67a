#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "bench/graph/job.h"

namespace prehend::bench {

/// The publishing side of a transport.
class Sender {
 public:
  virtual ~Sender() = default;
  /// What the receiver needs to find it: one line.
  virtual std::string address() const = 0;
  /// Returns when what is sent reaches the receiver. Throws BenchError after 10 s.
  virtual void wait_until_connected() = 0;
  /// Sends one message of the job's size with the time of the call in it, as monotonic_now().
  virtual void send() = 0;
};

/// The subscribing side; lives as long as messages shall come.
class Receiver {
 public:
  virtual ~Receiver() = default;
};

/// Called with the time in the message once its payload is readable.
using OnMessage = std::function<void(std::int64_t stamp)>;

using MakeSender = std::function<std::unique_ptr<Sender>(const Job&)>;
using MakeReceiver =
    std::function<std::unique_ptr<Receiver>(const Job&, const std::string& address, OnMessage)>;

/// Raises the thresholds above which glibc maps memory afresh for each allocation and gives it back
/// on each free.
void keep_heap_warm();

/// Ends the worker from any thread, with one line: for what a callback finds wrong.
[[noreturn]] void end_worker(const std::string& problem);

}  // namespace prehend::bench
