#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

#include "msgs/graph.pb.h"
#include "prehend/graph/link/peer_channels.h"
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

/// How long a connection to a server that the registry knows may take to stand; a server that died
/// while the registry was away, too, is noticed by that.
inline constexpr auto kConnectTime = std::chrono::seconds(2);

msgs::graph::Offer to_record(const OfferType& offer);

/// The node that offers a service or action.
struct FoundOffer {
  const msgs::graph::NodeRecord* node = nullptr;  ///< null: nobody
  std::string error;                              ///< not empty: its types differ
  std::string lost;  ///< instance that offers it, when the connection to the only one is broken
};

FoundOffer find_offer(const RegistryLink& registry, const PeerChannels& channels,
                      const OfferType& wanted);

}  // namespace prehend::graph
