// Many viewers at once, and for long.

#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <gmock/gmock.h>

#include "tests/nodes/looking.h"
#include "tests/nodes/viewer_graph.h"

namespace prehend::nodes {
namespace {

using std::chrono::steady_clock;

constexpr const char* kPad = "/tactile/left";
constexpr double kLast = 1e6;  // sum of the frame that ends a test

msgs::TactileFrame frame_of(double sum, int texels = 84) {
  msgs::TactileFrame frame;
  frame.set_rows(1);
  frame.set_columns(static_cast<std::uint32_t>(texels));
  for (int i = 0; i < texels; ++i) frame.add_intensity(static_cast<std::uint32_t>(i));
  frame.set_sum(sum);
  return frame;
}

double sum_of(const std::string& bytes) {
  msgs::TactileFrame frame;
  EXPECT_TRUE(frame.ParseFromString(bytes));
  return frame.sum();
}

/// Whether nothing came twice or too late.
void expect_rising(const std::vector<std::string>& frames) {
  for (std::size_t i = 1; i < frames.size(); ++i) {
    ASSERT_GT(sum_of(frames[i]), sum_of(frames[i - 1])) << i;
  }
}

/// MB of this process.
double memory() {
  std::ifstream file("/proc/self/statm");
  double all = 0, resident = 0;
  file >> all >> resident;
  return resident * static_cast<double>(::sysconf(_SC_PAGESIZE)) * 1e-6;
}

class ManyViewers : public ViewerGraph {
 protected:
  std::unique_ptr<Looking> looking(const std::string& topic, int receive_buffer = 0) {
    auto viewer = std::make_unique<Looking>(port(), receive_buffer);
    EXPECT_TRUE(viewer->has(topic));
    viewer->subscribe(topic, 1);
    return viewer;
  }
};

// Eight read, one has stopped to, and one comes and goes: those who read see the same, in order,
// and the talker is heard to the end.
TEST_F(ManyViewers, TenSeeTheSame) {
  start_viewer();
  const auto silent = looking(kPad, 4096);
  std::vector<std::unique_ptr<Looking>> readers;
  for (int i = 0; i < 8; ++i) readers.push_back(looking(kPad));
  EXPECT_EQ(bridge_->server().viewers(), 9);
  ASSERT_TRUE(frames_.wait_for_subscribers(1, std::chrono::seconds(10)));
  std::atomic<bool> ends{false};
  std::thread talks([&] {
    for (int i = 1; i <= 3000; ++i) {
      frames_.publish(frame_of(i, 2000));
      std::this_thread::sleep_for(std::chrono::microseconds(200));
    }
    // Whoever is late hears the last one.
    for (double sum = kLast; !ends; ++sum) {
      frames_.publish(frame_of(sum));
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
  });
  std::thread comes_and_goes([&] {
    while (!ends) looking(kPad)->until([] { return false; }, std::chrono::seconds(0));
  });
  std::vector<std::thread> reading;
  for (auto& reader : readers) {
    reading.emplace_back([&reader] {
      const auto& frames = reader->messages[1];
      EXPECT_TRUE(reader->until([&] { return !frames.empty() && sum_of(frames.back()) >= kLast; },
                                std::chrono::seconds(60)));
    });
  }
  for (std::thread& one : reading) one.join();
  ends = true;
  comes_and_goes.join();
  talks.join();
  for (auto& reader : readers) {
    EXPECT_GT(reader->messages[1].size(), 100);
    expect_rising(reader->messages[1]);
  }
}

// What a viewer leaves behind when it goes would add up in a day of them.
TEST_F(ManyViewers, ALongRunKeepsItsMemory) {
  start_viewer();
  const int rounds = std::getenv("PREHEND_THOROUGH_TESTS") ? 400 : 24;
  const int warm = rounds / 3;
  double before = 0, sum = 0;
  for (int round = 0; round < rounds; ++round) {
    if (round == warm) before = memory();
    const auto viewer = looking(kPad), silent = looking("/models", 4096);
    ASSERT_TRUE(viewer->has("/viewer/pad/left"));
    viewer->subscribe("/viewer/pad/left", 2);
    viewer->subscribe("/viewer/objects", 3);
    ASSERT_TRUE(frames_.wait_for_subscribers(1, std::chrono::seconds(10)));
    for (int i = 0; i < 1000; ++i) {
      frames_.publish(frame_of(++sum, 500));
      if (i % 50 == 0) publish_model(static_cast<std::uint32_t>(i / 50));
      if (i % 10 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    const double last = sum;
    ASSERT_TRUE(viewer->until([&] {
      const auto& frames = viewer->messages[1];
      if (!frames.empty() && sum_of(frames.back()) >= last) return true;
      frames_.publish(frame_of(++sum, 500));
      return false;
    }));
  }
  EXPECT_LT(memory(), 300);
#ifndef __SANITIZE_ADDRESS__  // which keeps what was freed
  EXPECT_LT(memory() - before, 30)
      << "MB more than after " << warm << " of " << rounds << " viewers";
#endif
}

}  // namespace
}  // namespace prehend::nodes
