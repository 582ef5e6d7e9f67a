#include "prehend/graph/link/offers.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

namespace prehend::graph {

msgs::graph::Offer to_record(const OfferType& offer) {
  msgs::graph::Offer record;
  record.set_name(offer.name);
  for (const std::string& name : offer.type_names) record.add_type_names(name);
  for (const std::uint64_t hash : offer.type_hashes) record.add_type_hashes(hash);
  return record;
}

FoundOffer find_offer(const RegistryLink& registry, const PeerChannels& channels,
                      const OfferType& wanted) {
  std::string lost;
  for (const auto& [instance, node] : registry.nodes()) {
    for (const auto& offer : wanted.is_action ? node.actions() : node.services()) {
      if (offer.name() != wanted.name) continue;
      if (channels.is_lost(instance)) {  // dead, though the registry has not noticed yet
        lost = instance;
        continue;
      }
      if (std::equal(offer.type_hashes().begin(), offer.type_hashes().end(),
                     wanted.type_hashes.begin(), wanted.type_hashes.end())) {
        return {&node, "", ""};
      }
      return {&node,
              fmt::format("{}: node '{}' serves it with other message types ({}) than its "
                          "client uses ({})",
                          wanted.label(), node.name(), fmt::join(offer.type_names(), ", "),
                          fmt::join(wanted.type_names, ", ")),
              ""};
    }
  }
  return {nullptr, "", lost};
}

}  // namespace prehend::graph
