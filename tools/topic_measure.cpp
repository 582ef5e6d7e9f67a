#include "tools/topic_measure.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <mutex>
#include <thread>

#include "prehend/graph/introspection.h"
#include "tools/arrivals.h"
#include "tools/command_node.h"
#include "tools/json.h"

namespace prehend::tools {
namespace {

using Quantity = MeasureOptions::Quantity;

double steady_seconds() {
  const auto now = std::chrono::steady_clock::now().time_since_epoch();
  return std::chrono::duration<double>(now).count();
}

std::string spread_text(const Spread& spread, double scale, const char* unit, int digits) {
  return fmt::format("mean {:.{}f}  least {:.{}f}  greatest {:.{}f}  deviation {:.{}f} {}",
                     spread.mean * scale, digits, spread.least * scale, digits,
                     spread.greatest * scale, digits, spread.deviation * scale, digits, unit);
}

std::string line_of(const Arrivals& arrivals, Quantity quantity) {
  if (arrivals.size() == 0) return "no message so far";
  if (quantity == Quantity::kDelay) {
    return "delay: " + spread_text(arrivals.delays(), 1e3, "ms", 3);
  }
  if (arrivals.size() == 1) return "one message so far";
  if (quantity == Quantity::kBandwidth) {
    return fmt::format("{:.3f} MB/s  message: {}", arrivals.bytes_per_second() * 1e-6,
                       spread_text(arrivals.bytes(), 1, "bytes", 0));
  }
  return fmt::format("{:.1f} messages/s  interval: {}", arrivals.rate(),
                     spread_text(arrivals.intervals(), 1e3, "ms", 2));
}

Json to_json(const Spread& spread) {
  Json json = Json::object();
  json.set("count", spread.count)
      .set("mean", spread.mean)
      .set("minimum", spread.least)
      .set("maximum", spread.greatest)
      .set("standard_deviation", spread.deviation);
  return json;
}

void report(const MeasureOptions& options, const Arrivals& arrivals,
            const graph::SubscriptionStatistics& statistics) {
  const std::uint64_t lost = statistics.dropped + statistics.missed + statistics.malformed;
  if (options.json) {
    Json json = Json::object();
    json.set("topic", options.topic)
        .set("messages", arrivals.total())
        .set("window", arrivals.size())
        .set("lost", lost)
        .set("rate", arrivals.rate())
        .set("bytes_per_second", arrivals.bytes_per_second())
        .set("interval_seconds", to_json(arrivals.intervals()))
        .set("message_bytes", to_json(arrivals.bytes()))
        .set("delay_seconds", to_json(arrivals.delays()));
    return print(json);
  }
  std::printf("%s  (last %zu of %llu)%s\n", line_of(arrivals, options.quantity).c_str(),
              arrivals.size(), static_cast<unsigned long long>(arrivals.total()),
              lost > 0 ? fmt::format("  {} LOST", lost).c_str() : "");
  std::fflush(stdout);
}

// Stamps are of the simulation's time where somebody publishes it.
bool is_simulated(const MeasureOptions& options) {
  if (options.clock != "auto") return options.clock == "simulated";
  for (const auto& node : graph::Introspection(options.registry).nodes()) {
    for (const auto& end : node.publishers()) {
      if (end.topic() == "/clock") return true;
    }
  }
  return false;
}

}  // namespace

int measure_topic(const MeasureOptions& options) {
  require_publisher(options.registry, options.topic);
  const bool simulated = options.quantity == Quantity::kDelay && is_simulated(options);
  const auto measure = [&](graph::Node& node) {
    std::mutex mutex;
    Arrivals arrivals(std::max<std::size_t>(2, options.window));
    const auto subscription = node.subscribe_raw(
        options.topic, graph::QoS::queue(10000), [&](const graph::RawMessage& message) {
          const std::lock_guard lock(mutex);
          if (options.count > 0 && arrivals.total() >= options.count) return;
          arrivals.add({steady_seconds(), static_cast<double>(message.bytes.size()),
                        graph::seconds(node.clock().now() - message.info.stamp)});
          if (arrivals.total() == options.count) node.shutdown();
        });
    const auto say = [&] {
      const std::lock_guard lock(mutex);
      report(options, arrivals, subscription.statistics());
    };
    node.spin_in_background();
    const double start = steady_seconds();
    double next = start + 1;  // of the wall clock, also where the simulation's stands still
    while (node.ok() && (options.duration == 0 || steady_seconds() - start < options.duration)) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
      if (steady_seconds() < next) continue;
      next += 1;
      say();
    }
    say();
  };
  return run_as_node("measure", options.registry, measure, simulated);
}

}  // namespace prehend::tools
