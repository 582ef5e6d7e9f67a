// Pause, step and speed of a published clock, and the nodes that follow it.

#include "prehend/graph/clock_control.h"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <random>

#include "tests/graph/test_graph.h"

namespace prehend::graph {
namespace {

using msgs::graph::ClockControlRequest;
using ::testing::HasSubstr;

constexpr std::int64_t kFar = std::numeric_limits<std::int64_t>::max();
constexpr std::int64_t kMs = 1'000'000;

// A pacer whose wall clock the test moves.
struct FakeWall {
  std::int64_t now = 5'000;
  ClockPacerOptions options(double speed = 1, std::int64_t start = 0) {
    ClockPacerOptions result;
    result.speed = speed;
    result.start = start;
    result.wall_clock = [this] { return now; };
    return result;
  }
};

TEST(ClockPacer, GrantsWhatIsDueAndNeverMoreThanAskedFor) {
  FakeWall wall;
  ClockPacer pacer(wall.options(2, 1'000));
  EXPECT_EQ(pacer.advance(kFar), 1'000);
  wall.now += 100;
  EXPECT_EQ(pacer.advance(kFar), 1'200);
  wall.now += 100;
  EXPECT_EQ(pacer.advance(1'300), 1'300);
  EXPECT_EQ(pacer.advance(1'000), 1'300) << "time never goes back";
  EXPECT_EQ(pacer.advance(kFar), 1'400) << "a late producer catches up";
  wall.now -= 150;
  EXPECT_EQ(pacer.advance(kFar), 1'400);
}

TEST(ClockPacer, SpeedZeroGrantsEverythingAtOnce) {
  FakeWall wall;
  ClockPacer pacer(wall.options(0));
  EXPECT_EQ(pacer.advance(7), 7);
  EXPECT_EQ(pacer.advance(1'000'000), 1'000'000);
  pacer.set_speed(1);
  wall.now += 5;
  EXPECT_EQ(pacer.advance(kFar), 1'000'005);
}

TEST(ClockPacer, PauseStopsStepGoesOnExactlyAndResumeContinues) {
  FakeWall wall;
  ClockPacer pacer(wall.options());
  wall.now += 10;
  EXPECT_EQ(pacer.advance(kFar), 10);
  pacer.pause();
  EXPECT_TRUE(pacer.state().paused);
  wall.now += 1'000;
  EXPECT_EQ(pacer.advance(kFar), 10);
  pacer.step(30);
  EXPECT_FALSE(pacer.state().paused);
  wall.now += 20;
  EXPECT_EQ(pacer.advance(kFar), 30);
  pacer.step(5);  // adds up
  wall.now += 500;
  EXPECT_EQ(pacer.advance(kFar), 45);
  EXPECT_TRUE(pacer.state().paused);
  wall.now += 500;
  EXPECT_EQ(pacer.advance(kFar), 45);
  pacer.resume();
  wall.now += 7;
  EXPECT_EQ(pacer.advance(kFar), 52);
}

TEST(ClockPacer, PausesWhereTheProducerStandsBetweenTwoTimesItWants) {
  FakeWall wall;
  ClockPacer pacer(wall.options());
  EXPECT_EQ(pacer.advance(1'000), 0);
  wall.now += 400;
  pacer.pause();
  EXPECT_EQ(pacer.state().time, 400);
  EXPECT_EQ(pacer.advance(1'000), 400);
}

TEST(ClockPacer, InSlicesATimeIsGrantedInFullOrNotAtAll) {
  FakeWall wall;
  auto options = wall.options();
  options.slice = 10;
  ClockPacer pacer(options);
  wall.now += 9;
  EXPECT_EQ(pacer.advance(10), 0);
  wall.now += 6;
  EXPECT_EQ(pacer.advance(10), 10);
  EXPECT_EQ(pacer.advance(20), 10);
  pacer.pause();
  EXPECT_EQ(pacer.state().time, 10);
  EXPECT_THROW(pacer.step(15), std::invalid_argument);
  pacer.step(20);
  wall.now += 100;
  EXPECT_EQ(pacer.advance(20), 20);
  EXPECT_EQ(pacer.advance(30), 30);
  EXPECT_EQ(pacer.advance(40), 30);
}

// Any mixture of commands against the sum of speed times wall time, worked out beside it.
TEST(ClockPacer, DoesNotDriftFromTheClosedForm) {
  std::mt19937_64 random(11);
  const auto pick = [&](std::int64_t most) {
    return static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(most)) + 1;
  };
  FakeWall wall;
  ClockPacer pacer(wall.options(1));
  long double time = 0, left_of_step = 0;
  double speed = 1;
  bool paused = false;
  for (int command = 0; command < 2'000; ++command) {
    const std::int64_t elapsed = pick(1'000'000'000);
    for (std::int64_t done = 0; done < elapsed;) {  // looked at often: must not matter
      const std::int64_t part = std::min(pick(400'000'000), elapsed - done);
      done += part;
      wall.now += part;
      pacer.advance(kFar);
    }
    long double gone = static_cast<long double>(elapsed) * speed;
    if (paused) {
      gone = std::min(gone, left_of_step);
      left_of_step -= gone;
    }
    time += gone;
    ASSERT_NEAR(static_cast<double>(pacer.state().time - static_cast<std::int64_t>(time)), 0,
                2.0 + command)
        << "at most 1 ns a command is rounded away; command " << command;
    switch (pick(4)) {
      case 1:
        pacer.pause();
        paused = true;
        left_of_step = 0;
        break;
      case 2:
        pacer.resume();
        paused = false;
        break;
      case 3:
        speed = static_cast<double>(pick(4'000)) * 1e-3;
        pacer.set_speed(speed);
        break;
      default:
        if (!paused) break;
        const std::int64_t step = pick(3'000'000'000);
        pacer.step(step);
        left_of_step += static_cast<long double>(step);
    }
  }
  // A year later, at a speed that is no binary fraction, looked at each minute.
  pacer.restart(0);
  pacer.resume();
  pacer.set_speed(0.1);
  constexpr std::int64_t kMinute = 60'000'000'000;
  for (int i = 0; i < 365 * 24 * 60; ++i) {
    wall.now += kMinute;
    pacer.advance(kFar);
  }
  EXPECT_NEAR(static_cast<double>(pacer.state().time), 365.0 * 24 * 60 * 60e9 * 0.1, 8);
}

TEST(ClockPacer, GivesUpALagWhenToldTo) {
  FakeWall wall;
  ClockPacer pacer(wall.options(2));
  wall.now += 1'000;
  EXPECT_EQ(pacer.advance(100), 100);
  EXPECT_FALSE(pacer.give_up_lag(std::chrono::nanoseconds(950)));
  EXPECT_TRUE(pacer.give_up_lag(std::chrono::nanoseconds(949)));
  wall.now += 10;
  EXPECT_EQ(pacer.advance(kFar), 120);
}

TEST(ClockPacer, RefusesWhatMakesNoSense) {
  ClockPacer pacer;
  EXPECT_THROW(pacer.step(10), std::invalid_argument) << "it runs";
  EXPECT_THROW(pacer.set_speed(-1), std::invalid_argument);
  EXPECT_THROW(pacer.set_speed(std::nan("")), std::invalid_argument);
  EXPECT_THROW(pacer.set_speed(INFINITY), std::invalid_argument);
  pacer.pause();
  EXPECT_THROW(pacer.step(0), std::invalid_argument);
  EXPECT_THROW(pacer.step(-5), std::invalid_argument);
  pacer.step(kFar);
  pacer.step(kFar);  // no overflow
  pacer.set_speed(1e300);
  EXPECT_GE(pacer.advance(kFar), 0);
}

TEST(ClockPacer, AWaitEndsAtItsTimeAtACommandAndAtItsLongest) {
  ClockPacer pacer;
  const std::int64_t soon = pacer.state().time + 20 * kMs;
  EXPECT_EQ(pacer.wait_for(soon, 60s), soon);
  pacer.pause();
  const std::int64_t here = pacer.state().time;
  EXPECT_EQ(pacer.wait_for(soon + 60'000 * kMs, 10ms), here);
  std::thread commander([&] {
    std::this_thread::sleep_for(50ms);
    pacer.set_speed(3);
  });
  EXPECT_EQ(pacer.wait_for(soon + 60'000 * kMs, 60s), here);
  commander.join();
}

class ControlledClock : public GraphTest {
 protected:
  ControlledClock() {
    node_.spin_in_background();
    EXPECT_TRUE(client_.wait_for_server(5s));
    producer_ = std::thread([this] { produce(); });
  }
  ~ControlledClock() override {
    done_ = true;
    producer_.join();
  }

  // Slices of 10 ms, as the simulation does it.
  void produce() {
    std::int64_t next = 10 * kMs;
    while (!done_) {
      if (pacer_.wait_for(next, 20ms) < next) continue;
      clock_.publish(clock_message(next));
      next += 10 * kMs;
    }
  }

  msgs::graph::ClockControlResponse ask(ClockControlRequest::Command command, std::int64_t step = 0,
                                        double speed = 0) {
    ClockControlRequest request;
    request.set_command(command);
    request.set_step(step);
    request.set_speed(speed);
    const auto answer = client_.call(request, 5s);
    EXPECT_TRUE(answer.ok()) << answer.error();
    return answer.ok() ? *answer : msgs::graph::ClockControlResponse();
  }

  static ClockPacerOptions slices() {
    ClockPacerOptions options;
    options.slice = 10 * kMs;
    options.paused = true;
    return options;
  }

  ClockPacer pacer_{slices()};
  Node node_{options("simulation")};
  Publisher<msgs::Clock> clock_ = node_.advertise<msgs::Clock>(kClockTopic, QoS::latched(20));
  std::atomic<double> told_speed_{-1};
  ClockControl control_{node_, pacer_, [this](double speed) { told_speed_ = speed; }};
  Node caller_{options("caller")};
  ServiceClient<ClockControlRequest, msgs::graph::ClockControlResponse> client_ =
      caller_.client<ClockControlRequest, msgs::graph::ClockControlResponse>(kClockControlService);
  std::atomic<bool> done_{false};
  std::thread producer_;
};

TEST_F(ControlledClock, TimersStopWhilePausedAndTickOnceEachStep) {
  NodeOptions simulated = options("follower");
  simulated.clock = ClockMode::kSimulated;
  Node follower(simulated);
  Inbox ticks;
  auto timer = follower.create_timer(0.01, [&] { ticks.add(follower.clock().now()); });
  follower.spin_in_background();
  ASSERT_TRUE(clock_.wait_for_subscribers(1, 5s));
  ask(ClockControlRequest::STEP, 10 * kMs);  // timers count from the first stamp
  ASSERT_TRUE(eventually([&] { return follower.clock().now() == 10 * kMs; }));
  std::this_thread::sleep_for(150ms);
  EXPECT_EQ(ticks.size(), 0u) << "paused";
  std::vector<std::int64_t> expected;
  for (std::int64_t i = 2; i <= 21; ++i) {
    ask(ClockControlRequest::STEP, 10 * kMs);
    expected.push_back(10 * kMs * i);
    ASSERT_TRUE(eventually([&] { return ticks.size() >= expected.size(); })) << i;
  }
  std::this_thread::sleep_for(100ms);
  EXPECT_EQ(ticks.values(), expected) << "20 steps, 20 ticks";

  EXPECT_FALSE(ask(ClockControlRequest::RESUME).paused());
  ASSERT_TRUE(eventually([&] { return ticks.size() > 30; }));
  EXPECT_TRUE(ask(ClockControlRequest::PAUSE).paused());
  const std::int64_t stopped = ask(ClockControlRequest::STATUS).time();
  ASSERT_TRUE(eventually([&] { return follower.clock().now() == stopped; }));
  std::this_thread::sleep_for(50ms);
  const auto seen = ticks.size();
  std::this_thread::sleep_for(150ms);
  EXPECT_EQ(ticks.size(), seen);
  EXPECT_EQ(ask(ClockControlRequest::STATUS).time(), stopped);
}

TEST_F(ControlledClock, AnswersSayWhereTheClockStandsAndWhatIsWrong) {
  auto answer = ask(ClockControlRequest::STATUS);
  EXPECT_TRUE(answer.paused());
  EXPECT_EQ(answer.speed(), 1);
  answer = ask(ClockControlRequest::SET_SPEED, 0, 0);
  EXPECT_EQ(answer.speed(), 0);
  EXPECT_EQ(told_speed_, 0);
  ask(ClockControlRequest::STEP, 1'000'000 * kMs);
  EXPECT_TRUE(eventually([&] { return ask(ClockControlRequest::STATUS).paused(); }, 20s));
  EXPECT_EQ(ask(ClockControlRequest::STATUS).time(), 1'000'000 * kMs);
  EXPECT_THAT(ask(ClockControlRequest::STEP, 15 * kMs).error(), HasSubstr("multiple"));
  EXPECT_THAT(ask(ClockControlRequest::STEP, -1).error(), HasSubstr("longer than 0"));
  EXPECT_THAT(ask(ClockControlRequest::SET_SPEED, 0, -2).error(), HasSubstr("speed"));
  EXPECT_EQ(told_speed_, 0);
  EXPECT_THAT(ask(static_cast<ClockControlRequest::Command>(77)).error(), HasSubstr("77"));
  ask(ClockControlRequest::RESUME);
  EXPECT_THAT(ask(ClockControlRequest::STEP, 10 * kMs).error(), HasSubstr("pause it before"));
}

}  // namespace
}  // namespace prehend::graph
