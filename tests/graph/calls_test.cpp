#include "tests/graph/test_graph.h"

namespace prehend::graph {
namespace {

using Clock_ = msgs::Clock;

class Services : public GraphTest {};

TEST_F(Services, AnswersAndErrorsReachTheCaller) {
  Node server(options("server")), caller(options("caller"));
  auto service = server.serve<Clock_, Clock_>("/half", [](const Clock_& request) -> Clock_ {
    if (request.time() % 2) throw std::runtime_error("odd numbers have no half");
    return clock_message(request.time() / 2);
  });
  server.spin_in_background();
  auto client = caller.client<Clock_, Clock_>("/half");
  const auto good = client.call(clock_message(8), 5s);
  ASSERT_TRUE(good.ok()) << good.error();
  EXPECT_EQ(good->time(), 4);
  const auto bad = client.call(clock_message(7), 5s);
  EXPECT_EQ(bad.status(), Status::kFailed);
  EXPECT_EQ(bad.error(), "service /half failed: odd numbers have no half");
  EXPECT_THROW(bad.value(), std::runtime_error);
  EXPECT_TRUE(client.call(clock_message(2), 5s).ok());  // it goes on
}

TEST_F(Services, ACallWaitsForItsServer) {
  Node caller(options("caller"));
  auto client = caller.client<Clock_, Clock_>("/answer");
  EXPECT_FALSE(client.wait_for_server(50ms));
  const auto none = client.call(clock_message(1), 100ms);
  EXPECT_EQ(none.status(), Status::kTimeout);
  EXPECT_EQ(none.error(), "service /answer: nobody serves it (waited 0.1 s)");
  Child server({"serve", "--registry", endpoint});
  const auto later = client.call(clock_message(1), 10s);
  ASSERT_TRUE(later.ok()) << later.error();
  EXPECT_EQ(later->time(), 2);
}

// It had mostly given up before anybody looked.
TEST_F(Services, ALookFindsTheServerThatIsThere) {
  Node caller(options("caller"));
  auto client = caller.client<Clock_, Clock_>("/answer");
  auto nobody = caller.client<Clock_, Clock_>("/nobody");
  Child server({"serve", "--registry", endpoint});
  ASSERT_TRUE(client.wait_for_server(10s));
  for (int i = 0; i < 200; ++i) {
    ASSERT_TRUE(client.wait_for_server(0s)) << i;
    ASSERT_FALSE(nobody.wait_for_server(0s)) << i;
  }
}

TEST_F(Services, SlowServerTimesOutAndKilledServerIsNoticedAtOnce) {
  Node caller(options("caller"));
  Child server({"serve", "--registry", endpoint});
  auto client = caller.client<Clock_, Clock_>("/hang");
  ASSERT_TRUE(client.wait_for_server(10s));
  const auto slow = client.call(clock_message(1), 200ms);
  EXPECT_EQ(slow.status(), Status::kTimeout);
  EXPECT_NE(slow.error().find("'test_serve' did not answer"), std::string::npos) << slow.error();
  std::thread killer([&] {
    std::this_thread::sleep_for(200ms);
    server.send(SIGKILL);
  });
  const auto begin = std::chrono::steady_clock::now();
  const auto gone = client.call(clock_message(1), 30s);
  killer.join();
  EXPECT_EQ(gone.status(), Status::kServerGone) << gone.error();
  EXPECT_LT(std::chrono::steady_clock::now() - begin, 5s);
}

TEST_F(Services, OtherTypesAreRefused) {
  Node server(options("server")), caller(options("caller"));
  auto service = server.serve<Clock_, Clock_>("/x", [](const Clock_& request) { return request; });
  server.spin_in_background();
  auto client = caller.client<Clock_, msgs::GripperState>("/x");
  const auto outcome = client.call(clock_message(1), 5s);
  EXPECT_EQ(outcome.status(), Status::kFailed);
  EXPECT_NE(outcome.error().find("other message types"), std::string::npos) << outcome.error();
}

TEST_F(Services, ShutdownEndsCalls) {
  Node caller(options("caller"));
  auto client = caller.client<Clock_, Clock_>("/nobody");
  std::thread stopper([&] {
    std::this_thread::sleep_for(100ms);
    caller.shutdown();
  });
  EXPECT_EQ(client.call(clock_message(1), 30s).status(), Status::kShutdown);
  stopper.join();
}

class Actions : public GraphTest {
 protected:
  // Counts to the goal, 1 ms each, with feedback; the result is how far it came.
  static Clock_ count(const Clock_& goal, ActionContext<Clock_>& context) {
    std::int64_t i = 0;
    while (i < goal.time() && context.sleep_for(1ms)) context.feedback(clock_message(++i));
    if (goal.time() < 0) throw std::runtime_error("cannot count down");
    return clock_message(i);
  }
  ActionServer serve(Node& node) {
    return node.serve_action<Clock_, Clock_, Clock_>("/count", &Actions::count);
  }
  static auto client_of(Node& node) { return node.action_client<Clock_, Clock_, Clock_>("/count"); }
};

TEST_F(Actions, FeedbackThenResult) {
  Node server(options("server")), user(options("user"));
  auto action = serve(server);
  Inbox feedback;  // delivered by wait(): this node does not spin
  const auto goal =
      client_of(user).send(clock_message(20), [&](const Clock_& f) { feedback.add(f.time()); });
  EXPECT_EQ(goal.wait(1ms).status(), Status::kTimeout);
  const auto result = goal.wait(10s);
  ASSERT_TRUE(result.ok()) << result.error();
  EXPECT_EQ(result->time(), 20);
  ASSERT_EQ(feedback.size(), 20u);
  EXPECT_EQ(feedback.values().back(), 20);
  const auto failed = client_of(user).send(clock_message(-1)).wait(5s);
  EXPECT_EQ(failed.status(), Status::kFailed);
  EXPECT_EQ(failed.error(), "action /count failed: cannot count down");
}

TEST_F(Actions, NoFeedbackAfterCancelHasReturned) {
  Node server(options("server")), user(options("user"));
  auto action = serve(server);
  user.spin_in_background();
  auto client = client_of(user);
  for (int round = 0; round < 20; ++round) {
    std::atomic<bool> cancelled = false;
    std::atomic<int> early = 0, late = 0;
    const auto goal =
        client.send(clock_message(1000000), [&](const Clock_&) { ++(cancelled ? late : early); });
    ASSERT_TRUE(eventually([&] { return early > 2; }));
    goal.cancel();
    cancelled = true;
    const auto result = goal.wait(5s);
    EXPECT_EQ(result.status(), Status::kCancelled) << result.error();
    EXPECT_GT(result->time(), 2);  // the handler's last word comes all the same
    EXPECT_EQ(late, 0);
  }
}

TEST_F(Actions, ANewGoalPreemptsTheOld) {
  Node server(options("server")), user(options("user")), other(options("other"));
  auto action = serve(server);
  user.spin_in_background();
  std::atomic<int> feedback = 0;
  const auto old = client_of(user).send(clock_message(1000000), [&](const Clock_&) { ++feedback; });
  ASSERT_TRUE(eventually([&] { return feedback > 0; }));
  const auto fresh = client_of(other).send(clock_message(5));
  EXPECT_EQ(old.wait(5s).status(), Status::kPreempted);
  EXPECT_EQ(fresh.wait(5s)->time(), 5);
}

TEST_F(Actions, KilledServerEndsTheGoal) {
  Node user(options("user"));
  user.spin_in_background();
  Child server({"serve", "--registry", endpoint});
  std::atomic<int> feedback = 0;
  auto client = user.action_client<Clock_, Clock_, Clock_>("/hang_action");
  const auto goal = client.send(clock_message(1), [&](const Clock_&) { ++feedback; });
  ASSERT_TRUE(eventually([&] { return feedback == 1; }, 10s));
  server.send(SIGKILL);
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_EQ(goal.wait(30s).status(), Status::kServerGone);
  EXPECT_LT(std::chrono::steady_clock::now() - begin, 5s);
}

TEST_F(Actions, KilledClientCancelsItsGoal) {
  Node server(options("server"));
  std::atomic<int> started = 0, cancelled = 0;
  auto action = server.serve_action<Clock_, Clock_, Clock_>(
      "/count", [&](const Clock_& goal, ActionContext<Clock_>& context) {
        ++started;
        while (context.sleep_for(1s)) {
        }
        ++cancelled;
        return goal;
      });
  Child client({"command", "--registry", endpoint});
  ASSERT_TRUE(eventually([&] { return started == 1; }, 10s));
  client.send(SIGKILL);
  EXPECT_TRUE(eventually([&] { return cancelled == 1; }));
}

TEST_F(Actions, WithoutAServerAGoalWaitsAndCanBeCancelled) {
  Node user(options("user"));
  const auto goal = client_of(user).send(clock_message(1));
  EXPECT_EQ(goal.wait(50ms).status(), Status::kTimeout);
  goal.cancel();
  EXPECT_EQ(goal.wait(5s).status(), Status::kCancelled);
}

TEST_F(Actions, EndOfTheServersNodeEndsTheGoal) {
  auto server = std::make_unique<Node>(options("server"));
  Node user(options("user"));
  auto action = serve(*server);
  user.spin_in_background();
  std::atomic<int> feedback = 0;
  const auto goal =
      client_of(user).send(clock_message(1000000), [&](const Clock_&) { ++feedback; });
  ASSERT_TRUE(eventually([&] { return feedback > 0; }));
  server.reset();
  const auto outcome = goal.wait(5s);
  EXPECT_EQ(outcome.status(), Status::kCancelled) << outcome.error();
}

}  // namespace
}  // namespace prehend::graph
