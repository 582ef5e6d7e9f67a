#include "prehend/graph/registry.h"

#include <gmock/gmock.h>

#include <map>
#include <set>
#include <zmq.hpp>

#include "prehend/graph/introspection.h"
#include "prehend/graph/link/runtime_folder.h"
#include "prehend/graph/registry_state.h"
#include "tests/graph/test_graph.h"

namespace prehend::graph {
namespace {

using msgs::graph::NodeRecord;
using msgs::graph::RegistryReply;
using msgs::graph::RegistryRequest;
using testing::HasSubstr;

NodeRecord record_of(const std::string& name, std::uint64_t version = 1) {
  NodeRecord record;
  record.set_name(name);
  record.set_instance(name + "-0-0");
  record.set_endpoint("ipc:///tmp/" + name);
  record.set_version(version);
  return record;
}

void add_publisher(NodeRecord& record, const std::string& topic) {
  auto& end = *record.add_publishers();
  end.set_topic(topic);
  end.set_schema_name("prehend.msgs.Clock");
  end.set_schema_hash(schema_of(*msgs::Clock::descriptor())->hash);
  end.set_id(static_cast<std::uint64_t>(record.publishers_size()));
}

/// What a registry answers, by route, without sockets.
class RegistryAnswers : public testing::Test {
 protected:
  RegistryAnswers() {
    limits.nodes = 5;
    limits.ends = 10;
    limits.record_bytes = 2000;
    limits.all_record_bytes = 6000;
    limits.schema_bytes = 20000;
    limits.all_schema_bytes = 30000;
    state = std::make_unique<RegistryState>(
        RegistryState::Options{std::chrono::milliseconds(3000), "registry", "/run/x",
                               process_space(), limits},
        [this](const std::string& route, const RegistryReply& reply) { sent[route] = reply; });
  }
  RegistryReply ask(const std::string& route, RegistryRequest request) {
    sent.clear();
    request.set_id(7);
    EXPECT_TRUE(state->take(route, request.SerializeAsString(), now));
    return sent[route];
  }
  RegistryReply update(const std::string& route, const NodeRecord& record) {
    RegistryRequest request;
    *request.mutable_update() = record;
    return ask(route, request);
  }
  RegistryReply put(const Schema& schema) {
    RegistryRequest request;
    request.mutable_put_schema()->set_name(schema.name);
    request.mutable_put_schema()->set_hash(schema.hash);
    request.mutable_put_schema()->set_descriptor_set(schema.descriptor_set);
    return ask("a", request);
  }
  int listed() {
    RegistryRequest request;
    request.mutable_list();
    return ask("looker", request).nodes_size();
  }

