#include <cmath>
#include <limits>

#include "prehend/graph/rate.h"
#include "tests/graph/test_graph.h"

namespace prehend::graph {
namespace {

constexpr std::int64_t kSecond = 1'000'000'000;

// A node on a simulated clock that the test sets.
class SimulatedTime : public GraphTest {
 protected:
  NodeOptions simulated() const {
    NodeOptions result = options("node");
    result.clock = ClockMode::kSimulated;
    return result;
  }
  void SetUp() override { ASSERT_TRUE(clock.wait_for_subscribers(1, 10s)); }
  // Returns when the node has seen the stamp.
  void set(std::int64_t stamp) {
    clock.publish(clock_message(stamp));
    ASSERT_TRUE(eventually([&] { return node.clock().now() == stamp; }));
  }

  Node simulation{options("simulation")};
  Node node{simulated()};
  Publisher<msgs::Clock> clock = simulation.advertise<msgs::Clock>("/clock", QoS::latched(1));
};

TEST_F(SimulatedTime, TimersKeepToTheClockThroughPausesAndJumps) {
  Inbox ticks;
  auto timer = node.create_timer(1, [&] { ticks.add(node.clock().now() / kSecond); });
  node.spin_in_background();
  set(10 * kSecond);
  std::this_thread::sleep_for(50ms);  // paused
  set(10 * kSecond + kSecond / 2);
  EXPECT_EQ(ticks.size(), 0u);
  set(11 * kSecond);
  EXPECT_TRUE(eventually([&] { return ticks.size() == 1; }));
  clock.publish(clock_message(11 * kSecond));  // the same once more
  set(1'000'000 * kSecond);                    // the ticks between merge
  EXPECT_TRUE(eventually([&] { return ticks.size() == 2; }));
  set(5 * kSecond);
  std::this_thread::sleep_for(20ms);
  set(6 * kSecond);
  EXPECT_TRUE(eventually([&] { return ticks.size() == 3; }));
  std::this_thread::sleep_for(20ms);
  EXPECT_EQ(ticks.values(), (std::vector<std::int64_t>{11, 1'000'000, 6}));
}

TEST_F(SimulatedTime, StampsBeyondReasonAreThrownAway) {
  std::atomic<int> ticks = 0, begun = 0;
  auto timer = node.create_timer(1e9, [&] { ++ticks; });
  auto beginning = node.create_one_shot_timer(1, [&] { ++begun; });
  node.spin_in_background();
  // Timers count from the first stamp that they are shown, which may be any of these.
  std::int64_t stamp = 0;
  ASSERT_TRUE(eventually([&] {
    set(++stamp * kSecond);
    return begun == 1;
  }));
  for (const std::int64_t beyond :
       {std::numeric_limits<std::int64_t>::max(), std::numeric_limits<std::int64_t>::min()}) {
    clock.publish(clock_message(beyond));
  }
  set(2);  // comes after those
  set(-kSecond);
  set(4 * kSecond * kSecond);  // 126 years
  EXPECT_TRUE(eventually([&] { return ticks == 1; }));
}

TEST_F(SimulatedTime, OneShotTimersTickOnce) {
  std::atomic<int> once = 0, again = 0;
  auto timer = node.create_one_shot_timer(1, [&] { ++once; });
  Node::Timer chained;
  auto first = node.create_one_shot_timer(
      1, [&] { chained = node.create_one_shot_timer(1, [&] { ++again; }); });
  node.spin_in_background();
  set(kSecond);
  std::this_thread::sleep_for(20ms);
  EXPECT_EQ(once, 0);
  set(2 * kSecond);
  EXPECT_TRUE(eventually([&] { return once == 1; }));
  std::this_thread::sleep_for(20ms);
  EXPECT_EQ(again, 0);
  set(3 * kSecond);
  EXPECT_TRUE(eventually([&] { return again == 1; }));
  set(100 * kSecond);
  std::this_thread::sleep_for(20ms);
  EXPECT_EQ(once + again, 2);
}

TEST_F(SimulatedTime, RatesFollowTheClock) {
  Inbox ticks;
  std::atomic<std::uint64_t> missed = 0;
  std::thread loop([&] {
    Rate rate(node.clock(), 1);
    while (rate.sleep()) {
      missed = rate.missed();
      ticks.add(node.clock().now() / kSecond);
    }
  });
  std::this_thread::sleep_for(20ms);
  const auto tick = [&](std::int64_t second, std::size_t count) {
    set(second * kSecond);
    EXPECT_TRUE(eventually([&] { return ticks.size() == count; })) << second;
    std::this_thread::sleep_for(10ms);
  };
  tick(7, 0);
  tick(8, 1);
  tick(9, 2);
  tick(20, 3);
  EXPECT_EQ(missed, 10u);
  tick(3, 3);  // back: anew from here
  tick(4, 4);
  EXPECT_EQ(ticks.values(), (std::vector<std::int64_t>{8, 9, 20, 4}));
  node.shutdown();
  loop.join();
}

TEST_F(SimulatedTime, ASleepBeginsAnewWhenTheClockJumpsBack) {
  set(100 * kSecond);
  std::atomic<bool> awake = false;
  std::thread sleeper([&] {
    EXPECT_TRUE(node.clock().sleep_for(10s));
    awake = true;
  });
  std::this_thread::sleep_for(50ms);
  set(109 * kSecond);
  set(5 * kSecond);
  set(14 * kSecond);
  std::this_thread::sleep_for(20ms);
  EXPECT_FALSE(awake);
  set(15 * kSecond);
  EXPECT_TRUE(eventually([&] { return awake.load(); }));
  node.shutdown();
  sleeper.join();
}

class WallTime : public GraphTest {};

TEST_F(WallTime, ARateDoesNotDriftAndCountsWhatItMissed) {
  Node node(options("node"));
  const auto begin = std::chrono::steady_clock::now();
  Rate rate(node.clock(), 100);
  std::uint64_t ticks = 0;
  while (ticks < 30) {
    ASSERT_TRUE(rate.sleep());
    ++ticks;
    if (ticks == 10) {
      std::this_thread::sleep_for(35ms);
      ASSERT_TRUE(rate.sleep());
      EXPECT_GE(rate.overrun(), 20ms);
      EXPECT_GE(rate.missed(), 2u);
      ++ticks;
    }
  }
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - begin;
  // Never early; every tick came or was counted, so late ones have not pushed the others back.
  EXPECT_GE(elapsed.count(), 0.01 * static_cast<double>(ticks + rate.missed()) - 1e-3);
}

TEST_F(WallTime, PeriodsFromANanosecondToThirtyYears) {
  Node node(options("node"));
  std::atomic<int> fast = 0, slow = 0, others = 0;
  auto shortest = node.create_timer(1e-9, [&] { ++fast; });
  auto second = node.create_timer(1e-9, [&] { ++others; });
  auto longest = node.create_timer(1e9, [&] { ++slow; });
  auto once = node.create_one_shot_timer(0.02, [&] { ++others; });
  node.spin_in_background();
  EXPECT_TRUE(eventually([&] { return fast > 1000 && others > 1000; }));
  EXPECT_EQ(slow, 0);
  Rate quick(node.clock(), 1e9);
  for (int i = 0; i < 100; ++i) EXPECT_TRUE(quick.sleep());
  const double nan = std::nan(""), infinity = std::numeric_limits<double>::infinity();
  for (const double bad : {0.0, -1.0, 1e-10, 1.1e9, nan, infinity}) {
    EXPECT_THROW((void)node.create_timer(bad, [] {}), std::invalid_argument) << bad;
    EXPECT_THROW((void)node.create_one_shot_timer(bad, [] {}), std::invalid_argument) << bad;
    EXPECT_THROW(Rate(node.clock(), bad), std::invalid_argument) << bad;
  }
}

TEST_F(WallTime, ShutdownEndsEverySleep) {
  Node node(options("node"));
  std::vector<std::thread> sleepers;
  std::atomic<int> ended = 0;
  const auto sleep = [&](const std::function<bool()>& work) {
    sleepers.emplace_back([&, work] {
      EXPECT_FALSE(work());
      ++ended;
    });
  };
  sleep([&] { return node.clock().sleep_for(std::chrono::nanoseconds::max()); });
  sleep([&] { return node.clock().sleep_until(std::numeric_limits<std::int64_t>::max()); });
  sleep([&] { return Rate(node.clock(), 1e-9).sleep(); });
  std::this_thread::sleep_for(100ms);
  EXPECT_EQ(ended, 0);
  node.shutdown();
  for (std::thread& sleeper : sleepers) sleeper.join();
  EXPECT_TRUE(Clock(node.clock()).sleep_until(0) || !node.ok());
}

TEST_F(WallTime, SecondsThatDoNotFitBecomeTheNearestThatDo) {
  EXPECT_EQ(nanoseconds(1.5), 1'500'000'000);
  EXPECT_EQ(nanoseconds(1e300), std::numeric_limits<std::int64_t>::max());
  EXPECT_EQ(nanoseconds(-1e300), std::numeric_limits<std::int64_t>::min());
  EXPECT_EQ(nanoseconds(std::nan("")), 0);
}

TEST_F(WallTime, ARateInACallbackIsRefused) {
  Node node(options("node"));
  Rate rate(node.clock(), 1);
  std::atomic<int> refused = 0;
  auto timer = node.create_timer(0.001, [&] {
    try {
      rate.sleep();
    } catch (const std::logic_error&) {
      ++refused;
    }
  });
  node.spin_in_background();
  EXPECT_TRUE(eventually([&] { return refused > 0; }));
}

}  // namespace
}  // namespace prehend::graph
