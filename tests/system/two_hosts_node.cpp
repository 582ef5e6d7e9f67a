// A node on one of two hosts: two_hosts_node NAME OTHER REGISTRY KEYS ADDRESS GO. It publishes to
// and takes from the node OTHER, and writes a line of counts to its output again and again; see
// two_hosts_test.cpp. It publishes while the file GO exists.

#include <fmt/core.h>

#include <array>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <string>
#include <thread>

#include "msgs/geometry.pb.h"
#include "msgs/sensors.pb.h"
#include "prehend/graph/node.h"

namespace {

using namespace std::chrono_literals;
using prehend::graph::ActionContext;
using prehend::graph::Node;
using prehend::graph::Publisher;
using prehend::graph::QoS;
using prehend::graph::Received;
using prehend::graph::Subscription;
using prehend::msgs::Clock;
using prehend::msgs::PointCloud;

enum Topic : std::size_t { kSmall, kLarge, kLatched, kTopics };
constexpr std::array<const char*, kTopics> kNames{"/small", "/large", "/latched"};
constexpr std::array<std::size_t, kTopics> kBytes{40, 1 << 20, 1000};
constexpr std::array<int, kTopics> kEvery{1, 10, 25};  // ticks of 10 ms

QoS qos_of(std::size_t topic) { return topic == kLatched ? QoS::latched(5) : QoS::queue(50); }

struct Traffic {
  std::array<Publisher<PointCloud>, kTopics> publishers;
  std::array<Subscription, kTopics> subscriptions;
  std::array<std::atomic<std::uint64_t>, kTopics> published{}, last{}, repeated{}, damaged{};
  std::atomic<std::uint64_t> calls{0}, failed_calls{0}, goals{0}, failed_goals{0};

  void take(std::size_t topic, const Received<PointCloud>& message) {
    const std::uint64_t sequence = message.info().sequence;
    if (sequence <= last[topic]) ++repeated[topic];
    last[topic] = sequence;
    if (message->data().size() != kBytes[topic] || message->count() != sequence) ++damaged[topic];
  }
  void publish(std::size_t topic) {
    PointCloud message;
    message.set_count(static_cast<std::uint32_t>(++published[topic]));
    message.set_data(std::string(kBytes[topic], 'x'));
    publishers[topic].publish(std::move(message));
  }
  void print() const {
    std::string line = "counts";
    for (std::size_t topic = 0; topic < kTopics; ++topic) {
      const auto s = subscriptions[topic].statistics();
      line += fmt::format(" {} {} {} {} {} {} {}", published[topic], s.received, s.missed,
                          s.dropped, s.delivered, repeated[topic], damaged[topic]);
    }
    fmt::print("{} {} {} {} {}\n", line, calls, failed_calls, goals, failed_goals);
    std::fflush(stdout);
  }
};

void run(Node& node, const std::string& other, const std::string& go) {
  Traffic traffic;
  for (std::size_t topic = 0; topic < kTopics; ++topic) {
    traffic.publishers[topic] =
        node.advertise<PointCloud>("/" + node.name() + kNames[topic], qos_of(topic));
    traffic.subscriptions[topic] = node.subscribe<PointCloud>(
        "/" + other + kNames[topic], qos_of(topic),
        [&traffic, topic](const Received<PointCloud>& message) { traffic.take(topic, message); });
  }
  const auto service = node.serve<Clock, Clock>("/" + node.name() + "/service",
                                                [](const Clock& request) { return request; });
  const auto action = node.serve_action<Clock, Clock, Clock>(
      "/" + node.name() + "/action", [](const Clock& goal, ActionContext<Clock>& context) {
        context.feedback(goal);
        context.sleep_for(50ms);
        return goal;
      });
  const auto service_client = node.client<Clock, Clock>("/" + other + "/service");
  const auto action_client = node.action_client<Clock, Clock, Clock>("/" + other + "/action");
  node.spin_in_background();
  for (auto& publisher : traffic.publishers) {
    while (node.ok() && !publisher.wait_for_subscribers(1, 200ms)) {
    }
  }
  fmt::print("joined\n");
  std::fflush(stdout);
  std::thread caller([&] {
    while (node.ok()) {
      ++(service_client.call(Clock(), 1s).ok() ? traffic.calls : traffic.failed_calls);
      const auto goal = action_client.send(Clock());
      ++(goal.wait(2s).ok() ? traffic.goals : traffic.failed_goals);
      node.clock().sleep_for(100ms);
    }
  });
  for (int tick = 0; node.ok(); ++tick) {
    for (std::size_t topic = 0; topic < kTopics && std::filesystem::exists(go); ++topic) {
      if (tick % kEvery[topic] == 0) traffic.publish(topic);
    }
    if (tick % 20 == 0) traffic.print();
    node.clock().sleep_for(10ms);
  }
  caller.join();
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 7) return 2;
  prehend::graph::NodeOptions options;
  options.name = argv[1];
  options.registry = argv[3];
  options.keys_file = argv[4];
  options.bind_address = argv[5];
  options.use_slab = false;  // the two hosts of the test share their memory
  try {
    Node node(options);
    run(node, argv[2], argv[6]);
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}: {}\n", argv[1], error.what());
    return 1;
  }
  return 0;
}
