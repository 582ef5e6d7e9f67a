// The RSI loop allocates nothing: whatever comes, whatever it does.

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <cstdlib>
#include <new>

#include "tests/drivers/kuka_rsi/virtual_robot.h"

namespace {
std::atomic<bool> counts_allocations = false;
std::atomic<int> allocations = 0;

void* counted(std::size_t size) {
  if (counts_allocations) ++allocations;
  if (void* memory = std::malloc(size)) return memory;
  throw std::bad_alloc();
}
}  // namespace

// NOLINTBEGIN: the whole program's
void* operator new(std::size_t size) { return counted(size); }
void* operator new[](std::size_t size) { return counted(size); }
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete[](void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t) noexcept { std::free(memory); }
// NOLINTEND

namespace prehend::drivers::kuka_rsi {
namespace {

TEST(RsiLoop, AllocatesNothing) {
  Limits::Options limits = wide_limits();
  limits.box = ToolBox{Eigen::Vector3d::Constant(-2), Eigen::Vector3d::Constant(2)};
  VirtualRobot robot({}, controller_of_kuka(), limits);
  robot.begin();
  Axes to = home_of_kuka();
  to[0] += 0.5;
  ASSERT_TRUE(robot.move(to, 0.5));
  std::array<char, 4096> damaged{};
  int moving = 0, answered = 0;
  for (int cycle = 0; cycle < 400; ++cycle) {
    robot.now += std::chrono::milliseconds(12);
    const std::string_view telegram = robot.controller.tick(robot.now);
    std::copy(telegram.begin(), telegram.end(), damaged.begin());
    if (cycle == 40) robot.driver->stop();
    if (cycle == 200) robot.driver->latch();
    counts_allocations = true;
    robot.driver->feel(1, robot.now);
    robot.driver->on_time(robot.now);
    robot.driver->on_packet({damaged.data(), static_cast<std::size_t>(cycle) % telegram.size()},
                            robot.now);
    const std::string_view answer =
        cycle % 50 == 49 ? std::string_view() : robot.driver->on_packet(telegram, robot.now);
    robot.driver->on_packet(telegram, robot.now);
    counts_allocations = false;
    const Snapshot& now = robot.snapshot();
    moving += now.state == State::kMoving || now.state == State::kStopping;
    answered += !answer.empty();
    robot.controller.receive(answer, robot.now);
  }
  EXPECT_EQ(allocations, 0);
  EXPECT_GT(moving, 30);
  EXPECT_GT(answered, 300);
}

}  // namespace
}  // namespace prehend::drivers::kuka_rsi
