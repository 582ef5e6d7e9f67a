#include "prehend/graph/link/registry_link.h"

#include <vector>

#include "prehend/graph/link/frames.h"

namespace prehend::graph {
namespace {

using namespace std::chrono_literals;
using msgs::graph::NodeRecord;
using msgs::graph::RegistryReply;
using msgs::graph::RegistryRequest;

constexpr auto kTick = 50ms;
constexpr auto kBeat = 1s;
constexpr auto kRepeat = 500ms;  // unanswered hellos and updates
constexpr auto kSilence = 3s;    // after which the registry counts as gone
constexpr auto kGathering = 2s;  // in which nodes find a new registry

auto now() { return std::chrono::steady_clock::now(); }

}  // namespace

RegistryLink::RegistryLink(IoLoop& loop, const CurveGate& gate, const std::string& endpoint,
                           Events events)
    : loop_(loop),
      events_(std::move(events)),
      key_trouble_(gate.has_keys()),
      socket_(loop.context(), zmq::socket_type::dealer),
      last_answer_(now()),
      last_beat_(now()),
      last_update_(now()),
      full_list_due_(now()) {
  // Nothing is kept for a registry that is away: its successor is told everything anew.
  socket_.set(zmq::sockopt::immediate, true);
  socket_.set(zmq::sockopt::reconnect_ivl, 50);
  socket_.set(zmq::sockopt::reconnect_ivl_max, 500);
  socket_.set(zmq::sockopt::linger, 300);
  socket_.set(zmq::sockopt::maxmsgsize, kMaxFrameBytes);
  gate.secure_client(socket_, endpoint);
  monitor_.emplace(loop_, socket_, key_events(),
                   [this](std::uint16_t event, std::uint32_t) { connection_event(event); });
  socket_.connect(endpoint);
  loop_.watch(socket_, [this] { read(); });
  loop_.every(kTick, [this] { tick(); });
}

RegistryLink::~RegistryLink() { loop_.unwatch(socket_); }

bool RegistryLink::send(RegistryRequest& request) {
  // A change that was under way when the node left would make the registry take it up again.
  if (left_) return false;
  request.set_id(next_id_++);
  Frames frames(1);
  frames[0] = zmq::message_t(request.SerializeAsString());
  loop_.touch(socket_);
  return graph::send(socket_, "", frames) == SendResult::kSent;
}

void RegistryLink::connection_event(std::uint16_t event) {
  key_trouble_.take(event);
  if (event != ZMQ_EVENT_HANDSHAKE_SUCCEEDED) return;
  last_beat_ = now() - kBeat;  // it may be a new registry, or have taken this node for dead
  tick();
}

void RegistryLink::hello(const NodeRecord& record) {
  record_ = record;
  send_hello();
}

void RegistryLink::send_hello() {
  RegistryRequest request;
  auto& hello = *request.mutable_hello();
  hello.set_name(record_.name());
  hello.set_instance(record_.instance());
  hello.set_pid(record_.pid());
  hello.set_process_space(record_.process_space());
  last_update_ = send(request) ? now() : now() - kRepeat;
}

std::uint64_t RegistryLink::update(const NodeRecord& record) {
  const std::uint64_t version = record_.version() + 1;
  record_ = record;
  record_.set_version(version);
  send_record();
  return version;
}

void RegistryLink::send_record() {
  RegistryRequest request;
  *request.mutable_update() = record_;
  const bool sent = send(request);
  update_id_ = request.id();
  last_update_ = sent ? now() : now() - kRepeat;
}

void RegistryLink::offer_schema(const std::shared_ptr<const Schema>& schema) {
  schemas_[schema->hash] = schema;
}

void RegistryLink::goodbye() {
  RegistryRequest request;
  request.mutable_goodbye()->set_instance(record_.instance());
  send(request);
  left_ = true;
}

void RegistryLink::tick() {
  if (left_ || record_.instance().empty()) return;
  if (!welcomed_) {
    if (now() - last_update_ >= kRepeat) send_hello();
    return;
  }
  if (known_version_ < record_.version() && now() - last_update_ >= kRepeat) send_record();
  if (now() - last_beat_ >= kBeat) {
    last_beat_ = now();
    RegistryRequest request;
    request.mutable_heartbeat()->set_instance(record_.instance());
    request.mutable_heartbeat()->set_version(record_.version());
    send(request);
  }
  if (full_list_wanted_ && now() >= full_list_due_) {
    RegistryRequest request;
    request.mutable_list();
    full_list_wanted_ = false;
    if (!send(request)) full_list_wanted_ = true;
    list_id_ = request.id();
  }
  if (answers_ && now() - last_answer_ > kSilence) {
    answers_ = false;
    events_.registry_answers(false);
  }
}

void RegistryLink::read() {
  while (!left_) {
    const Frames frames = receive(socket_);
    if (frames.empty()) return;
    RegistryReply reply;
    if (frames.size() != 1 ||
        !reply.ParseFromArray(frames[0].data(), static_cast<int>(frames[0].size()))) {
      continue;  // whatever listens there is no registry; silence from it is noticed
    }
    last_answer_ = now();
    if (!answers_) {
      answers_ = true;
      events_.registry_answers(true);
    }
    take(reply);
  }
}

void RegistryLink::take(const RegistryReply& reply) {
  if (!welcomed_) {
    if (!reply.error().empty()) return events_.refused(reply.error());
    if (reply.runtime_folder().empty()) return;
    welcomed_ = true;
    registry_instance_ = reply.registry_instance();
    return events_.welcome(reply.runtime_folder());
  }
  if (reply.registry_instance() != registry_instance_) {  // a new one
    registry_instance_ = reply.registry_instance();
    revision_ = reply.revision();
    known_version_ = 0;
    list_id_ = 0;  // the list that was asked of the one before knows nobody yet
    full_list_due_ = now() + kGathering;
    full_list_wanted_ = true;
  }
  if (reply.unknown_node()) {
    follow_revision(reply);
    events_.forgotten();
    return send_record();
  }
  if (reply.id() != 0 && reply.id() == update_id_) return take_update_answer(reply);
  if (reply.id() != 0 && reply.id() == list_id_) return take_all(reply);
  follow_revision(reply);
  if (reply.id() != 0) {
    if (!reply.error().empty()) events_.refused(reply.error());
    return;
  }
  for (const NodeRecord& record : reply.nodes()) take_node(record);
  for (const std::string& instance : reply.gone()) drop_node(instance);
}

void RegistryLink::follow_revision(const RegistryReply& reply) {
  const bool pushed = reply.id() == 0;
  const std::uint64_t expected = revision_ + (pushed ? 1 : 0);
  if (reply.revision() != expected && !full_list_wanted_) {  // changes were lost on the way
    full_list_wanted_ = true;
    full_list_due_ = now();
  }
  revision_ = reply.revision();
}

void RegistryLink::take_update_answer(const RegistryReply& reply) {
  if (!reply.error().empty()) {
    if (complain_) events_.refused(reply.error());
    complain_ = false;
    return;
  }
  complain_ = true;
  revision_ = reply.revision();
  for (const std::uint64_t hash : reply.wanted_schemas()) {
    const auto schema = schemas_.find(hash);
    if (schema == schemas_.end()) continue;
    RegistryRequest request;
    request.mutable_put_schema()->set_name(schema->second->name);
    request.mutable_put_schema()->set_hash(hash);
    request.mutable_put_schema()->set_descriptor_set(schema->second->descriptor_set);
    send(request);
  }
  for (const NodeRecord& record : reply.nodes()) take_node(record);
  known_version_ = reply.version();
  events_.known(known_version_);
}

void RegistryLink::take_all(const RegistryReply& reply) {
  revision_ = reply.revision();
  std::map<std::string, bool> listed;
  for (const NodeRecord& record : reply.nodes()) {
    listed[record.instance()] = true;
    take_node(record);
  }
  std::vector<std::string> missing;
  for (const auto& [instance, record] : nodes_) {
    if (!listed.count(instance)) missing.push_back(instance);
  }
  for (const std::string& instance : missing) drop_node(instance);
}

void RegistryLink::take_node(const NodeRecord& record) {
  const auto known = nodes_.find(record.instance());
  if (known != nodes_.end() && known->second.version() >= record.version()) return;
  nodes_[record.instance()] = record;
  events_.node_changed(record);
}

void RegistryLink::drop_node(const std::string& instance) {
  if (nodes_.erase(instance)) events_.node_gone(instance);
}

}  // namespace prehend::graph
