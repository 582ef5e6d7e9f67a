// A graph over two hosts with CURVE, whose cable is pulled for ten seconds.

#include <gtest/gtest.h>
#include <sched.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <fstream>
#include <functional>
#include <memory>
#include <optional>
#include <sstream>
#include <thread>

#include "tests/system/launched.h"
#include "tests/system/two_hosts.h"

namespace prehend::testing {
namespace {

using namespace std::chrono_literals;

constexpr std::size_t kTopics = 3;

bool eventually(const std::function<bool()>& condition, std::chrono::seconds timeout) {
  const auto deadline = std::chrono::steady_clock::now() + timeout;
  while (!condition()) {
    if (std::chrono::steady_clock::now() > deadline) return false;
    std::this_thread::sleep_for(50ms);
  }
  return true;
}

/// What a node counted: of its own publishers and of its subscriptions to the other's topics.
struct Counts {
  struct Topic {
    std::uint64_t published = 0, received = 0, missed = 0, dropped = 0, delivered = 0;
    std::uint64_t repeated = 0, damaged = 0;
  };
  std::array<Topic, kTopics> topics;
  std::uint64_t calls = 0, failed_calls = 0, goals = 0, failed_goals = 0;
};

/// The last whole line of counts that the node wrote.
Counts counts_of(const Launched& node) {
  std::istringstream lines(node.output());
  std::string line, last;
  while (std::getline(lines, line) && !lines.eof()) {
    if (line.starts_with("counts ")) last = line;
  }
  Counts counts;
  std::istringstream fields(last);
  std::string word;
  fields >> word;
  for (auto& topic : counts.topics) {
    fields >> topic.published >> topic.received >> topic.missed >> topic.dropped >>
        topic.delivered >> topic.repeated >> topic.damaged;
  }
  fields >> counts.calls >> counts.failed_calls >> counts.goals >> counts.failed_goals;
  return counts;
}

/// Whether the kernel refuses this user a network namespace; whatever else goes wrong in making
/// hosts is a failure of the test.
bool is_refused_namespaces() {
  const pid_t child = ::fork();
  if (child == 0) ::_exit(::unshare(CLONE_NEWNET) != 0 && errno == EPERM ? 1 : 0);
  int status = 0;
  return child > 0 && ::waitpid(child, &status, 0) == child && WIFEXITED(status) &&
         WEXITSTATUS(status) == 1;
}

class TwoHostsTest : public ::testing::Test {
 protected:
  void SetUp() override {
    if (is_refused_namespaces()) {
      GTEST_SKIP() << "the kernel refuses this user network namespaces (EPERM); run it as root";
    }
    hosts = std::make_unique<TwoHosts>();
    const auto made = run_program("prehend", {"keys", "create", keys}, 20s);
    ASSERT_EQ(made.exit_code, 0) << made.output;
  }

  std::unique_ptr<Launched> start(int host, const std::string& program,
                                  std::vector<std::string> arguments, const std::string& log) {
    const char* folder = std::getenv("PREHEND_BIN");
    const auto bin = std::filesystem::absolute(folder ? folder : "build/bin");
    auto words = hosts->on(host, bin / program);
    words.insert(words.end(), arguments.begin(), arguments.end());
    const std::string enter = words[0];
    words.erase(words.begin());
    return std::make_unique<Launched>(enter, words, scratch.path() / log);
  }
  void start_registry() {
    registry = start(0, "registry", {"--registry", endpoint, "--keys", keys}, "registry.log");
    ASSERT_TRUE(registry->wait_for_output("registry listens on", 20s)) << registry->output();
  }
  void start_nodes() {
    for (const int host : {0, 1}) {
      const std::string name = host == 0 ? "left" : "right";
      nodes[static_cast<std::size_t>(host)] =
          start(host, "two_hosts_node",
                {name, host == 0 ? "right" : "left", endpoint, keys, TwoHosts::address(host), go},
                name + ".log");
    }
    for (auto& node : nodes) ASSERT_TRUE(node->wait_for_output("joined", 40s)) << node->output();
  }
  /// The least growth of what any subscription received and any client was answered since `before`.
  std::uint64_t least_progress(const std::array<Counts, 2>& before) const {
    std::uint64_t least = ~std::uint64_t{0};
    for (const std::size_t i : {0u, 1u}) {
      const Counts now = counts_of(*nodes[i]);
      for (std::size_t topic = 0; topic < kTopics; ++topic) {
        least = std::min(least, now.topics[topic].received - before[i].topics[topic].received);
      }
      least = std::min({least, now.calls - before[i].calls, now.goals - before[i].goals});
    }
    return least;
  }
  std::array<Counts, 2> all_counts() const { return {counts_of(*nodes[0]), counts_of(*nodes[1])}; }
  /// Every message is accounted for at every subscription.
  bool balanced() const {
    const auto counts = all_counts();
    for (const std::size_t i : {0u, 1u}) {
      for (std::size_t topic = 0; topic < kTopics; ++topic) {
        const auto& mine = counts[i].topics[topic];
        if (mine.received + mine.missed != counts[1 - i].topics[topic].published) return false;
      }
    }
    return true;
  }
  std::string account() const {
    std::ostringstream text;
    const auto counts = all_counts();
    for (const std::size_t i : {0u, 1u}) {
      for (std::size_t topic = 0; topic < kTopics; ++topic) {
        const auto& mine = counts[i].topics[topic];
        text << (i == 0 ? "left" : "right") << " topic " << topic << ": published "
             << counts[1 - i].topics[topic].published << " received " << mine.received << " missed "
             << mine.missed << " delivered " << mine.delivered << " repeated " << mine.repeated
             << "\n";
      }
      text << "  calls " << counts[i].calls << " failed " << counts[i].failed_calls << ", goals "
           << counts[i].goals << " failed " << counts[i].failed_goals << "\n";
    }
    return text.str();
  }
  std::string logs() const { return nodes[0]->output() + nodes[1]->output(); }

