#include "bench/graph/soak.h"

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <cstring>
#include <deque>
#include <random>
#include <thread>

#include "bench/graph/node_options.h"
#include "bench/graph/peer.h"
#include "msgs/sensors.pb.h"

namespace prehend::bench {
namespace {

using namespace std::chrono_literals;
using graph::QoS;
using msgs::StereoPair;

constexpr auto kSlowCallback = 20ms;
const QoS kSoakQos = QoS::queue(100);
const QoS kSlowQos = QoS::queue(5);

void print_figure(const std::string& key, std::uint64_t value) {
  std::printf("%s %llu\n", key.c_str(), static_cast<unsigned long long>(value));
}

void publish(const graph::Publisher<StereoPair>& publisher, const SoakTopic& topic,
             const StereoPair& message) {
  switch (topic.way) {
    case SoakWay::kCopy:
      publisher.publish(message);
      return;
    case SoakWay::kVector:
      publisher.publish(StereoPair(), std::vector<std::uint8_t>(topic.bytes, kPayloadMark));
      return;
    case SoakWay::kLoaned:
      graph::LoanedPayload loan = publisher.loan(topic.bytes);
      std::memset(loan.bytes().data(), kPayloadMark, topic.bytes);
      publisher.publish(StereoPair(), std::move(loan));
      return;
  }
}

/// Which topic each message goes to, by the topics' shares; the same in every run.
class TopicChoice {
 public:
  std::size_t next() { return choice_(random_); }

 private:
  static std::vector<int> shares() {
    std::vector<int> result;
    for (const SoakTopic& topic : kSoakTopics) result.push_back(topic.share);
    return result;
  }
  std::mt19937 random_{1};
  const std::vector<int> shares_ = shares();
  std::discrete_distribution<std::size_t> choice_{shares_.begin(), shares_.end()};
};

/// One subscription of the receiving process, with a count of its own.
class Counter {
 public:
  Counter(graph::Node& node, const SoakTopic& topic, const QoS& qos, bool slow)
      : key_(std::string(slow ? "slow:" : "fast:") + topic.name),
        subscription_(node.subscribe<StereoPair>(
            topic.name, qos,
            [this, slow, bytes = topic.bytes](const graph::Received<StereoPair>& received) {
              const auto payload = received.payload();
              if (const char* problem = check_payload(payload.data(), payload.size(), bytes)) {
                end_worker(problem);
              }
              ++calls_;
              if (slow) std::this_thread::sleep_for(kSlowCallback);
            })) {}

  graph::SubscriptionStatistics statistics() const { return subscription_.statistics(); }
  /// No message waits for its callback.
  bool idle() const {
    const auto s = statistics();
    return s.received == s.delivered + s.dropped + s.superseded;
  }
  void print() const {
    const auto s = statistics();
    print_figure(key_ + ":received", s.received);
    print_figure(key_ + ":delivered", s.delivered);
    print_figure(key_ + ":dropped", s.dropped);
    print_figure(key_ + ":superseded", s.superseded);
    print_figure(key_ + ":missed", s.missed);
    print_figure(key_ + ":malformed", s.malformed);
    print_figure(key_ + ":calls", calls_);
  }

 private:
  std::string key_;
  std::atomic<std::uint64_t> calls_ = 0;
  graph::Subscription subscription_;
};

/// Returns when nothing has come for a second and nothing waits; after 30 s at the latest.
void wait_until_drained(const std::deque<Counter>& counters) {
  std::uint64_t before = 0;
  for (int i = 0; i < 30; ++i) {
    std::this_thread::sleep_for(1s);
    std::uint64_t received = 0;
    for (const Counter& counter : counters) received += counter.statistics().received;
    const bool idle = std::all_of(counters.begin(), counters.end(),
                                  [](const Counter& counter) { return counter.idle(); });
    if (idle && received == before) return;
    before = received;
  }
}

}  // namespace

void run_soak_sender(const Job& job, Channel& channel) {
  graph::Registry registry({.endpoint = "tcp://127.0.0.1:*"});
  graph::Node node(node_options("sender", registry.endpoint()));
  std::vector<graph::Publisher<StereoPair>> publishers;
  std::vector<StereoPair> messages(std::size(kSoakTopics));
  for (std::size_t i = 0; i < std::size(kSoakTopics); ++i) {
    publishers.push_back(node.advertise<StereoPair>(kSoakTopics[i].name, kSoakQos));
    messages[i].set_data(std::string(kSoakTopics[i].bytes, static_cast<char>(kPayloadMark)));
  }
  node.spin_in_background();
  channel.write_line(registry.endpoint());
  channel.read_line(20s);
  for (std::size_t i = 0; i < publishers.size(); ++i) {
    const std::size_t readers = kSoakTopics[i].has_slow_subscriber ? 2 : 1;
    if (!publishers[i].wait_for_subscribers(readers, 10s)) {
      throw BenchError(std::string("the subscribers of ") + kSoakTopics[i].name + " do not join");
    }
  }

  TopicChoice choice;
  const std::int64_t begin = monotonic_now();
  const auto total = static_cast<std::uint64_t>(job.seconds * kSoakRate);
  for (std::uint64_t sent = 0; sent < total && !interrupted;) {
    const double elapsed = static_cast<double>(monotonic_now() - begin) * 1e-9;
    const auto due = std::min(total, static_cast<std::uint64_t>(elapsed * kSoakRate) + 1);
    for (; sent < due; ++sent) {
      const std::size_t topic = choice.next();
      publish(publishers[topic], kSoakTopics[topic], messages[topic]);
    }
    std::this_thread::sleep_for(2ms);
  }
  channel.write_line("done");
  channel.read_line(60s);
  for (std::size_t i = 0; i < publishers.size(); ++i) {
    const auto s = publishers[i].statistics();
    const std::string key = std::string("publisher:") + kSoakTopics[i].name;
    print_figure(key + ":published", s.published);
    print_figure(key + ":dropped", s.dropped);
    print_figure(key + ":superseded", s.superseded);
  }
}

void run_soak_receiver(const Job& job, Channel& channel) {
  const std::string registry = channel.read_line(20s);
  graph::Node fast(node_options("fast", registry));
  graph::Node slow(node_options("slow", registry));
  std::deque<Counter> counters;
  for (const SoakTopic& topic : kSoakTopics) {
    counters.emplace_back(fast, topic, kSoakQos, false);
    if (!topic.has_slow_subscriber) continue;
    counters.emplace_back(slow, topic, kSlowQos, true);
  }
  fast.spin_in_background();
  slow.spin_in_background();
  channel.write_line("ready");
  channel.read_line(std::chrono::seconds(static_cast<int>(job.seconds * 1.5) + 60));
  wait_until_drained(counters);
  for (const Counter& counter : counters) counter.print();
  channel.write_line("drained");
  channel.wait_for_end();
}

}  // namespace prehend::bench
