#include "prehend/graph/node.h"

#include <cmath>

#include "prehend/graph/node_impl.h"

namespace prehend::graph {
namespace {

using Types = std::initializer_list<const google::protobuf::Descriptor*>;

std::vector<std::shared_ptr<const Schema>> schemas_of(Types types) {
  std::vector<std::shared_ptr<const Schema>> schemas;
  for (const auto* type : types) schemas.push_back(schema_of(*type));
  return schemas;
}

OfferType make_offer(bool is_action, std::string name, Types types) {
  OfferType offer;
  offer.is_action = is_action;
  offer.name = std::move(name);
  for (const auto& schema : schemas_of(types)) {
    offer.type_names.push_back(schema->name);
    offer.type_hashes.push_back(schema->hash);
  }
  return offer;
}

}  // namespace

Node::Node(NodeOptions options) : Node(std::move(options), false) {}

Node::Node(NodeOptions options, bool describing)
    : impl_(std::make_shared<Impl>(std::move(options), describing)) {
  if (!describing) impl_->join_graph();
}

Node::~Node() = default;

const std::string& Node::name() const { return impl_->options.name; }

ParameterValue Node::declare(ParameterInfo parameter) {
  impl_->announce_parameters();
  return impl_->parameters.declare(std::move(parameter));
}

ParameterValue Node::parameter_value(const std::string& name) const {
  return impl_->parameters.get(name).value;
}

std::vector<ParameterInfo> Node::parameters() const { return impl_->parameters.all(); }

bool Node::is_parameter_given(const std::string& name) const {
  return impl_->parameters.is_given(name);
}

void Node::set_parameter(const std::string& name, const std::string& text) {
  set_parameters({{name, text}});
}

void Node::set_parameters(const std::map<std::string, std::string>& texts) {
  impl_->parameters_were_set(impl_->parameters.set(texts));
}

std::shared_ptr<PublisherCore> Node::advertise_core(const std::string& topic, const QoS& qos,
                                                    std::shared_ptr<const Schema> schema) {
  return impl_->make_publisher(impl_->resolve(topic), qos, std::move(schema));
}

RawPublisher Node::advertise_raw(const std::string& topic, const QoS& qos,
                                 std::shared_ptr<const Schema> schema) {
  if (!schema) throw std::invalid_argument("topic " + topic + ": no schema given");
  return RawPublisher(advertise_core(topic, qos, std::move(schema)));
}

Subscription Node::subscribe_core(const std::string& topic, const QoS& qos,
                                  std::shared_ptr<const Schema> schema, ContentHandler handler) {
  return Subscription(impl_->make_subscription(
      impl_->resolve(topic), qos, std::move(schema),
      [handler = std::move(handler)](const WaitingMessage& message) {
        return handler(*message.content, message.info);
      },
      false));
}

Subscription Node::subscribe_raw(const std::string& topic, const QoS& qos,
                                 std::function<void(const RawMessage&)> callback) {
  return Subscription(impl_->make_subscription(
      impl_->resolve(topic), qos, nullptr,
      [callback = std::move(callback)](const WaitingMessage& message) {
        callback({*message.info, message.content->encoded().concatenated(), message.schema});
        return true;
      },
      false));
}

void Node::watch_topics(std::function<void(const TopicInfo&)> callback) {
  impl_->check_not_describing();
  impl_->link->loop->post([impl = impl_.get(), callback = std::move(callback)] {
    impl->topic_watchers.push_back(callback);
    for (const std::string& topic : impl->topics_told) impl->tell_topic(callback, topic);
  });
}

std::optional<ReaderQueues> Node::wait_until_delivered(std::chrono::nanoseconds timeout) {
  return impl_->wait_until_delivered(timeout);
}

Service Node::serve_core(const std::string& service, const Type& request, const Type& response,
                         BytesHandler handler) {
  Impl* impl = impl_.get();
  const std::string name = impl->resolve(service);
  impl->take_name("service", name);
  auto core = std::make_shared<ServiceCore>(
      impl->link, make_offer(false, name, {&request, &response}), std::move(handler));
  core->set_withdraw([impl, name, core = core.get()] {
    const auto found = impl->services.find(name);
    if (found == impl->services.end() || found->second.get() != core) return;  // replaced by now
    impl->services.erase(found);
    impl->record_changed();
  });
  impl->link->loop->post([impl, name, core, types = schemas_of({&request, &response})] {
    for (const auto& type : types) impl->registry->offer_schema(type);
    impl->services[name] = core;
    impl->record_changed();
  });
  return Service(core);
}

std::shared_ptr<ServiceClientCore> Node::client_core(const std::string& service,
                                                     const Type& request, const Type& response) {
  const std::string name = impl_->resolve(service);
  return std::make_shared<ServiceClientCore>(impl_->link, *impl_->calls,
                                             make_offer(false, name, {&request, &response}));
}

RawServiceClient Node::raw_client(const std::string& service, const Type& request,
                                  const Type& response) {
  return RawServiceClient(client_core(service, request, response));
}

RawActionClient Node::raw_action_client(const std::string& action, const Type& goal,
                                        const Type& feedback, const Type& result) {
  return RawActionClient(action_client_core(action, goal, feedback, result));
}

ActionServer Node::serve_action_core(const std::string& action, const Type& goal,
                                     const Type& feedback, const Type& result,
                                     GoalHandler handler) {
  Impl* impl = impl_.get();
  const std::string name = impl->resolve(action);
  impl->take_name("action", name);
  auto core = std::make_shared<ActionServerCore>(
      impl->link, make_offer(true, name, {&goal, &feedback, &result}), std::move(handler));
  core->set_withdraw([impl, name, core = core.get()] {
    const auto found = impl->action_servers.find(name);
    if (found == impl->action_servers.end() || found->second.get() != core)
      return;  // replaced by now
    impl->action_servers.erase(found);
    impl->record_changed();
  });
  core->start();
  {
    const std::lock_guard lock(impl->mutex);
    impl->action_server_list.push_back(core);
  }
  impl->link->loop->post([impl, name, core, types = schemas_of({&goal, &feedback, &result})] {
    for (const auto& type : types) impl->registry->offer_schema(type);
    impl->action_servers[name] = core;
    impl->record_changed();
  });
  return ActionServer(core);
}

std::shared_ptr<ActionClientCore> Node::action_client_core(const std::string& action,
                                                           const Type& goal, const Type& feedback,
                                                           const Type& result) {
  const std::string name = impl_->resolve(action);
  return std::make_shared<ActionClientCore>(impl_->link, *impl_->goals, *impl_->calls,
                                            make_offer(true, name, {&goal, &feedback, &result}));
}

const Clock& Node::clock() const { return impl_->clock; }

struct Node::Timer::State {
  std::shared_ptr<TimerSource> source;
};

Node::Timer::Timer(std::shared_ptr<State> state) : state_(std::move(state)) {}
Node::Timer::~Timer() {
  if (state_) state_->source->close();
}
Node::Timer::Timer(Timer&&) noexcept = default;
Node::Timer& Node::Timer::operator=(Timer&& other) noexcept {
  if (this != &other) {
    if (state_) state_->source->close();
    state_ = std::move(other.state_);
  }
  return *this;
}

Node::Timer Node::create_timer(double period_seconds, std::function<void()> callback) {
  return make_timer(period_seconds, false, std::move(callback));
}

Node::Timer Node::create_one_shot_timer(double delay_seconds, std::function<void()> callback) {
  return make_timer(delay_seconds, true, std::move(callback));
}

Node::Timer Node::make_timer(double seconds, bool once, std::function<void()> callback) {
  impl_->check_not_describing();
  if (!(seconds >= 1e-9) || !(seconds <= 1e9)) {
    throw std::invalid_argument(fmt::format("timer {} {} s must be from 1e-9 to 1e9 s",
                                            once ? "delay" : "period", seconds));
  }
  auto source = std::make_shared<TimerSource>(impl_->link->clock, nanoseconds(seconds), once,
                                              std::move(callback));
  impl_->link->executor->add_timer(source);
  auto state = std::make_shared<Timer::State>();
  state->source = std::move(source);
  return Timer(std::move(state));
}

void Node::log(LogLevel level, const std::string& text) { impl_->log(level, text); }

void Node::report(Health health, const std::string& text) { impl_->report(health, text); }

std::string Node::shield(const std::string& item, const std::function<void()>& work) {
  std::string what;
  try {
    work();
    return {};
  } catch (const DescriptionDone&) {
    throw;
  } catch (const std::exception& error) {
    what = error.what();
  } catch (...) {
    what = kForeignException;
  }
  if (what.empty()) what = "an exception without words";
  impl_->work_failed(Health::kWarning, item, item + ": " + what);
  return what;
}

void Node::spin() {
  impl_->check_not_describing();
  impl_->start_spinning();
  impl_->link->executor->run();
}

void Node::spin_in_background() {
  impl_->check_not_describing();
  if (impl_->spin_thread.joinable()) throw std::runtime_error("the node spins already");
  impl_->start_spinning();
  impl_->spin_thread = std::thread([impl = impl_.get()] { impl->link->executor->run(); });
}

void Node::shutdown() { impl_->shutdown(); }

bool Node::ok() const { return !impl_->link->executor->is_stopped(); }

}  // namespace prehend::graph
