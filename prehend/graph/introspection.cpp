#include "prehend/graph/introspection.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <random>
#include <stdexcept>
#include <thread>

#include "prehend/graph/link/curve.h"
#include "prehend/graph/link/frames.h"
#include "prehend/graph/link/statistics_report.h"
#include "prehend/graph/node.h"
#include "prehend/text/nearest_match.h"

namespace prehend::graph {

using msgs::graph::NodeRecord;
using msgs::graph::NodeStatistics;
using msgs::graph::ParameterRecord;
using msgs::graph::PeerMessage;
using msgs::graph::RegistryReply;
using msgs::graph::RegistryRequest;

namespace {

// What a client's socket tells of the keys at the other end.
class KeyWatch {
 public:
  KeyWatch(zmq::context_t& context, zmq::socket_ref socket, bool has_keys)
      : socket_(socket), events_(context, zmq::socket_type::pair), trouble_(has_keys) {
    const std::string name = fmt::format("inproc://keys-{}", socket.handle());
    if (zmq_socket_monitor(socket.handle(), name.c_str(), key_events()) != 0) throw zmq::error_t();
    // No bound: ZeroMQ's thread would wait for ever to tell a monitor that nobody reads.
    events_.set(zmq::sockopt::rcvhwm, 0);
    events_.set(zmq::sockopt::linger, 0);
    events_.connect(name);
  }
  ~KeyWatch() { zmq_socket_monitor(socket_.handle(), nullptr, 0); }
  KeyWatch(const KeyWatch&) = delete;
  KeyWatch& operator=(const KeyWatch&) = delete;

  // "" when there is none.
  std::string trouble() {
    for (Frames frames = receive(events_); !frames.empty(); frames = receive(events_)) {
      std::uint16_t event = 0;
      if (frames[0].size() < sizeof event) continue;
      std::memcpy(&event, frames[0].data(), sizeof event);
      trouble_.take(event);
    }
    return trouble_.words();
  }

 private:
  zmq::socket_ref socket_;
  zmq::socket_t events_;
  KeyTrouble trouble_;
};

// Nobody answered in time.
class NoAnswer : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace

struct Introspection::Impl {
  std::string registry;
  std::optional<GraphKeys> keys;
  std::chrono::milliseconds timeout;
  zmq::context_t context{1};
  zmq::socket_t socket;
  std::optional<KeyWatch> key_watch;  // of the socket
  std::uint64_t next_id = 1;

