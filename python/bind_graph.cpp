// prehend.Node: topics, services, actions, parameters and time of a graph.

#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <thread>
#include <type_traits>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <google/protobuf/descriptor.h>
#include <pybind11/functional.h>
#include <pybind11/stl.h>

#include "prehend/geometry/errors.h"
#include "prehend/graph/introspection.h"
#include "prehend/graph/node.h"
#include "prehend/graph/node_command_line.h"
#include "prehend/graph/node_impl.h"
#include "prehend/graph/stop_signals.h"
#include "prehend/recording/protobuf_schema.h"
#include "python/arrays.h"
#include "python/held_node.h"
#include "python/messages.h"
#include "python/servers.h"

namespace prehend::python {
namespace {

using google::protobuf::Descriptor;
using std::chrono::nanoseconds;
using std::chrono::steady_clock;

graph::QoS qos_of(const py::object& queue, int latched) {
  if (latched < 0) throw py::value_error("latched must not be negative");
  if (latched > 0) return graph::QoS::latched(static_cast<std::size_t>(latched));
  if (py::isinstance<py::str>(queue)) {
    if (py::cast<std::string>(queue) == "latest") return graph::QoS::latest();
    throw py::value_error("queue is to be a number of messages or 'latest'");
  }
  const int depth = py::cast<int>(queue);
  if (depth < 1) throw py::value_error("queue must be 1 or more messages, or 'latest'");
  return graph::QoS::queue(static_cast<std::size_t>(depth));
}

std::shared_ptr<google::protobuf::Message> decoded(const graph::Schema& schema,
                                                   const std::string& bytes) {
  std::shared_ptr<google::protobuf::Message> message =
      make_message(schema.name, schema.descriptor_set);
  if (!message->ParseFromString(bytes)) throw std::runtime_error("no " + schema.name);
  return message;
}

class Publisher {
 public:
  Publisher(std::shared_ptr<HeldNode> node, graph::RawPublisher publisher, std::string type)
      : node_(std::move(node)), publisher_(std::move(publisher)), type_(std::move(type)) {}

  void publish(const py::object& message, std::optional<std::int64_t> stamp) const {
    const std::unique_ptr<google::protobuf::Message> made = make_own_message(type_);
    fill_message(message, made.get());
    std::string bytes = made->SerializeAsString();
    const py::gil_scoped_release release;
    publisher_.publish(std::move(bytes), stamp ? *stamp : (*node_)->clock().now());
  }
  bool wait_for_subscribers(int count, double timeout) const {
    const py::gil_scoped_release release;
    (void)**node_;
    return wait_until(
        [&](nanoseconds turn) {
          return publisher_.wait_for_subscribers(static_cast<std::size_t>(std::max(count, 0)),
                                                 turn);
        },
        timeout);
  }

 private:
  std::shared_ptr<HeldNode> node_;
  graph::RawPublisher publisher_;
  std::string type_;
};

class Subscription {
 public:
  Subscription(std::shared_ptr<HeldNode> node, graph::Subscription subscription)
      : node_(std::move(node)), subscription_(std::move(subscription)) {}
  ~Subscription() { close(); }
  /// No callback runs afterwards.
  void close() {
    const py::gil_scoped_release release;
    subscription_.reset();
  }
  std::map<std::string, std::uint64_t> statistics() const {
    if (!subscription_) throw std::runtime_error("this Subscription is closed");
    const auto s = subscription_->statistics();
    return {{"received", s.received},     {"delivered", s.delivered}, {"dropped", s.dropped},
            {"superseded", s.superseded}, {"missed", s.missed},       {"malformed", s.malformed},
            {"publishers", s.publishers}};
  }

 private:
  std::shared_ptr<HeldNode> node_;
  std::optional<graph::Subscription> subscription_;
};

/// The types of a service or an action, as its server has told them.
struct Types {
  explicit Types(const std::vector<graph::Schema>& schemas) {
    for (const graph::Schema& schema : schemas) {
      made.push_back(make_message(schema.name, schema.descriptor_set));
    }
  }
  const Descriptor& operator[](std::size_t i) const { return *made[i]->GetDescriptor(); }
  std::shared_ptr<google::protobuf::Message> make(std::size_t i) const {
    return std::shared_ptr<google::protobuf::Message>(made[i]->New());
  }
  std::vector<std::shared_ptr<google::protobuf::Message>> made;
};

class Goal {
 public:
  Goal(std::shared_ptr<HeldNode> node, std::shared_ptr<const Types> types,
       graph::RawActionClient client, graph::RawGoalHandle handle, std::string action)
      : node_(std::move(node)),
        types_(std::move(types)),
        client_(std::move(client)),
        handle_(std::move(handle)),
        action_(std::move(action)) {}

