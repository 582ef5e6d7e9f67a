// SIGKILL at random moments, with a fixed seed, of every kind of process a graph has.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <map>
#include <random>
#include <set>
#include <thread>

#include "msgs/geometry.pb.h"
#include "prehend/graph/introspection.h"
#include "prehend/recording/mcap_reader.h"
#include "tests/system/fault_graph.h"

namespace prehend::testing {
namespace {

using namespace std::chrono_literals;
namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr int kKills = 200;
// Usually 0.3 s, and under 2 s; more than that tells of a busy machine, far more of a fault. [s]
constexpr double kWholeWithin = 10.0;
constexpr double kHangs = 20.0;  // [s]
constexpr std::size_t kMostSlabBytes = std::size_t{64} << 20;
constexpr std::size_t kMostResidentBytes = std::size_t{400} << 20;

std::int64_t nanoseconds(Clock::time_point time) {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(time.time_since_epoch()).count();
}

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// Waits, and notes for how long the machine did not let it run: that is nobody's fault here.
class PatientClock {
 public:
  void wait() {
    const auto start = Clock::now();
    std::this_thread::sleep_for(5ms);
    const double late = seconds_since(start) - 0.005;
    if (late > 0.01) stalled_ += late;
  }
  double stalled() const { return stalled_; }

