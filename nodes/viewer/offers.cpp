#include "nodes/viewer/offers.h"

#include <algorithm>

namespace prehend::nodes {

Offers offers_of(const std::vector<msgs::graph::NodeRecord>& nodes) {
  Offers offers;
  for (const msgs::graph::NodeRecord& node : nodes) {
    offers.nodes.push_back(node.name());
    for (const msgs::graph::TopicEnd& end : node.publishers()) {
      offers.graph.published[end.topic()].insert(node.name());
      OfferedTopic& topic = offers.topics[end.topic()];
      if (topic.schema_name.empty()) {
        topic.schema_name = end.schema_name();
        topic.schema_hash = end.schema_hash();
      }
      if (end.policy() == msgs::graph::LATCHED) {
        topic.latched = std::max<std::size_t>(topic.latched, end.depth());
      }
    }
    for (const msgs::graph::TopicEnd& end : node.subscribers()) {
      offers.graph.subscribed[end.topic()].insert(node.name());
    }
    for (const msgs::graph::Offer& offer : node.services()) {
      offers.graph.services[offer.name()].insert(node.name());
      if (offer.type_names_size() < 2 || offer.type_hashes_size() < 2) continue;
      offers.services[offer.name()] = {offer.type_names(0), offer.type_names(1),
                                       offer.type_hashes(0), offer.type_hashes(1)};
    }
  }
  return offers;
}

}  // namespace prehend::nodes