  bool done() const { return handle_.done(); }
  void cancel() const {
    const py::gil_scoped_release release;
    (void)**node_;
    handle_.cancel();
  }
  /// (status, error, result or None)
  py::tuple wait(std::optional<double> timeout) const {
    const auto result = types_->make(2);
    bool has_result = false;
    std::string error;
    graph::Status status = graph::Status::kTimeout;
    {
      const py::gil_scoped_release release;
      (void)**node_;
      wait_until(
          [&](nanoseconds turn) {
            status = handle_.wait(*result, has_result, turn, error);
            return status != graph::Status::kTimeout;
          },
          timeout);
    }
    const bool has = has_result || status == graph::Status::kOk;
    return py::make_tuple(graph::to_string(status), error, has ? to_python(result) : py::none());
  }
  const std::string& action() const { return action_; }

 private:
  std::shared_ptr<HeldNode> node_;
  std::shared_ptr<const Types> types_;
  graph::RawActionClient client_;
  graph::RawGoalHandle handle_;
  std::string action_;
};

graph::LogLevel level_named(const std::string& name) {
  if (name == "debug") return graph::LogLevel::kDebug;
  if (name == "info") return graph::LogLevel::kInfo;
  if (name == "warning") return graph::LogLevel::kWarning;
  if (name == "error") return graph::LogLevel::kError;
  throw py::value_error("there is no level '" + name + "'; give debug, info, warning or error");
}

py::object value_of(const graph::ParameterValue& value) {
  return std::visit([](const auto& one) -> py::object { return py::cast(one); }, value);
}

class Node {
 public:
  static std::unique_ptr<Node> make(const std::string& name, const std::string& registry,
                                    const std::string& clock, const std::string& name_space,
                                    double timeout) {
    graph::NodeOptions options;
    options.name = name;
    options.registry = registry;
    options.name_space = name_space;
    if (clock != "wall" && clock != "simulated") {
      throw py::value_error("clock is '" + clock + "'; give wall or simulated");
    }
    options.clock = clock == "wall" ? graph::ClockMode::kWall : graph::ClockMode::kSimulated;
    options.registry_timeout = duration_of(timeout);
    const py::gil_scoped_release release;
    auto* node = new graph::Node(std::move(options));
    auto held = std::make_shared<HeldNode>(node, [node] { delete node; });
    const py::gil_scoped_acquire lock;
    return std::make_unique<Node>(std::move(held), registry);
  }
  Node(std::shared_ptr<HeldNode> node, std::string registry)
      : node_(std::move(node)), registry_(std::move(registry)) {
    all().insert(this);
  }
  ~Node() {
    all().erase(this);
    close();
  }
  /// Those that are there, under the interpreter's lock.
  static std::set<Node*>& all() {
    static auto& nodes = *new std::set<Node*>();
    return nodes;
  }

  void close() {
    const py::gil_scoped_release release;
    node_->close();
  }
  std::string name() const { return (*node_)->name(); }
  bool ok() const { return node_->is_open() && (*node_)->ok(); }

  // --- topics -----------------------------------------------------------------------------------

  std::unique_ptr<Publisher> advertise(const std::string& topic, const std::string& type,
                                       const py::object& queue, int latched) const {
    const auto made = make_own_message(type);
    const graph::QoS qos = qos_of(queue, latched);
    const py::gil_scoped_release release;
    auto publisher = (*node_)->advertise_raw(topic, qos, graph::schema_of(*made->GetDescriptor()));
    node_->spin();
    return std::make_unique<Publisher>(node_, std::move(publisher), type);
  }

