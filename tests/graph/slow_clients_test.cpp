// Clients that ask for much and do not read it: what waits for them is bounded, and they are told.

#include <map>

#include "prehend/graph/introspection.h"
#include "prehend/graph/link/frames.h"
#include "prehend/graph/schema.h"
#include "tests/graph/test_graph.h"

namespace prehend::graph {
namespace {

using msgs::graph::PeerMessage;

// What waits in sockets besides the 10 000 that a node keeps for one client at most.
constexpr std::uint64_t kMostKept = 20'000;

/// A peer of one node, which takes as little as can be until it is read.
class LazyPeer {
 public:
  LazyPeer(const std::string& registry, const std::string& node)
      : socket_(context_, zmq::socket_type::dealer) {
    socket_.set(zmq::sockopt::routing_id, "lazy_peer");
    socket_.set(zmq::sockopt::rcvhwm, 1);
    socket_.set(zmq::sockopt::sndhwm, 100);
    socket_.set(zmq::sockopt::linger, 0);
    Introspection look(registry);
    std::map<std::string, std::string> endpoints;
    EXPECT_TRUE(eventually([&] {
      for (const auto& record : look.nodes()) endpoints[record.name()] = record.endpoint();
      return !endpoints[node].empty();
    }));
    socket_.connect(endpoints[node]);
  }

  void ask(const PeerMessage& message) {
    socket_.send(zmq::message_t(), zmq::send_flags::sndmore);
    socket_.send(zmq::message_t(message.SerializeAsString()), zmq::send_flags::none);
  }
  void ask_for_parameters(std::uint64_t id) {
    PeerMessage message;
    message.mutable_parameter_request()->set_id(id);
    ask(message);
  }
  /// The next message; one without content when none comes within 10 s.
  PeerMessage read() {
    PeerMessage message;
    const auto deadline = std::chrono::steady_clock::now() + 10s;
    while (std::chrono::steady_clock::now() < deadline) {
      const Frames frames = receive(socket_);
      if (frames.size() == 2) {
        message.ParseFromArray(frames[1].data(), static_cast<int>(frames[1].size()));
        return message;
      }
      std::this_thread::sleep_for(50us);
    }
    return message;
  }

