#include "tests/graph/test_graph.h"

#include <numeric>

#include "msgs/geometry.pb.h"
#include "msgs/objects.pb.h"

namespace prehend::graph {
namespace {

// For at most 2 s a new publisher keeps what it publishes for subscribers that are just joining.
constexpr auto kNobodyAwaited = 2200ms;

std::vector<std::int64_t> numbers(std::int64_t from, std::int64_t to) {
  std::vector<std::int64_t> result(static_cast<std::size_t>(to - from + 1));
  std::iota(result.begin(), result.end(), from);
  return result;
}

// All of this holds however messages travel.
enum class Transport { kFrames, kSharedMemory, kPointers };

class Topics : public GraphTest, public testing::WithParamInterface<Transport> {
 protected:
  NodeOptions options(const std::string& name) const {
    NodeOptions result = GraphTest::options(name);
    result.use_pointers = GetParam() == Transport::kPointers;
    result.use_slab = GetParam() != Transport::kFrames;
    return result;
  }
};

std::string transport_name(const testing::TestParamInfo<Transport>& transport) {
  if (transport.param == Transport::kFrames) return "Frames";
  return transport.param == Transport::kSharedMemory ? "SharedMemory" : "Pointers";
}
INSTANTIATE_TEST_SUITE_P(By, Topics,
                         testing::Values(Transport::kFrames, Transport::kSharedMemory,
                                         Transport::kPointers),
                         transport_name);

TEST_P(Topics, MessagesArriveInOrderWithTheirEnvelope) {
  Node talker(options("talker")), listener(options("listener"));
  Inbox inbox;
  std::vector<MessageInfo> infos;
  auto subscription = listener.subscribe<msgs::GripperState>(
      "/state", QoS::queue(100), [&](const Received<msgs::GripperState>& m) {
        infos.push_back(m.info());
        inbox.add(static_cast<std::int64_t>(m->opening()));
      });
  listener.spin_in_background();
  auto publisher = talker.advertise<msgs::GripperState>("/state", QoS::queue(100));
  ASSERT_TRUE(publisher.wait_for_subscribers(1, 5s));
  for (int i = 1; i <= 50; ++i) {
    msgs::GripperState state;
    state.mutable_header()->set_stamp(1000 + i);
    state.set_opening(i);
    publisher.publish(state);
  }
  ASSERT_TRUE(eventually([&] { return inbox.size() == 50; }));
  listener.shutdown();
  EXPECT_EQ(inbox.values(), numbers(1, 50));
  EXPECT_EQ(infos[49].sequence, 50u);
  EXPECT_EQ(infos[49].stamp, 1050);
  EXPECT_EQ(infos[49].sender, "talker");
  EXPECT_GT(infos[49].publish_time, infos[49].stamp);
  EXPECT_EQ(infos[49].schema_hash, schema_of(*msgs::GripperState::descriptor())->hash);
}

TEST_P(Topics, ANodeHearsItself) {
  Node node(options("both"));
  Inbox inbox;
  auto subscription = node.subscribe<msgs::Clock>("/self", QoS::queue(10), inbox.taker());
  auto publisher = node.advertise<msgs::Clock>("/self", QoS::queue(10));
  publisher.publish(clock_message(7));
  node.spin_in_background();
  EXPECT_TRUE(eventually([&] { return inbox.values() == std::vector<std::int64_t>{7}; }));
}

TEST_P(Topics, TcpWorksLikeIpc) {
  NodeOptions by_tcp = options("talker");
  by_tcp.use_tcp = true;
  Node talker(by_tcp), listener(options("listener"));
  Inbox inbox;
  auto publisher = talker.advertise<msgs::Clock>("/t", QoS::latched(3));
  std::this_thread::sleep_for(kNobodyAwaited);
  for (int i = 1; i <= 5; ++i) publisher.publish(clock_message(i));
  auto subscription = listener.subscribe<msgs::Clock>("/t", QoS::latched(10), inbox.taker());
  listener.spin_in_background();
  EXPECT_TRUE(eventually([&] { return inbox.values() == numbers(3, 5); }));
}

// The publisher's process publishes at once, before anybody can have joined it.
TEST_P(Topics, NoFirstMessageIsLostBetweenProcesses) {
  Node listener(options("listener"));
  Inbox inbox;
  auto subscription = listener.subscribe<msgs::Clock>("/numbers", QoS::queue(5000), inbox.taker());
  listener.spin_in_background();
  Child talker({"talk", "--registry", endpoint, "--param", "count:=2000"});
  EXPECT_TRUE(eventually([&] { return inbox.size() == 2000; }, 10s));
  EXPECT_EQ(inbox.values(), numbers(1, 2000));
  EXPECT_EQ(subscription.statistics().missed, 0u);
  talker.send(SIGTERM);
  EXPECT_EQ(talker.wait(), 0);
}

TEST_P(Topics, WhatWasPublishedJustBeforeTheEndArrives) {
  Node listener(options("listener"));
  Inbox inbox;
  auto subscription = listener.subscribe<msgs::Clock>("/last", QoS::queue(100), inbox.taker());
  listener.spin_in_background();
  {
    Node talker(options("talker"));
    auto publisher = talker.advertise<msgs::Clock>("/last", QoS::queue(100));
    for (int i = 1; i <= 20; ++i) publisher.publish(clock_message(i));
  }
  EXPECT_TRUE(eventually([&] { return inbox.values() == numbers(1, 20); }));
}

TEST_P(Topics, LateSubscribersGetTheLatchedHistory) {
  Node talker(options("talker")), listener(options("listener"));
  auto publisher = talker.advertise<msgs::Clock>("/map", QoS::latched(4));
  auto plain = talker.advertise<msgs::Clock>("/plain", QoS::queue(4));
  std::this_thread::sleep_for(kNobodyAwaited);
  for (int i = 1; i <= 9; ++i) publisher.publish(clock_message(i));
  for (int i = 1; i <= 9; ++i) plain.publish(clock_message(i));
  Inbox all, few, newest, none;
  auto a = listener.subscribe<msgs::Clock>("/map", QoS::latched(10), all.taker());
  auto b = listener.subscribe<msgs::Clock>("/map", QoS::queue(2), few.taker());
  auto c = listener.subscribe<msgs::Clock>("/map", QoS::latest(), newest.taker());
  auto d = listener.subscribe<msgs::Clock>("/plain", QoS::queue(10), none.taker());
  listener.spin_in_background();
  EXPECT_TRUE(eventually([&] { return all.values() == numbers(6, 9); }));
  EXPECT_TRUE(eventually([&] { return few.values() == numbers(8, 9); }));
  EXPECT_TRUE(eventually([&] { return newest.values() == numbers(9, 9); }));
  // One that joins the same topic of the same node later gets its history alone.
  Inbox later;
  auto e = listener.subscribe<msgs::Clock>("/map", QoS::latched(10), later.taker());
  EXPECT_TRUE(eventually([&] { return later.values() == numbers(6, 9); }));
  ASSERT_TRUE(publisher.wait_for_subscribers(4, 5s));
  publisher.publish(clock_message(10));
  EXPECT_TRUE(eventually([&] { return later.values() == numbers(6, 10); }));
  EXPECT_TRUE(eventually([&] { return all.values() == numbers(6, 10); }));
  EXPECT_EQ(none.size(), 0u);
  EXPECT_EQ(a.statistics().missed + e.statistics().missed, 0u);
}

TEST_P(Topics, LatchedSubscriberOfAPlainPublisherIsWarned) {
  LogReader log(options("log_reader"));
  Node talker(options("talker")), listener(options("listener"));
  auto publisher = talker.advertise<msgs::Clock>("/plain", QoS::queue(4));
  auto subscription = listener.subscribe<msgs::Clock>("/plain", QoS::latched(4),
                                                      [](const Received<msgs::Clock>&) {});
  EXPECT_TRUE(eventually([&] { return log.has("does not keep messages"); }));
}

TEST_P(Topics, FullQueueDropsOldestCountsAndSaysSo) {
  LogReader log(options("log_reader"));
  Node talker(options("talker")), listener(options("listener"));
  Inbox inbox;
  auto subscription = listener.subscribe<msgs::Clock>("/fast", QoS::queue(10), inbox.taker());
  auto publisher = talker.advertise<msgs::Clock>("/fast", QoS::queue(1000));
  ASSERT_TRUE(publisher.wait_for_subscribers(1, 5s));
  for (int i = 1; i <= 100; ++i) publisher.publish(clock_message(i));
  ASSERT_TRUE(eventually([&] { return subscription.statistics().received == 100; }));
  listener.spin_in_background();  // only now callbacks run
  EXPECT_TRUE(eventually([&] { return inbox.values() == numbers(91, 100); }));
  EXPECT_EQ(subscription.statistics().dropped, 90u);
  EXPECT_TRUE(eventually([&] { return log.has("/fast: 90 messages dropped in all"); }));
}

TEST_P(Topics, QueueIsBoundedInBytes) {
  Node talker(options("talker")), listener(options("listener"));
  std::atomic<int> got = 0;
  auto subscription = listener.subscribe<msgs::PointCloud>(
      "/cloud", QoS::queue(100, 2500), [&](const Received<msgs::PointCloud>&) { ++got; });
  auto publisher = talker.advertise<msgs::PointCloud>("/cloud", QoS::queue(100));
  ASSERT_TRUE(publisher.wait_for_subscribers(1, 5s));
  for (int i = 0; i < 10; ++i) publisher.publish({}, std::vector<std::uint8_t>(1000));
  ASSERT_TRUE(eventually([&] { return subscription.statistics().received == 10; }));
  listener.spin_in_background();
  EXPECT_TRUE(eventually([&] { return got == 2; }));
  EXPECT_EQ(subscription.statistics().dropped, 8u);
}

TEST_P(Topics, LatestKeepsTheNewest) {
  Node talker(options("talker")), listener(options("listener"));
  Inbox inbox;
  auto subscription = listener.subscribe<msgs::Clock>("/pose", QoS::latest(), inbox.taker());
  auto publisher = talker.advertise<msgs::Clock>("/pose", QoS::queue(1000));
  ASSERT_TRUE(publisher.wait_for_subscribers(1, 5s));
  for (int i = 1; i <= 100; ++i) publisher.publish(clock_message(i));
  ASSERT_TRUE(eventually([&] { return subscription.statistics().received == 100; }));
  listener.spin_in_background();
  EXPECT_TRUE(eventually([&] { return inbox.values() == numbers(100, 100); }));
  EXPECT_EQ(subscription.statistics().superseded, 99u);
  EXPECT_EQ(subscription.statistics().dropped, 0u);
}

// A stopped process: what ZeroMQ and the kernel cannot hold waits, then is dropped and counted. No
// message is lost without being counted by one side.
TEST_P(Topics, StoppedReaderCostsOnlyCountedMessages) {
  LogReader log(options("log_reader"));
  Node talker(options("talker"));
  Child listener({"listen", "--registry", endpoint});
  auto publisher = talker.advertise<msgs::Clock>("/numbers", QoS::queue(20));
  auto big = talker.advertise<msgs::PointCloud>("/big", QoS::queue(20));
  ASSERT_TRUE(publisher.wait_for_subscribers(1, 5s));
  listener.send(SIGSTOP);
  const auto begin = std::chrono::steady_clock::now();
  for (int i = 1; i <= 20000; ++i) {
    publisher.publish(clock_message(i));
    if (i % 100 == 0) std::this_thread::sleep_for(1ms);
  }
  EXPECT_LT(std::chrono::steady_clock::now() - begin, 5s);  // publish does not wait
  EXPECT_TRUE(eventually([&] { return publisher.statistics().dropped > 0; }));
  EXPECT_TRUE(eventually([&] { return log.has("as a subscriber reads too slowly"); }));
  listener.send(SIGCONT);
}

TEST_P(Topics, AnotherTypeIsRefusedVisibly) {
  LogReader log(options("log_reader"));
  Node talker(options("talker")), listener(options("listener"));
  Inbox inbox;
  auto publisher = talker.advertise<msgs::Plane>("/thing", QoS::latched(5));
  publisher.publish(msgs::Plane());
  auto subscription = listener.subscribe<msgs::Clock>("/thing", QoS::latched(5), inbox.taker());
  listener.spin_in_background();
  EXPECT_TRUE(eventually([&] {
    return log.has(
        "node 'talker' publishes prehend.msgs.Plane, this node expects "
        "prehend.msgs.Clock");
  }));
  EXPECT_EQ(subscription.statistics().refused_publishers, 1u);
  Node right(options("right"));
  auto fitting = right.advertise<msgs::Clock>("/thing", QoS::latched(5));
  fitting.publish(clock_message(3));
  EXPECT_TRUE(eventually([&] { return inbox.values() == numbers(3, 3); }));
  EXPECT_EQ(log.count("publishes prehend.msgs.Plane"), 1u);
}

TEST_P(Topics, PayloadIsPartOfTheStandardEncoding) {
  Node talker(options("talker")), listener(options("listener"));
  std::mutex mutex;
  std::vector<RawMessage> raw;
  std::vector<std::string> typed;
  auto subscription =
      listener.subscribe_raw("/cloud", QoS::queue(10), [&](const RawMessage& message) {
        const std::lock_guard lock(mutex);
        raw.push_back(message);
      });
  auto decoded = listener.subscribe<msgs::PointCloud>("/cloud", QoS::queue(10),
                                                      [&](const Received<msgs::PointCloud>& m) {
                                                        const std::lock_guard lock(mutex);
                                                        typed.push_back(m->data());
                                                      });
  listener.spin_in_background();
  auto publisher = talker.advertise<msgs::PointCloud>("/cloud", QoS::queue(10));
  msgs::PointCloud cloud;
  cloud.set_count(1000);
  cloud.set_stride(16);
  msgs::PointCloud without = cloud;
  cloud.set_data(std::string(16000, 'x'));
  publisher.publish(cloud);
  publisher.publish(msgs::PointCloud(cloud));
  publisher.publish(without, std::vector<std::uint8_t>(16000, 'x'));
  publisher.publish(without);
  ASSERT_TRUE(eventually([&] {
    const std::lock_guard lock(mutex);
    return raw.size() == 4 && typed.size() == 4;
  }));
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(raw[i].bytes, cloud.SerializeAsString()) << i;
    EXPECT_EQ(typed[i], cloud.data()) << i;
  }
  EXPECT_EQ(raw[3].bytes, without.SerializeAsString());
  EXPECT_EQ(raw[0].schema->name, "prehend.msgs.PointCloud");
  const auto again = schema_from_descriptor_set(raw[0].schema->name, raw[0].schema->descriptor_set);
  EXPECT_EQ(again->hash, raw[0].info.schema_hash);
  EXPECT_THROW(publisher.publish(cloud, std::vector<std::uint8_t>(4)), std::invalid_argument);
}

TEST_P(Topics, EncodedMessagesKeepTheirStamp) {
  Node talker(options("talker")), listener(options("listener"));
  Inbox inbox, stamps;
  auto subscription = listener.subscribe<msgs::Clock>("/replayed", QoS::queue(10),
                                                      [&](const Received<msgs::Clock>& m) {
                                                        stamps.add(m.info().stamp);
                                                        inbox.add(m->time());
                                                      });
  listener.spin_in_background();
  const auto schema = schema_of(*msgs::Clock::descriptor());
  auto publisher =
      talker.advertise_raw("/replayed", QoS::queue(10),
                           schema_from_descriptor_set(schema->name, schema->descriptor_set));
  publisher.publish(clock_message(5).SerializeAsString(), 1234);
  EXPECT_TRUE(eventually([&] { return inbox.values() == numbers(5, 5); }));
  EXPECT_EQ(stamps.values(), numbers(1234, 1234));
}

TEST_P(Topics, DamagedEncodingIsCountedNotFatal) {
  LogReader log(options("log_reader"));
  Node talker(options("talker")), listener(options("listener"));
  Inbox inbox;
  auto subscription = listener.subscribe<msgs::Clock>("/broken", QoS::queue(10), inbox.taker());
  listener.spin_in_background();
  auto publisher =
      talker.advertise_raw("/broken", QoS::queue(10), schema_of(*msgs::Clock::descriptor()));
  publisher.publish(std::string("\x08\xff\xff\xff", 4), 1);
  publisher.publish(clock_message(2).SerializeAsString(), 1);
  EXPECT_TRUE(eventually([&] { return inbox.values() == numbers(2, 2); }));
  EXPECT_EQ(subscription.statistics().malformed, 1u);
  EXPECT_TRUE(eventually([&] { return log.has("/broken: 1 damaged messages"); }));
}

TEST_P(Topics, KilledPublisherIsNoticedAndItsSuccessorFound) {
  Node listener(options("listener"));
  Inbox inbox;
  auto subscription = listener.subscribe<msgs::Clock>("/ticks", QoS::queue(100), inbox.taker());
  listener.spin_in_background();
  Child first({"talk", "--registry", endpoint});
  ASSERT_TRUE(eventually([&] { return inbox.size() > 5; }));
  first.send(SIGKILL);
  EXPECT_EQ(first.wait(), -SIGKILL);
  EXPECT_TRUE(eventually([&] { return subscription.statistics().publishers == 0; }, 4s));
  const std::size_t before = inbox.size();
  Child second({"talk", "--registry", endpoint});  // of the same name
  EXPECT_TRUE(eventually([&] { return inbox.size() > before + 5; }));
  EXPECT_EQ(subscription.statistics().missed, 0u);
}

TEST_P(Topics, PublisherAndSubscriptionEndWithTheirHandles) {
  Node talker(options("talker")), listener(options("listener"));
  Inbox inbox;
  listener.spin_in_background();
  auto publisher = talker.advertise<msgs::Clock>("/t", QoS::queue(10));
  EXPECT_THROW((void)talker.advertise<msgs::Clock>("/t", QoS::queue(10)), std::invalid_argument);
  for (int round = 0; round < 20; ++round) {  // some end before they know that they have joined
    {
      auto subscription = listener.subscribe<msgs::Clock>("/t", QoS::queue(10), inbox.taker());
      ASSERT_TRUE(publisher.wait_for_subscribers(1, 5s));
    }
    ASSERT_TRUE(eventually([&] { return publisher.subscriber_count() == 0; })) << round;
  }
  publisher = Publisher<msgs::Clock>();
  publisher = talker.advertise<msgs::Clock>("/t", QoS::queue(10));
  auto subscription = listener.subscribe<msgs::Clock>("/t", QoS::queue(10), inbox.taker());
  EXPECT_TRUE(publisher.wait_for_subscribers(1, 5s));
  EXPECT_THROW(Publisher<msgs::Clock>().publish(clock_message(1)), std::logic_error);
}

TEST_P(Topics, ExceptionInACallbackIsReportedAndTheNodeGoesOn) {
  LogReader log(options("log_reader"));
  Node node(options("clumsy"));
  Inbox inbox;
  auto subscription =
      node.subscribe<msgs::Clock>("/t", QoS::queue(10), [&](const Received<msgs::Clock>& m) {
        if (m->time() == 1) throw std::runtime_error("one is too few");
        inbox.add(m->time());
      });
  node.spin_in_background();
  auto publisher = node.advertise<msgs::Clock>("/t", QoS::queue(10));
  publisher.publish(clock_message(1));
  publisher.publish(clock_message(2));
  EXPECT_TRUE(eventually([&] { return inbox.values() == numbers(2, 2); }));
  EXPECT_TRUE(eventually([&] {
    return log.has(
        "clumsy: subscription to /t: exception in the "
        "callback: one is too few");
  }));
}

TEST_P(Topics, RemappedAndMalformedNames) {
  NodeOptions remapped = options("talker");
  remapped.remaps["/from"] = "/to";
  Node talker(remapped);
  auto publisher = talker.advertise<msgs::Clock>("/from", QoS::queue(10));
  EXPECT_EQ(publisher.topic(), "/to");
  remapped.name = "talkers";
  remapped.remaps = {
      {"/pads/*", "/world/pads/*"}, {"/pads/left/*", "/left/*"}, {"/pads/top", "/t"}};
  Node talkers(remapped);
  for (const auto& [from, to] : {std::pair{"/pads/thumb", "/world/pads/thumb"},
                                 {"/pads/left/thumb/tip", "/left/thumb/tip"},
                                 {"/pads/top", "/t"},
                                 {"/pads", "/pads"},
                                 {"/padscale/a", "/padscale/a"}}) {
    EXPECT_EQ(talkers.advertise<msgs::Clock>(from, QoS::queue(10)).topic(), to);
  }
  NodeOptions half = options("half");
  half.remaps["/pads/*"] = "/world";
  Node one_sided(half);
  EXPECT_THROW((void)one_sided.advertise<msgs::Clock>("/pads/a", QoS::queue(1)),
               std::invalid_argument);
  for (const char* bad : {"", "/", "no_slash", "/two//slashes", "/end/", "/spa ce"}) {
    EXPECT_THROW((void)talker.advertise<msgs::Clock>(bad, QoS::queue(1)), std::invalid_argument)
        << bad;
  }
  EXPECT_THROW((void)talker.advertise<msgs::Clock>("/zero", QoS::queue(0)), std::invalid_argument);
}

TEST_P(Topics, WatcherLearnsOfEveryTopicOnce) {
  Node watcher(options("watcher"));
  std::mutex mutex;
  std::vector<std::string> seen;
  watcher.watch_topics([&](const TopicInfo& info) {
    const std::lock_guard lock(mutex);
    if (info.topic == "/t") seen.push_back(info.publishers.at(0) + " " + info.schema_name);
  });
  watcher.spin_in_background();
  Node talker(options("talker"));
  auto publisher = talker.advertise<msgs::Clock>("/t", QoS::latched(10));
  const auto look = [&] {
    const std::lock_guard lock(mutex);
    return seen;
  };
  EXPECT_TRUE(eventually([&] { return !look().empty(); }));
  EXPECT_EQ(look(), std::vector<std::string>{"talker prehend.msgs.Clock"});
}

}  // namespace
}  // namespace prehend::graph
