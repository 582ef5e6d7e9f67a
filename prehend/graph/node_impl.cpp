#include "prehend/graph/node_impl.h"

#include <fmt/format.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <future>
#include <random>

#include "msgs/sensors.pb.h"
#include "prehend/graph/link/local_nodes.h"
#include "prehend/graph/link/runtime_folder.h"
#include "prehend/graph/names.h"

namespace prehend::graph {
namespace {

using namespace std::chrono_literals;

constexpr auto kFlushTime = 1s;

// Shared memory of one node; what would go beyond goes inline.
constexpr auto kSlabRest = 5s;
constexpr std::size_t kMaxSlabBytes = std::size_t{512} << 20;

std::shared_ptr<spdlog::logger> make_logger(const std::string& name, LogLevel level) {
  auto logger = std::make_shared<spdlog::logger>(
      name, std::make_shared<spdlog::sinks::stderr_color_sink_mt>());
  logger->set_pattern("[%H:%M:%S.%e] [%^%l%$] [%n] %v");
  static constexpr spdlog::level::level_enum kLevels[] = {spdlog::level::debug, spdlog::level::info,
                                                          spdlog::level::warn, spdlog::level::err};
  logger->set_level(kLevels[static_cast<int>(level)]);
  return logger;
}

std::string registry_endpoint(const NodeOptions& options) {
  if (!options.registry.empty()) return options.registry;
  const char* from_environment = std::getenv("PREHEND_REGISTRY");
  return from_environment && *from_environment ? from_environment : kDefaultRegistryEndpoint;
}

std::string make_instance(const std::string& name) {
  std::random_device random;
  return fmt::format("{}-{}-{:08x}", name, ::getpid(), random());
}

template <class Message>
void publish_to(const std::shared_ptr<PublisherCore>& publisher, const Message& message) {
  if (publisher) publisher->publish(encode(message), message.stamp());
}

}  // namespace

std::uint64_t next_local_id() {
  static std::atomic<std::uint64_t> next{1};
  return next++;
}

Node::Impl::Impl(NodeOptions node_options, bool is_describing)
    : options(std::move(node_options)),
      describing(is_describing),
      parameters(options.parameters, options.parameter_sources),
      link(std::make_shared<NodeLink>()),
      clock(link->clock = std::make_shared<Clock::State>(options.clock)),
      logger(make_logger(options.name, options.log_level)) {
  check_node_name(options.name);
  check_name_space(options.name_space);
  link->node_name = options.name;
  link->use_pointers = options.use_pointers;
  link->use_slab = options.use_slab;
  if (options.use_slab) link->slabs = std::make_shared<SlabPool>(kMaxSlabBytes);
  link->loop = std::make_shared<IoLoop>();
  link->log = [this](LogLevel level, const std::string& text) { log(level, text); };
  link->callback_failed = [this](const std::string& source, const std::string& what) {
    callback_failed(source, what);
  };
  link->hold_against = [this](const std::string& instance, const std::string& text) {
    hold_against(instance, text);
  };
  link->send_to_client = [this, loop = link->loop](const std::string& client,
                                                   const msgs::graph::PeerMessage& message) {
    ++link->waiting_to_send;
    const bool posted = loop->post([this, client, message] {
      --link->waiting_to_send;
      channels->send_to_client(client, message);
    });
    if (!posted) --link->waiting_to_send;
  };
  link->record_changed = [this] { record_changed(); };
  link->executor = std::make_shared<Executor>(
      link->clock,
      [this](const std::string& source, const std::string& what) { callback_failed(source, what); },
      options.busy_wait);
  record.set_name(options.name);
  record.set_program(options.program.empty() ? options.name : options.program);
  record.set_instance(make_instance(options.name));
  link->instance = record.instance();
  record.set_pid(::getpid());
  record.set_process_space(process_space());
}

void Node::Impl::join_graph() {
  start_link();
  make_own_topics();
  std::promise<std::string> ended;
  bool told = false;  // in the loop's thread
  join_ended = [&](const std::string& error) {
    if (!std::exchange(told, true)) ended.set_value(error);
  };
  link->loop->post([this] { registry->hello(record); });
  loop_thread = std::thread([this] { link->loop->run(options.busy_wait); });
  auto future = ended.get_future();
  const bool answered = future.wait_for(options.registry_timeout) == std::future_status::ready;
  std::string key_trouble;
  std::promise<void> cleared;
  link->loop->post([&] {
    join_ended = nullptr;
    key_trouble = registry->key_trouble();
    cleared.set_value();
  });
  cleared.get_future().wait();
  const std::string error =
      answered ? future.get() : no_answer(registry_endpoint(options), key_trouble);
  if (!error.empty()) throw std::runtime_error(error);
}

void Node::Impl::make_own_topics() {
  log_publisher =
      make_publisher("/log", QoS::latched(100), schema_of(*msgs::graph::LogLine::descriptor()));
  diagnostic_publisher = make_publisher("/diagnostics", QoS::latched(1),
                                        schema_of(*msgs::graph::Diagnostic::descriptor()));
  statistics_publisher = make_publisher(kStatisticsTopic, QoS::latched(1),
                                        schema_of(*msgs::graph::NodeStatistics::descriptor()));
  if (options.clock == ClockMode::kSimulated) {
    const auto take_clock = [this](const WaitingMessage& message) {
      msgs::Clock stamp;
      if (!stamp.ParseFromString(message.content->encoded().concatenated())) return false;
      if (!link->clock->set(stamp.time())) return false;
      link->executor->wake();
      return true;
    };
    clock_subscription = make_subscription("/clock", QoS::latest(),
                                           schema_of(*msgs::Clock::descriptor()), take_clock, true);
  }
}

void Node::Impl::start_link() {
  gate = make_gate();
  PeerChannels::Events peer;
  peer.client_message = [this](auto& client, auto& message) {
    take_client_message(client, message);
  };
  peer.server_message = [this](auto& server, auto& message) {
    take_server_message(server, message);
  };
  peer.topic_message = [this](auto& server, auto& frames) {
    if (!subscribers->take_message(server, frames)) count_malformed("a message from " + server);
  };
  peer.client_lost = [this](auto& client) {
    publishers->lose_client(client);
    deliveries->lose_client(client);
    for (auto& [name, server] : action_servers) server->lose_client(client);
  };
  peer.client_dropped = [this](auto& client, std::uint64_t messages) {
    log(LogLevel::kWarning,
        fmt::format("{} does not read what it asked for: {} answers and other messages thrown "
                    "away, its goals cancelled, its subscriptions ended",
                    client, messages));
  };
  peer.server_lost = [this](auto& server) {
    calls->lose_server(server);
    goals->lose_server(server);
  };
  peer.server_back = [this](auto& server) {
    subscribers->rejoin(server);
    calls->look_again();
    goals->look_again();
  };
  peer.malformed = [this](auto& what) { count_malformed(what); };
  channels = std::make_unique<PeerChannels>(*link->loop, *gate, record.instance(), std::move(peer),
                                            link->slabs);

  RegistryLink::Events events;
  events.welcome = [this](auto& folder) { welcome(folder); };
  events.refused = [this](auto& error) {
    if (join_ended) return join_ended(error);
    report(Health::kError, error);
  };
  events.known = [this](std::uint64_t version) {
    publishers->registry_knows(version);
    std::erase_if(known_waiters, [version](const KnownWaiter& waiter) {
      if (waiter.version == 0 || waiter.version > version) return false;
      waiter.known->set_value();
      return true;
    });
    joined = true;
    if (join_ended) join_ended("");
  };
  events.node_changed = [this](auto& node) { meet(node); };
  events.forgotten = [this] { subscribers->rejoin_all(); };
  events.node_gone = [this](auto& instance) { lose_node(instance); };
  events.registry_answers = [this](bool answers) {
    log(answers ? LogLevel::kInfo : LogLevel::kWarning,
        answers ? "the registry is back"
                : "the registry at " + registry_endpoint(options) +
                      " does not answer; messages flow on, but nobody new is found");
  };
  try {
    registry = std::make_unique<RegistryLink>(*link->loop, *gate, registry_endpoint(options),
                                              std::move(events));
  } catch (const zmq::error_t& error) {
    throw std::runtime_error("registry endpoint '" + registry_endpoint(options) +
                             "': " + error.what() + "; an example is " + kDefaultRegistryEndpoint);
  }
  publishers = std::make_unique<PublisherSide>(*link, *channels, *registry);
  subscribers = std::make_unique<SubscriberSide>(*link, *channels, *registry);
  statistics = std::make_unique<StatisticsReport>(*publishers, *subscribers,
                                                  [this](msgs::graph::NodeStatistics& report) {
                                                    report.set_stamp(link->clock->now());
                                                    report.set_node(options.name);
                                                    publish_to(statistics_publisher, report);
                                                  });
  calls = std::make_unique<CallSide>(*link->loop, *channels, *registry);
  goals = std::make_unique<GoalSide>(*link->loop, *channels, *registry);
  deliveries = std::make_unique<DeliverySide>(
      [this](auto& client, auto& question) { return ask_delivery(client, question); });
  if (options.use_pointers) {
    const auto when_delivered = [this, loop = link->loop](auto& server, auto reply) {
      loop->post([this, server, reply] { answer_delivery(server, reply); });
    };
    LocalNodes::of_this_process().add(record.instance(),
                                      {link->loop, publishers.get(), when_delivered});
  }
  link->loop->every(100ms, [this] { tick(); });
  link->loop->every(1s, [this] {
    publishers->look_after_lost_readers();
    subscribers->trim_slabs();
    if (link->slabs) link->slabs->trim(kSlabRest);
  });
}

void Node::Impl::shutdown() {
  std::vector<std::weak_ptr<ActionServerCore>> servers;
  {
    const std::lock_guard lock(mutex);
    if (std::exchange(is_shut_down, true)) return;
    servers = action_server_list;
  }
  for (const auto& server : servers) {
    if (const auto alive = server.lock()) alive->begin_stop();
  }
  link->clock->stop();
  link->executor->stop();
  if (!loop_thread.joinable()) return;
  link->loop->post([this] {
    calls->stop();
    goals->stop();
    record.set_state(msgs::graph::STOPPING);
    record_changed();
  });
}

Node::Impl::~Impl() {
  shutdown();
  if (spin_thread.joinable()) spin_thread.join();
  std::vector<std::weak_ptr<ActionServerCore>> servers;
  {
    const std::lock_guard lock(mutex);
    servers.swap(action_server_list);
  }
  for (const auto& server : servers) {
    if (const auto alive = server.lock()) alive->stop();
  }
  if (!loop_thread.joinable()) return;
  link->loop->post([this] {
    flush_deadline = std::chrono::steady_clock::now() + kFlushTime;
    flush_and_leave();
  });
  loop_thread.join();
  LocalNodes::of_this_process().remove(record.instance());
  // Sockets have to go before their context; both of this thread now, as the loop's has ended.
  goals.reset();
  calls.reset();
  deliveries.reset();
  subscribers.reset();
  publishers.reset();
  registry.reset();
  channels.reset();
  gate.reset();
  if (!socket_file.empty()) ::unlink(socket_file.c_str());
  if (!runtime_folder.empty()) clean_runtime_folder(runtime_folder);
}

void Node::Impl::check_not_describing() const {
  if (describing) throw DescriptionDone();
}

std::string Node::Impl::resolve(const std::string& name) {
  check_not_describing();
  if (name.starts_with("//")) {  // a name of the whole graph
    check_resource_name(name.substr(1));
    return name.substr(1);
  }
  check_resource_name(name);
  const std::lock_guard lock(mutex);
  names_used.insert(name);
  const auto remap = remap_of(options.remaps, name);
  if (remap == options.remaps.end()) return in_name_space(options.name_space, name);
  remaps_used.insert(remap->first);
  check_remap(remap->first, remap->second);
  return renamed(*remap, name);
}

void Node::Impl::take_name(const std::string& purpose, const std::string& name) {
  if (!link->names.take(purpose, name)) {
    throw std::invalid_argument("node '" + options.name + "' has the " + purpose + " " + name +
                                " already");
  }
}

std::shared_ptr<PublisherCore> Node::Impl::make_publisher(const std::string& topic, const QoS& qos,
                                                          std::shared_ptr<const Schema> schema) {
  if (qos.depth == 0 || qos.max_bytes == 0) {
    throw std::invalid_argument("topic " + topic + ": QoS depth and max_bytes must be positive");
  }
  take_name("publisher of", topic);
  const std::uint64_t id = next_local_id();
  auto core = std::make_shared<PublisherCore>(link, topic, qos, schema, id);
  core->set_drain([this, id] { publishers->drain(id); });
  link->loop->post([this, core, schema] {
    registry->offer_schema(schema);
    publishers->add(core);
    record_changed();
  });
  // The loop keeps the core; what users hold ends the publisher when the last copy goes.
  const auto withdraw = [core, shared = link, this, id](PublisherCore*) {
    shared->names.release("publisher of", core->topic());
    shared->loop->post([this, id] {
      publishers->remove(id);
      record_changed();
    });
  };
  return std::shared_ptr<PublisherCore>(core.get(), withdraw);
}

std::shared_ptr<SubscriptionCore> Node::Impl::make_subscription(
    const std::string& topic, const QoS& qos, std::shared_ptr<const Schema> schema,
    SubscriptionCore::Handler handler, bool in_loop) {
  if (qos.depth == 0 || qos.max_bytes == 0) {
    throw std::invalid_argument("topic " + topic + ": QoS depth and max_bytes must be positive");
  }
  const std::uint64_t id = next_local_id();
  auto core =
      std::make_shared<SubscriptionCore>(link, topic, qos, schema, std::move(handler), id, in_loop);
  core->set_withdraw([this, id] {
    subscribers->remove(id);
    record_changed();
  });
  link->loop->post([this, core, schema] {
    if (schema) registry->offer_schema(schema);
    subscribers->add(core);
    record_changed();
  });
  if (!in_loop) wait_until_known();
  return core;
}

void Node::Impl::wait_until_known() {
  auto known = std::make_shared<std::promise<void>>();
  auto future = known->get_future();
  link->loop->post([this, known = std::move(known)] {
    if (!registry->answers()) return;  // drops the promise, which ends the wait
    known_waiters.push_back({0, known});
    record_changed();
  });
  future.wait_for(1s);
}

void Node::Impl::log(LogLevel level, const std::string& text) {
  static constexpr spdlog::level::level_enum kLevels[] = {spdlog::level::debug, spdlog::level::info,
                                                          spdlog::level::warn, spdlog::level::err};
  if (level < options.log_level) return;
  logger->log(kLevels[static_cast<int>(level)], text);
  msgs::graph::LogLine line;
  line.set_stamp(link->clock->now());
  line.set_level(static_cast<msgs::graph::LogLevel>(level));
  line.set_node(options.name);
  line.set_text(text);
  publish_to(log_publisher, line);
}

void Node::Impl::report(Health level, const std::string& text) {
  {
    const std::lock_guard lock(mutex);
    if (!health.say({level, text})) return;
  }
  if (level != Health::kOk) {
    log(level == Health::kError ? LogLevel::kError : LogLevel::kWarning, text);
  }
  tell_health();
}

void Node::Impl::callback_failed(const std::string& source, const std::string& what) {
  work_failed(Health::kError, source, source + ": exception in the callback: " + what);
}

void Node::Impl::work_failed(Health level, const std::string& source, const std::string& text) {
  std::uint64_t count = 0;
  bool is_new = false;
  {
    const std::lock_guard lock(mutex);
    auto& [failed, line] = failures[source];
    if (line.is_due(++failed)) count = failed;
    is_new = health.fail({level, text}, std::chrono::steady_clock::now());
  }
  if (is_new) {
    log(level == Health::kError ? LogLevel::kError : LogLevel::kWarning, text);
    tell_health();
  } else if (count > 0) {
    log(level == Health::kError ? LogLevel::kError : LogLevel::kWarning,
        fmt::format("{} ({} times in all)", text, count));
  }
}

void Node::Impl::hold_against(const std::string& instance, const std::string& text) {
  {
    const std::lock_guard lock(mutex);
    health.hold(instance, text);
  }
  log(LogLevel::kError, text);
  tell_health();
}

void Node::Impl::tell_health() {
  NodeHealth::Word word;
  {
    const std::lock_guard lock(mutex);
    if (!health.take_news(std::chrono::steady_clock::now(), word)) return;
  }
  msgs::graph::Diagnostic diagnostic;
  diagnostic.set_stamp(link->clock->now());
  diagnostic.set_node(options.name);
  diagnostic.set_level(static_cast<msgs::graph::HealthLevel>(word.level));
  diagnostic.set_text(word.text);
  publish_to(diagnostic_publisher, diagnostic);
  link->loop->post([this] { record_changed(); });
}

void Node::Impl::start_spinning() {
  parameters.check_all_given_are_declared();
  for (const auto& [from, to] : options.remaps) {
    const std::lock_guard lock(mutex);
    if (remaps_used.count(from) || from == to) continue;
    std::string used;
    for (const std::string& name : names_used) used += " " + name;
    logger->warn("nothing of this node is named {}, which was to be remapped to {}; it uses:{}",
                 from, to, used);
  }
  link->loop->post([this] {
    record.set_state(msgs::graph::READY);
    record_changed();
  });
}

}  // namespace prehend::graph
