#include "drivers/camera/transport/frame_pairing.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "drivers/camera/transport/device_clock.h"

namespace prehend::drivers::camera {
namespace {

using namespace std::chrono_literals;
using Pairing = FramePairing<int>;

TEST(FramePairing, PairsWithinHalfAFrameAndCountsTheRest) {
  Pairing pairing(Pairing::half_a_frame(50));  // 10 ms
  EXPECT_FALSE(pairing.add(0, 100ms, 1));
  const auto pair = pairing.add(1, 110ms, 2);
  ASSERT_TRUE(pair);
  EXPECT_EQ(pair->first.item, 1);
  EXPECT_EQ(pair->second.item, 2);
  EXPECT_EQ(pair->second.stamp, 110ms);
  EXPECT_FALSE(pairing.add(0, 120ms, 3));
  EXPECT_FALSE(pairing.add(1, 131ms, 4));  // 11 ms later: 3 has no partner any more
  EXPECT_EQ(pairing.dropped(0), 1u);
  EXPECT_EQ(pairing.dropped(1), 0u);
  const auto next = pairing.add(0, 139ms, 5);
  ASSERT_TRUE(next);
  EXPECT_EQ(next->second.item, 4);
}

TEST(FramePairing, StampsThatDoNotGrowAreDropped) {
  Pairing pairing(10ms);
  EXPECT_FALSE(pairing.add(0, 100ms, 1));
  EXPECT_FALSE(pairing.add(0, 100ms, 2));
  EXPECT_FALSE(pairing.add(0, 50ms, 3));
  EXPECT_EQ(pairing.dropped(0), 2u);
  pairing.restart();  // e.g. the device began anew
  EXPECT_EQ(pairing.dropped(0), 3u);
  EXPECT_FALSE(pairing.add(0, 50ms, 4));
  EXPECT_TRUE(pairing.add(1, 50ms, 5));
}

TEST(FramePairing, ASideThatIsDeadFillsNoMemory) {
  Pairing pairing(10ms);
  for (int i = 0; i < 1000; ++i) EXPECT_FALSE(pairing.add(1, i * 20ms, i));
  EXPECT_EQ(pairing.dropped(1), 1000 - Pairing::kMost);
  EXPECT_THROW(Pairing(0ms), std::invalid_argument);
  EXPECT_THROW(Pairing(-1ms), std::invalid_argument);
}

struct Stamp {
  std::size_t side;
  Time time;
};

// Pairs of stamps, fed in the given order.
std::vector<std::pair<Time, Time>> pairs_of(const std::vector<Stamp>& order, Time tolerance,
                                            std::uint64_t& dropped) {
  Pairing pairing(tolerance);
  std::vector<std::pair<Time, Time>> pairs;
  for (const Stamp& stamp : order) {
    if (const auto pair = pairing.add(stamp.side, stamp.time, 0)) {
      pairs.emplace_back(pair->first.stamp, pair->second.stamp);
    }
  }
  pairing.restart();
  dropped = pairing.dropped(0) + pairing.dropped(1);
  return pairs;
}

// Two free-running cameras with lost frames and noisy stamps, whose frames arrive in any order that
// keeps each side's own: the same pairs come, each within half a frame, and every frame is in one
// pair or counted.
TEST(FramePairing, PairsDependOnTheStampsAlone) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(0, 1);
  const Time period = 33ms, half = period / 2;
  for (int trial = 0; trial < 300; ++trial) {
    std::vector<Stamp> sides[2];
    for (std::size_t side = 0; side < 2; ++side) {
      Time at = Time(static_cast<std::int64_t>(unit(random) * 33e6));
      for (int i = 0; i < 40; ++i) {
        at += period + Time(static_cast<std::int64_t>((unit(random) - 0.5) * 4e6));
        if (unit(random) > 0.15) sides[side].push_back({side, at});
      }
    }
    std::vector<Stamp> by_time = sides[0];
    by_time.insert(by_time.end(), sides[1].begin(), sides[1].end());
    std::sort(by_time.begin(), by_time.end(),
              [](const Stamp& a, const Stamp& b) { return a.time < b.time; });
    std::vector<Stamp> shuffled;  // a side is at most 6 frames behind
    std::size_t next[2] = {0, 0};
    while (next[0] < sides[0].size() || next[1] < sides[1].size()) {
      std::size_t side = unit(random) < 0.5 ? 0 : 1;
      if (next[side] == sides[side].size()) side = 1 - side;
      if (next[1 - side] < sides[1 - side].size() &&
          sides[side][next[side]].time - sides[1 - side][next[1 - side]].time > 5 * period) {
        side = 1 - side;
      }
      shuffled.push_back(sides[side][next[side]++]);
    }
    std::uint64_t dropped = 0, dropped_shuffled = 0;
    const auto pairs = pairs_of(by_time, half, dropped);
    EXPECT_EQ(pairs_of(shuffled, half, dropped_shuffled), pairs);
    EXPECT_EQ(dropped, dropped_shuffled);
    EXPECT_EQ(2 * pairs.size() + dropped, by_time.size());
    for (const auto& [left, right] : pairs)
      EXPECT_LE(std::abs((left - right).count()), half.count());
  }
}

// Undisturbed cameras of one rate lose nothing, whatever their phase (but exactly half a frame).
TEST(FramePairing, FreeRunningCamerasOfOneRateLoseNoFrame) {
  for (int phase = 0; phase < 33; ++phase) {
    Pairing pairing(Time(33ms) / 2);
    int pairs = 0;
    for (int i = 0; i < 200; ++i) {
      pairs += pairing.add(0, 1s + i * 33ms, i).has_value() ? 1 : 0;
      pairs += pairing.add(1, 1s + i * 33ms + phase * 1ms, i).has_value() ? 1 : 0;
    }
    EXPECT_GE(pairs, 199) << phase;
  }
}

TEST(DeviceClock, FollowsTheLeastDelay) {
  DeviceClock clock;
  // The device's clock began at 1 s of this host's; delays of 5 to 40 ms.
  EXPECT_EQ(clock.to_host(0ms, 1040ms), 1040ms);
  EXPECT_EQ(clock.to_host(33ms, 1038ms), 1038ms);  // the delay is 5 ms at most
  const Time later = clock.to_host(66ms, 1100ms);
  EXPECT_NEAR(to_seconds(later), 1.071, 1e-4);
}

TEST(DeviceClock, IsNeverLaterThanArrivalAndBearsDriftAndJumps) {
  std::mt19937 random(1);
  std::uniform_int_distribution<int> delay(2, 20);
  DeviceClock clock;
  Time host = 10s;
  for (int i = 0; i < 20000; ++i) {
    host += 33ms;
    // 30 ppm slow, and it begins anew now and then.
    const Time device =
        Time(static_cast<std::int64_t>(static_cast<double>(host.count()) * (1 - 3e-5))) -
        (i / 5000) * 100s;
    const Time arrival = host + delay(random) * 1ms;
    const Time said = clock.to_host(device, arrival);
    ASSERT_LE(said, arrival);
    ASSERT_TRUE(i % 5000 <= 200 || std::abs(to_seconds(said - host)) < 0.012) << i;
  }
}

}  // namespace
}  // namespace prehend::drivers::camera
