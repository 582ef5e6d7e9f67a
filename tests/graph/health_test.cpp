// A node's health recovers from what is over: failed callbacks, and other nodes that were wrong.

#include "prehend/graph/introspection.h"
#include "prehend/graph/link/node_health.h"
#include "tests/graph/test_graph.h"

namespace prehend::graph {
namespace {

using Word = NodeHealth::Word;

TEST(NodeHealth, AFailureCountsForAWhileOverTheNodesOwnWord) {
  NodeHealth health;
  const NodeHealth::Time start{};
  Word word;
  EXPECT_FALSE(health.take_news(start, word)) << "ok is what everybody takes for granted";
  EXPECT_TRUE(health.say({Health::kWarning, "no table"}));
  EXPECT_FALSE(health.say({Health::kWarning, "no table"}));
  ASSERT_TRUE(health.take_news(start, word));
  EXPECT_EQ(word, (Word{Health::kWarning, "no table"}));
  EXPECT_TRUE(health.fail({Health::kError, "bad request"}, start + 10s));
  EXPECT_FALSE(health.fail({Health::kError, "bad request"}, start + 11s)) << "said already";
  ASSERT_TRUE(health.take_news(start + 11s, word));
  EXPECT_EQ(word, (Word{Health::kError, "bad request"}));
  health.say({Health::kOk, "a table"});
  EXPECT_FALSE(health.take_news(start + 15s, word)) << "the last failure still counts";
  ASSERT_TRUE(health.take_news(start + 16s, word));
  EXPECT_EQ(word, (Word{Health::kOk, "a table"}));
  EXPECT_EQ(health.failures(), 2u) << "the counter stays";
}

TEST(NodeHealth, WhatAnotherNodeDoesWrongCountsUntilItIsGone) {
  NodeHealth health;
  Word word;
  health.hold("x-1", "x is wrong");
  health.hold("y-1", "y is wrong");
  ASSERT_TRUE(health.take_news({}, word));
  EXPECT_EQ(word, (Word{Health::kError, "x is wrong"}));
  health.release("x-1");
  ASSERT_TRUE(health.take_news({}, word));
  EXPECT_EQ(word, (Word{Health::kError, "y is wrong"}));
  health.release("y-1");
  ASSERT_TRUE(health.take_news({}, word));
  EXPECT_EQ(word, Word{});
}

// What a node "server" says of its health, heard by a node "user".
class HealthOfNodes : public GraphTest {
 protected:
  HealthOfNodes() {
    diagnostics_ = user_.subscribe<msgs::graph::Diagnostic>(
        "/diagnostics", QoS::queue(100), [this](const Received<msgs::graph::Diagnostic>& word) {
          if (word->node() != "server") return;
          const std::lock_guard lock(mutex_);
          words_.push_back(*word);
        });
    user_.spin_in_background();
  }

  std::vector<msgs::graph::Diagnostic> words() {
    const std::lock_guard lock(mutex_);
    return words_;
  }
  // True once it was in error and is well again.
  bool recovers() {
    return eventually(
        [&] {
          const auto all = words();
          bool was_wrong = false;
          for (const auto& word : all) was_wrong |= word.level() == msgs::graph::HEALTH_ERROR;
          return was_wrong && all.back().level() == msgs::graph::HEALTH_OK;
        },
        30s);
  }

  std::mutex mutex_;
  std::vector<msgs::graph::Diagnostic> words_;
  Node user_{options("user")};
  Subscription diagnostics_;
};

// It stayed in error for ever.
TEST_F(HealthOfNodes, RecoversFromADamagedRequestAndTheCounterStays) {
  Node server(options("server"));
  const auto service = server.serve<msgs::Clock, msgs::Clock>(
      "/half", [](const msgs::Clock& request) -> msgs::Clock {
        if (request.time() % 2 != 0) throw std::runtime_error("request is damaged");
        return clock_message(request.time() / 2);
      });
  server.report(Health::kOk, "serves");
  server.spin_in_background();
  auto client = user_.client<msgs::Clock, msgs::Clock>("/half");
  EXPECT_FALSE(client.call(clock_message(1), 10s).ok());
  EXPECT_TRUE(recovers());
  std::string all;
  for (const auto& word : words()) all += word.text() + "\n";
  EXPECT_NE(all.find("request is damaged"), std::string::npos) << all;
  EXPECT_EQ(words().back().text(), "serves");
  Introspection look(endpoint);
  EXPECT_TRUE(eventually(
      [&] {
        for (const auto& [instance, statistics] : look.statistics(look.nodes())) {
          if (statistics.failed_callbacks() == 1) return true;
        }
        return false;
      },
      10s));
}

TEST_F(HealthOfNodes, RecoversFromAnActionThatThrew) {
  Node server(options("server"));
  const auto action = server.serve_action<msgs::Clock, msgs::Clock, msgs::Clock>(
      "/act", [](const msgs::Clock&, ActionContext<msgs::Clock>&) -> msgs::Clock {
        throw std::runtime_error("the arm is gone");
      });
  server.spin_in_background();
  auto client = user_.action_client<msgs::Clock, msgs::Clock, msgs::Clock>("/act");
  EXPECT_EQ(client.send(clock_message(1)).wait(10s).status(), Status::kFailed);
  EXPECT_TRUE(recovers());
}

TEST_F(HealthOfNodes, RecoversWhenAPublisherOfAnotherTypeIsGone) {
  Node server(options("server"));
  const auto subscription =
      server.subscribe<msgs::Clock>("/t", QoS::queue(1), [](const Received<msgs::Clock>&) {});
  server.spin_in_background();
  {
    Node other(options("other"));
    const auto publisher = other.advertise<msgs::Wrench>("/t", QoS::queue(1));
    EXPECT_TRUE(eventually(
        [&] { return !words().empty() && words().back().level() == msgs::graph::HEALTH_ERROR; }));
  }
  EXPECT_TRUE(recovers());
}

}  // namespace
}  // namespace prehend::graph
