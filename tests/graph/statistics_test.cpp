// Every node's word on its traffic, on /statistics.

#include <map>

#include "tests/graph/test_graph.h"

namespace prehend::graph {
namespace {

using msgs::graph::NodeStatistics;
using msgs::graph::TopicStatistics;

class Statistics : public GraphTest {
 protected:
  // The last report of each node.
  class Reader {
   public:
    explicit Reader(NodeOptions options) : node_(std::move(options)) {
      subscription_ = node_.subscribe<NodeStatistics>(
          "/statistics", QoS::queue(100), [this](const Received<NodeStatistics>& report) {
            const std::lock_guard lock(mutex_);
            reports_[report->node()] = *report;
          });
      node_.spin_in_background();
    }
    NodeStatistics of(const std::string& node) const {
      const std::lock_guard lock(mutex_);
      const auto found = reports_.find(node);
      return found == reports_.end() ? NodeStatistics() : found->second;
    }
    TopicStatistics of(const std::string& node, const std::string& topic, bool publisher) const {
      const NodeStatistics report = of(node);
      for (const auto& entry : report.topics()) {
        if (entry.topic() == topic && entry.is_publisher() == publisher) return entry;
      }
      return {};
    }

   private:
    mutable std::mutex mutex_;
    std::map<std::string, NodeStatistics> reports_;
    Node node_;
    Subscription subscription_;
  };
};

TEST_F(Statistics, TellWhatWentOverATopicAtBothEnds) {
  Reader reader(options("reader"));
  Node source(options("source")), sink(options("sink"));
  Inbox inbox;
  const auto subscription = sink.subscribe<msgs::Clock>("/t", QoS::queue(100), inbox.taker());
  sink.spin_in_background();
  const auto publisher = source.advertise<msgs::Clock>("/t", QoS::queue(100));
  for (int i = 1; i <= 50; ++i) publisher.publish(clock_message(i));
  ASSERT_TRUE(eventually([&] {
    return reader.of("source", "/t", true).messages() == 50 &&
           reader.of("sink", "/t", false).messages() == 50;
  }));
  EXPECT_EQ(reader.of("source", "/t", true).peers(), 1u);
  EXPECT_EQ(reader.of("sink", "/t", false).peers(), 1u);
  EXPECT_EQ(reader.of("sink", "/t", false).dropped(), 0u);
  EXPECT_EQ(reader.of("source", "/t", true).bytes(), 50 * clock_message(1).ByteSizeLong());
  EXPECT_EQ(reader.of("sink", "/t", false).bytes(), 50 * clock_message(1).ByteSizeLong());
  EXPECT_GT(reader.of("sink").resident_bytes(), 1000000u);
  EXPECT_GT(reader.of("sink").cpu_seconds(), 0);
}

TEST_F(Statistics, RateIsThatOfTheLastSecond) {
  Reader reader(options("reader"));
  Node source(options("source"));
  const auto publisher = source.advertise<msgs::Clock>("/t", QoS::queue(100));
  const auto timer = source.create_timer(0.01, [&] { publisher.publish(clock_message(1)); });
  source.spin_in_background();
  EXPECT_TRUE(eventually([&] {
    const double rate = reader.of("source", "/t", true).rate();
    return rate > 40 && rate < 160;
  }));
}

TEST_F(Statistics, CountDropsOfASlowCallback) {
  Reader reader(options("reader"));
  Node source(options("source")), sink(options("sink"));
  const auto subscription = sink.subscribe<msgs::Clock>("/t", QoS::queue(2), [](const auto&) {});
  const auto publisher = source.advertise<msgs::Clock>("/t", QoS::queue(100));
  for (int i = 1; i <= 50; ++i) publisher.publish(clock_message(i));  // the sink does not spin
  EXPECT_TRUE(eventually([&] { return reader.of("sink", "/t", false).dropped() == 48; }));
  EXPECT_EQ(reader.of("sink", "/t", false).queue_high_water(), 2u);
}

TEST_F(Statistics, DoNotReportOnThemselves) {
  Reader reader(options("reader"));
  ASSERT_TRUE(eventually([&] { return reader.of("reader").stamp() > 0; }));
  const NodeStatistics report = reader.of("reader");
  for (const auto& topic : report.topics()) EXPECT_NE(topic.topic(), "/statistics");
  EXPECT_EQ(reader.of("reader", "/log", true).is_publisher(), true);
}

TEST_F(Statistics, LastReportIsThereForALateReader) {
  Node source(options("source"));
  std::this_thread::sleep_for(300ms);  // its first report is out
  const auto start = std::chrono::steady_clock::now();
  Reader reader(options("reader"));
  ASSERT_TRUE(eventually([&] { return reader.of("source").stamp() > 0; }));
  // Not waited for the next report: that was published before the reader came.
  EXPECT_LT(reader.of("source").stamp(), std::chrono::system_clock::now().time_since_epoch() / 1ns -
                                             (std::chrono::steady_clock::now() - start) / 1ns);
}

}  // namespace
}  // namespace prehend::graph
