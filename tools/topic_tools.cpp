#include "tools/topic_tools.h"

#include <google/protobuf/message.h>
#include <google/protobuf/text_format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <functional>
#include <map>
#include <memory>
#include <thread>
#include <vector>

#include "prehend/graph/introspection.h"
#include "prehend/graph/nearest_match.h"
#include "prehend/graph/node.h"
#include "prehend/graph/recording/protobuf_schema.h"
#include "prehend/graph/schema.h"
#include "tools/message_text.h"
#include "tools/own_message_types.h"

namespace prehend::tools {
namespace {

using graph::Node;
using graph::recording::SchemaMessageFactory;
using std::chrono::steady_clock;

// Runs `set_up` as a node with a name of its own; Ctrl-C shuts it down.
int run_as_node(const std::string& name, const std::string& registry,
                const std::function<void(Node&)>& set_up) {
  std::vector<std::string> words{"prehend", "--name", name + "_" + std::to_string(::getpid()),
                                 "--log-level", "warning"};
  if (!registry.empty()) words.insert(words.end(), {"--registry", registry});
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  return graph::run_node(static_cast<int>(words.size()), pointers.data(), {name, ""}, set_up);
}

void require_publisher(const std::string& registry, const std::string& topic) {
  graph::Introspection(registry).topic_schema(topic);
}

// Prints messages of any type; makes one factory for each type it meets.
class MessagePrinter {
 public:
  explicit MessagePrinter(bool full) : full_(full) {}
  void print(const graph::RawMessage& raw) {
    auto& factory = factories_[raw.info.schema_hash];
    if (!factory) {
      factory =
          std::make_unique<SchemaMessageFactory>(raw.schema->name, raw.schema->descriptor_set);
    }
    const auto message = factory->make();
    if (!message->ParseFromString(raw.bytes)) throw std::runtime_error("a message is damaged");
    std::printf("# %s from %s, message %llu, stamp %.9f s\n%s---\n", raw.schema->name.c_str(),
                raw.info.sender.c_str(), static_cast<unsigned long long>(raw.info.sequence),
                graph::seconds(raw.info.stamp), message_text(*message, full_).c_str());
    std::fflush(stdout);
  }

 private:
  const bool full_;
  std::map<std::uint64_t, std::unique_ptr<SchemaMessageFactory>> factories_;
};

// Arrivals since the last report.
struct Arrivals {
  std::uint64_t messages = 0, bytes = 0;
  double least = 0, greatest = 0;  // interval between arrivals [s]
  steady_clock::time_point last{};
  steady_clock::time_point since = steady_clock::now();

  void add(std::size_t size) {
    const auto now = steady_clock::now();
    if (last != steady_clock::time_point{}) {
      const double interval = std::chrono::duration<double>(now - last).count();
      least = messages == 0 ? interval : std::min(least, interval);
      greatest = std::max(greatest, interval);
    }
    last = now;
    ++messages;
    bytes += size;
  }

  void report(std::uint64_t lost) {
    const auto now = steady_clock::now();
    const double elapsed = std::chrono::duration<double>(now - since).count();
    std::printf("%8.1f Hz  %8.3f MB/s  interval %.1f .. %.1f ms%s\n",
                static_cast<double>(messages) / elapsed,
                static_cast<double>(bytes) * 1e-6 / elapsed, least * 1e3, greatest * 1e3,
                lost > 0 ? ("  " + std::to_string(lost) + " lost so far").c_str() : "");
    std::fflush(stdout);
    const auto kept = last;
    *this = {};
    last = kept;
  }
};

// A type of prehend's own, or one that a publisher of the graph has declared.
graph::Schema schema_named(graph::Introspection& introspection, const std::string& type) {
  if (const auto* descriptor = own_message_type(type)) return *graph::schema_of(*descriptor);
  return introspection.schema(type);
}

// The type of the topic's first publisher or, without one, of a subscriber.
graph::Schema type_of(const std::string& registry, const std::string& topic,
                      const std::string& type) {
  graph::Introspection introspection(registry);
  if (!type.empty()) return schema_named(introspection, type);
  std::vector<std::string> known;
  std::string found;
  for (const auto& node : introspection.nodes()) {
    for (const auto& ends : {node.publishers(), node.subscribers()}) {
      for (const auto& end : ends) {
        known.push_back(end.topic());
        if (end.topic() == topic && !end.schema_name().empty()) found = end.schema_name();
      }
    }
  }
  if (!found.empty()) return schema_named(introspection, found);
  std::sort(known.begin(), known.end());
  known.erase(std::unique(known.begin(), known.end()), known.end());
  throw std::runtime_error("nobody publishes or takes " + topic + ", so its type must be given" +
                           graph::nearest_match_hint(topic, known));
}

}  // namespace

int echo_topic(const EchoOptions& options) {
  if (!options.wait) require_publisher(options.registry, options.topic);
  return run_as_node("echo", options.registry, [&](Node& node) {
    MessagePrinter printer(options.full);
    std::uint64_t printed = 0;
    const auto subscription = node.subscribe_raw(
        options.topic, graph::QoS::queue(100), [&](const graph::RawMessage& message) {
          if (options.count > 0 && printed == options.count) return;
          printer.print(message);
          if (++printed == options.count) node.shutdown();
        });
    node.spin();
  });
}

int measure_topic(const RateOptions& options) {
  require_publisher(options.registry, options.topic);
  return run_as_node("hz", options.registry, [&](Node& node) {
    Arrivals arrivals;
    const auto start = steady_clock::now();
    const auto subscription = node.subscribe_raw(
        options.topic, graph::QoS::queue(10000),
        [&](const graph::RawMessage& message) { arrivals.add(message.bytes.size()); });
    const auto is_over = [&] {
      const std::chrono::duration<double> elapsed = steady_clock::now() - start;
      return options.duration > 0 && elapsed.count() >= options.duration;
    };
    const double period = options.duration > 0 ? std::min(1.0, options.duration) : 1.0;
    const auto timer = node.create_timer(period, [&] {
      const auto statistics = subscription.statistics();
      arrivals.report(statistics.dropped + statistics.missed + statistics.malformed);
      if (is_over()) node.shutdown();
    });
    node.spin();
  });
}

int publish_topic(const PublishOptions& options) {
  const graph::Schema schema = type_of(options.registry, options.topic, options.type);
  const SchemaMessageFactory factory(schema.name, schema.descriptor_set);
  const auto message = factory.make();
  if (!google::protobuf::TextFormat::ParseFromString(options.text, message.get())) {
    throw std::runtime_error("the text is no " + schema.name + " (the reason is above)");
  }
  const std::string bytes = message->SerializeAsString();
  return run_as_node("pub", options.registry, [&](Node& node) {
    const auto publisher = node.advertise_raw(options.topic, graph::QoS::queue(10),
                                              std::make_shared<graph::Schema>(schema));
    node.spin_in_background();
    const auto wait = std::chrono::nanoseconds(std::llround(options.wait * 1e9));
    if (!publisher.wait_for_subscribers(1, wait) && options.rate == 0) {
      throw std::runtime_error("nobody takes " + options.topic);
    }
    publisher.publish(bytes, node.clock().now());
    while (options.rate > 0 && node.ok()) {
      std::this_thread::sleep_for(std::chrono::duration<double>(1 / options.rate));
      publisher.publish(bytes, node.clock().now());
    }
  });
}

}  // namespace prehend::tools
