#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "python/held_node.h"

namespace prehend::python {

/// A service or an action of Python's, until it is closed or let go of.
template <class Server>
class Served {
 public:
  Served(std::shared_ptr<HeldNode> node, Server server)
      : node_(std::move(node)), server_(std::move(server)) {}
  ~Served() { close(); }
  Served(const Served&) = delete;
  Served& operator=(const Served&) = delete;
  /// No handler runs afterwards.
  void close() {
    const py::gil_scoped_release release;
    server_.reset();
  }

 private:
  std::shared_ptr<HeldNode> node_;
  std::optional<Server> server_;
};
using ServedService = Served<graph::Service>;
using ServedAction = Served<graph::ActionServer>;

/// `handler` takes a prehend.Message and returns one or a mapping. @throws geometry::InputError for
/// types that there are not. All with the interpreter's lock.
std::unique_ptr<ServedService> serve_service(std::shared_ptr<HeldNode> node,
                                             const std::string& service, const std::string& request,
                                             const std::string& response, py::function handler);
/// `handler` takes the goal and a GoalContext.
std::unique_ptr<ServedAction> serve_action(std::shared_ptr<HeldNode> node,
                                           const std::string& action, const std::string& goal,
                                           const std::string& feedback, const std::string& result,
                                           py::function handler);

void bind_servers(py::module_& m);

}  // namespace prehend::python
