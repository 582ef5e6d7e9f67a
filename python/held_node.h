#pragma once

#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>
#include <pybind11/pybind11.h>

#include "prehend/graph/clock.h"
#include "prehend/graph/node.h"

// What the bindings of the graph share: waits that Ctrl-C ends, Python's functions as callbacks,
// and a node that Python may let go of at any time.
namespace prehend::python {

namespace py = pybind11;

constexpr auto kTurn = std::chrono::milliseconds(50);  // how often a wait looks for Ctrl-C

/// A Python function that other threads may call and let go of.
using Callback = std::shared_ptr<py::function>;

inline Callback shared(py::function function) {
  return {new py::function(std::move(function)), [](py::function* held) {
            const py::gil_scoped_acquire lock;
            delete held;
          }};
}

inline std::chrono::nanoseconds duration_of(double seconds) {
  if (std::isnan(seconds) || seconds < 0) {
    throw std::invalid_argument(fmt::format("{} s is no time to wait", seconds));
  }
  return std::chrono::nanoseconds(graph::nanoseconds(std::min(seconds, 1e9)));
}

/// Raises what a signal's handler in Python has raised, as Ctrl-C does.
inline void check_signals() {
  const py::gil_scoped_acquire lock;
  if (PyErr_CheckSignals() != 0) throw py::error_already_set();
}

/// Calls `is_over` until it says so, at most `timeout`; false: the time is up. Without the
/// interpreter's lock.
inline bool wait_until(const std::function<bool(std::chrono::nanoseconds)>& is_over,
                       std::optional<double> timeout) {
  using std::chrono::nanoseconds;
  const auto end = std::chrono::steady_clock::now() + duration_of(timeout.value_or(1e9));
  while (true) {
    const nanoseconds left = end - std::chrono::steady_clock::now();
    if (is_over(std::min<nanoseconds>(std::max(left, nanoseconds(0)), kTurn))) return true;
    if (left <= nanoseconds(0)) return false;
    check_signals();
  }
}

/// An exception of a callback ends nothing: it is an error of the node, in Python's words.
template <class... Arguments>
py::object call_python(const py::function& callback, const Arguments&... arguments) {
  try {
    return callback(arguments...);
  } catch (py::error_already_set& error) {
    throw std::runtime_error(error.what());
  }
}

/// A node, of one process: what a fork made of it in the child is not touched.
class HeldNode {
 public:
  HeldNode(graph::Node* node, std::function<void()> let_go)
      : node_(node), let_go_(std::move(let_go)), process_(::getpid()) {}
  ~HeldNode() { close(); }
  HeldNode(const HeldNode&) = delete;

  graph::Node& operator*() const {
    if (process_ != ::getpid()) {
      throw std::runtime_error("this Node was made before a fork: make one in this process");
    }
    if (!node_) throw std::runtime_error("this Node is closed");
    return *node_;
  }
  graph::Node* operator->() const { return &**this; }
  bool is_open() const { return node_ && process_ == ::getpid(); }

  /// Callbacks may come from now on.
  void spin() {
    if (spins_.exchange(true)) return;
    (**this).spin_in_background();
  }
  /// No callback runs afterwards. Without the interpreter's lock, as one that runs needs it.
  void close() {
    if (!is_open()) return;
    node_->shutdown();
    node_ = nullptr;
    let_go_();
  }

 private:
  graph::Node* node_;
  std::function<void()> let_go_;
  pid_t process_;
  std::atomic<bool> spins_{false};
};

}  // namespace prehend::python
