// Node::wait_until_delivered: when everything published has been worked on.

#include <gmock/gmock.h>

#include "tests/graph/test_graph.h"

namespace prehend::graph {
namespace {

class Delivery : public GraphTest {
 protected:
  Delivery() { node_.spin_in_background(); }
  Node node_{options("source")};
  Publisher<msgs::Clock> publisher_ = node_.advertise<msgs::Clock>("/t", QoS::queue(1000));
};

TEST_F(Delivery, ReturnsOnceAllCallbacksHaveRunAndTellsTheirQueues) {
  EXPECT_TRUE(node_.wait_until_delivered(5s)) << "nobody listens";
  Node slow(options("slow"));
  std::atomic<int> done{0};
  const auto first =
      slow.subscribe<msgs::Clock>("/t", QoS::queue(100, 5'000), [&](const Received<msgs::Clock>&) {
        std::this_thread::sleep_for(2ms);
        ++done;
      });
  Inbox other;
  const auto second = slow.subscribe<msgs::Clock>("/t", QoS::latest(), other.taker());
  slow.spin_in_background();
  ASSERT_TRUE(publisher_.wait_for_subscribers(2, 5s));
  for (int turn = 1; turn <= 5; ++turn) {
    for (int i = 0; i < 50; ++i) publisher_.publish(clock_message(i));
    const auto queues = node_.wait_until_delivered(30s);
    ASSERT_TRUE(queues);
    EXPECT_EQ(done, 50 * turn);
    ASSERT_EQ(queues->size(), 1u) << "latest is no queue to wait for";
    EXPECT_EQ(queues->front().topic, "/t");
    EXPECT_EQ(queues->front().depth, 100u);
    EXPECT_EQ(queues->front().max_bytes, 5'000u);
  }
  EXPECT_EQ(first.statistics().dropped, 0u);
}

TEST_F(Delivery, GivesUpAfterItsTimeAndAtShutdown) {
  Node stuck(options("stuck"));  // never spins
  const auto subscription =
      stuck.subscribe<msgs::Clock>("/t", QoS::queue(10), [](const Received<msgs::Clock>&) {});
  ASSERT_TRUE(publisher_.wait_for_subscribers(1, 5s));
  publisher_.publish(clock_message(1));
  EXPECT_FALSE(node_.wait_until_delivered(50ms));
  std::thread stopper([&] {
    std::this_thread::sleep_for(50ms);
    node_.shutdown();
  });
  EXPECT_FALSE(node_.wait_until_delivered(60s));
  stopper.join();
}

TEST_F(Delivery, DoesNotWaitForASubscriberThatLeft) {
  auto stuck = std::make_unique<Node>(options("stuck"));
  auto subscription =
      stuck->subscribe<msgs::Clock>("/t", QoS::queue(10), [](const Received<msgs::Clock>&) {});
  ASSERT_TRUE(publisher_.wait_for_subscribers(1, 5s));
  publisher_.publish(clock_message(1));
  std::thread ender([&] {
    std::this_thread::sleep_for(50ms);
    stuck.reset();
  });
  EXPECT_TRUE(node_.wait_until_delivered(20s));
  ender.join();
}

}  // namespace
}  // namespace prehend::graph
