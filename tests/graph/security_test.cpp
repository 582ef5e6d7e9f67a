#include "prehend/graph/security.h"

#include <sys/stat.h>
#include <zmq.h>

#include <cstdlib>
#include <fstream>
#include <sstream>
#include <zmq.hpp>

#include "prehend/graph/introspection.h"
#include "tests/graph/raw_peer.h"
#include "tests/graph/test_graph.h"

namespace prehend::graph {
namespace {

namespace fs = std::filesystem;

std::string message_of(const std::function<void()>& throwing) {
  try {
    throwing();
  } catch (const std::exception& error) {
    return error.what();
  }
  return "nothing was thrown";
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

class KeyFiles : public testing::Test {
 protected:
  KeyFiles() {
    std::string pattern = fs::temp_directory_path() / "prehend_keys_XXXXXX";
    if (!::mkdtemp(pattern.data())) throw std::runtime_error("no scratch folder");
    folder = pattern;
    file = folder / "graph.keys";
  }
  ~KeyFiles() override { fs::remove_all(folder); }

  void write(const std::string& text, mode_t mode = 0600) const {
    std::ofstream(file, std::ios::binary | std::ios::trunc) << text;
    ::chmod(file.c_str(), mode);
  }
  std::string read() const {
    std::stringstream text;
    text << std::ifstream(file, std::ios::binary).rdbuf();
    return text.str();
  }
  std::string error() const {
    return message_of([&] { load_graph_keys(file); });
  }

  fs::path folder, file;
};

TEST_F(KeyFiles, AreForTheirUserAloneWhateverTheMask) {
  const mode_t before = ::umask(0);
  const GraphKeys made = create_graph_keys(file);
  ::umask(before);
  struct stat status = {};
  ASSERT_EQ(::stat(file.c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 07777, 0600u);
  const GraphKeys loaded = load_graph_keys(file);
  EXPECT_EQ(loaded.public_key, made.public_key);
  EXPECT_EQ(loaded.secret_key, made.secret_key);
  EXPECT_EQ(loaded.public_key.size(), 40u);
  const GraphKeys other = create_graph_keys(folder / "other.keys");
  EXPECT_NE(other.secret_key, made.secret_key);
}

TEST_F(KeyFiles, AreNeverOverwritten) {
  create_graph_keys(file);
  const std::string before = read();
  EXPECT_TRUE(contains(message_of([&] { create_graph_keys(file); }), "exists already"));
  EXPECT_EQ(read(), before);
  fs::create_symlink(folder / "elsewhere", folder / "link.keys");
  EXPECT_TRUE(contains(message_of([&] { create_graph_keys(folder / "link.keys"); }), "exists"));
  EXPECT_FALSE(fs::exists(folder / "elsewhere"));
  EXPECT_TRUE(
      contains(message_of([&] { create_graph_keys(folder / "no" / "f"); }), "No such file"));
}

TEST_F(KeyFiles, ThatOthersMayUseAreRefusedWithTheMend) {
  create_graph_keys(file);
  for (const mode_t mode : {0644, 0640, 0604, 0620, 0601}) {
    ::chmod(file.c_str(), mode);
    EXPECT_TRUE(contains(error(), "run: chmod 600 " + file.string())) << error();
  }
  ::chmod(file.c_str(), 0400);
  EXPECT_NO_THROW(load_graph_keys(file));
}

TEST_F(KeyFiles, DamagedOnesAreRefusedNamingTheLine) {
  EXPECT_TRUE(contains(error(), "'prehend keys create' makes one")) << error();
  create_graph_keys(file);
  const std::string good = read();
  const std::size_t secret = good.find("secret_key: ");
  const std::string without_secret = good.substr(0, secret);
  const auto refusal = [&](const std::string& text) {
    write(text);
    return error();
  };
  EXPECT_TRUE(contains(refusal(""), "public_key is missing"));
  EXPECT_TRUE(contains(refusal(without_secret), "secret_key is missing"));
  EXPECT_TRUE(contains(refusal(good.substr(0, good.size() - 3)), "line 3: secret_key has 38"));
  EXPECT_TRUE(contains(refusal(without_secret + "secret_key:\n"), "line 3: no such entry"));
  EXPECT_TRUE(contains(refusal(without_secret + "secret_key: \n"), "line 3: secret_key has 0"));
  EXPECT_TRUE(contains(refusal(without_secret + "secretkey: x\n"),
                       "line 3: no such entry; did you mean \"secret_key\"?"));
  EXPECT_TRUE(contains(refusal(good + good), "line 5: public_key a second time"));
  EXPECT_TRUE(contains(refusal(without_secret + "secret_key: " + std::string(40, '~')),
                       "line 3: secret_key is not in Z85"));
  EXPECT_TRUE(contains(refusal(without_secret + "secret_key: " + std::string(40, '\0')), "line 3"));
  create_graph_keys(folder / "other");
  fs::rename(folder / "other", file);
  const std::string other = read();
  EXPECT_TRUE(
      contains(refusal(without_secret + other.substr(other.find("secret_key"))), "are no pair"));
  EXPECT_TRUE(contains(refusal(good + std::string(1 << 20, '#')), "larger than any key file"));
  EXPECT_TRUE(contains(refusal(std::string("\xff\xfe\0\x01", 4)), "line 1: no such entry"));
  EXPECT_NO_THROW(refusal(good));
}

TEST_F(KeyFiles, WhatIsNoFileNeverBlocks) {
  EXPECT_TRUE(contains(message_of([&] { load_graph_keys(folder); }), "not a regular file"));
  ASSERT_EQ(::mkfifo(file.c_str(), 0600), 0);
  EXPECT_TRUE(contains(error(), "not a regular file"));
}

TEST_F(KeyFiles, TheEnvironmentNamesOneForAll) {
  ::unsetenv("PREHEND_KEYS");
  EXPECT_FALSE(find_graph_keys("").has_value());
  ::setenv("PREHEND_KEYS", file.c_str(), 1);
  EXPECT_THROW(find_graph_keys(""), std::runtime_error);  // named, but not there: never silent
  const GraphKeys made = create_graph_keys(file);
  EXPECT_EQ(find_graph_keys("")->public_key, made.public_key);
  ::unsetenv("PREHEND_KEYS");
  EXPECT_EQ(find_graph_keys(file)->public_key, made.public_key);
}

TEST(Endpoints, LoopbackIsToldFromTheRest) {
  for (const char* local : {"tcp://127.0.0.1:1", "tcp://127.255.1.2:*", "tcp://[::1]:5",
                            "tcp://localhost:11411", "ipc:///tmp/x", "inproc://x"}) {
    EXPECT_TRUE(is_local_endpoint(local)) << local;
  }
  for (const char* remote :
       {"tcp://10.0.0.1:1", "tcp://0.0.0.0:*", "tcp://*:5", "tcp://[::]:5", "tcp://[fe80::1]:5",
        "tcp://127.evil.org:5", "tcp://127.0.0.1.evil.org:5", "tcp://localhost.evil.org:5",
        "tcp://10.0.0.1:0;127.0.0.1:5", "tcp://127.0.0.1:0;10.0.0.1:5", "tcp://128.0.0.1:1",
        "tcp://eth0:5", "tcp://", "tcp://:5", "udp://127.0.0.1:5", "", "rubbish"}) {
    EXPECT_FALSE(is_local_endpoint(remote)) << remote;
  }
}

/// A registry with keys, on loopback.
class SecureGraph : public KeyFiles {
 protected:
  NodeOptions options(const std::string& name) const {
    NodeOptions result;
    result.name = name;
    result.registry = registry->endpoint();
    result.keys_file = file;
    result.use_tcp = true;
    result.use_pointers = false;  // all of it has to go over the sockets
    result.use_slab = false;
    result.registry_timeout = 3s;
    return result;
  }
  std::string endpoint_of(const std::string& name) const {
    Introspection look(registry->endpoint(), 2s, file);
    for (const auto& node : look.nodes()) {
      if (node.name() == name) return node.endpoint();
    }
    return "";
  }

  GraphKeys keys = create_graph_keys(file);
  std::unique_ptr<Registry> registry = std::make_unique<Registry>(
      RegistryOptions{.endpoint = "tcp://127.0.0.1:*", .keys_file = file});
};

TEST(Loopback, NothingGoesBeyondItWithoutKeys) {
  for (const char* endpoint : {"tcp://0.0.0.0:*", "tcp://*:*", "tcp://192.0.2.1:11411"}) {
    EXPECT_TRUE(contains(message_of([&] { Registry open({.endpoint = endpoint}); }),
                         "'prehend keys create'"))
        << endpoint;
  }
  NodeOptions far;
  far.name = "node";
  far.registry = "tcp://192.0.2.1:11411";
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_TRUE(contains(message_of([&] { Node node(far); }), "beyond this host's loopback"));
  EXPECT_TRUE(contains(message_of([&] { Introspection(far.registry).nodes(); }), "no keys"));
  EXPECT_LT(std::chrono::steady_clock::now() - begin, 4s);  // refused, not tried
  Registry registry({.endpoint = "tcp://127.0.0.1:*"});
  far.registry = registry.endpoint();
  far.bind_address = "192.0.2.5";
  EXPECT_TRUE(contains(message_of([&] { Node node(far); }), "beyond this host's loopback"));
  far.bind_address = "0.0.0.0";
  EXPECT_TRUE(contains(message_of([&] { Node node(far); }), "name the one address"));
  far.bind_address = "127.0.0.1";
  EXPECT_EQ(message_of([&] { Node node(far); }), "nothing was thrown");
}

/// A registry that was told of a node on another host, and somebody who reads the graph's log.
class ForeignRecord {
 public:
  explicit ForeignRecord(msgs::graph::NodeRecord record) {
    record.set_instance(record.name() + "-1-0");
    record.set_version(1);
    link_.set(zmq::sockopt::linger, 0);
    link_.connect(registry_.endpoint());
    msgs::graph::RegistryRequest request;
    *request.mutable_update() = std::move(record);
    link_.send(zmq::buffer(request.SerializeAsString()), zmq::send_flags::none);
  }
  NodeOptions options(const std::string& name) const {
    NodeOptions options;
    options.registry = registry_.endpoint();
    options.name = name;
    return options;
  }

 private:
  Registry registry_{{.endpoint = "tcp://127.0.0.1:*"}};
  zmq::context_t context_;
  zmq::socket_t link_{context_, zmq::socket_type::dealer};
};

TEST(Loopback, NodesOfAnotherRegistryRecordAreNotReachedWithoutKeys) {
  msgs::graph::NodeRecord record;
  record.set_name("far");
  record.set_endpoint("tcp://192.0.2.7:99");
  auto& end = *record.add_publishers();
  end.set_topic("/t");
  end.set_id(1);
  end.set_schema_hash(schema_of(*msgs::Clock::descriptor())->hash);
  const ForeignRecord graph(record);
  LogReader log(graph.options("log_reader"));
  Node node(graph.options("node"));
  Inbox inbox;
  auto subscription = node.subscribe<msgs::Clock>("/t", QoS::queue(10), inbox.taker());
  EXPECT_TRUE(eventually([&] { return log.has("beyond this host's loopback"); }));
}

TEST(Loopback, NodeOfAnotherHostThatHearsOnlyItselfIsNamed) {
  msgs::graph::NodeRecord record;
  record.set_name("deaf");
  record.set_process_space("another machine");
  record.set_endpoint("ipc:///tmp/prehend-no-such-folder/deaf-1-0");
  const ForeignRecord graph(record);
  LogReader log(graph.options("log_reader"));
  EXPECT_TRUE(eventually([&] { return log.has("node 'deaf' is on another host"); }));
}

TEST_F(SecureGraph, MembersTalk) {
  Node talker(options("talker")), listener(options("listener"));
  Inbox inbox;
  auto subscription = listener.subscribe<msgs::Clock>("/t", QoS::queue(100), inbox.taker());
  auto service = talker.serve<msgs::Clock, msgs::Clock>(
      "/s", [](const msgs::Clock& c) { return clock_message(c.time() + 1); });
  talker.spin_in_background();
  listener.spin_in_background();
  auto publisher = talker.advertise<msgs::Clock>("/t", QoS::queue(100));
  for (int i = 1; i <= 20; ++i) publisher.publish(clock_message(i));
  EXPECT_TRUE(eventually([&] { return inbox.size() == 20; }));
  auto client = listener.client<msgs::Clock, msgs::Clock>("/s");
  EXPECT_EQ(client.call(clock_message(1), 5s).value().time(), 2);
  EXPECT_EQ(Introspection(registry->endpoint(), 2s, file).nodes().size(), 2u);
}

TEST_F(SecureGraph, WhoHasNoKeysOrOthersIsToldSo) {
  NodeOptions stranger = options("stranger");
  stranger.registry_timeout = 3s;  // a busy machine takes its time to refuse
  stranger.keys_file.clear();
  EXPECT_TRUE(contains(message_of([&] { Node node(stranger); }), "give them with --keys"))
      << message_of([&] { Node node(stranger); });
  create_graph_keys(folder / "other.keys");
  stranger.keys_file = folder / "other.keys";
  EXPECT_TRUE(contains(message_of([&] { Node node(stranger); }), "has other keys"))
      << message_of([&] { Node node(stranger); });
  Registry open({.endpoint = "tcp://127.0.0.1:*"});
  stranger.registry = open.endpoint();
  EXPECT_TRUE(contains(message_of([&] { Node node(stranger); }), "uses no keys"));
  EXPECT_TRUE(contains(message_of([&] { Introspection(registry->endpoint(), 3s).nodes(); }),
                       "give them with --keys"));
}

TEST_F(SecureGraph, StrangersAtANodeAreRefusedCountedAndLogged) {
  LogReader log(options("log_reader"));
  Node node(options("victim"));
  Inbox inbox;
  auto subscription = node.subscribe<msgs::Clock>("/t", QoS::queue(10), inbox.taker());
  node.spin_in_background();
  const std::string victim = endpoint_of("victim");
  ASSERT_TRUE(contains(victim, "tcp://127.0.0.1:"));
  const GraphKeys other = create_graph_keys(folder / "other.keys");
  zmq::context_t context;
  std::vector<zmq::socket_t> strangers;
  const auto connect = [&](const std::function<void(zmq::socket_t&)>& set_up) {
    zmq::socket_t& socket = strangers.emplace_back(context, zmq::socket_type::dealer);
    socket.set(zmq::sockopt::linger, 0);
    socket.set(zmq::sockopt::reconnect_ivl, -1);
    set_up(socket);
    socket.connect(victim);
    msgs::graph::PeerMessage question;
    question.mutable_parameter_request()->set_id(7);
    socket.send(zmq::message_t(), zmq::send_flags::sndmore);
    socket.send(zmq::buffer(question.SerializeAsString()), zmq::send_flags::none);
  };
  connect([](zmq::socket_t&) {});  // unencrypted
  connect([&](zmq::socket_t& socket) {
    socket.set(zmq::sockopt::curve_serverkey, other.public_key);
    socket.set(zmq::sockopt::curve_publickey, other.public_key);
    socket.set(zmq::sockopt::curve_secretkey, other.secret_key);
  });
  connect([&](zmq::socket_t& socket) {  // knows the public key, which is no secret
    socket.set(zmq::sockopt::curve_serverkey, keys.public_key);
    socket.set(zmq::sockopt::curve_publickey, other.public_key);
    socket.set(zmq::sockopt::curve_secretkey, other.secret_key);
  });
  EXPECT_TRUE(eventually([&] { return log.has("3 connections refused in all"); }));
  for (zmq::socket_t& stranger : strangers) {
    zmq::message_t answer;
    EXPECT_FALSE(stranger.recv(answer, zmq::recv_flags::dontwait));
  }
  RawPeer raw(victim);
  EXPECT_FALSE(raw.shake_hands() && !raw.is_hung_up(2s));
  Node talker(options("talker"));
  auto publisher = talker.advertise<msgs::Clock>("/t", QoS::queue(10));
  publisher.publish(clock_message(1));
  EXPECT_TRUE(eventually([&] { return inbox.size() == 1; }));
  EXPECT_LE(log.count("connections refused in all"), 4u);  // one a second
}

// What a peer announces is not allocated before it is looked at.
TEST(Sizes, FramesAboveTheLimitEndTheConnection) {
  Registry registry({.endpoint = "tcp://127.0.0.1:*"});
  NodeOptions options;
  options.name = "node";
  options.registry = registry.endpoint();
  options.use_tcp = true;
  Node node(options);
  Introspection look(registry.endpoint());
  const std::string endpoint = look.nodes().at(0).endpoint();
  const std::size_t before = resident_bytes();
  for (const std::string& target : {registry.endpoint(), endpoint}) {
    for (const std::uint64_t size : {std::uint64_t{257} << 20, std::uint64_t{1} << 40,
                                     ~std::uint64_t{0} >> 1, ~std::uint64_t{0}}) {
      RawPeer liar(target);
      ASSERT_TRUE(liar.shake_hands());
      liar.announce_frame(size);
      EXPECT_TRUE(liar.is_hung_up(5s)) << target << " " << size;
    }
  }
  EXPECT_LT(resident_bytes(), before + (std::size_t{64} << 20));
  // The registry has no use for anything near what a cloud needs.
  RawPeer fat(registry.endpoint());
  ASSERT_TRUE(fat.shake_hands());
  fat.announce_frame(std::uint64_t{16} << 20);
  EXPECT_TRUE(fat.is_hung_up(5s));
  EXPECT_EQ(look.nodes().size(), 1u);
}

}  // namespace
}  // namespace prehend::graph