 private:
  double stalled_ = 0;
};

/// But for Open MPI's segments, which other tests may have meanwhile.
std::set<std::string> shared_memory() {
  std::set<std::string> names;
  for (const auto& entry : fs::directory_iterator("/dev/shm")) {
    if (!entry.path().filename().string().starts_with("vader_segment")) names.insert(entry.path());
  }
  return names;
}

/// Everything below a folder.
std::vector<std::string> files_below(const fs::path& folder) {
  std::vector<std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) files.push_back(entry.path());
  return files;
}

std::size_t resident_bytes(pid_t pid) {
  std::ifstream file("/proc/" + std::to_string(pid) + "/statm");
  std::size_t total = 0, resident = 0;
  file >> total >> resident;
  return resident * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
}

/// Processes whose environment names the folder.
std::vector<std::string> processes_of(const fs::path& folder) {
  std::vector<std::string> found;
  for (const auto& entry : fs::directory_iterator("/proc")) {
    const std::string pid = entry.path().filename();
    if (pid.find_first_not_of("0123456789") != std::string::npos) continue;
    if (pid == std::to_string(::getpid())) continue;
    std::ifstream file(entry.path() / "environ", std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    if (text.find(folder.string()) != std::string::npos) found.push_back(pid);
  }
  return found;
}

class Kill : public ::testing::Test {
 protected:
  void SetUp() override {
    shared_memory_before_ = shared_memory();
    graph_.start_registry();
    graph_.start_publisher("steady_talker", 0);
    graph_.start_publisher("talker", 1);
    graph_.start_subscriber("steady_listener");
    graph_.start_subscriber("listener");
    graph_.start_recorder("recorder");
  }

  /// What is missing to a whole graph, empty: nothing. Every subscriber has to have had, after
  /// `since`, a message of every publisher on both topics, and its latched one whenever; the
  /// registry has to list all as ready.
  std::string missing_since(Clock::time_point since) {
    for (const std::string& subscriber : graph_.subscribers()) {
      for (const std::string& publisher : graph_.publishers()) {
        for (std::size_t topic = 0; topic < kTopicCount; ++topic) {
          const std::size_t index = publisher == "talker" ? 1 : 0;
          const SenderState& sender = graph_.state(subscriber).senders[topic][index];
          const bool present = sender.pid == static_cast<std::uint64_t>(graph_.pid(publisher));
          const bool fresh = topic == kLatched || sender.last_time > nanoseconds(since);
          if (present && fresh) continue;
          return subscriber + " has nothing of " + publisher + " on " + kTopicNames[topic];
        }
      }
    }
    return missing_in_registry();
  }

  std::string missing_in_registry() {
    std::map<std::string, msgs::graph::NodeRecord> nodes;
    try {
      for (auto& node : introspection_.nodes()) nodes[node.name()] = node;
    } catch (const std::runtime_error&) {
      return "the registry does not answer";
    }
    for (const std::string& name : graph_.names()) {
      if (name == "registry") continue;
      const auto node = nodes.find(name);
      if (node == nodes.end() || node->second.pid() != graph_.pid(name) ||
          node->second.state() != msgs::graph::READY) {
        return "the registry does not know " + name;
      }
    }
    return "";
  }

  /// How long it took from `since` on until the graph was whole [s], without the machine's stalls.
  double time_to_whole(Clock::time_point since) {
    PatientClock clock;
    std::string missing;
    while (seconds_since(since) - clock.stalled() < kHangs) {
      missing = missing_since(since);
      if (missing.empty()) return seconds_since(since) - clock.stalled();
      clock.wait();
    }
    ADD_FAILURE() << "not whole after " << kHangs << " s: " << missing;
    for (const std::string& name : graph_.names()) {
      std::printf("--- %s\n%s\n", name.c_str(), graph_.output(name).c_str());
    }
    return kHangs;
  }

  void kill(const std::string& name) {
    graph_.kill(name);
    // It did not live to give the file its name.
    if (name == "recorder") check_recording(graph_.recording(name).string() + ".partial");
  }

  /// A recording whose writer was killed: what is in it is whole and in order.
  void check_recording(const fs::path& path) {
    ASSERT_TRUE(fs::exists(path));
    recording::McapReader reader(path);
    auto cursor = reader.messages();
    std::map<std::pair<std::string, std::uint64_t>, std::uint32_t> last;
    while (const auto message = cursor.next()) {
      const std::string& topic = reader.channels().at(message->channel_id).topic;
      if (topic != "/small" && topic != "/large" && topic != "/latched") continue;
      msgs::PointCloud content;
      ASSERT_TRUE(content.ParseFromArray(message->data.data(), int(message->data.size())));
      auto& number = last[{topic, content.width()}];
      ASSERT_GT(content.height(), number) << topic;
      number = content.height();
      ++recorded_;
    }
    ++recordings_;
    fs::remove(path);
  }

  void check_living() {
    for (const std::string& name : graph_.subscribers()) {
      const TrafficState& state = graph_.state(name);
      EXPECT_EQ(state.damaged, 0u) << name;
      EXPECT_EQ(state.reordered, 0u) << name;
      for (const auto& losses : state.losses) EXPECT_EQ(losses.unseen, 0u) << name;
    }
    for (const std::string& name : graph_.publishers()) {
      EXPECT_LT(graph_.state(name).most_slab_bytes, kMostSlabBytes) << name;
      EXPECT_LT(resident_bytes(graph_.pid(name)), kMostResidentBytes) << name;
    }
  }

  /// Ends all, as a user does, and looks for what was left behind.
  void end_and_check();

  FaultGraph graph_;
  graph::Introspection introspection_{graph_.registry_endpoint(), 300ms};
  std::set<std::string> shared_memory_before_;
  std::size_t recordings_ = 0, recorded_ = 0;
};

void print_distribution(const std::string& name, std::vector<double> times) {
  if (times.empty()) return;
  std::sort(times.begin(), times.end());
  std::printf("%-9s %3zu kills, whole again after %.2f s (median), %.2f s (90 %%), %.2f s (most)\n",
              name.c_str(), times.size(), times[times.size() / 2], times[times.size() * 9 / 10],
              times.back());
}

void Kill::end_and_check() {
  for (const std::string& name : graph_.publishers()) EXPECT_EQ(graph_.stop(name), 0) << name;
  // What was published last is on its way still.
  PatientClock clock;
  const auto listener_is_done = [&] {
    const auto& losses = graph_.state("steady_listener").losses;
    return std::all_of(losses.begin(), losses.end(),
                       [](const auto& loss) { return loss.gaps == loss.counted; });
  };
  const auto start = Clock::now();
  while (!listener_is_done() && seconds_since(start) < 3) clock.wait();
  for (std::size_t topic = 0; topic < kTopicCount; ++topic) {
    const auto& losses = graph_.state("steady_listener").losses[topic];
    EXPECT_EQ(losses.gaps, losses.counted) << kTopicNames[topic];
    std::printf("%s: the listener that lived all along lacks %llu messages, counted %llu\n",
                kTopicNames[topic], static_cast<unsigned long long>(losses.gaps),
                static_cast<unsigned long long>(losses.counted));
  }
  for (const std::string& name : graph_.subscribers()) EXPECT_EQ(graph_.stop(name), 0) << name;
  EXPECT_EQ(graph_.stop("recorder"), 0) << graph_.output("recorder");
  const recording::McapReader last(graph_.recording("recorder"));
  EXPECT_TRUE(last.complete());
  EXPECT_THAT(last.problems(), ::testing::IsEmpty());
  EXPECT_EQ(graph_.stop("registry"), 0) << graph_.output("registry");
  EXPECT_THAT(processes_of(graph_.folder()), ::testing::IsEmpty());
  EXPECT_THAT(files_below(graph_.runtime_base()), ::testing::IsEmpty());
  EXPECT_EQ(shared_memory(), shared_memory_before_);
}

TEST_F(Kill, EveryKindOfProcessAtRandomMoments) {
  time_to_whole(Clock::now());
  if (HasFailure()) return;
  std::mt19937 random(20240611);
  const std::vector<std::string> victims{"talker",   "talker",   "talker",   "listener",
                                         "listener", "listener", "registry", "recorder"};
  std::map<std::string, std::vector<double>> times;
  for (int done = 0; done < kKills && !HasFailure();) {
    std::this_thread::sleep_for(std::chrono::milliseconds(random() % 60));
    std::set<std::string> dead{victims[random() % victims.size()]};
    if (random() % 8 == 0) dead.insert(victims[random() % victims.size()]);
    const auto start = Clock::now();
    for (const std::string& name : dead) kill(name);
    for (const std::string& name : dead) graph_.restart(name);
    const double time = time_to_whole(start);
    times[dead.size() > 1 ? "two" : *dead.begin()].push_back(time);
    times["all"].push_back(time);
    EXPECT_LT(time, kWholeWithin) << "after kill " << done << " of " << *dead.begin();
    check_living();
    done += static_cast<int>(dead.size());
  }
  for (const auto& [name, durations] : times) print_distribution(name, durations);
  std::printf("%zu recordings of killed recorders with %zu messages were read\n", recordings_,
              recorded_);
  if (!HasFailure()) end_and_check();
}

}  // namespace
}  // namespace prehend::testing
