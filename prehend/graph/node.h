#pragma once

#include <fmt/core.h>

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "prehend/graph/action.h"
#include "prehend/graph/clock.h"
#include "prehend/graph/delivery.h"
#include "prehend/graph/outcome.h"
#include "prehend/graph/parameter.h"
#include "prehend/graph/publisher.h"
#include "prehend/graph/qos.h"
#include "prehend/graph/raw_clients.h"
#include "prehend/graph/schema.h"
#include "prehend/graph/service.h"
#include "prehend/graph/subscription.h"

namespace prehend::graph {

enum class LogLevel { kDebug, kInfo, kWarning, kError };
enum class Health { kOk, kWarning, kError };

/// Default of --registry when the environment variable PREHEND_REGISTRY is not set.
inline constexpr const char* kDefaultRegistryEndpoint = "tcp://127.0.0.1:11411";

/// How a node joins the graph; run_node fills it from the command line.
struct NodeOptions {
  std::string name;      ///< unique in the graph, see check_node_name
  std::string program;   ///< kind of node; empty: the name
  std::string registry;  ///< endpoint; empty: PREHEND_REGISTRY, else default
  std::map<std::string, std::string> parameters;         ///< name -> text, instead of defaults
  std::map<std::string, std::string> parameter_sources;  ///< name -> "FILE:LINE", for messages
  std::string name_space;  ///< before every topic, service and action name, e.g. "/left"; or none
  /// Topic, service or action name -> name in the graph, to which no namespace is added.
  std::map<std::string, std::string> remaps;
  ClockMode clock = ClockMode::kWall;
  LogLevel log_level = LogLevel::kInfo;  ///< least level that is written and published
  bool use_tcp = false;                  ///< peers connect by tcp on loopback, not ipc
  bool use_slab = true;      ///< large payloads to processes on this host go through shared memory
  bool use_pointers = true;  ///< messages to nodes of this process are handed over by pointer
  /// How long the node's two threads look out for more before they sleep. Waking a sleeper takes
  /// 5 to 50 µs; each message then costs up to this much processor time in either thread.
  std::chrono::nanoseconds busy_wait{0};
  /// Of this host, where peers connect by tcp; empty: PREHEND_BIND, else ipc or use_tcp.
  std::string bind_address;
  std::string keys_file;  ///< of create_graph_keys; empty: PREHEND_KEYS, else no keys
  std::chrono::nanoseconds registry_timeout = std::chrono::seconds(5);  ///< to wait for it at start
};

/// What a topic carries, as far as the graph knows.
struct TopicInfo {
  std::string topic;
  std::string schema_name;
  std::uint64_t schema_hash = 0;
  QoS::Policy policy = QoS::Policy::kQueue;  ///< of the first publisher
  std::size_t depth = 0;                     ///< of the first publisher
  std::vector<std::string> publishers;       ///< node names
};

struct NodeDescription;
struct DescribedNode;

/// A node of the graph: one per process as a rule, several are possible.
///
/// Threads: callbacks (messages, service requests, timers, feedback, parameter changes) run one at
/// a time, in the order they came due, in the thread that calls spin(), or one background thread
/// after spin_in_background(); never under a lock. All functions may be called from any thread,
/// also in callbacks. One thread of the node's own moves the messages and keeps the registry's
/// lease, so a long callback delays nobody but its own node.
///
/// What blocks (call, wait, wait_for_server, wait_for_subscribers, sleeps of the clock) is refused
/// inside the node's callbacks, with a line that names the mend. Handlers of actions may block.
///
/// An exception that leaves a callback is logged, counted, and an error of the node's health for 5
/// s; the node goes on. So that one item of several does not lose the others, see shield().
///
/// Names of topics, services and actions start with '/'. They are put into the node's namespace,
/// except those of the whole graph (/clock, /log, /diagnostics, /parameter_events, /statistics) and
/// those that start with "//": "//left/camera" is "/left/camera" for every node. A malformed name,
/// or one that this node already uses for the same purpose, throws std::invalid_argument.
class Node {
 public:
  /// Joins the graph. Throws std::runtime_error with one clear line when no registry answers within
  /// options.registry_timeout or a live node has the same name (the line names its pid).
  explicit Node(NodeOptions options);
  /// Shuts down, sends what waits to be sent (at most 1 s), and leaves the graph. Publishers,
  /// subscriptions and handles may outlive the node; they do nothing then.
  ~Node();
  Node(const Node&) = delete;
  Node& operator=(const Node&) = delete;

