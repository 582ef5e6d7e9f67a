#include "prehend/graph/registry.h"

#include <fmt/format.h>

#include <chrono>
#include <optional>
#include <random>
#include <stdexcept>
#include <thread>

#include "msgs/graph.pb.h"
#include "prehend/graph/link/curve.h"
#include "prehend/graph/link/frames.h"
#include "prehend/graph/link/io_loop.h"
#include "prehend/graph/link/node_link.h"
#include "prehend/graph/link/runtime_folder.h"
#include "prehend/graph/registry_state.h"

namespace prehend::graph {

using msgs::graph::RegistryReply;

namespace {

void log(const std::string& text) {
  fmt::print(stderr, "registry: {}\n", text);
  std::fflush(stderr);
}

std::string random_instance() {
  std::random_device random;
  return fmt::format("registry-{:08x}{:08x}", random(), random());
}

}  // namespace

struct Registry::Impl {
  explicit Impl(RegistryOptions registry_options)
      : options(std::move(registry_options)),
        gate(loop, find_graph_keys(options.keys_file), log),
        socket(loop.context(), zmq::socket_type::router) {}
  ~Impl() { gate.release(socket); }

  void listen();
  void read();
  void send(const std::string& route, const RegistryReply& reply);
  void sweep();

  const RegistryOptions options;
  IoLoop loop;
  CurveGate gate;
  zmq::socket_t socket;
  std::string endpoint;
  std::string folder;
  std::thread thread;
  std::optional<RegistryState> state;
  std::uint64_t malformed = 0;
  LossLine malformed_line;
};

void Registry::Impl::listen() {
  socket.set(zmq::sockopt::maxmsgsize, kMaxRequestBytes);
  socket.set(zmq::sockopt::linger, 300);
  socket.set(zmq::sockopt::router_mandatory, true);
  // A node that reads nothing any more must not make this process grow.
  socket.set(zmq::sockopt::sndhwm, 2000);
  gate.secure_server(socket, options.endpoint);
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
  state.emplace(
      RegistryState::Options{options.lease, random_instance(), folder, process_space(), {}},
      [this](const std::string& route, const RegistryReply& reply) { send(route, reply); });
  loop.watch(socket, [this] { read(); });
  loop.every(std::chrono::milliseconds(100), [this] { sweep(); });
  thread = std::thread([this] { loop.run(); });
}

void Registry::Impl::read() {
  const auto now = std::chrono::steady_clock::now();
  for (int i = 0; i < 100; ++i) {
    const Frames frames = receive(socket);
    if (frames.empty()) return;
    if (frames.size() != 2 ||
        !state->take(frames[0].to_string(), frames[1].to_string_view(), now)) {
      ++malformed;
    }
  }
}

void Registry::Impl::send(const std::string& route, const RegistryReply& reply) {
  Frames frames(1);
  frames[0] = zmq::message_t(reply.SerializeAsString());
  // A node that cannot be reached loses its lease; one that missed a change sees it by the
  // revision.
  loop.touch(socket);
  graph::send(socket, route, frames);
}

void Registry::Impl::sweep() {
  if (malformed_line.is_due(malformed)) {
    log(fmt::format("{} messages that are no requests thrown away in all", malformed));
  }
  if (state->sweep(std::chrono::steady_clock::now())) clean_runtime_folder(folder);
}

Registry::Registry(RegistryOptions options) : impl_(std::make_unique<Impl>(std::move(options))) {
  impl_->listen();
}

Registry::~Registry() {
  impl_->loop.close();
  impl_->thread.join();
  impl_->gate.release(impl_->socket);
  impl_->socket.close();
  leave_runtime_folder(impl_->folder);
}

const std::string& Registry::endpoint() const { return impl_->endpoint; }
const std::string& Registry::runtime_folder() const { return impl_->folder; }

}  // namespace prehend::graph