  RegistryLimits limits;
  std::unique_ptr<RegistryState> state;
  std::map<std::string, RegistryReply> sent;
  RegistryState::Time now{};
};

TEST_F(RegistryAnswers, RecordsThatAreNoneAreRefusedInWords) {
  EXPECT_THAT(update("a", NodeRecord()).error(), HasSubstr("its name is empty"));
  EXPECT_THAT(update("a", record_of("bad name")).error(), HasSubstr("use 1 to 100 letters"));
  EXPECT_THAT(update("a", record_of(std::string(5000, 'x'))).error(), HasSubstr("5000 bytes"));
  NodeRecord record = record_of("node");
  record.set_instance(std::string(100000, 'i'));
  EXPECT_THAT(update("a", record).error(), HasSubstr("its instance has 100000 bytes"));
  EXPECT_LT(update("a", record).error().size(), 300u);
  record = record_of("node");
  record.clear_endpoint();
  EXPECT_THAT(update("a", record).error(), HasSubstr("its endpoint is empty"));
  record = record_of("node");
  record.set_health_text(std::string(3000, 'h'));
  EXPECT_THAT(update("a", record).error(), HasSubstr("at most 2000 are taken"));
  record = record_of("node");
  for (int i = 0; i < 11; ++i) add_publisher(record, "/t");
  EXPECT_THAT(update("a", record).error(), HasSubstr("at most 10 are taken"));
  record = record_of("node");
  add_publisher(record, "no slash");
  EXPECT_THAT(update("a", record).error(), HasSubstr("'no slash'"));
  EXPECT_EQ(listed(), 0);
  EXPECT_EQ(update("a", record_of("node")).error(), "");
  EXPECT_EQ(listed(), 1);
}

TEST_F(RegistryAnswers, WrongProcessesAndStolenInstancesAreRefused) {
  NodeRecord record = record_of("node");
  record.set_process_space(process_space());
  for (const std::int64_t pid : {std::int64_t{0}, std::int64_t{-1}, std::int64_t{1} << 40}) {
    record.set_pid(pid);
    EXPECT_THAT(update("a", record).error(), HasSubstr("no process")) << pid;
  }
  record.set_pid(::getpid());
  EXPECT_EQ(update("a", record).error(), "");
  NodeRecord thief = record_of("thief");
  thief.set_instance(record.instance());
  EXPECT_THAT(update("b", thief).error(), HasSubstr("node 'node'"));
  EXPECT_EQ(listed(), 1);
}

TEST_F(RegistryAnswers, NodesAndTheirRecordsHaveABound) {
  for (int i = 0; i < 5; ++i) {
    EXPECT_EQ(update("a", record_of("n" + std::to_string(i))).error(), "");
  }
  EXPECT_THAT(update("a", record_of("n5")).error(), HasSubstr("holds 5 nodes already"));
  for (int i = 0; i < 3; ++i) {
    NodeRecord record = record_of("n" + std::to_string(i), 2);
    record.set_health_text(std::string(1800, 'h'));
    EXPECT_EQ(update("a", record).error(), "");
  }
  NodeRecord record = record_of("n3", 2);
  record.set_health_text(std::string(1800, 'h'));
  EXPECT_THAT(update("a", record).error(), HasSubstr("bytes of node records already"));
  EXPECT_EQ(update("a", record_of("n0", 3)).error(), "");  // a smaller one makes room
  EXPECT_EQ(update("a", record).error(), "");
  RegistryRequest goodbye;
  goodbye.mutable_goodbye()->set_instance("n1-0-0");
  ask("a", goodbye);
  EXPECT_EQ(update("a", record_of("n5")).error(), "");
}

TEST_F(RegistryAnswers, MessageTypesAreCheckedAndBounded) {
  const Schema clock = *schema_of(*msgs::Clock::descriptor());
  Schema wrong = clock;
  wrong.hash ^= 1;
  EXPECT_THAT(put(wrong).error(), HasSubstr("its hash is not that of its descriptors"));
  wrong = clock;
  wrong.descriptor_set = "rubbish";
  EXPECT_THAT(put(wrong).error(), HasSubstr("not a FileDescriptorSet"));
  wrong.descriptor_set = std::string(100000, '\0');
  EXPECT_THAT(put(wrong).error(), HasSubstr("at most 20000 are taken"));
  EXPECT_EQ(put(clock).error(), "");
  RegistryRequest question;
  question.mutable_get_schema()->set_name(clock.name);
  EXPECT_EQ(ask("a", question).schema().hash(), clock.hash);
  wrong.hash = clock.hash;  // cannot replace the true one
  EXPECT_EQ(put(wrong).error(), "");
  EXPECT_EQ(ask("a", question).schema().descriptor_set(), clock.descriptor_set);
  question.mutable_get_schema()->set_name(std::string(100000, 'x'));
  EXPECT_LT(ask("a", question).error().size(), 400u);
}

TEST_F(RegistryAnswers, MessageTypesNobodyUsesMakeRoomForOthers) {
  limits.all_schema_bytes =
      schema_of(*msgs::graph::LogLine::descriptor())->descriptor_set.size() + 200;
  state = std::make_unique<RegistryState>(
      RegistryState::Options{std::chrono::milliseconds(3000), "registry", "/run/x", process_space(),
                             limits},
      [this](const std::string& route, const RegistryReply& reply) { sent[route] = reply; });
  EXPECT_EQ(put(*schema_of(*msgs::graph::LogLine::descriptor())).error(), "");
  EXPECT_EQ(put(*schema_of(*msgs::graph::Diagnostic::descriptor())).error(), "");
  NodeRecord record = record_of("node");
  auto& end = *record.add_publishers();
  end.set_topic("/diagnostics");
  end.set_schema_hash(schema_of(*msgs::graph::Diagnostic::descriptor())->hash);
  EXPECT_EQ(update("a", record).wanted_schemas_size(), 0);
  EXPECT_THAT(put(*schema_of(*msgs::graph::LogLine::descriptor())).error(),
              HasSubstr("bytes of message types already"));
}

TEST_F(RegistryAnswers, BeatOfANodeThatCameBackBringsItsNewRoute) {
  update("first", record_of("node"));
  RegistryRequest beat;
  beat.mutable_heartbeat()->set_instance("node-0-0");
  beat.mutable_heartbeat()->set_version(1);
  EXPECT_FALSE(ask("second", beat).unknown_node());
  update("other", record_of("other"));
  EXPECT_EQ(sent.count("second"), 1u);  // pushed changes go there now
  EXPECT_EQ(sent.count("first"), 0u);
}

class RegistryUnderLoad : public GraphTest {};

/// A node in the registry's eyes only.
class FakeNode {
 public:
  FakeNode(zmq::context_t& context, const std::string& registry, const std::string& name)
      : record_(record_of(name, 0)), socket_(context, zmq::socket_type::dealer) {
    socket_.set(zmq::sockopt::linger, 0);
    socket_.connect(registry);
  }
  void change() {
    record_.set_version(record_.version() + 1);
    add_publisher(record_, "/" + record_.name() + "/t" + std::to_string(record_.version()));
    RegistryRequest request;
    request.set_id(record_.version());
    *request.mutable_update() = record_;
    socket_.send(zmq::buffer(request.SerializeAsString()), zmq::send_flags::none);
  }
  void read() {
    zmq::message_t message;
    while (socket_.recv(message, zmq::recv_flags::dontwait)) {
      ++messages;
      bytes += message.size();
      RegistryReply reply;
      if (!reply.ParseFromArray(message.data(), static_cast<int>(message.size()))) continue;
      EXPECT_EQ(reply.error(), "");
      for (const auto& node : reply.nodes()) {
        std::uint64_t& version = versions[node.instance()];
        version = std::max(version, node.version());
      }
    }
  }
  /// All of `count` nodes are known here in `version`.
  bool knows(std::size_t count, std::uint64_t version) const {
    if (versions.size() != count) return false;
    for (const auto& [instance, known] : versions) {
      if (known != version) return false;
    }
    return true;
  }

