// The emergency stop between its node and those who listen to it, in one process. What happens when
// processes die is in tests/system.

#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <limits>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "nodes/emergency_stop/emergency_stop_node.h"
#include "nodes/emergency_stop/required_nodes.h"
#include "nodes/emergency_stop/stop_state.h"
#include "nodes/emergency_stop_listener/emergency_stop_listener.h"
#include "prehend/graph/link/runtime_folder.h"
#include "prehend/graph/node.h"
#include "prehend/graph/registry.h"
#include "tests/drivers/eventually.h"

namespace prehend::nodes {
namespace {

using namespace std::chrono_literals;
using drivers::eventually;
using std::chrono::steady_clock;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;

msgs::EmergencyStopRequest request(const std::string& source, const std::string& reason,
                                   bool persists = false) {
  msgs::EmergencyStopRequest message;
  message.set_source(source);
  message.set_reason(reason);
  message.set_persists(persists);
  return message;
}

// --- StopState ----------------------------------------------------------------------------------

TEST(StopState, TheFirstWhoAsksIsNamedUntilItIsReset) {
  StopState state;
  const steady_clock::time_point now{};
  EXPECT_FALSE(state.message().stopped());
  EXPECT_TRUE(state.stop(request("jog", "a key"), now, 7));
  EXPECT_TRUE(state.stop(request("prehend stop", "again"), now, 8));
  EXPECT_TRUE(state.message().stopped());
  EXPECT_EQ(state.message().source(), "jog");
  EXPECT_EQ(state.message().reason(), "a key");
  EXPECT_EQ(state.message().since(), 7);
  EXPECT_EQ(state.message().count(), 2u) << "who presses again is heard again";
  EXPECT_THAT(state.reset(now), IsEmpty());
  EXPECT_FALSE(state.message().stopped());
  EXPECT_THAT(state.message().source(), IsEmpty());
  EXPECT_EQ(state.message().count(), 2u);
}

TEST(StopState, IsNotResetWhileItsCausePersists) {
  StopState state;
  steady_clock::time_point now{};
  EXPECT_TRUE(state.stop(request("sdh", "off", true), now, 0));
  for (int i = 0; i < 10; ++i) {
    now += 100ms;
    EXPECT_FALSE(state.stop(request("sdh", "off", true), now, 0)) << "told already";
    EXPECT_THAT(state.reset(now), HasSubstr("sdh: off"));
    EXPECT_TRUE(state.message().stopped());
  }
  EXPECT_EQ(state.message().count(), 1u);
  now += StopState::kPersistence + 1ms;
  EXPECT_THAT(state.reset(now), IsEmpty());
  EXPECT_FALSE(state.message().stopped());
}

TEST(StopState, ACauseThatPersistsStopsAnewAfterAReset) {
  StopState state;
  steady_clock::time_point now{};
  state.stop(request("sdh", "off", true), now, 0);
  now += StopState::kPersistence + 1ms;
  ASSERT_THAT(state.reset(now), IsEmpty());
  EXPECT_TRUE(state.stop(request("sdh", "off", true), now, 0));
  EXPECT_TRUE(state.message().stopped());
}

TEST(StopState, StopsWhateverTheWordsAre) {
  StopState state;
  EXPECT_TRUE(state.stop({}, {}, std::numeric_limits<std::int64_t>::min()));
  EXPECT_TRUE(state.message().stopped());
  EXPECT_EQ(state.message().source(), "somebody");
  ASSERT_THAT(state.reset({}), IsEmpty());
  std::string umlauts;
  for (int i = 0; i < 100000; ++i) umlauts += "\xC3\xA4";
  EXPECT_TRUE(state.stop(request("x" + umlauts, umlauts), {}, 0));
  EXPECT_LE(state.message().reason().size(), StopState::kLongestText);
  // Cut between characters: "x" makes the source's an odd number of bytes.
  EXPECT_EQ(state.message().source().size() % 2, 1u);
  EXPECT_EQ(state.message().reason().size() % 2, 0u);
  // Names that somebody invents fill no memory.
  for (int i = 0; i < 5000; ++i) state.stop(request(std::to_string(i), "", true), {}, 0);
  EXPECT_LT(state.reset({}).size(), 20000u);
}

// --- RequiredNodes ------------------------------------------------------------------------------

msgs::graph::NodeRecord record(const std::string& name, pid_t pid, const std::string& instance) {
  msgs::graph::NodeRecord node;
  node.set_name(name);
  node.set_pid(pid);
  node.set_instance(instance);
  node.set_process_space(graph::process_space());
  return node;
}

/// A process that does nothing until it is killed.
class Idle {
 public:
  Idle() : pid_(::fork()) {
    if (pid_ != 0) return;
    ::alarm(60);
    while (true) ::pause();
  }
  ~Idle() { kill(); }
  void kill() {
    if (pid_ <= 0) return;
    ::kill(pid_, SIGKILL);
    ::waitpid(pid_, nullptr, 0);
    pid_ = -1;
  }
  pid_t pid() const { return pid_; }

