// prehend.Service, ActionServer and GoalContext: what a node of Python offers.

#include <mutex>

#include <google/protobuf/descriptor.h>

#include "prehend/graph/raw_clients.h"
#include "python/messages.h"
#include "python/servers.h"

namespace prehend::python {
namespace {

using google::protobuf::Message;

/// A message of a type, from bytes. @throws std::runtime_error for damaged ones.
std::shared_ptr<Message> from_bytes(const Message& type, const std::string& bytes) {
  std::shared_ptr<Message> message(type.New());
  if (!message->ParseFromString(bytes)) {
    throw std::runtime_error("no " + type.GetDescriptor()->full_name());
  }
  return message;
}

/// What a handler has returned, as bytes. Needs the interpreter's lock.
std::string to_bytes(const Message& type, const py::object& value) {
  const std::unique_ptr<Message> message(type.New());
  if (!value.is_none()) fill_message(value, message.get());
  return message->SerializeAsString();
}

/// What a handler of goals sees; only while that runs.
class GoalContext {
 public:
  GoalContext(graph::GoalTask& task, std::shared_ptr<const Message> feedback)
      : context_(graph::RawActionContext(task)), feedback_(std::move(feedback)) {}
  void end() {
    const std::lock_guard lock(mutex_);
    context_.reset();
  }
  bool cancelled() const { return !context_ || context_->cancelled(); }
  bool preempted() const { return context_ && context_->preempted(); }
  void feedback(const py::object& value) const {
    const std::unique_ptr<Message> message(feedback_->New());
    fill_message(value, message.get());
    const py::gil_scoped_release release;
    const std::lock_guard lock(mutex_);
    if (!context_) throw std::runtime_error("the goal has ended");
    context_->feedback(*message);
  }
  bool sleep(double seconds) const {
    const std::chrono::nanoseconds duration = duration_of(seconds);
    const py::gil_scoped_release release;
    return context_ && context_->sleep_for(duration);
  }

 private:
  mutable std::mutex mutex_;
  std::optional<graph::RawActionContext> context_;
  std::shared_ptr<const Message> feedback_;
};

template <class Class>
void bind_closing(Class& bound) {
  bound.def("close", &Class::type::close, "No handler runs afterwards.")
      .def("__enter__", [](py::object self) { return self; })
      .def("__exit__", [](typename Class::type& self, const py::args&) { self.close(); });
}

}  // namespace

std::unique_ptr<ServedService> serve_service(std::shared_ptr<HeldNode> node,
                                             const std::string& service, const std::string& request,
                                             const std::string& response, py::function handler) {
  const std::shared_ptr<const Message> asked = make_own_message(request),
                                       answered = make_own_message(response);
  const Callback callback = shared(std::move(handler));
  const py::gil_scoped_release release;
  auto server =
      (*node)->serve_raw(service, *asked->GetDescriptor(), *answered->GetDescriptor(),
                         [asked, answered, callback](const std::string& bytes) {
                           const auto message = from_bytes(*asked, bytes);
                           const py::gil_scoped_acquire lock;
                           return to_bytes(*answered, call_python(*callback, to_python(message)));
                         });
  node->spin();
  return std::make_unique<ServedService>(std::move(node), std::move(server));
}

std::unique_ptr<ServedAction> serve_action(std::shared_ptr<HeldNode> node,
                                           const std::string& action, const std::string& goal,
                                           const std::string& feedback, const std::string& result,
                                           py::function handler) {
  const std::shared_ptr<const Message> asked = make_own_message(goal),
                                       told = make_own_message(feedback),
                                       ended = make_own_message(result);
  const Callback callback = shared(std::move(handler));
  const py::gil_scoped_release release;
  auto server = (*node)->serve_action_raw(
      action, *asked->GetDescriptor(), *told->GetDescriptor(), *ended->GetDescriptor(),
      [asked, told, ended, callback](const std::string& bytes, graph::GoalTask& task) {
        const auto message = from_bytes(*asked, bytes);
        const auto context = std::make_shared<GoalContext>(task, told);
        // Whatever Python keeps of it, it has ended with the handler.
        struct Ends {
          GoalContext& context;
          ~Ends() { context.end(); }
        } const ends{*context};
        const py::gil_scoped_acquire lock;
        return to_bytes(*ended, call_python(*callback, to_python(message), py::cast(context)));
      });
  node->spin();
  return std::make_unique<ServedAction>(std::move(node), std::move(server));
}

void bind_servers(py::module_& m) {
  py::class_<ServedService> service(m, "Service", "A service that a node of Python offers.");
  bind_closing(service);
  py::class_<ServedAction> action(m, "ActionServer", "An action that a node of Python offers.");
  bind_closing(action);
  py::class_<GoalContext, std::shared_ptr<GoalContext>>(
      m, "GoalContext", "What the handler of a goal sees of the world outside.")
      .def_property_readonly("cancelled", &GoalContext::cancelled,
                             "True once the handler should stop soon and return: its client "
                             "cancelled or died, a newer goal came, or the node shuts down.")
      .def_property_readonly("preempted", &GoalContext::preempted,
                             "True when the reason is a newer goal.")
      .def("feedback", &GoalContext::feedback, py::arg("message"),
           "Sends feedback, a Message or a dict, to the goal's client.")
      .def("sleep", &GoalContext::sleep, py::arg("seconds"),
           "By the node's clock; False at once when it is cancelled.");
}

}  // namespace prehend::python
