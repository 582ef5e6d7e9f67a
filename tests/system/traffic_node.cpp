// A process of the tests of faults: `traffic_node publish|subscribe [options of run_node]`. What it
// sees it writes to the file given by the parameter `state`; see traffic_state.h.

#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <string>

#include "msgs/geometry.pb.h"
#include "prehend/graph/node.h"
#include "tests/system/traffic_state.h"

namespace {

using namespace prehend::testing;
using prehend::graph::Node;
using prehend::graph::QoS;
using prehend::msgs::PointCloud;

std::int64_t steady_now() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

std::string state_file(Node& node) {
  return node.declare_parameter<std::string>({.name = "state", .description = "file to write to"});
}

QoS qos_of(Topic topic) {
  switch (topic) {
    case kSmall:
      return QoS::queue(50);
    case kLarge:
      return QoS::queue(5);
    default:
      return QoS::latched(4);  // of several publishers
  }
}

// One publisher on each topic. A message says which publisher, process and message it is; every
// byte of its payload is the message's number, so that a mixture of two would be seen.
class Talker {
 public:
  Talker(Node& node, const std::string& state, int index)
      : state_(state), index_(static_cast<std::uint32_t>(index)) {
    state_.clear();
    for (std::size_t topic = 0; topic < kTopicCount; ++topic) {
      publishers_[topic] =
          node.advertise<PointCloud>(kTopicNames[topic], qos_of(static_cast<Topic>(topic)));
    }
  }

  void publish(Topic topic) {
    PointCloud message;
    message.set_count(index_);
    message.set_width(static_cast<std::uint32_t>(::getpid()));
    message.set_height(++counters_[topic]);
    const auto content = static_cast<std::uint8_t>(counters_[topic]);
    const std::int64_t start = steady_now();
    if (topic == kLarge && counters_[topic] % 2 == 0) {
      auto loan = publishers_[topic].loan(kPayloadBytes[topic]);
      std::fill(loan.bytes().begin(), loan.bytes().end(), content);
      publishers_[topic].publish(std::move(message), std::move(loan));
    } else {
      message.set_data(std::string(kPayloadBytes[topic], static_cast<char>(content)));
      publishers_[topic].publish(std::move(message));
    }
    const auto duration = static_cast<std::uint64_t>(steady_now() - start);
    state_->slowest_publish = std::max(state_->slowest_publish.load(), duration);
    const std::uint64_t slab_bytes = publishers_[topic].statistics().slab_bytes;
    state_->most_slab_bytes = std::max(state_->most_slab_bytes.load(), slab_bytes);
  }

 private:
  TrafficFile state_;
  const std::uint32_t index_;
  std::array<prehend::graph::Publisher<PointCloud>, kTopicCount> publishers_;
  std::array<std::uint32_t, kTopicCount> counters_{};
};

void publish(Node& node) {
  const std::string state = state_file(node);
  const auto index = node.declare_parameter<int>({.name = "index", .default_value = 0});
  Talker talker(node, state, index);
  talker.publish(kLatched);
  const auto small = node.create_timer(0.02, [&] { talker.publish(kSmall); });
  const auto large = node.create_timer(0.2, [&] { talker.publish(kLarge); });
  node.spin();
}

class Listener {
 public:
  Listener(Node& node, const std::string& state) : state_(state) {
    state_.clear();
    for (std::size_t i = 0; i < kTopicCount; ++i) {
      const auto topic = static_cast<Topic>(i);
      subscriptions_[i] = node.subscribe<PointCloud>(
          kTopicNames[i], qos_of(topic),
          [this, topic](const prehend::graph::Received<PointCloud>& message) {
            take(topic, message);
          });
    }
  }

  void count_losses() {
    for (std::size_t topic = 0; topic < kTopicCount; ++topic) {
      const auto statistics = subscriptions_[topic].statistics();
      state_->losses[topic].missed = statistics.missed;
      state_->losses[topic].counted =
          statistics.missed + statistics.dropped + statistics.superseded;
    }
  }

 private:
  void take(Topic topic, const prehend::graph::Received<PointCloud>& message) {
    if (message.body().count() >= kSenders || !is_whole(topic, message)) {
      ++state_->damaged;
      return;
    }
    SenderState& sender = state_->senders[topic][message.body().count()];
    const std::uint64_t sequence = message.info().sequence;
    if (sender.pid != message.body().width()) {
      sender.first_sequence = sequence;
      sender.received = 0;
      sender.pid = message.body().width();
    } else if (sequence <= sender.last_sequence) {
      ++state_->reordered;
    } else {
      state_->losses[topic].gaps += sequence - sender.last_sequence - 1;
    }
    sender.last_sequence = sequence;
    ++sender.received;
    count_losses();
    auto& losses = state_->losses[topic];
    if (losses.gaps > losses.counted) {
      losses.unseen = std::max(losses.unseen.load(), losses.gaps - losses.counted);
    }
    sender.last_time = steady_now();
  }

  static bool is_whole(Topic topic, const prehend::graph::Received<PointCloud>& message) {
    const auto payload = message.payload();
    return payload.size() == kPayloadBytes[topic] &&
           std::all_of(payload.begin(), payload.end(),
                       [expected = static_cast<std::uint8_t>(message.body().height())](
                           std::uint8_t byte) { return byte == expected; });
  }

  TrafficFile state_;
  std::array<prehend::graph::Subscription, kTopicCount> subscriptions_;
};

void subscribe(Node& node) {
  const std::string state = state_file(node);
  Listener listener(node, state);
  const auto timer = node.create_timer(0.05, [&] { listener.count_losses(); });
  node.spin();
}

}  // namespace

int main(int argc, char** argv) {
  const std::string role = argc > 1 ? argv[1] : "";
  return prehend::graph::run_node(argc - 1, argv + 1, {"traffic_" + role, "A node for tests."},
                                  role == "publish" ? publish : subscribe);
}