  std::unique_ptr<Subscription> subscribe(const std::string& topic, py::function function,
                                          const py::object& queue, int latched) const {
    const graph::QoS qos = qos_of(queue, latched);
    const Callback callback = shared(std::move(function));
    const py::gil_scoped_release release;
    auto subscription =
        (*node_)->subscribe_raw(topic, qos, [callback](const graph::RawMessage& raw) {
          const auto message = decoded(*raw.schema, raw.bytes);
          const py::gil_scoped_acquire lock;
          call_python(*callback, to_python(message));
        });
    node_->spin();
    return std::make_unique<Subscription>(node_, std::move(subscription));
  }

  // --- services and actions ---------------------------------------------------------------------

  py::object call_service(const std::string& service, const py::object& request,
                          double timeout) const {
    const Types types =
        types_of([&](graph::Introspection& look) { return look.service(service); }, timeout);
    const auto asked = types.make(0), answered = types.make(1);
    fill_message(request, asked.get());
    std::string error;
    graph::Status status = graph::Status::kTimeout;
    {
      const py::gil_scoped_release release;
      const auto client = (*node_)->raw_client(service, types[0], types[1]);
      status = client.call(*asked, *answered, duration_of(timeout), error);
    }
    if (status == graph::Status::kTimeout) time_out(error);
    if (status != graph::Status::kOk) throw std::runtime_error(error);
    return to_python(answered);
  }

  std::unique_ptr<Goal> send_goal(const std::string& action, const py::object& goal,
                                  const std::optional<py::function>& on_feedback,
                                  double timeout) const {
    const auto types = std::make_shared<const Types>(
        types_of([&](graph::Introspection& look) { return look.action(action); }, timeout));
    const auto asked = types->make(0);
    fill_message(goal, asked.get());
    const Callback callback = on_feedback ? shared(*on_feedback) : nullptr;
    const py::gil_scoped_release release;
    auto client = (*node_)->raw_action_client(action, (*types)[0], (*types)[1], (*types)[2]);
    node_->spin();
    auto handle = client.send(*asked, [callback, types](const std::string& bytes) {
      if (!callback) return;
      const auto feedback = types->make(1);
      if (!feedback->ParseFromString(bytes)) throw std::runtime_error("feedback is damaged");
      const py::gil_scoped_acquire lock;
      call_python(*callback, to_python(feedback));
    });
    return std::make_unique<Goal>(node_, types, std::move(client), std::move(handle), action);
  }

  std::unique_ptr<ServedService> serve(const std::string& service, const std::string& request,
                                       const std::string& response, py::function handler) const {
    return serve_service(node_, service, request, response, std::move(handler));
  }
  std::unique_ptr<ServedAction> serve_goals(const std::string& action, const std::string& goal,
                                            const std::string& feedback, const std::string& result,
                                            py::function handler) const {
    return serve_action(node_, action, goal, feedback, result, std::move(handler));
  }

  // --- parameters, time, words ------------------------------------------------------------------

  py::object declare_parameter(const std::string& name, const py::object& value,
                               const std::string& description, const std::string& unit,
                               const py::object& minimum, const py::object& maximum,
                               const py::object& choices, bool read_only) const {
    const auto declare = [&](auto zero) -> py::object {
      using Type = decltype(zero);
      using Element = typename graph::ParameterElement<Type>::type;
      graph::ParameterDeclaration<Type> declaration;
      declaration.name = name;
      declaration.default_value = py::cast<Type>(value);
      declaration.description = description;
      declaration.unit = unit;
      declaration.read_only = read_only;
      if constexpr (!std::is_same_v<Element, bool> && !std::is_same_v<Element, std::string>) {
        if (!minimum.is_none()) declaration.minimum = py::cast<Element>(minimum);
        if (!maximum.is_none()) declaration.maximum = py::cast<Element>(maximum);
      } else if (!minimum.is_none() || !maximum.is_none()) {
        throw py::type_error("minimum and maximum are of numbers, which " + name + " is none of");
      }
      if (!choices.is_none()) declaration.choices = py::cast<std::vector<Element>>(choices);
      return py::cast((*node_)->declare_parameter<Type>(declaration));
    };
    if (py::isinstance<py::bool_>(value)) return declare(bool{});
    if (py::isinstance<py::int_>(value)) return declare(std::int64_t{});
    if (py::isinstance<py::float_>(value)) return declare(double{});
    if (py::isinstance<py::str>(value)) return declare(std::string{});
    if (py::isinstance<py::list>(value)) {
      const auto list = py::reinterpret_borrow<py::list>(value);
      return list.empty() || py::isinstance<py::str>(list[0]) ? declare(std::vector<std::string>{})
                                                              : declare(std::vector<double>{});
    }
    throw py::type_error("the parameter " + name +
                         " is to be a bool, int, float, str, or a list of float or str");
  }