  const std::string& name() const;

  // --- parameters -------------------------------------------------------------------------------

  /// Declares a parameter and returns its value: the default, or what the command line or parameter
  /// file says. Call before anything else in a run_node set-up, so that --help lists it.
  /// Throws std::invalid_argument when the value does not fit its type, range or choices.
  template <class Type>
  Type declare_parameter(const ParameterDeclaration<Type>& declaration) {
    return static_cast<Type>(
        std::get<ParameterStorage<Type>>(declare(to_parameter_info(declaration))));
  }

  /// The value now; it may be changed at run time (`prehend param set`).
  /// Throws std::invalid_argument when there is no such parameter or its type differs.
  template <class Type>
  Type parameter(const std::string& name) const {
    const ParameterValue value = parameter_value(name);
    const auto* typed = std::get_if<ParameterStorage<Type>>(&value);
    if (!typed) throw std::invalid_argument("parameter '" + name + "' has another type");
    return static_cast<Type>(*typed);
  }

  std::vector<ParameterInfo> parameters() const;
  /// Whether the command line, a parameter file or the launch gave it, be it the default's value:
  /// what is given but does not apply beside others is to be refused, not ignored.
  bool is_parameter_given(const std::string& name) const;
  /// Sets from text, with the checks of declare_parameter; then on_change is called back, and
  /// topic /parameter_events (msgs::graph::ParameterEvent) tells everybody.
  void set_parameter(const std::string& name, const std::string& text);
  /// The same for several, name -> text: sets all of them, or none when one is refused, and throws.
  void set_parameters(const std::map<std::string, std::string>& texts);

  // --- topics -----------------------------------------------------------------------------------

  /// Subscriptions made anywhere in the graph before this call (subscribe has returned) get every
  /// message from the first one on. Later ones join within milliseconds; use QoS::latched or
  /// wait_for_subscribers for them.
  template <class Message>
  [[nodiscard]] Publisher<Message> advertise(const std::string& topic, const QoS& qos) {
    return Publisher<Message>(advertise_core(topic, qos, schema_of(*Message::descriptor())));
  }

  /// Returns when the registry knows the subscription, after about 2 ms.
  /// `callback` takes each message. A publisher of another message type is
  /// refused: one error line and a diagnostic, no message of it is delivered.
  template <class Message>
  [[nodiscard]] Subscription subscribe(const std::string& topic, const QoS& qos,
                                       std::function<void(const Received<Message>&)> callback) {
    ContentHandler handler = [callback = std::move(callback)](
                                 const Content& content,
                                 const std::shared_ptr<const MessageInfo>& info) {
      MessageParts parts;
      if (!take_parts(content, Message::default_instance(), parts)) return false;
      callback(Received<Message>(std::move(parts), info));
      return true;
    };
    return subscribe_core(topic, qos, schema_of(*Message::descriptor()), std::move(handler));
  }

  /// Any type; `schema` from schema_of or schema_from_descriptor_set.
  [[nodiscard]] RawPublisher advertise_raw(const std::string& topic, const QoS& qos,
                                           std::shared_ptr<const Schema> schema);
  /// Takes messages of any type, not decoded. Copies each message once.
  [[nodiscard]] Subscription subscribe_raw(const std::string& topic, const QoS& qos,
                                           std::function<void(const RawMessage&)> callback);

  /// Calls back once for every topic that has a publisher, now and whenever one appears.
  void watch_topics(std::function<void(const TopicInfo&)> callback);

  /// Waits until all subscribers that have joined this node's topics have run their callbacks for
  /// everything it published before the call: nothing of it waits in any queue. Nothing when that
  /// took longer than `timeout` (wall time) or the node was shut down. Costs a message to and from
  /// each subscribing node; not for callbacks of a node that hears itself.
  [[nodiscard]] std::optional<ReaderQueues> wait_until_delivered(std::chrono::nanoseconds timeout);

  // --- services and actions ---------------------------------------------------------------------

  /// `handler` answers requests, among the node's callbacks. When it throws, the caller gets what()
  /// as error.
  template <class Request, class Response>
  [[nodiscard]] Service serve(const std::string& service,
                              std::function<Response(const Request&)> handler) {
    BytesHandler bytes = [handler = std::move(handler)](const std::string& body) {
      Request request;
      if (!request.ParseFromString(body)) throw std::runtime_error("request is damaged");
      return handler(request).SerializeAsString();
    };
    return serve_core(service, *Request::descriptor(), *Response::descriptor(), std::move(bytes));
  }

