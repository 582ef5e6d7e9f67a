#include <atomic>
#include <optional>

#include "tests/graph/test_graph.h"

namespace prehend::graph {
namespace {

using Clock_ = msgs::Clock;

// What callbacks may and may not do.
class Callbacks : public GraphTest {
 protected:
  // Runs `work` in a timer's callback of the node, once, and waits for its end.
  static void in_callback(Node& node, const std::function<void()>& work) {
    std::atomic<bool> done = false;
    auto timer = node.create_timer(0.001, [&] {
      if (done) return;
      work();
      done = true;
    });
    ASSERT_TRUE(eventually([&] { return done.load(); }, 10s));
  }

  template <class Action>
  static std::string refusal(const Action& action) {
    try {
      action();
    } catch (const std::logic_error& error) {
      return error.what();
    }
    return "not refused";
  }
};

TEST_F(Callbacks, ABlockingCallIsRefusedAtOnceWithTheMend) {
  Node node(options("node"));
  node.spin_in_background();
  auto client = node.client<Clock_, Clock_>("/nobody");
  auto goals = node.action_client<Clock_, Clock_, Clock_>("/nobody_acts");
  auto numbers = node.advertise<Clock_>("/numbers", QoS::queue(10));
  const auto begin = std::chrono::steady_clock::now();
  in_callback(node, [&] {
    const auto call = client.call(clock_message(1), 60s);
    EXPECT_EQ(call.status(), Status::kRefused);
    EXPECT_EQ(call.error(),
              "service /nobody: call is refused inside a callback (timer), as it would hold up all "
              "callbacks of this node: use call_async, or call in a thread of your own");
    const auto goal = goals.send(clock_message(1));
    const auto wait = goal.wait(60s);
    EXPECT_EQ(wait.status(), Status::kRefused);
    EXPECT_NE(wait.error().find("on_result"), std::string::npos) << wait.error();
    EXPECT_EQ(goal.wait(0s).status(), Status::kTimeout);  // a look is no wait
    EXPECT_NE(refusal([&] { client.wait_for_server(60s); }).find("/nobody: wait_for_server"),
              std::string::npos);
    EXPECT_FALSE(client.wait_for_server(0s));
    EXPECT_NE(refusal([&] { goals.wait_for_server(60s); }).find("thread of your own"),
              std::string::npos);
    EXPECT_NE(refusal([&] { node.clock().sleep_for(60s); }).find("use a timer"), std::string::npos);
    EXPECT_NE(refusal([&] { node.clock().sleep_until(0); }).find("use a timer"), std::string::npos);
    EXPECT_TRUE(node.clock().sleep_for(0s));
    EXPECT_NE(refusal([&] { numbers.wait_for_subscribers(1, 60s); }).find("/numbers"),
              std::string::npos);
    EXPECT_FALSE(numbers.wait_for_subscribers(1, 0s));
    goal.cancel();
  });
  EXPECT_LT(std::chrono::steady_clock::now() - begin, 20s);
  EXPECT_STREQ(to_string(Status::kRefused), "refused");
}

TEST_F(Callbacks, AnUncaughtRefusalIsLoggedAndTheNodeGoesOn) {
  LogReader log(options("reader"));
  Node node(options("node"));
  std::atomic<int> ticks = 0;
  auto timer = node.create_timer(0.005, [&] {
    ++ticks;
    node.clock().sleep_for(60s);
  });
  node.spin_in_background();
  EXPECT_TRUE(
      eventually([&] { return ticks > 2 && log.has("refused inside a callback (timer)"); }));
}

// Once one object that could not be planned lost all others of its view.
TEST_F(Callbacks, AShieldedItemDoesNotLoseTheOthers) {
  LogReader log(options("reader"));
  Node node(options("node"));
  std::atomic<int> done = 0, views = 0;
  std::mutex mutex;
  std::vector<std::string> problems;
  auto timer = node.create_timer(0.005, [&] {
    for (int item = 0; item < 4; ++item) {
      const std::string problem = node.shield("object " + std::to_string(item), [&] {
        if (item == 1) throw std::invalid_argument("no volume");
        if (item == 2) throw 7;
        ++done;
      });
      const std::lock_guard lock(mutex);
      if (views == 0) problems.push_back(problem);
    }
    ++views;
  });
  node.spin_in_background();
  EXPECT_TRUE(eventually([&] { return views > 2; }));
  EXPECT_GE(done, 2 * views - 2);
  EXPECT_TRUE(eventually([&] {
    return log.has("object 1: no volume") &&
           log.has("object 2: an exception that is no std::exception");
  }));
  const std::lock_guard lock(mutex);
  EXPECT_EQ(problems, (std::vector<std::string>{"", "no volume",
                                                "an exception that is no std::exception", ""}));
}

TEST_F(Callbacks, OtherThreadsAndOtherNodesMayBlockMeanwhile) {
  Node server(options("server")), node(options("node"));
  auto service = server.serve<Clock_, Clock_>(
      "/next", [](const Clock_& request) { return clock_message(request.time() + 1); });
  server.spin_in_background();
  node.spin_in_background();
  auto of_node = node.client<Clock_, Clock_>("/next");
  Node second(options("second"));
  auto of_second = second.client<Clock_, Clock_>("/next");
  in_callback(node, [&] {
    EXPECT_EQ(of_second.call(clock_message(1), 10s)->time(), 2);
    std::thread([&] { EXPECT_EQ(of_node.call(clock_message(2), 10s)->time(), 3); }).join();
  });
}

TEST_F(Callbacks, AsynchronousCallsAnswerInCallbacks) {
  Node server(options("server")), node(options("node"));
  auto service = server.serve<Clock_, Clock_>("/half", [](const Clock_& request) -> Clock_ {
    if (request.time() % 2) throw 3;
    return clock_message(request.time() / 2);
  });
  server.spin_in_background();
  auto client = node.client<Clock_, Clock_>("/half");
  Inbox answers;
  std::atomic<int> failed = 0;
  // A chain: each answer asks anew, from a callback.
  std::function<void(std::int64_t)> ask = [&](std::int64_t value) {
    client.call_async(clock_message(value), 10s, [&](const Outcome<Clock_>& outcome) {
      if (!outcome.ok()) {
        EXPECT_EQ(outcome.error(), "service /half failed: an exception that is no std::exception");
        ++failed;
        return;
      }
      answers.add(outcome->time());
      ask(outcome->time());
    });
  };
  ask(8);
  EXPECT_EQ(answers.size(), 0u);  // the node does not spin yet
  node.spin_in_background();
  EXPECT_TRUE(eventually([&] { return failed == 1; }));
  EXPECT_EQ(answers.values(), (std::vector<std::int64_t>{4, 2, 1}));
  EXPECT_THROW(client.call_async(clock_message(1), 1s, nullptr), std::invalid_argument);
}

TEST_F(Callbacks, AsynchronousCallsEndInTime) {
  Node node(options("node"));
  node.spin_in_background();
  auto nobody = node.client<Clock_, Clock_>("/nobody");
  std::mutex mutex;
  std::vector<std::string> errors;
  const auto take = [&](const Outcome<Clock_>& outcome) {
    const std::lock_guard lock(mutex);
    errors.push_back(std::string(to_string(outcome.status())) + ": " + outcome.error());
  };
  nobody.call_async(clock_message(1), 100ms, take);
  nobody.call_async(clock_message(1), 0ms, take);
  nobody.call_async(clock_message(1), -5s, take);
  ASSERT_TRUE(eventually([&] {
    const std::lock_guard lock(mutex);
    return errors.size() == 3;
  }));
  EXPECT_EQ(errors.back(), "timeout: service /nobody: nobody serves it (waited 0.1 s)");

  Child server({"serve", "--registry", endpoint});
  auto hang = node.client<Clock_, Clock_>("/hang");
  ASSERT_TRUE(hang.wait_for_server(10s));
  hang.call_async(clock_message(1), std::chrono::nanoseconds::max(), take);
  std::this_thread::sleep_for(100ms);
  server.send(SIGKILL);
  ASSERT_TRUE(eventually([&] {
    const std::lock_guard lock(mutex);
    return errors.size() == 4;
  }));
  EXPECT_NE(errors.back().find("its server ended before it answered"), std::string::npos)
      << errors.back();
}

TEST_F(Callbacks, NoneIsCalledAfterTheNodesEnd) {
  std::atomic<int> called = 0;
  ServiceClient<Clock_, Clock_> client;
  {
    Node node(options("node"));
    node.spin_in_background();
    client = node.client<Clock_, Clock_>("/nobody");
    client.call_async(clock_message(1), 60s, [&](const auto&) { ++called; });
  }
  client.call_async(clock_message(1), 60s, [&](const auto&) { ++called; });
  EXPECT_EQ(client.call(clock_message(1), 60s).status(), Status::kShutdown);
  EXPECT_EQ(called, 0);
}

TEST_F(Callbacks, MayEndTheirOwnHandlesAndMakeNewOnes) {
  Node node(options("node"));
  node.spin_in_background();
  auto numbers = node.advertise<Clock_>("/numbers", QoS::queue(10));
  auto answers = node.advertise<Clock_>("/answers", QoS::queue(10));
  Inbox first, second;
  std::atomic<int> ticks = 0;
  Subscription subscription, late;
  Node::Timer timer;
  subscription = node.subscribe<Clock_>("/numbers", QoS::queue(10), [&](const auto& message) {
    first.add(message->time());
    late = node.subscribe<Clock_>("/answers", QoS::queue(10), second.taker());
    timer = node.create_timer(0.001, [&] {
      ++ticks;
      answers.publish(clock_message(7));
      timer = {};
    });
    subscription = {};
  });
  ASSERT_TRUE(numbers.wait_for_subscribers(1, 5s));
  for (int i = 1; i <= 5; ++i) numbers.publish(clock_message(i));
  EXPECT_TRUE(eventually([&] { return second.size() == 1; }));
  EXPECT_EQ(first.size(), 1u);
  EXPECT_EQ(ticks, 1);
}

TEST_F(Callbacks, AServiceMayWithdrawItselfInItsHandler) {
  Node server(options("server")), caller(options("caller"));
  Service service;
  std::atomic<bool> withdrawn{false};
  service = server.serve<Clock_, Clock_>("/once", [&](const Clock_& request) {
    service = {};
    withdrawn = true;
    return request;
  });
  server.spin_in_background();
  auto client = caller.client<Clock_, Clock_>("/once");
  EXPECT_EQ(client.call(clock_message(5), 10s)->time(), 5);
  EXPECT_TRUE(withdrawn);
  EXPECT_FALSE(client.call(clock_message(5), 200ms).ok());
}

TEST_F(Callbacks, AnActionsHandlerMayBlockAndEndItsOwnServer) {
  Node server(options("server")), user(options("user"));
  auto service = server.serve<Clock_, Clock_>(
      "/next", [](const Clock_& request) { return clock_message(request.time() + 1); });
  server.spin_in_background();
  auto next = server.client<Clock_, Clock_>("/next");
  ActionServer action;
  action = server.serve_action<Clock_, Clock_, Clock_>(
      "/act", [&](const Clock_& goal, ActionContext<Clock_>& context) {
        const auto answer = next.call(goal, 10s);  // of its own node
        EXPECT_TRUE(server.clock().sleep_for(1ms));
        context.feedback(goal);
        action = {};
        EXPECT_TRUE(context.cancelled());
        return *answer;
      });
  const auto outcome =
      user.action_client<Clock_, Clock_, Clock_>("/act").send(clock_message(1)).wait(10s);
  ASSERT_TRUE(outcome.has_value()) << outcome.error();
  EXPECT_EQ(outcome->time(), 2);
}

TEST_F(Callbacks, FeedbackMayCancelItsGoalAndDropTheHandle) {
  Node server(options("server")), user(options("user"));
  std::atomic<int> ended = 0;
  auto action = server.serve_action<Clock_, Clock_, Clock_>(
      "/act", [&](const Clock_& goal, ActionContext<Clock_>& context) {
        while (context.sleep_for(1ms)) context.feedback(goal);
        ++ended;
        return goal;
      });
  std::atomic<int> feedback = 0, results = 0;
  std::mutex mutex;
  GoalHandle<Clock_> goal;
  {
    const std::lock_guard lock(mutex);
    goal = user.action_client<Clock_, Clock_, Clock_>("/act").send(
        clock_message(1), [&](const Clock_&) {
          ++feedback;
          const std::lock_guard inside(mutex);
          EXPECT_EQ(goal.wait(0s).status(), Status::kTimeout);
          goal.on_result([&](const Outcome<Clock_>& outcome) {
            EXPECT_EQ(outcome.status(), Status::kCancelled);
            ++results;
          });
          goal.cancel();
          goal = {};
        });
  }
  user.spin_in_background();
  EXPECT_TRUE(eventually([&] { return results == 1; }));
  EXPECT_EQ(feedback, 1);
  EXPECT_EQ(ended, 1);
}

}  // namespace
}  // namespace prehend::graph
