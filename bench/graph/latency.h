#pragma once

#include "bench/graph/channel.h"
#include "bench/graph/peer.h"

namespace prehend::bench {

/// Sends one message after the other, each when the one before was acknowledged and the receiver
/// has had time to go to sleep again: queues stay empty.
void run_latency_sender(const Job& job, const MakeSender& make, Channel& channel);

/// Measures from the time in each message until its payload is in hand; writes all to stdout as
/// `latency_ns N N N ...`. The first messages are warm-up and not counted.
void run_latency_receiver(const Job& job, const MakeReceiver& make, Channel& channel);

/// Both in this process.
void run_latency_same_process(const Job& job, const MakeSender& make_sender,
                              const MakeReceiver& make_receiver);

/// `latency_ns ...` for the coordinator, without the warm-up.
void print_latencies(const std::vector<std::int64_t>& nanoseconds);

}  // namespace prehend::bench
