// Where a node is reached, whom it admits, and what it says when either does not work.

#include <fmt/format.h>

#include <cstdlib>
#include <filesystem>
#include <string_view>

#include "prehend/graph/node_impl.h"

namespace prehend::graph {
namespace {

std::string bind_address(const NodeOptions& options) {
  if (!options.bind_address.empty()) return options.bind_address;
  const char* from_environment = std::getenv("PREHEND_BIND");
  return from_environment ? from_environment : "";
}

}  // namespace

std::string Node::Impl::tcp_endpoint() const {
  const std::string address = bind_address(options);
  if (address.empty()) return options.use_tcp ? "tcp://127.0.0.1:*" : "";
  const bool is_ipv6 = address.find(':') != std::string::npos;
  return is_ipv6 ? "tcp://[" + address + "]:*" : "tcp://" + address + ":*";
}

std::unique_ptr<CurveGate> Node::Impl::make_gate() {
  const std::string address = bind_address(options);
  if (address == "0.0.0.0" || address == "::" || address == "*") {
    throw std::runtime_error("--bind " + address +
                             ": name the one address by which other hosts reach this one");
  }
  auto made = std::make_unique<CurveGate>(
      *link->loop, find_graph_keys(options.keys_file),
      [this](const std::string& text) { log(LogLevel::kWarning, text); });
  if (!tcp_endpoint().empty()) check_endpoint_is_safe(tcp_endpoint(), made->has_keys());
  return made;
}

std::string Node::Impl::no_answer(const std::string& endpoint,
                                  const std::string& key_trouble) const {
  return fmt::format("no registry answers at {} within {:.3g} s: {}", endpoint,
                     std::chrono::duration<double>(options.registry_timeout).count(),
                     key_trouble.empty() ? "start one with 'registry', or this node by 'prehend "
                                           "launch'"
                                         : key_trouble);
}

std::string Node::Impl::bind_failure(const std::string& folder, const std::string& what) const {
  if (const std::string endpoint = tcp_endpoint(); !endpoint.empty()) {
    return fmt::format("cannot listen on {}: {}; it must be an address of this host", endpoint,
                       what);
  }
  const bool elsewhere = !std::filesystem::exists(folder);
  return fmt::format("cannot open a socket in {}: {}{}", folder, what,
                     elsewhere ? "; the registry seems to be on another host, so give this node an "
                                 "address with --bind"
                               : "");
}

void Node::Impl::warn_if_out_of_reach(const msgs::graph::NodeRecord& node) {
  static constexpr std::string_view kIpc = "ipc://";
  if (!node.endpoint().starts_with(kIpc) || node.process_space() == record.process_space() ||
      std::filesystem::exists(node.endpoint().substr(kIpc.size())) ||
      !conflicts_told.insert("reach of " + node.instance()).second) {
    return;
  }
  log(LogLevel::kWarning,
      fmt::format("node '{}' is on another host and listens there only; nothing of it comes here "
                  "unless it is started with --bind ADDRESS",
                  node.name()));
}

}  // namespace prehend::graph