  ScratchFolder scratch;
  std::string keys = scratch.path() / "graph.keys";
  std::filesystem::path go = scratch.path() / "go";
  std::string endpoint = "tcp://" + TwoHosts::address(0) + ":11411";
  std::unique_ptr<TwoHosts> hosts;
  std::unique_ptr<Launched> registry;
  std::array<std::unique_ptr<Launched>, 2> nodes;
};

TEST_F(TwoHostsTest, RecoversFromACutCableWithEveryLossCounted) {
  start_registry();
  start_nodes();
  std::ofstream(go) << "\n";
  const auto at_start = all_counts();
  ASSERT_TRUE(eventually([&] { return least_progress(at_start) >= 10; }, 40s)) << account();
  const auto before_cut = all_counts();
  for (const auto& counts : before_cut) {
    for (const auto& topic : counts.topics) EXPECT_EQ(topic.missed, 0u) << account();
  }

  hosts->cut_cable();
  std::this_thread::sleep_for(10s);
  const auto in_cut = all_counts();
  hosts->mend_cable();
  const auto mended = std::chrono::steady_clock::now();
  ASSERT_TRUE(eventually([&] { return least_progress(in_cut) >= 3; }, 30s)) << account() << logs();
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - mended;
  std::printf("all traffic flows again after %.1f s\n", took.count());

  std::filesystem::remove(go);
  EXPECT_TRUE(eventually([&] { return balanced(); }, 20s)) << account() << logs();
  std::printf("%s", account().c_str());
  std::uint64_t missed = 0;
  for (const auto& counts : all_counts()) {
    for (const auto& topic : counts.topics) {
      EXPECT_EQ(topic.repeated, 0u) << account();
      EXPECT_EQ(topic.damaged, 0u) << account();
      missed += topic.missed;
    }
    EXPECT_GT(counts.failed_calls, 0u);  // bounded: they ended, and the next ones succeeded
  }
  EXPECT_GT(missed, 100u);  // else nothing was cut
  const auto run = [&](std::vector<std::string> words, const std::string& log) {
    words.insert(words.end(), {"--registry", endpoint, "--keys", keys});
    const auto command = start(1, "prehend", words, log);
    EXPECT_EQ(command->wait(20s), 0) << command->output();
    return command->output();
  };
  const std::string listed = run({"node", "list"}, "list.log");
  EXPECT_NE(listed.find("left"), std::string::npos) << listed;
  EXPECT_NE(listed.find("right"), std::string::npos) << listed;
  run({"topic", "echo", "/left/latched", "-n", "1", "--bind", TwoHosts::address(1)}, "echo.log");
}

TEST_F(TwoHostsTest, WithoutTheKeysNobodyJoinsOverTheCable) {
  start_registry();
  const auto without = start(1, "prehend", {"node", "list", "--registry", endpoint}, "none.log");
  EXPECT_EQ(without->wait(20s), 1);
  EXPECT_NE(without->output().find("no keys are given"), std::string::npos) << without->output();
  const std::string others = scratch.path() / "other.keys";
  ASSERT_EQ(run_program("prehend", {"keys", "create", others}, 20s).exit_code, 0);
  const auto wrong = start(1, "two_hosts_node",
                           {"wrong", "x", endpoint, others, TwoHosts::address(1), go}, "wrong.log");
  EXPECT_EQ(wrong->wait(30s), 1);
  EXPECT_NE(wrong->output().find("has other keys"), std::string::npos) << wrong->output();
  EXPECT_TRUE(registry->wait_for_output("connections refused", 10s));
}

}  // namespace
}  // namespace prehend::testing