  zmq::socket_t open(const std::string& endpoint);
  // Sends and receives until `is_answer` takes a reply.
  void exchange(zmq::socket_t& to, const std::string& who, Frames frames,
                const std::function<bool(const Frames&)>& is_answer) const;
  RegistryReply ask(RegistryRequest request);
  Schema ask_schema(const std::string& name, std::uint64_t hash);
  Schema await_schema(const std::string& name, std::uint64_t hash);
  std::vector<Schema> await_types(const msgs::graph::Offer& offer, int expected);
  std::vector<ParameterRecord> ask_parameters(const NodeRecord& node,
                                              PeerMessage::ParameterRequest request);
  void cancel(const NodeRecord& node, const std::string& action);
  void ask_statistics(const NodeRecord& node, zmq::socket_t& peer) const;
};

zmq::socket_t Introspection::Impl::open(const std::string& endpoint) {
  zmq::socket_t result(context, zmq::socket_type::dealer);
  result.set(zmq::sockopt::linger, 0);
  result.set(zmq::sockopt::maxmsgsize, kMaxFrameBytes);
  result.set(zmq::sockopt::reconnect_ivl, 50);
  std::random_device random;
  result.set(zmq::sockopt::routing_id, fmt::format("look-{}-{:08x}", ::getpid(), random()));
  secure_client(result, endpoint, keys);
  try {
    result.connect(endpoint);
  } catch (const zmq::error_t& error) {
    throw std::runtime_error("endpoint '" + endpoint + "': " + error.what());
  }
  return result;
}

void Introspection::Impl::exchange(zmq::socket_t& to, const std::string& who, Frames frames,
                                   const std::function<bool(const Frames&)>& is_answer) const {
  const auto deadline = std::chrono::steady_clock::now() + timeout;
  graph::send(to, "", frames);
  while (true) {
    const auto left =
        std::chrono::ceil<std::chrono::milliseconds>(deadline - std::chrono::steady_clock::now());
    zmq::pollitem_t item{to.handle(), 0, ZMQ_POLLIN, 0};
    if (left.count() <= 0 || zmq::poll(&item, 1, left) == 0) {
      throw NoAnswer(fmt::format("{} does not answer within {:.3g} s", who,
                                 std::chrono::duration<double>(timeout).count()));
    }
    if (is_answer(receive(to))) return;
  }
}

RegistryReply Introspection::Impl::ask(RegistryRequest request) {
  if (!socket) {
    socket = open(registry);
    key_watch.emplace(context, socket, keys.has_value());
  }
  request.set_id(next_id++);
  Frames frames(1);
  frames[0] = zmq::message_t(request.SerializeAsString());
  RegistryReply reply;
  const std::uint64_t id = request.id();
  try {
    exchange(socket,
             "no graph is running (start one with prehend launch): the registry at " + registry,
             std::move(frames), [&](const Frames& got) {
               return got.size() == 1 &&
                      reply.ParseFromArray(got[0].data(), static_cast<int>(got[0].size())) &&
                      reply.id() == id;
             });
  } catch (const NoAnswer&) {
    const std::string trouble = key_watch->trouble();
    if (trouble.empty()) throw;
    throw KeyError("the registry at " + registry + " cannot be asked: " + trouble);
  }
  if (!reply.error().empty()) throw std::runtime_error(reply.error());
  return reply;
}

Schema Introspection::Impl::ask_schema(const std::string& name, std::uint64_t hash) {
  RegistryRequest request;
  request.mutable_get_schema()->set_name(name);
  request.mutable_get_schema()->set_hash(hash);
  const RegistryReply reply = ask(request);
  return {reply.schema().name(), reply.schema().hash(), reply.schema().descriptor_set()};
}

// The type of a topic reaches the registry a moment after the topic itself.
Schema Introspection::Impl::await_schema(const std::string& name, std::uint64_t hash) {
  const auto deadline = std::chrono::steady_clock::now() + timeout;
  while (true) {
    try {
      return ask_schema(name, hash);
    } catch (const std::runtime_error&) {
      if (std::chrono::steady_clock::now() > deadline) throw;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
}

std::vector<ParameterRecord> Introspection::Impl::ask_parameters(
    const NodeRecord& node, PeerMessage::ParameterRequest request) {
  zmq::socket_t peer = open(node.endpoint());
  PeerMessage message;
  request.set_id(next_id++);
  *message.mutable_parameter_request() = request;
  PeerMessage answer;
  exchange(peer, "node '" + node.name() + "'", to_wire(message), [&](const Frames& got) {
    return got.size() == 2 &&
           answer.ParseFromArray(got[1].data(), static_cast<int>(got[1].size())) &&
           answer.has_parameter_answer() && answer.parameter_answer().id() == request.id();
  });
  if (!answer.parameter_answer().error().empty()) {
    throw std::runtime_error("node '" + node.name() + "': " + answer.parameter_answer().error());
  }
  return {answer.parameter_answer().parameters().begin(),
          answer.parameter_answer().parameters().end()};
}

void Introspection::Impl::cancel(const NodeRecord& node, const std::string& action) {
  zmq::socket_t peer = open(node.endpoint());
  PeerMessage message, answer;
  message.mutable_cancel()->set_action(action);
  exchange(peer, "node '" + node.name() + "'", to_wire(message), [&](const Frames& got) {
    return got.size() == 2 &&
           answer.ParseFromArray(got[1].data(), static_cast<int>(got[1].size())) &&
           answer.has_answer() && answer.answer().id() == 0;
  });
  if (!answer.answer().error().empty()) throw std::runtime_error(answer.answer().error());
}

Introspection::Introspection(std::string registry, std::chrono::milliseconds timeout,
                             const std::string& keys_file)
    : impl_(std::make_unique<Impl>()) {
  impl_->keys = find_graph_keys(keys_file);
  const char* from_environment = std::getenv("PREHEND_REGISTRY");
  if (registry.empty() && from_environment) registry = from_environment;
  impl_->registry = registry.empty() ? kDefaultRegistryEndpoint : registry;
  impl_->timeout = timeout;
}

Introspection::~Introspection() = default;

const std::string& Introspection::registry() const { return impl_->registry; }

std::vector<NodeRecord> Introspection::nodes() {
  RegistryRequest request;
  request.mutable_list();
  const RegistryReply reply = impl_->ask(request);
  std::vector<NodeRecord> result(reply.nodes().begin(), reply.nodes().end());
  std::sort(result.begin(), result.end(),
            [](const NodeRecord& a, const NodeRecord& b) { return a.name() < b.name(); });
  return result;
}

Schema Introspection::topic_schema(const std::string& topic) {
  std::vector<std::string> topics;
  for (const NodeRecord& node : nodes()) {
    for (const auto& end : node.publishers()) {
      if (end.topic() == topic) return impl_->await_schema(end.schema_name(), end.schema_hash());
      topics.push_back(end.topic());
    }
  }
  std::sort(topics.begin(), topics.end());
  topics.erase(std::unique(topics.begin(), topics.end()), topics.end());
  throw std::runtime_error("nobody publishes topic " + topic +
                           text::nearest_match_hint(topic, topics));
}

Schema Introspection::schema(const std::string& name, std::uint64_t hash) {
  return impl_->ask_schema(name, hash);
}

// Joins the node's topic /statistics, whose history is its last report.
void Introspection::Impl::ask_statistics(const NodeRecord& node, zmq::socket_t& peer) const {
  PeerMessage message;
  auto& subscribe = *message.mutable_subscribe();
  subscribe.set_topic(kStatisticsTopic);
  subscribe.set_subscription(1);
  subscribe.set_policy(msgs::graph::LATCHED);
  subscribe.set_depth(1);
  for (const auto& end : node.publishers()) {
    if (end.topic() == kStatisticsTopic) subscribe.set_publisher(end.id());
  }
  Frames frames = to_wire(message);
  graph::send(peer, "", frames);
}

namespace {

// Takes one message of a node that was asked; true when it was the last one.
bool take_statistics(const Frames& frames, NodeStatistics& report) {
  if (frames.size() == 5 && frames[0].to_string_view() == kStatisticsTopic) {
    report.ParseFromArray(frames[2].data(), static_cast<int>(frames[2].size()));
    return false;
  }
  PeerMessage message;
  return frames.size() == 2 &&
         message.ParseFromArray(frames[1].data(), static_cast<int>(frames[1].size())) &&
         (message.has_history_end() || !message.subscribed().error().empty());
}

}  // namespace

std::map<std::string, NodeStatistics> Introspection::statistics(
    const std::vector<NodeRecord>& nodes, std::chrono::milliseconds wait) {
  const auto deadline = std::chrono::steady_clock::now() + wait;
  std::vector<zmq::socket_t> peers;
  std::vector<zmq::pollitem_t> items;
  std::vector<NodeStatistics> reports(nodes.size());
  for (const NodeRecord& node : nodes) {
    peers.push_back(impl_->open(node.endpoint()));
    items.push_back({peers.back().handle(), 0, ZMQ_POLLIN, 0});
    impl_->ask_statistics(node, peers.back());
  }
  std::map<std::string, NodeStatistics> result;
  while (result.size() < nodes.size()) {
    const auto left =
        std::chrono::ceil<std::chrono::milliseconds>(deadline - std::chrono::steady_clock::now());
    if (left.count() <= 0 || zmq::poll(items, left) == 0) break;
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      if (!(items[i].revents & ZMQ_POLLIN)) continue;
      if (take_statistics(receive(peers[i]), reports[i])) {
        result[nodes[i].instance()] = reports[i];
        items[i].events = 0;
      }
    }
  }
  return result;
}

namespace {

NodeRecord find_node(const std::vector<NodeRecord>& nodes, const std::string& name) {
  std::vector<std::string> names;
  for (const NodeRecord& node : nodes) {
    if (node.name() == name) return node;
    names.push_back(node.name());
  }
  throw std::runtime_error("no node '" + name + "' is there" +
                           text::nearest_match_hint(name, names));
}

}  // namespace

namespace {

// The node that offers a service or action, and the offer.
std::pair<NodeRecord, msgs::graph::Offer> find_offer(const std::vector<NodeRecord>& nodes,
                                                     const std::string& name, bool is_action) {
  std::vector<std::string> known;
  for (const NodeRecord& node : nodes) {
    for (const auto& offer : is_action ? node.actions() : node.services()) {
      if (offer.name() == name) return {node, offer};
      known.push_back(offer.name());
    }
  }
  throw std::runtime_error(fmt::format("nobody serves {} {}{}", is_action ? "action" : "service",
                                       name, text::nearest_match_hint(name, known)));
}

}  // namespace

std::vector<Schema> Introspection::Impl::await_types(const msgs::graph::Offer& offer,
                                                     int expected) {
  if (offer.type_names_size() != expected || offer.type_hashes_size() != expected) {
    throw std::runtime_error(offer.name() + ": its node does not say its message types");
  }
  std::vector<Schema> types;
  for (int i = 0; i < expected; ++i) {
    types.push_back(await_schema(offer.type_names(i), offer.type_hashes(i)));
  }
  return types;
}

std::vector<Schema> Introspection::service(const std::string& name) {
  return impl_->await_types(find_offer(nodes(), name, false).second, 2);
}

std::vector<Schema> Introspection::action(const std::string& name) {
  return impl_->await_types(find_offer(nodes(), name, true).second, 3);
}

void Introspection::cancel_action(const std::string& action) {
  impl_->cancel(find_offer(nodes(), action, true).first, action);
}

std::vector<ParameterRecord> Introspection::parameters(const std::string& node) {
  return impl_->ask_parameters(find_node(nodes(), node), {});
}

ParameterRecord Introspection::parameter(const std::string& node, const std::string& name) {
  PeerMessage::ParameterRequest request;
  request.set_name(name);
  return impl_->ask_parameters(find_node(nodes(), node), request).at(0);
}

ParameterRecord Introspection::set_parameter(const std::string& node, const std::string& name,
                                             const std::string& text) {
  PeerMessage::ParameterRequest request;
  request.set_name(name);
  request.set_set_text(text);
  return impl_->ask_parameters(find_node(nodes(), node), request).at(0);
}

std::vector<ParameterRecord> Introspection::set_parameters(
    const std::string& node, const std::map<std::string, std::string>& texts) {
  PeerMessage::ParameterRequest request;
  for (const auto& [parameter, text] : texts) {
    auto& setting = *request.add_settings();
    setting.set_name(parameter);
    setting.set_text(text);
  }
  return impl_->ask_parameters(find_node(nodes(), node), request);
}

std::string to_text(const msgs::graph::ParameterValue& value) {
  using Value = msgs::graph::ParameterValue;
  switch (value.value_case()) {
    case Value::kBoolValue:
      return value.bool_value() ? "true" : "false";
    case Value::kIntValue:
      return std::to_string(value.int_value());
    case Value::kDoubleValue:
      return fmt::format("{}", value.double_value());
    case Value::kStringValue:
      return value.string_value();
    case Value::kNumbersValue:
      return to_text(ParameterValue(std::vector<double>(value.numbers_value().values().begin(),
                                                        value.numbers_value().values().end())));
    case Value::kTextsValue:
      return to_text(ParameterValue(std::vector<std::string>(value.texts_value().values().begin(),
                                                             value.texts_value().values().end())));
    case Value::VALUE_NOT_SET:
      break;
  }
  return "";
}

}  // namespace prehend::graph