 private:
  pid_t pid_;
};

/// Nobody tells it of nodes but the test: no registry listens there.
constexpr const char* kNobody = "tcp://127.0.0.1:1";

std::vector<std::string> words_of(const std::vector<RequiredNodes::Loss>& losses) {
  std::vector<std::string> words;
  for (const auto& loss : losses) words.push_back(loss.node + ": " + loss.reason);
  return words;
}

TEST(RequiredNodes, TheDeathOfAProcessIsALoss) {
  Idle process;
  RequiredNodes nodes({"pg70", "sdh"}, "", kNobody);
  EXPECT_EQ(nodes.missing(), "pg70, sdh");
  EXPECT_THAT(nodes.wait_for_losses(0ms), IsEmpty()) << "who never came is not lost";
  nodes.take({record("pg70", process.pid(), "a")}, steady_clock::now());
  EXPECT_EQ(nodes.missing(), "sdh");
  EXPECT_THAT(nodes.wait_for_losses(0ms), IsEmpty());
  process.kill();
  EXPECT_THAT(words_of(nodes.wait_for_losses(10s)), ElementsAre("pg70: its process ended"));
  EXPECT_EQ(nodes.away(), "pg70");
  // The registry has not seen it yet.
  nodes.take({record("pg70", 999999999, "a")}, steady_clock::now());
  EXPECT_EQ(nodes.away(), "pg70");
  const Idle again;
  nodes.take({record("pg70", again.pid(), "b")}, steady_clock::now());
  EXPECT_THAT(nodes.away(), IsEmpty());
  EXPECT_THAT(nodes.wait_for_losses(0ms), IsEmpty());
}

TEST(RequiredNodes, AnotherInstanceIsALossOfTheOneBefore) {
  const Idle one, two;
  RequiredNodes nodes({"pg70"}, "", kNobody);
  nodes.take({record("pg70", one.pid(), "a")}, steady_clock::now());
  nodes.take({record("pg70", two.pid(), "b")}, steady_clock::now());
  EXPECT_THAT(words_of(nodes.wait_for_losses(0ms)),
              ElementsAre("pg70: it ended and was started again"));
  EXPECT_THAT(nodes.away(), IsEmpty());
}

TEST(RequiredNodes, OneThatHangsOrLeavesIsLostAndMayComeBack) {
  const Idle process;
  RequiredNodes nodes({"pg70"}, "", kNobody);
  auto now = steady_clock::now() + 1h;  // whatever its own thread, which finds no registry, says
  auto seen = record("pg70", process.pid(), "a");
  nodes.take({seen}, now);
  seen.set_silence(std::chrono::nanoseconds(RequiredNodes::kSilence + 1ms).count());
  nodes.take({seen}, now);
  EXPECT_THAT(words_of(nodes.wait_for_losses(0ms)), ElementsAre(HasSubstr("not heard for 2.5 s")));
  EXPECT_EQ(nodes.away(), "pg70");
  seen.set_silence(0);
  nodes.take({seen}, now);
  EXPECT_THAT(nodes.away(), IsEmpty());
}

TEST(RequiredNodes, ARegistryThatKnowsNobodyYetIsNoLoss) {
  const Idle process;
  RequiredNodes nodes({"pg70"}, "", kNobody);
  auto now = steady_clock::now() + 1h;
  nodes.take({record("pg70", process.pid(), "a")}, now);
  nodes.take({}, now + 1s);
  EXPECT_THAT(nodes.wait_for_losses(0ms), IsEmpty());
  nodes.take({record("pg70", process.pid(), "a")}, now + 2s);
  nodes.take({}, now + 4s);
  EXPECT_THAT(nodes.wait_for_losses(0ms), IsEmpty());
}

TEST(RequiredNodes, ThoseOfItsOwnNamespaceAreMeant) {
  const Idle process;
  RequiredNodes nodes({"pg70"}, "left_", kNobody);
  nodes.take({record("right_pg70", process.pid(), "r")}, steady_clock::now());
  EXPECT_EQ(nodes.missing(), "pg70");
  nodes.take({record("left_pg70", process.pid(), "l")}, steady_clock::now());
  EXPECT_THAT(nodes.missing(), IsEmpty());
}

TEST(RequiredNodes, RefusesNamesThatCannotBeMeant) {
  EXPECT_THROW(RequiredNodes({""}, "", kNobody), std::invalid_argument);
  EXPECT_THROW(RequiredNodes({"a", "a"}, "", kNobody), std::invalid_argument);
}

// --- node and listeners -------------------------------------------------------------------------

class EmergencyStopGraph : public ::testing::Test {
 protected:
  graph::NodeOptions options(const std::string& name) const {
    graph::NodeOptions options;
    options.name = name;
    options.registry = registry_.endpoint();
    options.log_level = graph::LogLevel::kError;
    return options;
  }
  graph::Registry registry_{{.endpoint = "tcp://127.0.0.1:*"}};
};

/// What `make` makes, once the registry knows that a node of its name has left, which on a busy
/// machine it may not have heard before the lease of that one is over.
template <class Made>
std::unique_ptr<Made> made_again(const std::function<std::unique_ptr<Made>()>& make) {
  const auto end = steady_clock::now() + 20s;
  while (true) {
    try {
      return make();
    } catch (const std::runtime_error&) {
      if (steady_clock::now() > end) throw;
    }
    std::this_thread::sleep_for(50ms);
  }
}

/// The node emergency_stop, alive.
class Server {
 public:
  Server(graph::NodeOptions options, const std::vector<std::string>& required = {})
      : node_(options), server_(node_, required, options.registry) {
    node_.spin_in_background();
  }
  std::string missing() const { return server_.missing(); }

