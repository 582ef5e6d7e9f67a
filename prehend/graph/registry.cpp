#include "prehend/graph/registry.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <map>
#include <random>
#include <stdexcept>
#include <thread>

#include "msgs/graph.pb.h"
#include "prehend/graph/link/frames.h"
#include "prehend/graph/link/io_loop.h"
#include "prehend/graph/link/runtime_folder.h"

namespace prehend::graph {

using msgs::graph::NodeRecord;
using msgs::graph::RegistryReply;
using msgs::graph::RegistryRequest;

struct Registry::Impl {
  explicit Impl(RegistryOptions registry_options)
      : options(std::move(registry_options)),
        socket(loop.context(), zmq::socket_type::router),
        space(process_space()) {
    std::random_device random;
    instance = fmt::format("registry-{:08x}{:08x}", random(), random());
  }

  void listen();
  void read();
  void answer(const std::string& route, const RegistryRequest& request);
  void take_update(const std::string& route, const NodeRecord& record, RegistryReply& reply);
  void push(RegistryReply change, const std::string& except = "");
  void send(const std::string& route, const RegistryReply& reply);
  void remove(const std::string& node_instance);
  void sweep();
  const NodeRecord* living_node_of_name(const std::string& name, const std::string& but_not);
  bool is_dead(const NodeRecord& record) const;

  struct Entry {
    NodeRecord record;
    std::string route;
    std::chrono::steady_clock::time_point last_beat;
  };

