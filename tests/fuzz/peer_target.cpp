// What peers say to a node, through its real sockets. The fuzzer plays another node of the graph: a
// server whose topics the node under test has subscribed, and a client of its services, actions,
// parameters and topics. An input is a sequence of multipart messages: `control byte | runs`. Bit 0
// of the control byte: as server or as client; bits 1 to 3: how many frames, each a run, follow.

#include <array>
#include <cerrno>
#include <chrono>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include <zmq.hpp>

#include "msgs/geometry.pb.h"
#include "msgs/sensors.pb.h"
#include "prehend/graph/link/frames.h"
#include "prehend/graph/node.h"
#include "prehend/graph/registry.h"
#include "tests/fuzz/fuzz_input.h"
#include "tests/fuzz/quiet_protobuf.h"

namespace {

using namespace prehend::graph;
using namespace std::chrono_literals;
using prehend::msgs::Clock;
using prehend::msgs::PointCloud;
using prehend::msgs::graph::PeerMessage;

constexpr const char* kFuzzer = "fuzzer-1-00000001";

NodeOptions options_of(const Registry& registry) {
  NodeOptions options;
  options.name = "target";
  options.registry = registry.endpoint();
  options.use_tcp = true;
  options.log_level = LogLevel::kError;
  return options;
}

// A node that uses everything a node may have.
class Target {
 public:
  explicit Target(const Registry& registry) : node_(options_of(registry)) {
    node_.declare_parameter<double>({.name = "rate", .default_value = 1, .minimum = 0});
    cloud_ = node_.subscribe<PointCloud>("/cloud", QoS::queue(10),
                                         [](const Received<PointCloud>& m) { m->ByteSizeLong(); });
    latched_ = node_.subscribe<Clock>("/clock_of_fuzzer", QoS::latched(3),
                                      [](const Received<Clock>& m) { m->time(); });
    raw_ = node_.subscribe_raw("/cloud_too", QoS::latest(),
                               [](const RawMessage& m) { FUZZ_CHECK(m.schema != nullptr); });
    publisher_ = node_.advertise<PointCloud>("/answers", QoS::latched(2));
    PointCloud message;
    message.set_data(std::string(100000, 'x'));
    publisher_.publish(message);
    service_ = node_.serve<Clock, Clock>("/service", [](const Clock& request) { return request; });
    action_ = node_.serve_action<Clock, Clock, Clock>(
        "/action", [](const Clock& goal, ActionContext<Clock>& context) {
          context.feedback(goal);
          return goal;
        });
    node_.spin_in_background();
  }

 private:
  Node node_;
  Subscription cloud_, latched_, raw_;
  Publisher<PointCloud> publisher_;
  Service service_;
  ActionServer action_;
};

// The fuzzer's sockets. Waits are bounded: a node that does not answer is a finding.
class Fuzzer {
 public:
  Fuzzer() : target_(registry_) {
    server_.set(zmq::sockopt::linger, 0);
    client_.set(zmq::sockopt::linger, 0);
    client_.set(zmq::sockopt::routing_id, kFuzzer);
    server_.bind("tcp://127.0.0.1:*");
    client_.connect(endpoint_of_target());
    for (int subscriptions = 0; subscriptions < 3;) {
      Frames frames = wait(server_);
      FUZZ_CHECK(frames.size() == 3);
      PeerMessage message;
      if (!message.ParseFromArray(frames[2].data(), static_cast<int>(frames[2].size()))) continue;
      if (!message.has_subscribe()) continue;
      route_ = frames[0].to_string();
      accept(message.subscribe());
      ++subscriptions;
    }
  }

  void send_as_server(Frames frames) { send(server_, route_, frames); }
  void send_as_client(Frames frames) { send(client_, "", frames); }

  /// Until the node has seen everything: it reads each socket at least once between two answers.
  void wait_until_seen() {
    for (int i = 0; i < 2; ++i) {
      PeerMessage request;
      request.mutable_parameter_request()->set_id(++last_id_);
      request.mutable_parameter_request()->set_name("rate");
      send_as_client(to_wire(request));
      PeerMessage answer;
      do {
        const Frames frames = wait(client_);
        answer.Clear();
        if (frames.size() != 2) continue;
        answer.ParseFromArray(frames[1].data(), static_cast<int>(frames[1].size()));
      } while (answer.parameter_answer().id() != last_id_);
    }
    while (!receive(server_).empty()) {
    }
  }