 private:
  graph::Node node_;
  EmergencyStopNode server_;
};

/// A node that moves something.
class Mover {
 public:
  explicit Mover(const graph::NodeOptions& options, bool is_minded = true)
      : node_(options),
        listener_(node_, is_minded),
        action_(listener_.on_stop([this](const std::string& why) {
          const std::lock_guard lock(mutex_);
          EXPECT_EQ(why.empty(), false);
          stops_.push_back(why);
        })),
        stop_(node_.client<msgs::EmergencyStopRequest, msgs::Acknowledge>("/emergency_stop/stop")),
        reset_(node_.client<msgs::Empty, msgs::Acknowledge>("/emergency_stop/reset")) {
    node_.spin_in_background();
  }
  ~Mover() { node_.shutdown(); }
  std::vector<std::string> stops() const {
    const std::lock_guard lock(mutex_);
    return stops_;
  }
  std::string refusal() const { return listener_.refusal(); }
  bool is_stopped() const { return !refusal().empty(); }
  EmergencyStopListener& listener() { return listener_; }
  graph::Node& node() { return node_; }
  msgs::Acknowledge stop(const std::string& source, const std::string& reason) const {
    const auto outcome = stop_.call(request(source, reason), 20s);
    EXPECT_TRUE(outcome) << outcome.error();
    return outcome ? *outcome : msgs::Acknowledge();
  }
  msgs::Acknowledge reset() const {
    const auto outcome = reset_.call({}, 20s);
    EXPECT_TRUE(outcome) << outcome.error();
    return outcome ? *outcome : msgs::Acknowledge();
  }