  std::map<std::string, std::uint64_t> versions;
  std::size_t messages = 0, bytes = 0;

 private:
  NodeRecord record_;
  zmq::socket_t socket_;
};

TEST_F(RegistryUnderLoad, TwoHundredNodesJoinAndChange) {
  constexpr std::size_t kNodes = 200;
  constexpr std::uint64_t kChanges = 5;
  registry.reset();
  registry = std::make_unique<Registry>(RegistryOptions{.endpoint = endpoint, .lease = 60s});
  zmq::context_t context;
  std::vector<std::unique_ptr<FakeNode>> nodes;
  for (std::size_t i = 0; i < kNodes; ++i) {
    nodes.push_back(std::make_unique<FakeNode>(context, endpoint, "fake" + std::to_string(i)));
  }
  const auto begin = std::chrono::steady_clock::now();
  for (std::uint64_t change = 1; change <= kChanges; ++change) {
    for (auto& node : nodes) {
      node->change();
      node->read();
    }
  }
  EXPECT_TRUE(eventually(
      [&] {
        bool all = true;
        for (auto& node : nodes) {
          node->read();
          all = all && node->knows(kNodes, kChanges);
        }
        return all;
      },
      60s));
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
  std::size_t messages = 0, bytes = 0;
  for (const auto& node : nodes) {
    messages += node->messages;
    bytes += node->bytes;
  }
  std::printf("%zu nodes with %d changes each: %.2f s, %zu messages, %.1f MB to the nodes\n",
              kNodes, static_cast<int>(kChanges), took.count(), messages,
              static_cast<double>(bytes) * 1e-6);
  // Each change goes to each node once, and the whole list once to each node that joins.
  EXPECT_LE(messages, kNodes * (kNodes + 1) * kChanges);
  NodeRecord largest = record_of("fake199", kChanges);
  for (std::uint64_t i = 1; i <= kChanges; ++i) add_publisher(largest, "/fake199/t1");
  EXPECT_LE(bytes, kNodes * (kNodes + 1) * (kChanges + 1) * (largest.ByteSizeLong() + 64));
}

TEST_F(RegistryUnderLoad, NodesFindANewRegistryAndItAllOfThem) {
  constexpr std::size_t kNodes = 12;
  std::vector<std::unique_ptr<Node>> nodes;
  for (std::size_t i = 0; i < kNodes; ++i) {
    nodes.push_back(std::make_unique<Node>(options("node" + std::to_string(i))));
  }
  for (int round = 0; round < 3; ++round) {
    registry.reset();
    std::this_thread::sleep_for(700ms);
    const auto begin = std::chrono::steady_clock::now();
    registry = std::make_unique<Registry>(RegistryOptions{.endpoint = endpoint});
    Introspection look(endpoint);
    EXPECT_TRUE(eventually([&] { return look.nodes().size() == kNodes; }));
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
    std::printf("%zu nodes known to the new registry after %.2f s\n", kNodes, took.count());
  }
}

TEST_F(RegistryUnderLoad, RubbishIsCountedAndLoggedOnceASecond) {
  testing::internal::CaptureStderr();
  zmq::context_t context;
  zmq::socket_t rude(context, zmq::socket_type::dealer);
  rude.set(zmq::sockopt::linger, 0);
  rude.connect(endpoint);
  for (int i = 0; i < 500; ++i) {
    rude.send(zmq::buffer(std::string("\xff\xff rubbish")), zmq::send_flags::none);
  }
  for (int frames = 0; frames < 20; ++frames) rude.send(zmq::message_t(), zmq::send_flags::sndmore);
  rude.send(zmq::message_t(), zmq::send_flags::none);
  std::this_thread::sleep_for(1500ms);
  EXPECT_TRUE(Introspection(endpoint).nodes().empty());
  const std::string words = testing::internal::GetCapturedStderr();
  EXPECT_THAT(words, HasSubstr("501 messages that are no requests thrown away in all"));
  EXPECT_LE(std::count(words.begin(), words.end(), '\n'), 3);
}

}  // namespace
}  // namespace prehend::graph
