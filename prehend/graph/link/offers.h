#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "msgs/graph.pb.h"
#include "prehend/graph/link/registry_link.h"

namespace prehend::graph {

/// A service or action as its server and its clients name it.
struct OfferType {
  bool is_action = false;
  std::string name;
  std::vector<std::string> type_names;
  std::vector<std::uint64_t> type_hashes;

  /// "service /x" or "action /x".
  std::string label() const { return (is_action ? "action " : "service ") + name; }
};

msgs::graph::Offer to_record(const OfferType& offer);

/// The node that offers a service or action.
struct FoundOffer {
  const msgs::graph::NodeRecord* node = nullptr;  ///< null: nobody
  std::string error;                              ///< not empty: its types differ
};

FoundOffer find_offer(const RegistryLink& registry, const OfferType& wanted);

}  // namespace prehend::graph
