#include "tools/topic_publish.h"

#include <google/protobuf/message.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>
#include <thread>
#include <vector>

#include "prehend/graph/introspection.h"
#include "prehend/recording/protobuf_schema.h"
#include "prehend/text/nearest_match.h"
#include "tools/command_node.h"
#include "tools/message_input.h"
#include "tools/own_message_types.h"

namespace prehend::tools {
namespace {

using graph::Node;
using std::chrono::steady_clock;

// A type of prehend's own, or one that a node of the graph has declared.
graph::Schema schema_named(graph::Introspection& introspection, const std::string& type) {
  if (const auto* descriptor = own_message_type(type)) return *graph::schema_of(*descriptor);
  return introspection.schema(type);
}

// The type of the topic's first publisher or, without one, of a subscriber.
graph::Schema type_of(const PublishOptions& options) {
  graph::Introspection introspection(options.registry);
  if (!options.type.empty()) return schema_named(introspection, options.type);
  std::vector<std::string> known;
  std::string found;
  for (const auto& node : introspection.nodes()) {
    for (const auto& ends : {node.publishers(), node.subscribers()}) {
      for (const auto& end : ends) {
        known.push_back(end.topic());
        if (end.topic() == options.topic && !end.schema_name().empty()) found = end.schema_name();
      }
    }
  }
  if (!found.empty()) return schema_named(introspection, found);
  std::sort(known.begin(), known.end());
  known.erase(std::unique(known.begin(), known.end()), known.end());
  throw std::runtime_error("nobody publishes or takes " + options.topic +
                           ", so its type must be given" +
                           text::nearest_match_hint(options.topic, known));
}

// Sleeps until `deadline`; false when the node was shut down first.
bool sleep_until(const Node& node, steady_clock::time_point deadline) {
  while (node.ok() && steady_clock::now() < deadline) {
    const auto left = deadline - steady_clock::now();
    std::this_thread::sleep_for(
        std::min<steady_clock::duration>(left, std::chrono::milliseconds(20)));
  }
  return node.ok();
}

steady_clock::duration duration_of(double seconds) {
  return std::chrono::duration_cast<steady_clock::duration>(
      std::chrono::duration<double>(std::min(seconds, 1e9)));
}

}  // namespace

int publish_topic(const PublishOptions& options) {
  const graph::Schema schema = type_of(options);
  const recording::SchemaMessageFactory factory(schema.name, schema.descriptor_set);
  const auto message = factory.make();
  parse_message(options.text, *message);
  const std::string bytes = message->SerializeAsString();
  const auto qos = options.latched ? graph::QoS::latched(1) : graph::QoS::queue(10);
  return run_as_node("pub", options.registry, [&](Node& node) {
    const auto publisher =
        node.advertise_raw(options.topic, qos, std::make_shared<graph::Schema>(schema));
    node.spin_in_background();
    const bool single = options.rate == 0;
    if (!options.latched && !publisher.wait_for_subscribers(1, duration_of(options.wait)) &&
        single) {
      throw std::runtime_error("nobody takes " + options.topic);
    }
    auto next = steady_clock::now();
    for (std::uint64_t sent = 1; node.ok(); ++sent) {
      publisher.publish(bytes, node.clock().now());
      if (single || sent == options.count) break;
      next += duration_of(1 / options.rate);
      sleep_until(node, next);
    }
    if (!options.latched) return;
    const double hold = options.hold > 0 ? options.hold : 1e9;
    sleep_until(node, steady_clock::now() + duration_of(hold));
  });
}

}  // namespace prehend::tools