 private:
  zmq::context_t context_;
  zmq::socket_t socket_;
};

class SlowClients : public GraphTest {
 protected:
  SlowClients() {
    registry.reset();  // one whose leases outlast a stopped process
    registry = std::make_unique<Registry>(
        RegistryOptions{.endpoint = "tcp://127.0.0.1:*", .lease = std::chrono::seconds(120)});
    endpoint = registry->endpoint();
  }
};

// 150 000 requests made a node grow by 173 MB.
TEST_F(SlowClients, AnswersForOneThatDoesNotReadAreBoundedAndItIsTold) {
  constexpr std::uint64_t kRequests = 60'000;
  Node node(options("node"));
  node.declare_parameter<int>({.name = "gain", .description = std::string(300, 'x')});
  LogReader log(options("log"));
  Node user(options("user"));
  std::atomic<std::uint64_t> told_dropped = 0;
  const auto statistics = user.subscribe<msgs::graph::NodeStatistics>(
      "/statistics", QoS::queue(100), [&](const Received<msgs::graph::NodeStatistics>& m) {
        if (m->node() == "node") told_dropped = m->control_dropped();
      });
  user.spin_in_background();
  LazyPeer peer(endpoint, "node");
  for (std::uint64_t id = 1; id <= kRequests; ++id) peer.ask_for_parameters(id);
  ASSERT_TRUE(
      eventually([&] { return log.has("lazy_peer does not read what it asked for"); }, 60s));
  EXPECT_TRUE(eventually([&] { return told_dropped > kRequests - kMostKept; }, 60s));

  std::uint64_t answers = 0, dropped = 0;
  while (answers + dropped < kRequests) {
    const PeerMessage message = peer.read();
    ASSERT_NE(message.content_case(), PeerMessage::CONTENT_NOT_SET)
        << answers << " answers and word of " << dropped << " dropped ones";
    if (message.has_dropped()) dropped += message.dropped().messages();
    if (message.has_parameter_answer()) ++answers;
  }
  EXPECT_LT(answers, kMostKept);
  EXPECT_EQ(answers + dropped, kRequests) << "none is missing silently";
  EXPECT_EQ(log.count("lazy_peer does not read"), 1u);
  peer.ask_for_parameters(kRequests + 1);
  EXPECT_EQ(peer.read().parameter_answer().id(), kRequests + 1) << "it reads, and is served again";
}

TEST_F(SlowClients, FeedbackForOneThatDoesNotReadIsBoundedAndTheGoalCancelled) {
  Node node(options("node"));
  std::atomic<std::uint64_t> poured = 0;
  std::atomic<bool> cancelled = false;
  const auto action = node.serve_action<msgs::Clock, msgs::Clock, msgs::Clock>(
      "/pour", [&](const msgs::Clock& goal, ActionContext<msgs::Clock>& context) {
        while (!context.cancelled() && poured < 3'000'000) {
          context.feedback(goal);
          ++poured;
        }
        cancelled = context.cancelled();
        return goal;
      });
  node.spin_in_background();
  LogReader log(options("log"));
  LazyPeer peer(endpoint, "node");
  PeerMessage message;
  auto& goal = *message.mutable_goal();
  goal.set_id(7);
  goal.set_action("/pour");
  goal.set_goal_hash(schema_of(*msgs::Clock::descriptor())->hash);
  goal.set_body(clock_message(1).SerializeAsString());
  peer.ask(message);
  ASSERT_TRUE(
      eventually([&] { return log.has("lazy_peer does not read what it asked for"); }, 60s));
  EXPECT_TRUE(eventually([&] { return cancelled.load(); }, 60s));
  std::uint64_t feedback = 0;
  for (message = peer.read(); message.has_feedback(); message = peer.read()) ++feedback;
  ASSERT_TRUE(message.has_dropped());
  EXPECT_LT(feedback, kMostKept);
  EXPECT_GT(message.dropped().messages(), 9'000u);
}

// A node that was stopped for a while (SIGSTOP, a debugger) takes part again.
TEST_F(SlowClients, ANodeThatWasGivenUpSaysSoAndSubscribesAgain) {
  Node node(options("node"));
  std::atomic<bool> begun = false, go_on = false;
  const auto action = node.serve_action<msgs::Clock, msgs::Clock, msgs::Clock>(
      "/pour", [&](const msgs::Clock& goal, ActionContext<msgs::Clock>& context) {
        begun = true;
        while (!go_on) std::this_thread::sleep_for(1ms);
        for (int i = 0; i < 3'000'000 && !context.cancelled(); ++i) context.feedback(goal);
        return goal;
      });
  const auto numbers = node.advertise<msgs::Clock>("/numbers", QoS::queue(10));
  std::atomic<std::int64_t> ended = -1, heard = 0;
  const auto ends = node.subscribe<msgs::Clock>(
      "/ended", QoS::latched(1), [&](const Received<msgs::Clock>& m) { ended = m->time(); });
  const auto echoes = node.subscribe<msgs::Clock>(
      "/heard", QoS::queue(1000), [&](const Received<msgs::Clock>& m) { heard = m->time(); });
  node.spin_in_background();
  LogReader log(options("log"));
  Child child({"take_part", "--registry", endpoint});
  ASSERT_TRUE(eventually([&] { return begun.load(); }, 20s));
  ASSERT_TRUE(numbers.wait_for_subscribers(1, 20s));
  child.send(SIGSTOP);
  go_on = true;
  const bool given_up = eventually([&] { return log.has("does not read what it asked for"); }, 60s);
  child.send(SIGCONT);
  ASSERT_TRUE(given_up);
  EXPECT_TRUE(eventually([&] { return ended == static_cast<int>(Status::kServerGone); }, 20s));
  EXPECT_TRUE(eventually([&] { return log.has("has thrown away"); }, 20s));
  std::int64_t number = 0;
  EXPECT_TRUE(eventually(
      [&] {
        numbers.publish(clock_message(++number));
        return heard > 0;
      },
      20s));
}

}  // namespace
}  // namespace prehend::graph