  py::object parameter(const std::string& name) const {
    for (const graph::ParameterInfo& one : (*node_)->parameters()) {
      if (one.name == name) return value_of(one.value);
    }
    throw geometry::InputError("The node has no parameter '" + name + "'",
                               "Declare it by declare_parameter()");
  }

  std::int64_t now() const { return (*node_)->clock().now(); }

  /// Of the node's clock. False: it was shut down.
  bool sleep(double seconds) const {
    const std::int64_t end = now() + duration_of(seconds).count();
    const py::gil_scoped_release release;
    node_->spin();
    // In turns of the wall's time, as a simulated clock may stand.
    while ((*node_)->ok() && (*node_)->clock().now() < end) {
      const std::int64_t left = end - (*node_)->clock().now();
      if ((*node_)->clock().mode() == graph::ClockMode::kWall) {
        (*node_)->clock().sleep_for(std::min<nanoseconds>(nanoseconds(left), kTurn));
      } else {
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      }
      check_signals();
    }
    return (*node_)->ok();
  }

  /// Until it is shut down.
  void spin() const {
    const py::gil_scoped_release release;
    node_->spin();
    while (node_->is_open() && (*node_)->ok()) {
      std::this_thread::sleep_for(kTurn);
      check_signals();
    }
  }

  void log(const std::string& text, const std::string& level) const {
    (*node_)->log(level_named(level), text);
  }
  void report(const std::string& text, const std::string& health) const {
    const std::map<std::string, graph::Health> known{{"ok", graph::Health::kOk},
                                                     {"warning", graph::Health::kWarning},
                                                     {"error", graph::Health::kError}};
    const auto found = known.find(health);
    if (found == known.end()) throw py::value_error("health is to be ok, warning or error");
    (*node_)->report(found->second, text);
  }

 private:
  [[noreturn]] static void time_out(const std::string& error) {
    PyErr_SetString(PyExc_TimeoutError, error.c_str());
    throw py::error_already_set();
  }

  Types types_of(const std::function<std::vector<graph::Schema>(graph::Introspection&)>& ask,
                 double timeout) const {
    std::vector<graph::Schema> schemas;
    {
      const py::gil_scoped_release release;
      graph::Introspection look(registry_);
      const auto end = steady_clock::now() + duration_of(timeout);
      while (true) {
        try {
          schemas = ask(look);
          break;
        } catch (const std::runtime_error&) {
          if (steady_clock::now() >= end) throw;
        }
        std::this_thread::sleep_for(kTurn);
        check_signals();
      }
    }
    return Types(schemas);
  }

