#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "msgs/graph.pb.h"

namespace prehend::graph {

/// What a registry keeps at most, so that no node, broken or hostile, makes it grow without bound.
struct RegistryLimits {
  std::size_t nodes = 2000;
  std::size_t ends = 2000;  ///< publishers, subscribers, services and actions of one node
  std::size_t record_bytes = std::size_t{512} << 10;     ///< of one node
  std::size_t all_record_bytes = std::size_t{64} << 20;  ///< of all nodes
  std::size_t schema_bytes = std::size_t{1} << 20;       ///< of one message type
  std::size_t all_schema_bytes = std::size_t{64} << 20;  ///< of all message types
};

/// Largest request a registry takes; ZeroMQ closes the connection of who announces more.
inline constexpr std::int64_t kMaxRequestBytes = std::int64_t{2} << 20;

/// Why a registry cannot take the record, in one line; empty when it can.
std::string record_fault(const msgs::graph::NodeRecord& record, const RegistryLimits& limits);

/// The same for a message type, whose hash has to be that of its descriptors.
std::string schema_fault(const msgs::graph::Schema& schema, const RegistryLimits& limits);

}  // namespace prehend::graph
