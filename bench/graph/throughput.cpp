// How many small messages one publisher gets through to a callback in another process. The sender
// keeps a bounded number of messages on their way, so that none needs to be dropped; what is lost
// all the same is counted.

#include <atomic>
#include <cstdio>

#include "bench/graph/node_options.h"
#include "bench/graph/peers.h"
#include "msgs/sensors.pb.h"

namespace prehend::bench {
namespace {

using namespace std::chrono_literals;
using graph::QoS;
using msgs::StereoPair;

constexpr const char* kThroughputTopic = "/bench/small";
constexpr std::uint64_t kBatch = 1024;          // messages between two acknowledgements
constexpr std::uint64_t kWindow = 64 * kBatch;  // at most on their way
const QoS kThroughputQos = QoS::queue(2 * kWindow);

class Flow {
 public:
  explicit Flow(Channel& channel) : channel_(channel) {}
  std::uint64_t acknowledged() const { return acknowledged_; }
  /// False: nothing came for 5 s, so messages were lost; or interrupted.
  bool wait_until(std::uint64_t acknowledged) {
    while (acknowledged_ < acknowledged) {
      const std::size_t batches = channel_.wait_for_acknowledgement(5s);
      if (batches == 0) return false;
      acknowledged_ += batches * kBatch;
    }
    return true;
  }

 private:
  Channel& channel_;
  std::uint64_t acknowledged_ = 0;
};

void publish_batch(const graph::Publisher<StereoPair>& publisher,
                   const std::vector<StereoPair>& messages, bool batched) {
  if (batched) {
    publisher.publish_all(messages);
  } else {
    for (const StereoPair& message : messages) publisher.publish(message);
  }
}

}  // namespace

void run_throughput_sender(const Job& job, bool batched, Channel& channel) {
  graph::Registry registry({.endpoint = "tcp://127.0.0.1:*"});
  graph::Node node(node_options("sender", registry.endpoint()));
  const auto publisher = node.advertise<StereoPair>(kThroughputTopic, kThroughputQos);
  node.spin_in_background();
  channel.write_line(registry.endpoint());
  channel.read_line(20s);
  if (!publisher.wait_for_subscribers(1, 10s)) throw BenchError("the subscriber does not join");

  StereoPair message;
  message.set_data(std::string(job.bytes, static_cast<char>(kPayloadMark)));
  const std::vector<StereoPair> messages(kBatch, message);
  const std::int64_t begin = monotonic_now();
  const std::int64_t end = begin + static_cast<std::int64_t>(job.seconds * 1e9);
  Flow flow(channel);
  std::uint64_t sent = 0;
  while (!interrupted && monotonic_now() < end) {
    publish_batch(publisher, messages, batched);
    sent += kBatch;
    if (sent > kWindow && !flow.wait_until(sent - kWindow)) break;
  }
  flow.wait_until(sent);
  const double seconds = static_cast<double>(monotonic_now() - begin) * 1e-9;
  std::printf("sent %llu\nseconds %.9f\n", static_cast<unsigned long long>(sent), seconds);
}

void run_throughput_receiver(const Job& job, Channel& channel) {
  std::atomic<std::uint64_t> received = 0;
  {
    graph::Node node(node_options("receiver", channel.read_line(20s)));
    const auto subscription = node.subscribe<StereoPair>(
        kThroughputTopic, kThroughputQos, [&](const graph::Received<StereoPair>& message) {
          const auto payload = message.payload();
          if (const char* problem = check_payload(payload.data(), payload.size(), job.bytes)) {
            end_worker(problem);
          }
          if (++received % kBatch == 0) channel.acknowledge();
        });
    node.spin_in_background();
    channel.write_line("ready");
    channel.wait_for_end();
  }
  std::printf("received %llu\n", static_cast<unsigned long long>(received.load()));
}

}  // namespace prehend::bench