  std::shared_ptr<HeldNode> node_;
  std::string registry_;  // empty: the environment's
};

/// The main function of a program that is one node: `work` gets the node.
int run_node(const py::function& work, const std::string& name, const std::string& summary,
             const std::vector<std::string>& words) {
  const py::object done = py::module_::import("prehend._prehend").attr("DescriptionDone");
  const graph::NodeDescription description{name, summary, 0};
  const auto run = [&](graph::Node& node) {
    const auto held = std::make_shared<HeldNode>(&node, [] {});
    const py::gil_scoped_acquire lock;
    py::object made = py::cast(std::make_unique<Node>(held, ""));
    try {
      work(made);
    } catch (py::error_already_set& error) {
      made.attr("close")();
      if (error.matches(done)) throw graph::DescriptionDone();
      throw;
    }
    made.attr("close")();
  };
  const py::gil_scoped_release release;
  graph::NodeCommandLine command;
  try {
    command = graph::read_node_command_line(words, description);
  } catch (const std::invalid_argument& error) {
    fmt::print(stderr, "{}: {}\n", name, error.what());
    return 2;
  }
  if (graph::print_what_is_asked(command, description, run)) return 0;
  if (!command.options.registry.empty()) {
    ::setenv("PREHEND_REGISTRY", command.options.registry.c_str(), 1);
  }
  graph::Node node(std::move(command.options));
  const graph::StopSignals signals([&node] { node.shutdown(); });
  run(node);
  return 0;
}

py::dict nodes_of(const std::string& registry) {
  std::vector<msgs::graph::NodeRecord> nodes;
  {
    const py::gil_scoped_release release;
    nodes = graph::Introspection(registry).nodes();
  }
  py::dict all;
  for (const auto& node : nodes) {
    py::list publishes, subscribes, services, actions;
    for (const auto& one : node.publishers()) publishes.append(one.topic());
    for (const auto& one : node.subscribers()) subscribes.append(one.topic());
    for (const auto& one : node.services()) services.append(one.name());
    for (const auto& one : node.actions()) actions.append(one.name());
    py::dict said;
    said["publishes"] = publishes;
    said["subscribes"] = subscribes;
    said["services"] = services;
    said["actions"] = actions;
    all[py::str(node.name())] = said;
  }
  return all;
}

py::dict topics_of(const std::string& registry) {
  std::vector<msgs::graph::NodeRecord> nodes;
  {
    const py::gil_scoped_release release;
    nodes = graph::Introspection(registry).nodes();
  }
  py::dict all;
  for (const auto& node : nodes) {
    for (const auto& one : node.publishers()) all[py::str(one.topic())] = one.schema_name();
  }
  return all;
}

std::string get_parameter(const std::string& node, const std::string& name,
                          const std::string& registry) {
  const py::gil_scoped_release release;
  return graph::to_text(graph::Introspection(registry).parameter(node, name).value());
}

std::string set_parameter(const std::string& node, const std::string& name, const py::object& value,
                          const std::string& registry) {
  std::string text = py::cast<std::string>(py::str(value));
  if (py::isinstance<py::bool_>(value)) text = py::cast<bool>(value) ? "true" : "false";
  const py::gil_scoped_release release;
  return graph::to_text(graph::Introspection(registry).set_parameter(node, name, text).value());
}

}  // namespace

void bind_graph(py::module_& m) {
  // No Exception, so that a script's own handlers let it through.
  static py::object done = py::reinterpret_steal<py::object>(
      PyErr_NewException("prehend._prehend.DescriptionDone", PyExc_BaseException, nullptr));
  m.attr("DescriptionDone") = done;
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const graph::DescriptionDone&) {
      PyErr_SetString(done.ptr(), "the node is only described");
    }
  });

  py::class_<Publisher>(m, "Publisher", "Publishes on a topic.")
      .def("publish", &Publisher::publish, py::arg("message"), py::arg("stamp") = py::none(),
           "Publishes a Message, or a dict of the fields that are set. stamp: [ns], when it was "
           "published; None: now, by the node's clock.")
      .def("wait_for_subscribers", &Publisher::wait_for_subscribers, py::arg("count") = 1,
           py::arg("timeout") = 5.0, "True once so many listen; False after `timeout` [s].");
  py::class_<Subscription>(m, "Subscription", "Listens to a topic until it is closed or let go of.")
      .def("close", &Subscription::close, "No callback runs afterwards.")
      .def_property_readonly("statistics", &Subscription::statistics,
                             "What became of its messages, by name.");
  py::class_<Goal>(m, "Goal", "A goal that was sent to an action.")
      .def_property_readonly("done", &Goal::done)
      .def_property_readonly("action", &Goal::action)
      .def("cancel", &Goal::cancel, "Asks the server to stop.")
      .def(
          "wait_status", &Goal::wait, py::arg("timeout") = py::none(),
          "Waits at most `timeout` [s], None: until it has ended. (status, error, result or None); "
          "status: ok, timeout (the goal goes on), failed, cancelled, preempted, server gone.");
  bind_servers(m);
  py::class_<Node>(m, "Node",
                   "A node of a graph. Callbacks run one at a time in a thread of the node.")
      .def(py::init(&Node::make), py::arg("name"), py::arg("registry") = "",
           py::arg("clock") = "wall", py::arg("name_space") = "", py::arg("timeout") = 5.0,
           "Joins the graph. registry: its endpoint; '': $PREHEND_REGISTRY, else this machine's. "
           "clock: wall, or simulated, which follows /clock. Raises RuntimeError when no registry "
           "answers within `timeout` [s], or a node has that name.")
      .def("close", &Node::close, "Leaves the graph. No callback runs afterwards.")
      .def("__enter__", [](py::object self) { return self; })
      .def("__exit__", [](Node& self, const py::args&) { self.close(); })
      .def_property_readonly("name", &Node::name)
      .def_property_readonly("ok", &Node::ok, "False once it was shut down.")
      .def("advertise", &Node::advertise, py::arg("topic"), py::arg("type"), py::arg("queue") = 10,
           py::arg("latched") = 0,
           "A Publisher. type: of prehend's messages, as 'JointState'. queue: how many messages "
           "wait for a slow reader, or 'latest'. latched: how many late readers get.")
      .def("subscribe", &Node::subscribe, py::arg("topic"), py::arg("callback"),
           py::arg("queue") = 10, py::arg("latched") = 0,
           "A Subscription, which lasts as long as it is kept. callback: takes each Message, of "
           "whatever type. latched: so many of those that were published before come, too.")
      .def("call", &Node::call_service, py::arg("service"), py::arg("request") = py::dict(),
           py::arg("timeout") = 5.0,
           "Calls a service, and returns its answer. Waits for it to be there. Raises TimeoutError "
           "after `timeout` [s], RuntimeError with what the server says against it.")
      .def("send_goal", &Node::send_goal, py::arg("action"), py::arg("goal") = py::dict(),
           py::arg("on_feedback") = py::none(), py::arg("timeout") = 5.0,
           "Sends a goal to an action, and returns a Goal. Waits up to `timeout` [s] for a server.")
      .def("serve", &Node::serve, py::arg("service"), py::arg("request"), py::arg("response"),
           py::arg("handler"),
           "A Service, which lasts as long as it is kept. request, response: types, as "
           "'Acknowledge'. handler: takes the request, a Message, and returns a Message or a dict; "
           "what it raises is the caller's error.")
      .def("serve_action", &Node::serve_goals, py::arg("action"), py::arg("goal"),
           py::arg("feedback"), py::arg("result"), py::arg("handler"),
           "An ActionServer, which lasts as long as it is kept. goal, feedback, result: types, as "
           "'MoveGripperGoal'. handler: takes the goal and a GoalContext, in a thread of its own, "
           "and returns the result, a Message or a dict. A newer goal cancels the one that runs.")
      .def(
          "declare_parameter", &Node::declare_parameter, py::arg("name"), py::arg("default"),
          py::arg("description") = "", py::arg("unit") = "", py::arg("minimum") = py::none(),
          py::arg("maximum") = py::none(), py::arg("choices") = py::none(),
          py::arg("read_only") = false,
          "Declares a parameter (bool, int, float, str, or a list of float or str) and returns its "
          "value: the default, or what the command line or launch file says.")
      .def("parameter", &Node::parameter, py::arg("name"), "Its value now.")
      .def_property_readonly("now", &Node::now, "The node's time [ns].")
      .def("sleep", &Node::sleep, py::arg("seconds"),
           "Of the node's clock. False when the node was shut down first.")
      .def("spin", &Node::spin, "Until the node is shut down, by Ctrl-C or a launch.")
      .def("log", &Node::log, py::arg("text"), py::arg("level") = "info",
           "level: debug, info, warning, error.")
      .def("report", &Node::report, py::arg("text"), py::arg("health") = "ok",
           "The node's word on its own health, on /diagnostics: ok, warning, error.");

  m.def("run_node", &run_node, py::arg("work"), py::arg("name"), py::arg("summary"),
        py::arg("words"));
  m.def("nodes", &nodes_of, py::arg("registry") = "",
        "The graph's nodes by name, each with what it publishes, subscribes to, serves.");
  m.def("topics", &topics_of, py::arg("registry") = "",
        "The topics that somebody publishes: the protobuf name of the type, by name.");
  m.def("get_parameter", &get_parameter, py::arg("node"), py::arg("name"), py::arg("registry") = "",
        "A node's parameter, as text.");
  m.def("set_parameter", &set_parameter, py::arg("node"), py::arg("name"), py::arg("value"),
        py::arg("registry") = "", "Sets it, and returns what the node then has, as text.");
  m.def("_close_nodes", [] {
    for (Node* node : std::set<Node*>(Node::all())) node->close();
  });
}

}  // namespace prehend::python