 private:
  static void add_publisher(prehend::msgs::graph::NodeRecord& record, const std::string& topic,
                            const google::protobuf::Descriptor& type) {
    auto& end = *record.add_publishers();
    end.set_topic(topic);
    end.set_schema_name(type.full_name());
    end.set_schema_hash(schema_of(type)->hash);
    end.set_id(static_cast<std::uint64_t>(record.publishers_size()));
  }

  // Joins the graph as a node and finds the target in it.
  std::string endpoint_of_target() {
    zmq::socket_t registry(context_, zmq::socket_type::dealer);
    registry.set(zmq::sockopt::linger, 0);
    registry.connect(registry_.endpoint());
    prehend::msgs::graph::RegistryRequest request;
    auto& record = *request.mutable_update();
    record.set_name("fuzzer");
    record.set_instance(kFuzzer);
    record.set_endpoint(server_.get(zmq::sockopt::last_endpoint));
    record.set_version(1);
    add_publisher(record, "/cloud", *PointCloud::descriptor());
    add_publisher(record, "/clock_of_fuzzer", *Clock::descriptor());
    add_publisher(record, "/cloud_too", *PointCloud::descriptor());
    Frames frames(1);
    frames[0] = zmq::message_t(request.SerializeAsString());
    send(registry, "", frames);
    while (true) {
      frames = wait(registry);
      prehend::msgs::graph::RegistryReply reply;
      FUZZ_CHECK(reply.ParseFromArray(frames[0].data(), static_cast<int>(frames[0].size())));
      for (const auto& node : reply.nodes()) {
        if (node.name() == "target") return node.endpoint();
      }
    }
  }

  void accept(const PeerMessage::Subscribe& request) {
    PeerMessage answer;
    auto& subscribed = *answer.mutable_subscribed();
    subscribed.set_topic(request.topic());
    subscribed.set_subscription(request.subscription());
    subscribed.set_next_sequence(1);
    subscribed.set_slab_reader(1);
    subscribed.mutable_schema()->set_name("prehend.msgs.PointCloud");
    subscribed.mutable_schema()->set_hash(schema_of(*PointCloud::descriptor())->hash);
    send_as_server(to_wire(answer));
    PeerMessage end;
    end.mutable_history_end()->set_topic(request.topic());
    end.mutable_history_end()->set_subscription(request.subscription());
    send_as_server(to_wire(end));
  }

  static Frames wait(zmq::socket_t& socket) {
    std::array<zmq::pollitem_t, 1> items{{{socket.handle(), 0, ZMQ_POLLIN, 0}}};
    int ready = 0;
    do {  // libFuzzer's own timer interrupts it
      ready = zmq_poll(items.data(), 1, 15000);
    } while (ready < 0 && zmq_errno() == EINTR);
    FUZZ_CHECK(ready == 1);
    return receive(socket);
  }

  const Registry registry_{RegistryOptions{.endpoint = "tcp://127.0.0.1:*", .lease = 24h}};
  Target target_;
  zmq::context_t context_;
  zmq::socket_t server_{context_, zmq::socket_type::router};
  zmq::socket_t client_{context_, zmq::socket_type::dealer};
  std::string route_;  // to the target
  std::uint64_t last_id_ = 1000000;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  prehend::fuzz::quiet_protobuf();
  static Fuzzer fuzzer;
  prehend::fuzz::FuzzInput input(data, size);
  for (int messages = 0; messages < 20 && !input.is_empty(); ++messages) {
    const std::uint8_t control = input.byte();
    Frames frames;
    for (int i = (control >> 1) & 7; i >= 0; --i) frames.emplace_back(input.run());
    if (control & 1) {
      fuzzer.send_as_server(std::move(frames));
    } else {
      fuzzer.send_as_client(std::move(frames));
    }
  }
  fuzzer.wait_until_seen();
  return 0;
}
