// Shows a graph to viewers: our own page, Foxglove, Lichtblick. See bridge.h.

#include <chrono>
#include <memory>
#include <random>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "msgs/views/views.h"
#include "nodes/platform_source/platform_source.h"
#include "nodes/viewer/bridge.h"
#include "prehend/graph/node_program.h"
#include "prehend/graph/stop_signals.h"
#include "prehend/graph/warm_heap.h"
#include "prehend/robot/robot_files.h"
#include "prehend/text/tree_file.h"

namespace {

using namespace prehend;

std::string random_token() {
  std::random_device random;
  return fmt::format("{:08x}{:08x}{:08x}{:08x}", random(), random(), random(), random());
}

viewing::ServerOptions declare_server(graph::Node& node) {
  viewing::ServerOptions options;
  options.name = "prehend";
  options.address = node.declare_parameter<std::string>(
      {.name = "address",
       .default_value = "127.0.0.1",
       .description = "to listen at; 0.0.0.0: at all of this machine, which needs a token",
       .read_only = true});
  options.port = static_cast<std::uint16_t>(
      node.declare_parameter<int>({.name = "port",
                                   .default_value = 8765,
                                   .minimum = 0,
                                   .maximum = 65535,
                                   .description = "to listen at; 0: any that is free",
                                   .read_only = true}));
  options.token = node.declare_parameter<std::string>(
      {.name = "token",
       .description = "that the page's address has to have, ?token=...; empty: none on this "
                      "machine, else one is made up and logged",
       .read_only = true});
  options.allowed_origins = node.declare_parameter<std::vector<std::string>>(
      {.name = "allowed_origins",
       .description =
           "pages of other sites that may connect, as https://app.foxglove.dev; '*': all",
       .read_only = true});
  options.page = node.declare_parameter<std::string>({.name = "page",
                                                      .default_value = text::tree_file("web/dist"),
                                                      .description = "folder of the page's files",
                                                      .read_only = true});
  options.most_viewers = static_cast<std::size_t>(
      node.declare_parameter<int>({.name = "most_viewers",
                                   .default_value = 64,
                                   .minimum = 1,
                                   .maximum = 1000,
                                   .description = "at once; further ones are refused",
                                   .read_only = true}));
  options.limits.outbox_bytes =
      static_cast<std::size_t>(1e6 * node.declare_parameter<double>(
                                         {.name = "outbox",
                                          .default_value = 16,
                                          .unit = "MB",
                                          .minimum = 0.1,
                                          .maximum = 1000,
                                          .description = "that may wait for a viewer that is slow "
                                                         "before it misses messages",
                                          .read_only = true}));
  return options;
}

std::shared_ptr<const robot::Platform> declare_platform(graph::Node& node) {
  const std::string platforms = nodes::declare_platforms(node);
  const auto name = node.declare_parameter<std::string>(
      {.name = "platform",
       .description = "robot that is shown, of `platforms` without .yaml, or a file; empty: none",
       .read_only = true});
  if (name.empty()) return nullptr;
  return std::make_shared<const robot::Platform>(
      robot::read_platform(robot::platform_file(platforms, name)));
}

void show(graph::Node& node) {
  nodes::Bridge::Options options;
  options.server = declare_server(node);
  options.control = node.declare_parameter<bool>(
      {.name = "control",
       .default_value = true,
       .description = "viewers may set parameters, call services and publish; false: only look",
       .read_only = true});
  options.views = views::standard_views(declare_platform(node));
  const bool is_here = viewing::is_loopback_host(options.server.address);
  if (!is_here && options.server.token.empty()) options.server.token = random_token();
  graph::keep_heap_warm();

  node.spin_in_background();
  nodes::Bridge bridge(node, std::move(options));
  node.report(graph::Health::kOk, fmt::format("the page: {}", bridge.server().page_address()));
  node.log_info("the page: {}", bridge.server().page_address());
  constexpr int kLook = 15;  // times that the time is told before the graph is looked at
  for (int i = 0; node.ok() && !graph::stop_requested(); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(33));
    bridge.tell_time();
    if (i % kLook == 0) bridge.look();
  }
  node.shutdown();
}

const graph::RegisteredNodeProgram registered(
    {"viewer",
     "Shows the graph to viewers in a browser (its own page), Foxglove and Lichtblick, any number "
     "at "
     "once: one port for HTTP and the Foxglove WebSocket protocol, with every topic, service and "
     "parameter, and robot, objects, grasps, images, frames and log as types that they draw. What "
     "nobody looks at costs nothing; who is slow misses messages and is told. See docs/viewer.md."},
    show, true);

}  // namespace