  template <class Request, class Response>
  [[nodiscard]] ServiceClient<Request, Response> client(const std::string& service) {
    return ServiceClient<Request, Response>(
        client_core(service, *Request::descriptor(), *Response::descriptor()));
  }

  /// `handler` works on one goal at a time in a thread of its own; see ActionContext. A new goal
  /// preempts: the running one is cancelled, and the new one starts when its handler has returned.
  /// A goal whose client dies is cancelled. When the handler throws, the client gets kFailed and
  /// what(). The handler may block, call services and wait for other goals.
  template <class Goal, class Feedback, class Result>
  [[nodiscard]] ActionServer serve_action(
      const std::string& action,
      std::function<Result(const Goal&, ActionContext<Feedback>&)> handler) {
    GoalHandler bytes = [handler = std::move(handler)](const std::string& body, GoalTask& task) {
      Goal goal;
      if (!goal.ParseFromString(body)) throw std::runtime_error("goal is damaged");
      ActionContext<Feedback> context(task);
      return handler(goal, context).SerializeAsString();
    };
    return serve_action_core(action, *Goal::descriptor(), *Feedback::descriptor(),
                             *Result::descriptor(), std::move(bytes));
  }

  template <class Goal, class Feedback, class Result>
  [[nodiscard]] ActionClient<Goal, Feedback, Result> action_client(const std::string& action) {
    return ActionClient<Goal, Feedback, Result>(action_client_core(
        action, *Goal::descriptor(), *Feedback::descriptor(), *Result::descriptor()));
  }

  /// The same for message types that are known at run time only, e.g. from a schema. The
  /// descriptors must live as long as the process.
  /// `handler` gets the request encoded, and returns the answer so; what it throws is the caller's
  /// error.
  using BytesHandler = std::function<std::string(const std::string& request)>;
  [[nodiscard]] Service serve_raw(const std::string& service,
                                  const google::protobuf::Descriptor& request,
                                  const google::protobuf::Descriptor& response,
                                  BytesHandler handler) {
    return serve_core(service, request, response, std::move(handler));
  }
  using GoalHandler = std::function<std::string(const std::string& goal, GoalTask&)>;
  [[nodiscard]] ActionServer serve_action_raw(const std::string& action,
                                              const google::protobuf::Descriptor& goal,
                                              const google::protobuf::Descriptor& feedback,
                                              const google::protobuf::Descriptor& result,
                                              GoalHandler handler) {
    return serve_action_core(action, goal, feedback, result, std::move(handler));
  }
  [[nodiscard]] RawServiceClient raw_client(const std::string& service,
                                            const google::protobuf::Descriptor& request,
                                            const google::protobuf::Descriptor& response);
  [[nodiscard]] RawActionClient raw_action_client(const std::string& action,
                                                  const google::protobuf::Descriptor& goal,
                                                  const google::protobuf::Descriptor& feedback,
                                                  const google::protobuf::Descriptor& result);

  // --- time -------------------------------------------------------------------------------------

  const Clock& clock() const;

  /// Holds a timer: destroying it stops the timer.
  class Timer {
   public:
    struct State;
    Timer() = default;
    explicit Timer(std::shared_ptr<State> state);
    ~Timer();
    Timer(Timer&&) noexcept;
    Timer& operator=(Timer&&) noexcept;

   private:
    std::shared_ptr<State> state_;
  };

  /// Calls back every `period_seconds` of the node's clock, first one period from now (simulated:
  /// from the first /clock stamp). Ticks missed by a slow callback or a jump of the clock merge
  /// into one; while the clock is paused there is none; when it jumps back, the period begins anew
  /// there. Throws std::invalid_argument unless the period is from 1e-9 to 1e9 s.
  [[nodiscard]] Timer create_timer(double period_seconds, std::function<void()> callback);
  /// The same, but calls back once only, `delay_seconds` from now.
  [[nodiscard]] Timer create_one_shot_timer(double delay_seconds, std::function<void()> callback);

  // --- words to the outside ---------------------------------------------------------------------