 private:
  graph::Node node_;
  mutable std::mutex mutex_;
  std::vector<std::string> stops_;
  EmergencyStopListener listener_;
  EmergencyStopListener::Action action_;
  graph::ServiceClient<msgs::EmergencyStopRequest, msgs::Acknowledge> stop_;
  graph::ServiceClient<msgs::Empty, msgs::Acknowledge> reset_;
};

TEST_F(EmergencyStopGraph, WithoutSuchANodeNothingChanges) {
  const Mover mover(options("mover"));
  std::this_thread::sleep_for(2 * EmergencyStopListener::kSilence);
  EXPECT_THAT(mover.refusal(), IsEmpty());
  EXPECT_THAT(mover.stops(), IsEmpty());
}

TEST_F(EmergencyStopGraph, StopsEverybodyUntilItIsReset) {
  const Server server(options("emergency_stop"));
  const Mover arm(options("arm")), hand(options("hand"));
  const Mover wired(options("wired"), false);
  EXPECT_TRUE(arm.stop("jog", "the space key").success());
  for (const Mover* mover : {&arm, &hand}) {
    ASSERT_TRUE(eventually([&] { return mover->is_stopped() && !mover->stops().empty(); }));
    EXPECT_EQ(mover->refusal(), "emergency stop by jog: the space key");
    EXPECT_THAT(mover->stops(), ElementsAre("emergency stop by jog: the space key"));
  }
  const Mover late(options("late"));
  ASSERT_TRUE(eventually([&] { return late.is_stopped(); })) << "who comes later is told, too";
  std::this_thread::sleep_for(2 * EmergencyStopListener::kSilence);
  EXPECT_TRUE(arm.is_stopped()) << "it ends by reset alone";
  EXPECT_EQ(arm.stops().size(), 1u) << "repetitions are no stops";
  EXPECT_TRUE(arm.reset().success());
  for (const Mover* mover : {&arm, &hand, &late}) {
    EXPECT_TRUE(eventually([&] { return !mover->is_stopped(); }));
  }
  EXPECT_EQ(arm.reset().reason(), "nothing was stopped");
  EXPECT_TRUE(hand.stop("prehend stop", "").success());
  ASSERT_TRUE(eventually([&] { return arm.stops().size() == 2; }));
  EXPECT_EQ(arm.refusal(), "emergency stop by prehend stop");
  EXPECT_THAT(wired.stops(), IsEmpty()) << "its driver minds it";
}

TEST_F(EmergencyStopGraph, WhoAsksAgainStopsAgain) {
  const Server server(options("emergency_stop"));
  const Mover mover(options("mover"));
  mover.stop("a", "1");
  ASSERT_TRUE(eventually([&] { return mover.stops().size() == 1; }));
  EXPECT_THAT(mover.stop("b", "2").reason(), HasSubstr("stopped already, by a: 1"));
  ASSERT_TRUE(eventually([&] { return mover.stops().size() == 2; }));
  EXPECT_EQ(mover.refusal(), "emergency stop by a: 1");
}

TEST_F(EmergencyStopGraph, TheSilenceOfItsNodeIsAStopThatAnotherNodeTakesOver) {
  auto server = std::make_unique<Server>(options("emergency_stop"));
  const Mover mover(options("mover")), other(options("other"));
  // It has been heard.
  mover.stop("test", "");
  ASSERT_TRUE(eventually([&] { return mover.is_stopped() && other.is_stopped(); }));
  mover.reset();
  ASSERT_TRUE(eventually([&] { return !mover.is_stopped() && !other.is_stopped(); }));
  server.reset();
  ASSERT_TRUE(eventually([&] { return mover.is_stopped() && mover.stops().size() == 2; }));
  EXPECT_THAT(mover.refusal(), HasSubstr("the node emergency_stop was not heard for 0.3 s"));
  ASSERT_TRUE(eventually([&] { return other.is_stopped(); }));
  // A new one knows nothing of it, and is told.
  server = made_again<Server>([&] { return std::make_unique<Server>(options("emergency_stop")); });
  ASSERT_TRUE(eventually([&] { return mover.refusal().starts_with("emergency stop by "); }))
      << mover.refusal();
  EXPECT_THAT(mover.refusal(), HasSubstr("was not heard"));
  EXPECT_TRUE(mover.reset().success());
  EXPECT_TRUE(eventually([&] { return !mover.is_stopped() && !other.is_stopped(); }));
}

TEST_F(EmergencyStopGraph, AStopOutlivesTheNodeThatSaidIt) {
  auto server = std::make_unique<Server>(options("emergency_stop"));
  const Mover mover(options("mover"));
  mover.stop("test", "a hand in the cell");
  ASSERT_TRUE(eventually([&] { return mover.is_stopped(); }));
  server.reset();
  server = made_again<Server>([&] { return std::make_unique<Server>(options("emergency_stop")); });
  // Told by whom it was stopped before, the new node says so to those who come now.
  const Mover late(options("late"));
  ASSERT_TRUE(eventually([&] { return late.is_stopped(); }));
  EXPECT_THAT(late.refusal(), HasSubstr("a hand in the cell"));
  EXPECT_TRUE(mover.is_stopped());
  EXPECT_TRUE(mover.reset().success());
  EXPECT_TRUE(eventually([&] { return !mover.is_stopped() && !late.is_stopped(); }));
}

TEST_F(EmergencyStopGraph, AStopThatWasResetBeforeItWasHeardStopsOnce) {
  graph::Node node(options("emergency_stop"));
  auto publisher = node.advertise<msgs::EmergencyStop>("/emergency_stop", graph::QoS::latched(1));
  node.spin_in_background();
  const Mover mover(options("mover"));
  publisher.wait_for_subscribers(1, 20s);
  msgs::EmergencyStop message;
  message.set_count(3);
  publisher.publish(message);
  std::this_thread::sleep_for(100ms);
  EXPECT_THAT(mover.stops(), IsEmpty()) << "stops before it came are not its own";
  message.set_count(4);
  publisher.publish(message);
  ASSERT_TRUE(eventually([&] { return mover.stops().size() == 1; }));
  EXPECT_THAT(mover.stops().front(), HasSubstr("reset already"));
}

TEST_F(EmergencyStopGraph, ACallbackThatWaitsHasNotHeardSilence) {
  const Server server(options("emergency_stop"));
  Mover mover(options("mover"));
  mover.stop("test", "");
  ASSERT_TRUE(eventually([&] { return mover.is_stopped(); }));
  mover.reset();
  ASSERT_TRUE(eventually([&] { return !mover.is_stopped(); }));
  const auto service =
      mover.node().serve<msgs::Empty, msgs::Acknowledge>("/waits", [&](const msgs::Empty&) {
        const EmergencyStopListener::Wait wait(mover.listener());
        std::this_thread::sleep_for(3 * EmergencyStopListener::kSilence);
        return msgs::Acknowledge();
      });
  EXPECT_TRUE((mover.node().client<msgs::Empty, msgs::Acknowledge>("/waits").call({}, 20s)));
  EXPECT_EQ(mover.stops().size(), 1u);
  EXPECT_FALSE(mover.is_stopped());
}

TEST_F(EmergencyStopGraph, ADeviceThatStandsStillByItselfStopsEverythingAndIsNamed) {
  const Server server(options("emergency_stop"));
  Mover hand(options("sdh"));
  const Mover arm(options("kuka_rsi"));
  arm.stop("test", "");
  ASSERT_TRUE(eventually([&] { return hand.is_stopped() && arm.is_stopped(); }));
  arm.reset();
  ASSERT_TRUE(eventually([&] { return !hand.is_stopped() && !arm.is_stopped(); }));
  hand.listener().tell_device("");
  std::atomic<bool> is_off = true;
  std::thread driver([&] {
    while (is_off) {
      hand.listener().tell_device("its supply is off");
      std::this_thread::sleep_for(50ms);
    }
  });
  ASSERT_TRUE(eventually([&] { return arm.is_stopped(); }));
  EXPECT_EQ(arm.refusal(), "emergency stop by sdh: its supply is off");
  const msgs::Acknowledge refused = arm.reset();
  EXPECT_FALSE(refused.success());
  EXPECT_THAT(refused.reason(), AllOf(HasSubstr("goes on"), HasSubstr("sdh: its supply is off")));
  EXPECT_TRUE(arm.is_stopped());
  is_off = false;
  driver.join();
  EXPECT_TRUE(eventually([&] { return arm.reset().success(); }));
  EXPECT_TRUE(eventually([&] { return !arm.is_stopped() && !hand.is_stopped(); }));
}

TEST_F(EmergencyStopGraph, ARequiredNodeThatLeavesStopsAndIsNamedByTheReset) {
  const Server server(options("emergency_stop"), {"pad"});
  const Mover arm(options("arm"));
  auto pad = std::make_unique<graph::Node>(options("pad"));
  pad->spin_in_background();
  ASSERT_TRUE(eventually([&] { return server.missing().empty(); }));
  EXPECT_THAT(arm.refusal(), IsEmpty());
  pad.reset();  // its process, this one, lives
  ASSERT_TRUE(eventually([&] { return arm.is_stopped(); }));
  EXPECT_THAT(arm.refusal(), StartsWith("emergency stop by emergency_stop: required node pad was "
                                        "lost"));
  const msgs::Acknowledge refused = arm.reset();
  EXPECT_FALSE(refused.success());
  EXPECT_THAT(refused.reason(), HasSubstr("pad is required, and was lost"));
  pad = made_again<graph::Node>([&] { return std::make_unique<graph::Node>(options("pad")); });
  pad->spin_in_background();
  EXPECT_TRUE(eventually([&] { return arm.reset().success(); }));
  EXPECT_TRUE(eventually([&] { return !arm.is_stopped(); }));
}

}  // namespace
}  // namespace prehend::nodes
