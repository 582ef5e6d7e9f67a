#include "tests/graph/test_graph.h"

#include <sys/socket.h>

#include <zmq.hpp>

#include <cmath>
#include <fstream>
#include <limits>

#include "prehend/graph/introspection.h"

namespace prehend::graph {
namespace {

std::string message_of(const std::function<void()>& throwing) {
  try {
    throwing();
  } catch (const std::exception& error) {
    return error.what();
  }
  return "nothing was thrown";
}

class Parameters : public GraphTest {};

TEST_F(Parameters, GivenValuesAreCheckedAgainstTheDeclaration) {
  NodeOptions given = options("node");
  given.parameters = {{"depth", "9"}, {"rate", "1e-3"}, {"on", "true"}, {"mode", "fast"}};
  Node node(given);
  EXPECT_EQ(node.declare_parameter<int>({.name = "depth", .default_value = 7}), 9);
  EXPECT_EQ(node.declare_parameter<double>({.name = "rate", .default_value = 2}), 1e-3);
  EXPECT_EQ(node.declare_parameter<bool>({.name = "on"}), true);
  EXPECT_EQ(node.declare_parameter<std::string>(
                {.name = "mode", .default_value = "slow", .choices = {"slow", "fast"}}),
            "fast");
  EXPECT_EQ(node.declare_parameter<std::int64_t>({.name = "other", .default_value = 3}), 3);
  EXPECT_EQ(node.parameter<int>("depth"), 9);
  EXPECT_THROW(node.parameter<double>("depth"), std::invalid_argument);
  EXPECT_THROW(node.declare_parameter<int>({.name = "depth"}), std::invalid_argument);
  EXPECT_EQ(message_of([&] { node.parameter<int>("dpeth"); }),
            "no parameter 'dpeth'; did you mean \"depth\"?");
}

TEST_F(Parameters, BadValuesAreRefusedWithTheReason) {
  Node node(options("node"));
  node.declare_parameter<int>({.name = "n", .default_value = 5, .minimum = 1, .maximum = 9});
  node.declare_parameter<double>({.name = "x", .default_value = 1, .unit = "m", .minimum = 0});
  node.declare_parameter<std::string>({.name = "s", .default_value = "a", .choices = {"a", "b"}});
  for (const char* bad : {"", "0", "10", "3.5", "x", "5 ", "99999999999999999999"}) {
    EXPECT_THROW(node.set_parameter("n", bad), std::invalid_argument) << bad;
  }
  for (const char* bad : {"nan", "inf", "-0.1", "1e999"}) {
    EXPECT_THROW(node.set_parameter("x", bad), std::invalid_argument) << bad;
  }
  EXPECT_EQ(message_of([&] { node.set_parameter("x", "-1"); }),
            "parameter 'x' [m]: '-1' must be at least 0");
  EXPECT_EQ(message_of([&] { node.set_parameter("s", "c"); }),
            "parameter 's': 'c' must be one of: a, b");
  EXPECT_EQ(node.parameter<int>("n"), 5);  // unharmed
}

TEST_F(Parameters, UnknownGivenParameterStopsTheNodeBeforeItSpins) {
  NodeOptions given = options("node");
  given.parameters["orientatoins"] = "3";
  Node node(given);
  node.declare_parameter<int>({.name = "orientations", .default_value = 5});
  EXPECT_EQ(message_of([&] { node.spin(); }),
            "unknown parameter 'orientatoins'; did you mean \"orientations\"?");
  Child child({"talk", "--registry", endpoint, "--param", "cuont:=3"});
  EXPECT_EQ(child.wait(), 1);
}

TEST_F(Parameters, AreReadAndSetFromOutside) {
  Node node(options("node"));
  std::atomic<int> changed_to = 0;
  node.declare_parameter<int>(
      {.name = "n", .default_value = 5, .minimum = 1, .on_change = [&](const int& value) {
         changed_to = value;
       }});
  node.spin_in_background();
  Introspection look(endpoint);
  EXPECT_EQ(to_text(look.parameter("node", "n").value()), "5");
  EXPECT_EQ(to_text(look.set_parameter("node", "n", "8").value()), "8");
  EXPECT_EQ(node.parameter<int>("n"), 8);
  EXPECT_TRUE(eventually([&] { return changed_to == 8; }));
  EXPECT_EQ(look.parameters("node").size(), 1u);
  EXPECT_EQ(message_of([&] { look.set_parameter("node", "n", "0"); }),
            "node 'node': parameter 'n': '0' must be at least 1");
  EXPECT_EQ(message_of([&] { look.parameters("nodee"); }),
            "no node 'nodee' is there; did you mean \"node\"?");
}

TEST_F(Parameters, FileOfParameters) {
  const auto file = std::filesystem::temp_directory_path() /
                    ("prehend_parameters_" + std::to_string(::getpid()) + ".yaml");
  std::ofstream(file) << "count: 0.5\n";
  Child wrong({"talk", "--registry", endpoint, "--params", file});
  EXPECT_EQ(wrong.wait(), 2);
  std::ofstream(file) << "count: 3\n";
  Child overridden({"talk", "--registry", endpoint, "--params", file, "--param", "count:=4"});
  Introspection look(endpoint);
  EXPECT_TRUE(eventually([&] {
    const auto nodes = look.nodes();
    return nodes.size() == 1 && nodes[0].state() == msgs::graph::READY;
  }));
  EXPECT_EQ(to_text(look.parameter("test_talk", "count").value()), "4");
  std::filesystem::remove(file);
}

class RegistryOfNodes : public GraphTest {};

TEST_F(RegistryOfNodes, ListsWhatNodesOffer) {
  Node node(options("node"));
  auto publisher = node.advertise<msgs::Clock>("/t", QoS::latched(3));
  auto service = node.serve<msgs::Clock, msgs::Clock>("/s", [](const msgs::Clock& c) { return c; });
  node.report(Health::kWarning, "no table");
  node.spin_in_background();
  Introspection look(endpoint);
  EXPECT_TRUE(eventually([&] {
    const auto nodes = look.nodes();
    return nodes.size() == 1 && nodes[0].state() == msgs::graph::READY &&
           nodes[0].services_size() == 1 && nodes[0].publishers_size() == 4 &&
           nodes[0].health_text() == "no table" && nodes[0].pid() == ::getpid();
  }));
  const Schema schema = look.topic_schema("/t");
  EXPECT_EQ(schema_from_descriptor_set(schema.name, schema.descriptor_set)->hash, schema.hash);
  EXPECT_THROW(look.topic_schema("/tt"), std::runtime_error);
}

TEST_F(RegistryOfNodes, SecondNodeOfANameIsRefusedNamingThePid) {
  Node first(options("twin"));
  const std::string error = message_of([&] { Node second(options("twin")); });
  EXPECT_NE(error.find("'twin' runs already (pid " + std::to_string(::getpid()) + ")"),
            std::string::npos)
      << error;
}

TEST_F(RegistryOfNodes, NameOfADeadNodeIsFreeAtOnce) {
  Child first({"talk", "--registry", endpoint});
  Introspection look(endpoint);
  ASSERT_TRUE(eventually([&] { return look.nodes().size() == 1; }));
  first.send(SIGKILL);
  first.wait();
  EXPECT_NO_THROW(Node(options("test_talk")));
}

// What changes while a node leaves must not make the registry take it up again, until its lease.
TEST_F(RegistryOfNodes, NodeThatLeavesAmidChangesIsGoneAtOnce) {
  Introspection look(endpoint);
  for (int round = 0; round < 20; ++round) {
    {
      Node node(options("guest"));
      auto publisher = node.advertise<msgs::Clock>("/t", QoS::queue(10));
      auto subscription =
          node.subscribe<msgs::Clock>("/t", QoS::queue(10), [](const Received<msgs::Clock>&) {});
    }
    ASSERT_TRUE(eventually([&] { return look.nodes().empty(); }, 2s)) << round;
  }
}

TEST_F(RegistryOfNodes, SilentNodeLosesItsLease) {
  registry.reset();
  registry = std::make_unique<Registry>(RegistryOptions{.endpoint = endpoint, .lease = 1500ms});
  Child child({"talk", "--registry", endpoint});
  Introspection look(endpoint);
  ASSERT_TRUE(eventually([&] { return look.nodes().size() == 1; }));
  child.send(SIGSTOP);
  EXPECT_TRUE(eventually([&] { return look.nodes().empty(); }));
  child.send(SIGCONT);  // and comes back by itself
  EXPECT_TRUE(eventually([&] { return look.nodes().size() == 1; }));
}

TEST_F(RegistryOfNodes, PortInUseIsAClearError) {
  EXPECT_NE(message_of([&] { Registry second({.endpoint = endpoint}); }).find("is in use"),
            std::string::npos);
  EXPECT_NE(message_of([&] { Registry wrong({.endpoint = "rubbish"}); }).find("an example is"),
            std::string::npos);
}

TEST_F(RegistryOfNodes, NoRegistryIsAClearError) {
  registry.reset();
  NodeOptions alone = options("alone");
  alone.registry_timeout = 300ms;
  EXPECT_NE(message_of([&] { Node node(alone); }).find("no registry answers at " + endpoint),
            std::string::npos);
  Introspection look(endpoint, 200ms);
  EXPECT_NE(message_of([&] { look.nodes(); }).find("does not answer"), std::string::npos);
}

TEST_F(RegistryOfNodes, MessagesFlowWhileTheRegistryIsReplaced) {
  Node talker(options("talker")), listener(options("listener"));
  Inbox inbox;
  auto subscription = listener.subscribe<msgs::Clock>("/t", QoS::queue(1000), inbox.taker());
  listener.spin_in_background();
  auto publisher = talker.advertise<msgs::Clock>("/t", QoS::queue(1000));
  ASSERT_TRUE(publisher.wait_for_subscribers(1, 5s));
  registry.reset();
  publisher.publish(clock_message(1));
  EXPECT_TRUE(eventually([&] { return inbox.size() == 1; }));
  registry = std::make_unique<Registry>(RegistryOptions{.endpoint = endpoint});
  Introspection look(endpoint);
  EXPECT_TRUE(eventually([&] { return look.nodes().size() == 2; }));
  Node newcomer(options("newcomer"));
  Inbox other;
  auto late = newcomer.subscribe<msgs::Clock>("/t", QoS::queue(1000), other.taker());
  newcomer.spin_in_background();
  ASSERT_TRUE(publisher.wait_for_subscribers(2, 5s));
  publisher.publish(clock_message(2));
  EXPECT_TRUE(eventually([&] { return inbox.size() == 2 && other.size() == 1; }));
  EXPECT_EQ(subscription.statistics().missed, 0u);
}

TEST_F(RegistryOfNodes, SocketsAreRemoved) {
  namespace fs = std::filesystem;
  const std::string folder = registry->runtime_folder();
  const auto sockets = [&] {
    return std::distance(fs::directory_iterator(folder), fs::directory_iterator());
  };
  Child child({"talk", "--registry", endpoint});
  {
    Node node(options("node"));
    ASSERT_TRUE(eventually([&] { return sockets() == 3; }));
  }
  EXPECT_EQ(sockets(), 2);  // the other node's, and the registry's own file
  child.send(SIGKILL);
  child.wait();
  EXPECT_TRUE(eventually([&] { return sockets() == 1; }));
  registry.reset();
  EXPECT_FALSE(fs::exists(folder));
}

// Rubbish at a node's own socket and from a foreign "publisher" must not hurt.
TEST_F(RegistryOfNodes, DamagedFramesAreCountedAndLogged) {
  LogReader log(options("log_reader"));
  Node node(options("victim"));
  Inbox inbox;
  auto subscription = node.subscribe<msgs::Clock>("/t", QoS::queue(10), inbox.taker());
  node.spin_in_background();
  Introspection look(endpoint);
  std::string victim;
  for (const auto& record : look.nodes()) {
    if (record.name() == "victim") victim = record.endpoint();
  }
  zmq::context_t context;
  zmq::socket_t attacker(context, zmq::socket_type::dealer);
  attacker.set(zmq::sockopt::linger, 0);
  attacker.connect(victim);
  for (int frames = 1; frames <= 20; ++frames) {
    for (int i = 1; i <= frames; ++i) {
      attacker.send(zmq::buffer(std::string("\xff\x00rubbish", 9)),
                    i < frames ? zmq::send_flags::sndmore : zmq::send_flags::none);
    }
  }
  msgs::graph::PeerMessage strange;  // an answer nobody asked for
  strange.mutable_answer()->set_id(99);
  attacker.send(zmq::message_t(), zmq::send_flags::sndmore);
  attacker.send(zmq::buffer(strange.SerializeAsString()), zmq::send_flags::none);
  EXPECT_TRUE(eventually([&] { return log.has("21 damaged or foreign messages"); }));
  Node talker(options("talker"));
  auto publisher = talker.advertise<msgs::Clock>("/t", QoS::queue(10));
  publisher.publish(clock_message(1));
  EXPECT_TRUE(eventually([&] { return inbox.size() == 1; }));
}

TEST_F(RegistryOfNodes, DamagedFramesOfAPublisherAreCounted) {
  LogReader log(options("log_reader"));
  zmq::context_t context;
  zmq::socket_t fake(context, zmq::socket_type::router), link(context, zmq::socket_type::dealer);
  fake.set(zmq::sockopt::linger, 0);
  link.set(zmq::sockopt::linger, 0);
  fake.bind("tcp://127.0.0.1:*");
  link.connect(endpoint);
  msgs::graph::RegistryRequest request;
  auto& record = *request.mutable_update();
  record.set_name("fake");
  record.set_instance("fake-0-0");
  record.set_endpoint(fake.get(zmq::sockopt::last_endpoint));
  record.set_version(1);
  auto& end = *record.add_publishers();
  end.set_topic("/t");
  end.set_id(1);
  end.set_schema_hash(schema_of(*msgs::Clock::descriptor())->hash);
  link.send(zmq::buffer(request.SerializeAsString()), zmq::send_flags::none);

  Node node(options("victim"));
  Inbox inbox;
  auto subscription = node.subscribe<msgs::Clock>("/t", QoS::queue(10), inbox.taker());
  node.spin_in_background();
  fake.set(zmq::sockopt::rcvtimeo, 5000);
  zmq::message_t route, empty, join;
  ASSERT_TRUE(fake.recv(route));
  ASSERT_TRUE(fake.recv(empty));
  ASSERT_TRUE(fake.recv(join));
  msgs::graph::PeerMessage subscribe;
  ASSERT_TRUE(subscribe.ParseFromArray(join.data(), static_cast<int>(join.size())));
  const auto send = [&](const std::vector<std::string>& frames) {
    fake.send(zmq::buffer(route.to_string()), zmq::send_flags::sndmore);
    for (std::size_t i = 0; i < frames.size(); ++i) {
      fake.send(zmq::buffer(frames[i]),
                i + 1 < frames.size() ? zmq::send_flags::sndmore : zmq::send_flags::none);
    }
  };
  msgs::graph::PeerMessage joined;
  joined.mutable_subscribed()->set_topic("/t");
  joined.mutable_subscribed()->set_subscription(subscribe.subscribe().subscription());
  joined.mutable_subscribed()->set_next_sequence(1);
  send({"", joined.SerializeAsString()});
  msgs::graph::PeerMessage history_end;
  history_end.mutable_history_end()->set_topic("/t");
  history_end.mutable_history_end()->set_subscription(subscribe.subscribe().subscription());
  send({"", history_end.SerializeAsString()});
  msgs::graph::Envelope envelope;
  envelope.set_sequence(1);
  envelope.set_schema_hash(end.schema_hash());
  send({"/t", "\xff\xff", "a", "b", "c"});                                 // envelope
  send({"/t"});                                                            // too few
  send({"/t", envelope.SerializeAsString(), "", "", "", "", "", "", ""});  // too many
  send({"/t", envelope.SerializeAsString(), "\xff", "\xff", "\xff"});      // content
  envelope.set_sequence(2);
  envelope.set_schema_hash(5);
  send({"/t", envelope.SerializeAsString(), "", "", ""});  // another type
  envelope.set_sequence(6);
  envelope.set_schema_hash(end.schema_hash());
  send({"/t", envelope.SerializeAsString(), clock_message(6).SerializeAsString(), "", ""});
  EXPECT_TRUE(eventually([&] { return inbox.values() == std::vector<std::int64_t>{6}; }));
  const auto statistics = subscription.statistics();
  EXPECT_EQ(statistics.malformed, 2u);
  EXPECT_EQ(statistics.missed, 4u);  // 2 … 5
  EXPECT_TRUE(eventually([&] { return log.has("3 damaged or foreign messages"); }));
  EXPECT_TRUE(eventually([&] { return log.has("/t: 4 messages never came"); }));
}

class Time : public GraphTest {};

TEST_F(Time, TimersFollowTheSimulatedClock) {
  Node simulation(options("simulation"));
  NodeOptions simulated = options("node");
  simulated.clock = ClockMode::kSimulated;
  Node node(simulated);
  Inbox ticks;
  auto timer = node.create_timer(0.1, [&] { ticks.add(node.clock().now()); });
  node.spin_in_background();
  auto clock = simulation.advertise<msgs::Clock>("/clock", QoS::latched(1));
  ASSERT_TRUE(clock.wait_for_subscribers(1, 5s));
  std::atomic<int> slept = 0;
  const auto advance = [&](std::int64_t stamp) {
    clock.publish(clock_message(stamp));
    ASSERT_TRUE(eventually([&] { return node.clock().now() == stamp; }));
    std::this_thread::sleep_for(20ms);
  };
  advance(1'000'000'000);
  std::thread sleeper([&] { slept = node.clock().sleep_for(250ms) ? 1 : -1; });
  std::this_thread::sleep_for(300ms);  // wall time does not count
  EXPECT_EQ(slept, 0);
  EXPECT_EQ(ticks.size(), 0u);
  for (std::int64_t stamp : {1'050'000'000, 1'100'000'000, 1'200'000'000}) advance(stamp);
  EXPECT_EQ(ticks.values(), (std::vector<std::int64_t>{1'100'000'000, 1'200'000'000}));
  EXPECT_EQ(slept, 0);
  advance(1'250'000'000);
  EXPECT_TRUE(eventually([&] { return slept == 1; }));
  sleeper.join();
  advance(500'000'000);  // back to an earlier time, as a replay that loops
  advance(600'000'000);
  EXPECT_EQ(ticks.values().back(), 600'000'000);
}

TEST_F(Time, ShutdownEndsSleeps) {
  Node node(options("node"));
  std::thread stopper([&] {
    std::this_thread::sleep_for(50ms);
    node.shutdown();
  });
  EXPECT_FALSE(node.clock().sleep_for(60s));
  EXPECT_FALSE(node.clock().sleep_until(node.clock().now() + nanoseconds(60)));
  stopper.join();
  EXPECT_FALSE(node.ok());
}

TEST_F(Time, WallTimerRunsAtItsRate) {
  Node node(options("node"));
  std::atomic<int> ticks = 0;
  auto timer = node.create_timer(0.02, [&] { ++ticks; });
  const auto begin = std::chrono::steady_clock::now();
  node.spin_in_background();
  std::this_thread::sleep_for(500ms);
  timer = {};
  const int seen = ticks;
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - begin;
  EXPECT_GE(seen, 5);  // a busy machine merges ticks, but never adds any
  EXPECT_LE(seen, elapsed.count() / 0.02 + 1);
  std::this_thread::sleep_for(100ms);
  EXPECT_EQ(ticks, seen);
  EXPECT_THROW((void)node.create_timer(0, [] {}), std::invalid_argument);
  EXPECT_THROW((void)node.create_timer(std::nan(""), [] {}), std::invalid_argument);
}

}  // namespace
}  // namespace prehend::graph
