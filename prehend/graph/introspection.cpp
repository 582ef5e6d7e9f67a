#include "prehend/graph/introspection.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <random>
#include <stdexcept>
#include <thread>

#include "prehend/graph/link/frames.h"
#include "prehend/graph/nearest_match.h"
#include "prehend/graph/node.h"

namespace prehend::graph {

using msgs::graph::NodeRecord;
using msgs::graph::ParameterRecord;
using msgs::graph::PeerMessage;
using msgs::graph::RegistryReply;
using msgs::graph::RegistryRequest;

struct Introspection::Impl {
  std::string registry;
  std::chrono::milliseconds timeout;
  zmq::context_t context{1};
  zmq::socket_t socket;
  std::uint64_t next_id = 1;

  zmq::socket_t open(const std::string& endpoint);
  // Sends and receives until `is_answer` takes a reply.
  void exchange(zmq::socket_t& to, const std::string& who, Frames frames,
                const std::function<bool(const Frames&)>& is_answer) const;
  RegistryReply ask(RegistryRequest request);
  Schema ask_schema(const std::string& name, std::uint64_t hash);
  Schema await_schema(const std::string& name, std::uint64_t hash);
  std::vector<ParameterRecord> ask_parameters(const NodeRecord& node,
                                              PeerMessage::ParameterRequest request);
};

zmq::socket_t Introspection::Impl::open(const std::string& endpoint) {
  zmq::socket_t result(context, zmq::socket_type::dealer);
  result.set(zmq::sockopt::linger, 0);
  result.set(zmq::sockopt::maxmsgsize, kMaxFrameBytes);
  result.set(zmq::sockopt::reconnect_ivl, 50);
  std::random_device random;
  result.set(zmq::sockopt::routing_id, fmt::format("look-{}-{:08x}", ::getpid(), random()));
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
      throw std::runtime_error(fmt::format("{} does not answer within {:.3g} s", who,
                                           std::chrono::duration<double>(timeout).count()));
    }
    if (is_answer(receive(to))) return;
  }
}

RegistryReply Introspection::Impl::ask(RegistryRequest request) {
  if (!socket) socket = open(registry);
  request.set_id(next_id++);
  Frames frames(1);
  frames[0] = zmq::message_t(request.SerializeAsString());
  RegistryReply reply;
  const std::uint64_t id = request.id();
  exchange(socket,
           "no graph is running (start one with prehend launch): the registry at " + registry,
           std::move(frames), [&](const Frames& got) {
             return got.size() == 1 &&
                    reply.ParseFromArray(got[0].data(), static_cast<int>(got[0].size())) &&
                    reply.id() == id;
           });
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

Introspection::Introspection(std::string registry, std::chrono::milliseconds timeout)
    : impl_(std::make_unique<Impl>()) {
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
  throw std::runtime_error("nobody publishes topic " + topic + nearest_match_hint(topic, topics));
}

Schema Introspection::schema(const std::string& name, std::uint64_t hash) {
  return impl_->ask_schema(name, hash);
}

namespace {

NodeRecord find_node(const std::vector<NodeRecord>& nodes, const std::string& name) {
  std::vector<std::string> names;
  for (const NodeRecord& node : nodes) {
    if (node.name() == name) return node;
    names.push_back(node.name());
  }
  throw std::runtime_error("no node '" + name + "' is there" + nearest_match_hint(name, names));
}

}  // namespace

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
    case Value::VALUE_NOT_SET:
      break;
  }
  return "";
}

}  // namespace prehend::graph
