#include "prehend/launch/readiness.h"

#include <algorithm>
#include <stdexcept>

#include "prehend/text/nearest_match.h"

namespace prehend::launch {
namespace {

constexpr std::chrono::milliseconds kReadinessTime{300};

// The names the node uses itself, as far as the graph shows them.
std::vector<std::string> names_of(const msgs::graph::NodeRecord& record) {
  std::vector<std::string> used;
  for (const auto& end : record.publishers()) used.push_back(end.topic());
  for (const auto& end : record.subscribers()) used.push_back(end.topic());
  for (const auto& offer : record.services()) used.push_back(offer.name());
  for (const auto& offer : record.actions()) used.push_back(offer.name());
  return used;
}

}  // namespace

Readiness::Readiness(const std::string& registry) : introspection_(registry, kReadinessTime) {}

bool Readiness::ask() {
  try {
    records_ = introspection_.nodes();
    return true;
  } catch (const std::runtime_error&) {
    return false;  // the registry is being restarted; its end is reported
  }
}

bool Readiness::is_ready(const LaunchProcess& process, pid_t pid) const {
  return std::all_of(process.nodes.begin(), process.nodes.end(), [&](const LaunchNode* node) {
    return std::any_of(records_.begin(), records_.end(), [&](const auto& record) {
      return record.pid() == pid && record.name() == node->name &&
             record.state() == msgs::graph::READY;
    });
  });
}

bool Readiness::is_ready(const std::string& node) const {
  return std::any_of(records_.begin(), records_.end(), [&](const auto& record) {
    return record.name() == node && record.state() == msgs::graph::READY;
  });
}

void Readiness::check_remaps(const LaunchNode& node, LaunchOutput& output) const {
  for (const auto& record : records_) {
    if (record.name() != node.name) continue;
    const std::vector<std::string> used = names_of(record);
    for (const auto& [from, to] : node.remaps) {
      if (from == to) continue;  // kept from another remap, if there is such a name
      const bool all_below = to.ends_with("/*");
      const std::string beginning = all_below ? to.substr(0, to.size() - 1) : to;
      if (std::ranges::any_of(used, [&](const std::string& name) {
            return all_below ? name.starts_with(beginning) : name == to;
          })) {
        continue;
      }
      output.warning(node.place + ": remap of " + from + ": " + node.name +
                     " has no such topic, service or action" +
                     text::nearest_match_hint(from, used));
    }
  }
}

}  // namespace prehend::launch
