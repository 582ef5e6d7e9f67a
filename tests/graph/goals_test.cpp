#include "tests/graph/test_graph.h"

namespace prehend::graph {
namespace {

using Clock_ = msgs::Clock;

// Goals in the less even cases: many, late, lost, cancelled under load.
class Goals : public GraphTest {
 protected:
  static auto client_of(Node& node, const std::string& action = "/act") {
    return node.action_client<Clock_, Clock_, Clock_>(action);
  }
  // Sends feedback 1, 2, … until it is cancelled; the result is how far it came.
  static ActionServer serve_endless(Node& node, const std::string& action = "/act") {
    return node.serve_action<Clock_, Clock_, Clock_>(
        action, [](const Clock_&, ActionContext<Clock_>& context) {
          std::int64_t i = 0;
          while (context.sleep_for(50us)) context.feedback(clock_message(++i));
          return clock_message(i);
        });
  }
};

TEST_F(Goals, NoFeedbackAfterCancelUnderLoad) {
  constexpr int kThreads = 4, kRounds = 250;
  Node server(options("server")), user(options("user"));
  user.spin_in_background();
  std::vector<ActionServer> actions;
  for (int i = 0; i < kThreads; ++i) {
    actions.push_back(serve_endless(server, "/act" + std::to_string(i)));
  }
  std::atomic<int> late = 0, wrong_end = 0, silent = 0;
  const auto work = [&](int index) {
    auto client = client_of(user, "/act" + std::to_string(index));
    for (int round = 0; round < kRounds; ++round) {
      std::atomic<bool> cancelled = false;
      std::atomic<int> early = 0;
      const auto goal = client.send(clock_message(1), [&](const Clock_&) {
        ++early;
        if (cancelled) ++late;
      });
      if (!eventually([&] { return early > 0; }, 20s)) ++silent;
      goal.cancel();
      cancelled = true;
      if (goal.wait(20s).status() != Status::kCancelled) ++wrong_end;
    }
  };
  std::vector<std::thread> threads;
  for (int i = 0; i < kThreads; ++i) threads.emplace_back(work, i);
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(late, 0);
  EXPECT_EQ(wrong_end, 0);
  EXPECT_EQ(silent, 0);
}

TEST_F(Goals, FeedbackKeepsItsOrderAndComesBeforeTheResult) {
  Node server(options("server")), user(options("user"));
  auto action = server.serve_action<Clock_, Clock_, Clock_>(
      "/act", [](const Clock_& goal, ActionContext<Clock_>& context) {
        for (std::int64_t i = 1; i <= goal.time(); ++i) context.feedback(clock_message(i));
        return goal;
      });
  user.spin_in_background();
  std::vector<std::int64_t> feedback;
  std::atomic<int> results = 0;
  std::size_t before_result = 0;
  const auto goal = client_of(user).send(clock_message(500),
                                         [&](const Clock_& f) { feedback.push_back(f.time()); });
  const auto take = [&](const Outcome<Clock_>& outcome) {
    EXPECT_TRUE(outcome.ok()) << outcome.error();
    before_result = feedback.size();
    ++results;
  };
  goal.on_result(take);
  ASSERT_TRUE(eventually([&] { return results == 1; }));
  ASSERT_EQ(before_result, 500u);
  for (std::size_t i = 0; i < feedback.size(); ++i) {
    ASSERT_EQ(feedback[i], static_cast<std::int64_t>(i + 1));
  }
  goal.on_result(take);  // it has ended already
  EXPECT_TRUE(eventually([&] { return results == 2; }));
  EXPECT_THROW(goal.on_result(nullptr), std::invalid_argument);
  EXPECT_EQ(goal.wait(5s)->time(), 500);
}

TEST_F(Goals, LargeFeedbackArrivesWhole) {
  Node server(options("server")), user(options("user"));
  auto action = server.serve_action<Clock_, msgs::graph::LogLine, Clock_>(
      "/act", [](const Clock_& goal, ActionContext<msgs::graph::LogLine>& context) {
        msgs::graph::LogLine large;
        large.set_text(std::string(static_cast<std::size_t>(goal.time()), 'x'));
        for (int i = 0; i < 3; ++i) context.feedback(large);
        return goal;
      });
  std::vector<std::size_t> sizes;
  const auto outcome = user.action_client<Clock_, msgs::graph::LogLine, Clock_>("/act")
                           .send(clock_message(8 << 20),
                                 [&](const auto& line) { sizes.push_back(line.text().size()); })
                           .wait(20s);
  EXPECT_TRUE(outcome.ok()) << outcome.error();
  EXPECT_EQ(sizes, std::vector<std::size_t>(3, 8 << 20));
}

TEST_F(Goals, AGoalsTimeoutCancelsItAndEndsIt) {
  Node server(options("server")), user(options("user"));
  std::atomic<int> cancelled = 0;
  std::atomic<bool> stubborn = false;
  auto action = server.serve_action<Clock_, Clock_, Clock_>(
      "/act", [&](const Clock_& goal, ActionContext<Clock_>& context) {
        if (stubborn) std::this_thread::sleep_for(1s);
        while (context.sleep_for(1ms)) context.feedback(goal);
        ++cancelled;
        return goal;
      });
  user.spin_in_background();
  std::atomic<int> feedback = 0;
  const auto goal = client_of(user).send(clock_message(1), [&](const Clock_&) { ++feedback; },
                                         {.timeout = 100ms});
  const auto outcome = goal.wait(20s);
  EXPECT_EQ(outcome.status(), Status::kTimeout);
  EXPECT_EQ(outcome.error(), "action /act: not done within 0.1 s, so it was cancelled");
  EXPECT_TRUE(goal.done());
  EXPECT_TRUE(eventually([&] { return cancelled == 1; }));
  EXPECT_GT(feedback, 0);
  stubborn = true;  // a handler that does not look whether it is cancelled cannot keep the client
  std::atomic<int> results = 0;
  client_of(user)
      .send(clock_message(1), nullptr, {.timeout = 50ms})
      .on_result([&](const Outcome<Clock_>& end) {
        EXPECT_EQ(end.status(), Status::kTimeout);
        ++results;
      });
  EXPECT_TRUE(eventually([&] { return results == 1; }));
  const auto nobody = client_of(user, "/nobody").send(clock_message(1), nullptr, {.timeout = 50ms});
  EXPECT_EQ(nobody.wait(20s).error(), "action /nobody: nobody serves it (waited 0.05 s)");
  EXPECT_THROW(client_of(user).send(clock_message(1), nullptr, {.timeout = -1s}),
               std::invalid_argument);
  stubborn = false;
  const auto in_time = client_of(user).send(clock_message(1), nullptr, {.timeout = 60s});
  in_time.cancel();
  EXPECT_EQ(in_time.wait(20s).status(), Status::kCancelled);
}

TEST_F(Goals, OnlyTheNewestOfManyGoalsRunsToItsEnd) {
  Node server(options("server")), user(options("user"));
  std::atomic<int> started = 0;
  std::atomic<bool> saw_preempted = false;
  auto action = server.serve_action<Clock_, Clock_, Clock_>(
      "/act", [&](const Clock_& goal, ActionContext<Clock_>& context) {
        ++started;
        if (goal.time() == 9) return goal;
        while (context.sleep_for(1s)) {
        }
        saw_preempted = context.preempted();
        std::this_thread::sleep_for(100ms);  // takes its time to stop: others come meanwhile
        return goal;
      });
  const auto first = client_of(user).send(clock_message(1));
  ASSERT_TRUE(eventually([&] { return started == 1; }));
  const auto second = client_of(user).send(clock_message(2));
  const auto third = client_of(user).send(clock_message(9));
  const auto of_first = first.wait(10s);
  EXPECT_EQ(of_first.status(), Status::kPreempted);
  EXPECT_EQ(of_first->time(), 1);  // what it had done by then
  const auto of_second = second.wait(10s);
  EXPECT_EQ(of_second.status(), Status::kPreempted);
  EXPECT_FALSE(of_second.has_value());
  EXPECT_EQ(third.wait(10s)->time(), 9);
  EXPECT_EQ(started, 2);
  EXPECT_TRUE(saw_preempted);
}

TEST_F(Goals, ACancelledGoalStaysCancelledWhenAnotherComes) {
  Node server(options("server")), user(options("user"));
  std::atomic<int> started = 0;
  auto action = server.serve_action<Clock_, Clock_, Clock_>(
      "/act", [&](const Clock_& goal, ActionContext<Clock_>& context) {
        ++started;
        if (goal.time() == 2) return goal;
        while (context.sleep_for(1s)) {
        }
        std::this_thread::sleep_for(100ms);
        EXPECT_FALSE(context.preempted());
        return goal;
      });
  const auto first = client_of(user).send(clock_message(1));
  ASSERT_TRUE(eventually([&] { return started == 1; }));
  first.cancel();
  const auto second = client_of(user).send(clock_message(2));
  EXPECT_EQ(first.wait(10s).status(), Status::kCancelled);
  EXPECT_TRUE(second.wait(10s).ok());
}

TEST_F(Goals, AnythingThrownIsAFailure) {
  Node server(options("server")), user(options("user"));
  auto action = server.serve_action<Clock_, Clock_, Clock_>(
      "/act", [](const Clock_& goal, ActionContext<Clock_>&) -> Clock_ {
        if (goal.time() == 1) throw 42;
        return goal;
      });
  const auto failed = client_of(user).send(clock_message(1)).wait(10s);
  EXPECT_EQ(failed.status(), Status::kFailed);
  EXPECT_EQ(failed.error(), "action /act failed: an exception that is no std::exception");
  EXPECT_TRUE(client_of(user).send(clock_message(2)).wait(10s).ok());  // it goes on
}

TEST_F(Goals, ADeadServerIsNoticedWithoutTheRegistry) {
  Node user(options("user"));
  Child server({"serve", "--registry", endpoint});
  std::atomic<int> feedback = 0;
  auto client = client_of(user, "/hang_action");
  auto service = user.client<Clock_, Clock_>("/hang");
  const auto running = client.send(clock_message(1), [&](const Clock_&) { ++feedback; });
  user.spin_in_background();
  ASSERT_TRUE(eventually([&] { return feedback == 1; }, 10s));
  registry.reset();
  server.send(SIGKILL);
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_EQ(running.wait(60s).status(), Status::kServerGone);
  // Nobody can say that it is gone: the record of it lives on.
  const auto later = client.send(clock_message(1)).wait(60s);
  EXPECT_EQ(later.status(), Status::kServerGone) << later.error();
  EXPECT_NE(later.error().find("cannot be reached"), std::string::npos) << later.error();
  EXPECT_EQ(service.call(clock_message(1), 60s).status(), Status::kServerGone);
  EXPECT_LT(std::chrono::steady_clock::now() - begin, 30s);
}

TEST_F(Goals, ADeadClientIsNoticedWithoutTheRegistry) {
  Node server(options("server"));
  std::atomic<int> started = 0, cancelled = 0;
  auto action = server.serve_action<Clock_, Clock_, Clock_>(
      "/count", [&](const Clock_& goal, ActionContext<Clock_>& context) {
        ++started;
        while (context.sleep_for(60s)) {
        }
        ++cancelled;
        return goal;
      });
  Child client({"command", "--registry", endpoint});
  ASSERT_TRUE(eventually([&] { return started == 1; }, 10s));
  registry.reset();
  client.send(SIGKILL);
  EXPECT_TRUE(eventually([&] { return cancelled == 1; }, 20s));
}

TEST_F(Goals, ASuccessorOfADeadServerGetsItsOwnGoals) {
  Node user(options("user"));
  user.spin_in_background();
  auto client = client_of(user, "/hang_action");
  for (std::int64_t round = 1; round <= 3; ++round) {
    Child server({"serve", "--registry", endpoint});
    Inbox feedback;
    const auto goal =
        client.send(clock_message(round), [&](const Clock_& f) { feedback.add(f.time()); });
    ASSERT_TRUE(eventually([&] { return feedback.size() == 1; }, 20s)) << round;
    EXPECT_EQ(feedback.values(), std::vector<std::int64_t>{round});
    server.send(SIGKILL);
    EXPECT_EQ(goal.wait(20s).status(), Status::kServerGone);
    server.wait();
  }
}

TEST_F(Goals, ManyClientsGetTheirOwnAnswers) {
  Node server(options("server"));
  auto service = server.serve<Clock_, Clock_>("/same", [](const Clock_& r) { return r; });
  server.spin_in_background();
  std::vector<std::unique_ptr<Node>> nodes;
  for (int i = 0; i < 3; ++i) {
    nodes.push_back(std::make_unique<Node>(options("user" + std::to_string(i))));
  }
  std::atomic<int> wrong = 0;
  std::vector<std::thread> threads;
  for (std::int64_t t = 0; t < 6; ++t) {
    threads.emplace_back([&, t] {
      auto client = nodes[static_cast<std::size_t>(t % 3)]->client<Clock_, Clock_>("/same");
      for (std::int64_t i = 0; i < 200; ++i) {
        const auto outcome = client.call(clock_message(1000 * t + i), 20s);
        if (!outcome.ok() || outcome->time() != 1000 * t + i) ++wrong;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(wrong, 0);
}

TEST_F(Goals, HandlesMayOutliveTheirNodes) {
  auto server = std::make_unique<Node>(options("server"));
  auto user = std::make_unique<Node>(options("user"));
  auto action = serve_endless(*server);
  std::atomic<int> feedback = 0;
  auto client = client_of(*user);
  auto goal = client.send(clock_message(1), [&](const Clock_&) { ++feedback; });
  user->spin_in_background();
  ASSERT_TRUE(eventually([&] { return feedback > 0; }));
  user.reset();
  EXPECT_EQ(goal.wait(10s).status(), Status::kShutdown);
  goal.cancel();
  goal.on_result([](const Outcome<Clock_>&) { ADD_FAILURE() << "called after its node's end"; });
  EXPECT_EQ(client.send(clock_message(1)).wait(10s).status(), Status::kShutdown);
  server.reset();
  action = {};
}

}  // namespace
}  // namespace prehend::graph
