#include "bench/graph/latency.h"

#include <malloc.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <mutex>
#include <thread>

namespace prehend::bench {
namespace {

using namespace std::chrono_literals;

constexpr std::size_t kWarmUpMessages = 20;

/// The times of one run, from the receiver's thread.
class Latencies {
 public:
  OnMessage recorder(Channel& channel) {
    return [this, &channel](std::int64_t stamp) {
      const std::int64_t latency = monotonic_now() - stamp;
      {
        const std::lock_guard lock(mutex_);
        nanoseconds_.push_back(latency);
      }
      channel.acknowledge();
    };
  }
  std::vector<std::int64_t> take() {
    const std::lock_guard lock(mutex_);
    return std::move(nanoseconds_);
  }

 private:
  std::mutex mutex_;
  std::vector<std::int64_t> nanoseconds_;
};

void send_paced(const Job& job, Sender& sender, Channel& channel) {
  const std::int64_t end = monotonic_now() + static_cast<std::int64_t>(job.seconds * 1e9);
  for (int count = 0; !interrupted; ++count) {
    const bool limit_reached = job.message_limit > 0 && count >= job.message_limit;
    if (limit_reached || monotonic_now() > end) return;
    sender.send();
    if (channel.wait_for_acknowledgement(10s) == 0 && !interrupted) {
      throw BenchError("a message was lost: nothing came within 10 s");
    }
  }
}

}  // namespace

void keep_heap_warm() {
  mallopt(M_MMAP_THRESHOLD, 32 << 20);
  mallopt(M_TRIM_THRESHOLD, 256 << 20);
}

void end_worker(const std::string& problem) {
  std::fprintf(stderr, "bench_graph: %s\n", problem.c_str());
  std::_Exit(1);
}

void print_latencies(const std::vector<std::int64_t>& nanoseconds) {
  std::printf("latency_ns");
  const std::size_t warm_up = std::min(kWarmUpMessages, nanoseconds.size() / 4);
  for (std::size_t i = warm_up; i < nanoseconds.size(); ++i) {
    std::printf(" %lld", static_cast<long long>(nanoseconds[i]));
  }
  std::printf("\n");
}

void run_latency_sender(const Job& job, const MakeSender& make, Channel& channel) {
  const auto sender = make(job);
  channel.write_line(sender->address());
  channel.read_line(20s);
  sender->wait_until_connected();
  send_paced(job, *sender, channel);
}

void run_latency_receiver(const Job& job, const MakeReceiver& make, Channel& channel) {
  Latencies latencies;
  const std::string address = channel.read_line(20s);
  {
    const auto receiver = make(job, address, latencies.recorder(channel));
    channel.write_line("ready");
    channel.wait_for_end();
  }
  print_latencies(latencies.take());
}

void run_latency_same_process(const Job& job, const MakeSender& make_sender,
                              const MakeReceiver& make_receiver) {
  const ChannelEnds ends = make_channel();
  Channel sender_end(ends.sender);
  Channel receiver_end(ends.receiver);
  Latencies latencies;
  {
    const auto sender = make_sender(job);
    const auto receiver = make_receiver(job, sender->address(), latencies.recorder(receiver_end));
    sender->wait_until_connected();
    send_paced(job, *sender, sender_end);
  }
  print_latencies(latencies.take());
}

}  // namespace prehend::bench