  const RegistryOptions options;
  IoLoop loop;
  zmq::socket_t socket;
  const std::string space;
  std::string instance;
  std::string endpoint;
  std::string folder;
  std::thread thread;
  std::map<std::string, Entry> nodes;  // by instance
  std::map<std::uint64_t, msgs::graph::Schema> schemas;
  std::uint64_t revision = 0;
};

void Registry::Impl::listen() {
  socket.set(zmq::sockopt::maxmsgsize, kMaxFrameBytes);
  socket.set(zmq::sockopt::linger, 300);
  socket.set(zmq::sockopt::router_mandatory, true);
  socket.set(zmq::sockopt::sndhwm, 100000);  // small messages; a stopped node loses its lease
  try {
    socket.bind(options.endpoint);
  } catch (const zmq::error_t& error) {
    throw std::runtime_error(
        error.num() == EADDRINUSE
            ? options.endpoint +
                  " is in use: another registry or program listens there. Stop it, "
                  "or choose another endpoint"
            : "cannot listen on '" + options.endpoint + "': " + error.what() +
                  "; an example is tcp://127.0.0.1:11411");
  }
  endpoint = socket.get(zmq::sockopt::last_endpoint);
  clean_stale_runtime_folders();
  folder = make_runtime_folder();
  loop.watch(socket, [this] { read(); });
  loop.every(std::chrono::milliseconds(100), [this] { sweep(); });
  thread = std::thread([this] { loop.run(); });
}

void Registry::Impl::read() {
  for (int i = 0; i < 100; ++i) {
    const Frames frames = receive(socket);
    if (frames.empty()) return;
    RegistryRequest request;
    if (frames.size() != 2 ||
        !request.ParseFromArray(frames[1].data(), static_cast<int>(frames[1].size()))) {
      fmt::print(stderr, "registry: a message that is no request was thrown away\n");
      continue;
    }
    answer(frames[0].to_string(), request);
  }
}

void Registry::Impl::answer(const std::string& route, const RegistryRequest& request) {
  RegistryReply reply;
  reply.set_id(request.id());
  switch (request.request_case()) {
    case RegistryRequest::kHello:
      if (const NodeRecord* other =
              living_node_of_name(request.hello().name(), request.hello().instance())) {
        reply.set_error(
            fmt::format("a node named '{}' runs already (pid {}); choose another with "
                        "--name, or stop that one",
                        other->name(), other->pid()));
      }
      reply.set_runtime_folder(folder);
      break;
    case RegistryRequest::kUpdate:
      return take_update(route, request.update(), reply);
    case RegistryRequest::kHeartbeat: {
      const auto found = nodes.find(request.heartbeat().instance());
      reply.set_unknown_node(found == nodes.end() ||
                             found->second.record.version() != request.heartbeat().version());
      if (found != nodes.end()) found->second.last_beat = std::chrono::steady_clock::now();
      break;
    }
    case RegistryRequest::kGoodbye:
      return remove(request.goodbye().instance());
    case RegistryRequest::kList:
      for (const auto& [name, entry] : nodes) *reply.add_nodes() = entry.record;
      break;
    case RegistryRequest::kGetSchema: {
      const auto& wanted = request.get_schema();
      const auto found = std::find_if(schemas.begin(), schemas.end(), [&](const auto& item) {
        return item.second.name() == wanted.name() &&
               (wanted.hash() == 0 || wanted.hash() == item.first);
      });
      if (found != schemas.end()) {
        *reply.mutable_schema() = found->second;
      } else {
        reply.set_error("no node has declared the message type " + wanted.name());
      }
      break;
    }
    case RegistryRequest::kPutSchema:
      schemas[request.put_schema().hash()] = request.put_schema();
      break;
    case RegistryRequest::REQUEST_NOT_SET:
      return;
  }
  send(route, reply);
}

void Registry::Impl::take_update(const std::string& route, const NodeRecord& record,
                                 RegistryReply& reply) {
  if (record.instance().empty() || record.name().empty()) return;
  if (const NodeRecord* other = living_node_of_name(record.name(), record.instance())) {
    reply.set_error(
        fmt::format("a node named '{}' runs already (pid {}); choose another with "
                    "--name, or stop that one",
                    other->name(), other->pid()));
    return send(route, reply);
  }
  const bool is_new = !nodes.count(record.instance());
  Entry& entry = nodes[record.instance()];
  entry.route = route;
  entry.last_beat = std::chrono::steady_clock::now();
  if (is_new || record.version() > entry.record.version()) {
    entry.record = record;
    RegistryReply change;
    *change.add_nodes() = record;
    push(std::move(change), record.instance());
  }
  reply.set_version(entry.record.version());
  for (const auto& [name, other] : nodes) {
    if (is_new || name == record.instance()) *reply.add_nodes() = other.record;
  }
  for (const auto& end : record.publishers()) {
    if (!schemas.count(end.schema_hash())) reply.add_wanted_schemas(end.schema_hash());
  }
  send(route, reply);
}

void Registry::Impl::push(RegistryReply change, const std::string& except) {
  ++revision;
  for (const auto& [name, entry] : nodes) {
    if (name != except) send(entry.route, change);
  }
}

void Registry::Impl::send(const std::string& route, const RegistryReply& reply) {
  RegistryReply full = reply;
  full.set_registry_instance(instance);
  full.set_revision(revision);
  Frames frames(1);
  frames[0] = zmq::message_t(full.SerializeAsString());
  // A node that cannot be reached loses its lease; one that missed a change sees it by the
  // revision.
  graph::send(socket, route, frames);
}

void Registry::Impl::remove(const std::string& node_instance) {
  if (!nodes.count(node_instance)) return;
  RegistryReply change;
  change.add_gone(node_instance);
  push(std::move(change));
  nodes.erase(node_instance);
}

bool Registry::Impl::is_dead(const NodeRecord& record) const {
  return record.process_space() == space && !is_process_alive(record.pid());
}

void Registry::Impl::sweep() {
  const auto oldest = std::chrono::steady_clock::now() - options.lease;
  std::vector<std::string> gone;
  for (const auto& [name, entry] : nodes) {
    if (entry.last_beat < oldest || is_dead(entry.record)) gone.push_back(name);
  }
  for (const std::string& name : gone) remove(name);
  if (!gone.empty()) clean_runtime_folder(folder);
}

const NodeRecord* Registry::Impl::living_node_of_name(const std::string& name,
                                                      const std::string& but_not) {
  for (const auto& [other, entry] : nodes) {
    if (entry.record.name() != name || other == but_not) continue;
    if (!is_dead(entry.record)) return &entry.record;
    remove(other);
    return nullptr;
  }
  return nullptr;
}

Registry::Registry(RegistryOptions options) : impl_(std::make_unique<Impl>(std::move(options))) {
  impl_->listen();
}

Registry::~Registry() {
  impl_->loop.close();
  impl_->thread.join();
  impl_->socket.close();
  leave_runtime_folder(impl_->folder);
}

const std::string& Registry::endpoint() const { return impl_->endpoint; }
const std::string& Registry::runtime_folder() const { return impl_->folder; }

}  // namespace prehend::graph
