#include "prehend/graph/registry_state.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <set>
#include <vector>

#include "prehend/graph/link/runtime_folder.h"

namespace prehend::graph {

using msgs::graph::NodeRecord;
using msgs::graph::RegistryReply;
using msgs::graph::RegistryRequest;

namespace {

using namespace std::chrono_literals;

// Hashes of all message types of a node's topics, services and actions.
std::set<std::uint64_t> types_of(const NodeRecord& record) {
  std::set<std::uint64_t> hashes;
  for (const auto& end : record.publishers()) hashes.insert(end.schema_hash());
  for (const auto& end : record.subscribers()) hashes.insert(end.schema_hash());
  for (const auto* offers : {&record.services(), &record.actions()}) {
    for (const auto& offer : *offers) {
      hashes.insert(offer.type_hashes().begin(), offer.type_hashes().end());
    }
  }
  hashes.erase(0);  // any type
  return hashes;
}

std::string name_taken(const NodeRecord& other) {
  return fmt::format(
      "a node named '{}' runs already (pid {}); choose another with --name, or stop that one",
      other.name(), other.pid());
}

std::string out_of_room(const char* what, std::size_t limit) {
  return fmt::format("the registry refuses this node: it holds {} {} already, its limit", limit,
                     what);
}

}  // namespace

RegistryState::RegistryState(Options options, Send send)
    : options_(std::move(options)), send_(std::move(send)) {}

bool RegistryState::take(const std::string& route, std::string_view bytes, Time now) {
  RegistryRequest request;
  if (bytes.size() > std::size_t{std::numeric_limits<int>::max()} ||
      !request.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) {
    return false;
  }
  answer(route, request, now);
  return true;
}

void RegistryState::answer(const std::string& route, const RegistryRequest& request, Time now) {
  RegistryReply reply;
  reply.set_id(request.id());
  switch (request.request_case()) {
    case RegistryRequest::kHello:
      if (const NodeRecord* other =
              living_node_of_name(request.hello().name(), request.hello().instance())) {
        reply.set_error(name_taken(*other));
      }
      reply.set_runtime_folder(options_.runtime_folder);
      break;
    case RegistryRequest::kUpdate:
      return take_update(route, request.update(), reply, now);
    case RegistryRequest::kHeartbeat: {
      const auto found = nodes_.find(request.heartbeat().instance());
      reply.set_unknown_node(found == nodes_.end() ||
                             found->second.record.version() != request.heartbeat().version());
      if (found != nodes_.end()) {
        found->second.last_beat = now;
        found->second.route = route;  // after a broken connection it has another one
      }
      break;
    }
    case RegistryRequest::kGoodbye:
      return remove(request.goodbye().instance());
    case RegistryRequest::kList:
      for (const auto& [name, entry] : nodes_) {
        *reply.add_nodes() = entry.record;
        reply.mutable_nodes()->rbegin()->set_silence((now - entry.last_beat) / 1ns);
      }
      break;
    case RegistryRequest::kGetSchema: {
      const auto& wanted = request.get_schema();
      const auto found = std::find_if(schemas_.begin(), schemas_.end(), [&](const auto& item) {
        return item.second.name() == wanted.name() &&
               (wanted.hash() == 0 || wanted.hash() == item.first);
      });
      if (found != schemas_.end()) {
        *reply.mutable_schema() = found->second;
      } else {
        reply.set_error(
            fmt::format("no node has declared the message type {:.200}", wanted.name()));
      }
      break;
    }
    case RegistryRequest::kPutSchema:
      take_schema(request.put_schema(), reply);
      break;
    case RegistryRequest::REQUEST_NOT_SET:
      return;
  }
  send(route, reply);
}

void RegistryState::take_update(const std::string& route, const NodeRecord& record,
                                RegistryReply& reply, Time now) {
  if (const std::string refusal = fault(record); !refusal.empty()) {
    reply.set_error(refusal);
    return send(route, reply);
  }
  if (const NodeRecord* other = living_node_of_name(record.name(), record.instance())) {
    reply.set_error(name_taken(*other));
    return send(route, reply);
  }
  const bool is_new = !nodes_.count(record.instance());
  Entry& entry = nodes_[record.instance()];
  entry.route = route;
  entry.last_beat = now;
  if (is_new || record.version() > entry.record.version()) {
    entry.record = record;
    const std::size_t bytes = record.ByteSizeLong();
    record_bytes_ += bytes - entry.bytes;
    entry.bytes = bytes;
    RegistryReply change;
    *change.add_nodes() = record;
    push(change, record.instance());
  }
  reply.set_version(entry.record.version());
  for (const auto& [name, other] : nodes_) {
    if (is_new || name == record.instance()) *reply.add_nodes() = other.record;
  }
  for (const std::uint64_t hash : types_of(record)) {
    if (!schemas_.count(hash)) reply.add_wanted_schemas(hash);
  }
  send(route, reply);
}

std::string RegistryState::fault(const NodeRecord& record) {
  if (std::string refusal = record_fault(record, options_.limits); !refusal.empty()) {
    return refusal;
  }
  if (is_dead(record)) {
    return fmt::format("the registry refuses node '{}': no process {} runs here", record.name(),
                       record.pid());
  }
  const auto known = nodes_.find(record.instance());
  if (known != nodes_.end()) {
    const NodeRecord& other = known->second.record;
    if (other.name() != record.name() || other.pid() != record.pid()) {
      return fmt::format("the registry refuses node '{}': node '{}' (pid {}) has its instance '{}'",
                         record.name(), other.name(), other.pid(), record.instance());
    }
  } else if (nodes_.size() >= options_.limits.nodes) {
    return out_of_room("nodes", options_.limits.nodes);
  }
  const std::size_t before = known == nodes_.end() ? 0 : known->second.bytes;
  if (record_bytes_ - before + record.ByteSizeLong() > options_.limits.all_record_bytes) {
    return out_of_room("bytes of node records", options_.limits.all_record_bytes);
  }
  return "";
}

void RegistryState::take_schema(const msgs::graph::Schema& schema, RegistryReply& reply) {
  if (schemas_.count(schema.hash())) return;  // equal hashes are equal types
  if (const std::string refusal = schema_fault(schema, options_.limits); !refusal.empty()) {
    return reply.set_error(refusal);
  }
  const std::size_t bytes = schema.ByteSizeLong();
  if (schema_bytes_ + bytes > options_.limits.all_schema_bytes) forget_unused_schemas();
  if (schema_bytes_ + bytes > options_.limits.all_schema_bytes) {
    return reply.set_error(out_of_room("bytes of message types", options_.limits.all_schema_bytes));
  }
  schema_bytes_ += bytes;
  schemas_[schema.hash()] = schema;
}

void RegistryState::forget_unused_schemas() {
  std::set<std::uint64_t> used;
  for (const auto& [name, entry] : nodes_) {
    for (const auto& end : entry.record.publishers()) used.insert(end.schema_hash());
  }
  std::erase_if(schemas_, [&](const auto& item) {
    if (used.count(item.first)) return false;
    schema_bytes_ -= item.second.ByteSizeLong();
    return true;
  });
}

void RegistryState::push(RegistryReply& change, const std::string& except) {
  ++revision_;
  for (const auto& [name, entry] : nodes_) {
    if (name != except) send(entry.route, change);
  }
}

void RegistryState::send(const std::string& route, RegistryReply& reply) {
  reply.set_registry_instance(options_.instance);
  reply.set_revision(revision_);
  send_(route, reply);
}

void RegistryState::remove(const std::string& node_instance) {
  const auto found = nodes_.find(node_instance);
  if (found == nodes_.end()) return;
  RegistryReply change;
  change.add_gone(node_instance);
  push(change);
  record_bytes_ -= found->second.bytes;
  nodes_.erase(found);
}

bool RegistryState::is_dead(const NodeRecord& record) const {
  return record.process_space() == options_.process_space && !is_process_alive(record.pid());
}

bool RegistryState::sweep(Time now) {
  const Time oldest = now - options_.lease;
  std::vector<std::string> gone;
  for (const auto& [name, entry] : nodes_) {
    if (entry.last_beat < oldest || is_dead(entry.record)) gone.push_back(name);
  }
  for (const std::string& name : gone) remove(name);
  return !gone.empty();
}

const NodeRecord* RegistryState::living_node_of_name(const std::string& name,
                                                     const std::string& but_not) {
  for (const auto& [other, entry] : nodes_) {
    if (entry.record.name() != name || other == but_not) continue;
    if (!is_dead(entry.record)) return &entry.record;
    remove(other);
    return nullptr;
  }
  return nullptr;
}

}  // namespace prehend::graph
