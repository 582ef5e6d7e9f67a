// A subscriber that does not read: its publisher goes on, holds no more than its queue says, and
// every message that did not get through is counted at both ends.

#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <string>
#include <thread>

#include "msgs/geometry.pb.h"
#include "prehend/graph/node.h"
#include "tests/system/fault_graph.h"

namespace prehend::testing {
namespace {

using namespace std::chrono_literals;
using graph::QoS;
using Clock = std::chrono::steady_clock;

constexpr int kMessages = 400;  // of 1 MB, at most
constexpr auto kStopped = 2s;   // less than the lease of a node that is silent
// What ZeroMQ holds for one reader besides the queue, on both sides, and what is being filled.
constexpr std::size_t kMessagesOnTheWay = 32 + 32 + 8;

// Of this process, shared memory included.
std::size_t resident_bytes() {
  std::ifstream file("/proc/self/statm");
  std::size_t total = 0, resident = 0;
  file >> total >> resident;
  return resident * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
}

bool is_stopped(pid_t pid) {
  std::ifstream file("/proc/" + std::to_string(pid) + "/stat");
  std::string text;
  std::getline(file, text);
  return text.find(") T ") != std::string::npos;
}

bool eventually(const std::function<bool()>& condition) {
  const auto deadline = Clock::now() + 20s;
  while (!condition()) {
    if (Clock::now() > deadline) return false;
    std::this_thread::sleep_for(5ms);
  }
  return true;
}

struct Policy {
  std::string name;
  QoS qos;
};

class SlowSubscriber : public ::testing::TestWithParam<Policy> {
 protected:
  SlowSubscriber() {
    graph_.start_registry();
    graph_.start_subscriber("listener");
    graph::NodeOptions options;
    options.name = "talker";
    options.registry = graph_.registry_endpoint();
    options.log_level = graph::LogLevel::kError;
    node_ = std::make_unique<graph::Node>(options);
    publisher_ = node_->advertise<msgs::PointCloud>(kTopicNames[kLarge], GetParam().qos);
  }

  void publish() {
    msgs::PointCloud message;
    message.set_width(static_cast<std::uint32_t>(::getpid()));
    message.set_height(++count_);
    message.set_data(std::string(kPayloadBytes[kLarge], static_cast<char>(count_)));
    const auto start = Clock::now();
    publisher_.publish(std::move(message));
    slowest_ = std::max(slowest_, Clock::now() - start);
  }
  bool listener_has_all() {
    return graph_.state("listener").senders[kLarge][0].last_sequence == count_;
  }

  FaultGraph graph_;
  std::unique_ptr<graph::Node> node_;
  graph::Publisher<msgs::PointCloud> publisher_;
  std::uint32_t count_ = 0;
  Clock::duration slowest_{};
};

TEST_P(SlowSubscriber, HoldsNobodyUpAndLosesNothingInSilence) {
  ASSERT_TRUE(publisher_.wait_for_subscribers(1, 20s));
  for (int i = 0; i < 20; ++i) {
    publish();
    std::this_thread::sleep_for(5ms);
  }
  ASSERT_TRUE(eventually([this] { return listener_has_all(); }));

  const std::size_t before = resident_bytes();
  const pid_t listener = graph_.pid("listener");
  graph_.send_signal("listener", SIGSTOP);
  ASSERT_TRUE(eventually([&] { return is_stopped(listener); }));
  const std::uint32_t published_before = count_;
  const auto end = Clock::now() + kStopped;
  for (int i = 0; i < kMessages && Clock::now() < end; ++i) {
    publish();
    std::this_thread::sleep_for(5ms);
  }
  const std::uint32_t published = count_ - published_before;
  // That this point is reached before the listener goes on shows that nobody waited for it.
  ASSERT_TRUE(is_stopped(listener));
  const std::size_t held = resident_bytes() - std::min(before, resident_bytes());
  graph_.send_signal("listener", SIGCONT);
  // One more message makes the listener see what is missing before it.
  ASSERT_TRUE(eventually([&] {
    publish();
    std::this_thread::sleep_for(20ms);
    return listener_has_all();
  }));

  const auto& losses = graph_.state("listener").losses[kLarge];
  const auto lost = [this] {
    const auto statistics = publisher_.statistics();
    return statistics.dropped + statistics.superseded;
  };
  EXPECT_TRUE(eventually([&] { return losses.missed == lost(); }))
      << losses.missed << " missed, " << lost() << " dropped";
  EXPECT_EQ(losses.gaps, losses.counted);
  const std::size_t kept = std::min<std::size_t>(GetParam().qos.depth, 20) + kMessagesOnTheWay;
  EXPECT_GE(lost() + kept, published);
  EXPECT_GT(published, kept);  // else nothing was shown
  EXPECT_EQ(graph_.state("listener").damaged, 0u);
  EXPECT_EQ(graph_.state("listener").reordered, 0u);
  const std::size_t queue =
      std::min(GetParam().qos.max_bytes, GetParam().qos.depth * kPayloadBytes[kLarge]);
  const auto high_water = publisher_.statistics();
  EXPECT_GT(high_water.queue_high_water, 0u);
  EXPECT_LE(high_water.queue_high_water, GetParam().qos.depth);
  EXPECT_LE(high_water.queue_high_water_bytes, queue + kPayloadBytes[kLarge]);
  // Shared memory comes in sizes up to half as large again.
  EXPECT_LT(held, queue + kMessagesOnTheWay * kPayloadBytes[kLarge] * 3 / 2);
  std::printf(
      "%s: %llu of %u messages lost and counted at both ends, %.0f MB held, publish took "
      "at most %.2f ms\n",
      GetParam().name.c_str(), static_cast<unsigned long long>(lost()), count_,
      static_cast<double>(held) * 1e-6,
      std::chrono::duration<double, std::milli>(slowest_).count());
}

INSTANTIATE_TEST_SUITE_P(
    Policies, SlowSubscriber,
    ::testing::Values(Policy{"latest", QoS::latest()}, Policy{"queue", QoS::queue(5)},
                      Policy{"queue_of_bytes", QoS::queue(1000, std::size_t{20} << 20)},
                      Policy{"latched", QoS::latched(5)}),
    [](const auto& instance) { return instance.param.name; });

}  // namespace
}  // namespace prehend::testing