  /// Writes one line to stderr and topic /log. fmt format strings, checked at compile time.
  template <class... Arguments>
  void log_debug(fmt::format_string<Arguments...> format, Arguments&&... arguments) {
    log(LogLevel::kDebug, fmt::format(format, std::forward<Arguments>(arguments)...));
  }
  template <class... Arguments>
  void log_info(fmt::format_string<Arguments...> format, Arguments&&... arguments) {
    log(LogLevel::kInfo, fmt::format(format, std::forward<Arguments>(arguments)...));
  }
  template <class... Arguments>
  void log_warning(fmt::format_string<Arguments...> format, Arguments&&... arguments) {
    log(LogLevel::kWarning, fmt::format(format, std::forward<Arguments>(arguments)...));
  }
  template <class... Arguments>
  void log_error(fmt::format_string<Arguments...> format, Arguments&&... arguments) {
    log(LogLevel::kError, fmt::format(format, std::forward<Arguments>(arguments)...));
  }
  void log(LogLevel level, const std::string& text);

  /// The node's word on its own health, until the next report: published on /diagnostics (latched)
  /// and shown by `prehend node list`. A change to kWarning or kError is logged too.
  void report(Health health, const std::string& text);

  /// Does `work`: one item of a callback that has several, or a turn of a thread of the caller's
  /// own. An exception that leaves it, of any type, is logged and reported as diagnostic (kWarning,
  /// repetitions now and then), and what it says is returned; empty: all went well. `item` names
  /// it in the line: "object 3".
  std::string shield(const std::string& item, const std::function<void()>& work);

  // --- running ----------------------------------------------------------------------------------

  /// Declares the node ready and runs callbacks until shutdown.
  /// Throws std::runtime_error when a parameter was given that nobody declared, naming the nearest
  /// one, or when the node spins already.
  void spin();
  /// The same in a background thread, for programs with a sequential main; the checks throw here.
  void spin_in_background();
  /// Stops spin(), sleeps and waits. Also what SIGINT and SIGTERM do under run_node.
  void shutdown();
  /// False after shutdown.
  bool ok() const;

  struct Impl;

 private:
  using ContentHandler =
      std::function<bool(const Content&, const std::shared_ptr<const MessageInfo>&)>;
  using Type = google::protobuf::Descriptor;

  Timer make_timer(double seconds, bool once, std::function<void()> callback);
  ParameterValue declare(ParameterInfo parameter);
  ParameterValue parameter_value(const std::string& name) const;
  std::shared_ptr<PublisherCore> advertise_core(const std::string& topic, const QoS& qos,
                                                std::shared_ptr<const Schema> schema);
  Subscription subscribe_core(const std::string& topic, const QoS& qos,
                              std::shared_ptr<const Schema> schema, ContentHandler handler);
  Service serve_core(const std::string& service, const Type& request, const Type& response,
                     BytesHandler handler);
  std::shared_ptr<ServiceClientCore> client_core(const std::string& service, const Type& request,
                                                 const Type& response);
  ActionServer serve_action_core(const std::string& action, const Type& goal, const Type& feedback,
                                 const Type& result, GoalHandler handler);
  std::shared_ptr<ActionClientCore> action_client_core(const std::string& action, const Type& goal,
                                                       const Type& feedback, const Type& result);

  friend DescribedNode describe_node(const NodeOptions&, const std::function<void(Node&)>&);
  Node(NodeOptions options, bool describing);  // describing: joins no graph, for --help

  std::shared_ptr<Impl> impl_;
};

/// What a program that is a node says of itself.
struct NodeDescription {
  std::string name;     ///< default node name, as the program's
  std::string summary;  ///< one paragraph for --help
  /// [s] it may take to end after SIGINT, because it has something to write then. A launch gives it
  /// that time even when somebody is in a hurry. 0: the launch's usual 3 s, or 2 s.
  double stop_time = 0;
};

/// The main function of a program that is one node. Reads the command line
///   --name NAME  --registry ENDPOINT  --param KEY:=VALUE ...  --params FILE.yaml
///   --remap FROM:=TO ...  --namespace /NAME  --clock wall|simulated
///   --log-level debug|info|warning|error  --tcp  --bind ADDRESS  --keys FILE  --busy-wait SECONDS
///   --help (lists the parameters that `set_up` declares before anything else it does on the node)
///   --describe (the same for programs: a NodeProgramDescription as JSON)
/// joins the graph, calls `set_up`, which as a rule ends in node.spin(), and leaves the graph when
/// it returns. SIGINT and SIGTERM shut the node down; a second one kills, unless it comes within
/// the description's stop_time. Returns the exit code: 0, or 1 after printing what an exception
/// that left `set_up` says. A parameter file is a mapping of names to values; nested mappings join
/// names with '.'. Programs of nodes/ use node_program.h.
int run_node(int argc, char** argv, const NodeDescription& description,
             const std::function<void(Node&)>& set_up);

}  // namespace prehend::graph
