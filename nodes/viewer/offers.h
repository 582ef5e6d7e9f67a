#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "msgs/graph.pb.h"
#include "prehend/viewing/types.h"

namespace prehend::nodes {

/// A topic that somebody publishes.
struct OfferedTopic {
  std::string schema_name;
  std::uint64_t schema_hash = 0;
  std::size_t latched = 0;  ///< messages that late readers get of each sender
};

struct OfferedService {
  std::string request, response;  ///< message types
  std::uint64_t request_hash = 0, response_hash = 0;
};

/// What a graph's nodes offer, by name.
struct Offers {
  std::map<std::string, OfferedTopic> topics;
  std::map<std::string, OfferedService> services;
  viewing::ConnectionGraph graph;
  std::vector<std::string> nodes;
};

Offers offers_of(const std::vector<msgs::graph::NodeRecord>& nodes);

}  // namespace prehend::nodes
