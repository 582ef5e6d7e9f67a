#include "prehend/graph/registry_limits.h"

#include <fmt/format.h>

#include <stdexcept>

#include "prehend/graph/names.h"
#include "prehend/graph/schema.h"

namespace prehend::graph {
namespace {

constexpr std::size_t kMaxTextBytes = 512;  // of instances, endpoints, type names

void check_length(const char* what, const std::string& text) {
  if (text.empty()) throw std::invalid_argument(fmt::format("its {} is empty", what));
  if (text.size() > kMaxTextBytes) {
    throw std::invalid_argument(
        fmt::format("its {} has {} bytes, at most {} are taken", what, text.size(), kMaxTextBytes));
  }
}

void check_record(const msgs::graph::NodeRecord& record, const RegistryLimits& limits) {
  check_length("name", record.name());
  check_node_name(record.name());
  check_length("instance", record.instance());
  check_length("endpoint", record.endpoint());
  if (const std::size_t bytes = record.ByteSizeLong(); bytes > limits.record_bytes) {
    throw std::invalid_argument(
        fmt::format("its record has {} bytes, at most {} are taken", bytes, limits.record_bytes));
  }
  const int ends = record.publishers_size() + record.subscribers_size() + record.services_size() +
                   record.actions_size();
  if (static_cast<std::size_t>(ends) > limits.ends) {
    throw std::invalid_argument(
        fmt::format("it has {} publishers, subscribers, services and actions, at most {} are taken",
                    ends, limits.ends));
  }
  const auto check_names = [](const auto& entries, const auto& name_of) {
    for (const auto& entry : entries) {
      check_length("topic, service or action name", name_of(entry));
      check_resource_name(name_of(entry));
    }
  };
  const auto topic = [](const msgs::graph::TopicEnd& end) { return end.topic(); };
  const auto name = [](const msgs::graph::Offer& offer) { return offer.name(); };
  check_names(record.publishers(), topic);
  check_names(record.subscribers(), topic);
  check_names(record.services(), name);
  check_names(record.actions(), name);
}

}  // namespace

std::string record_fault(const msgs::graph::NodeRecord& record, const RegistryLimits& limits) {
  try {
    check_record(record, limits);
  } catch (const std::invalid_argument& error) {
    return fmt::format("the registry refuses node '{:.100}': {}", record.name(), error.what());
  }
  return "";
}

std::string schema_fault(const msgs::graph::Schema& schema, const RegistryLimits& limits) {
  const std::string start =
      fmt::format("the registry refuses message type '{:.100}': ", schema.name());
  if (schema.ByteSizeLong() > limits.schema_bytes) {
    return fmt::format("{}its descriptors have {} bytes, at most {} are taken", start,
                       schema.ByteSizeLong(), limits.schema_bytes);
  }
  try {
    const auto true_one = schema_from_descriptor_set(schema.name(), schema.descriptor_set());
    return true_one->hash == schema.hash() ? "" : start + "its hash is not that of its descriptors";
  } catch (const std::invalid_argument& error) {
    return start + error.what();
  }
}

}  // namespace prehend::graph
