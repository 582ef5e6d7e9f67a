#include "prehend/recording/latched_messages.h"

#include <algorithm>
#include <charconv>
#include <deque>
#include <map>
#include <string>
#include <utility>

namespace prehend::recording {

std::size_t latched_depth(const McapChannel& channel) {
  constexpr std::size_t kMost = 10000;
  const auto entry = channel.metadata.find(kLatchedKey);
  if (entry == channel.metadata.end()) return 0;
  const std::string& text = entry->second;
  std::size_t depth = 1;  // other recorders write "true"
  std::from_chars(text.data(), text.data() + text.size(), depth);
  return std::clamp<std::size_t>(depth, 1, kMost);
}

std::vector<McapMessage> latched_before(McapReader& reader, const TopicFilter& filter,
                                        std::uint64_t time) {
  McapMessageFilter before;
  std::map<std::string, std::size_t> depths;
  for (const auto& [id, channel] : reader.channels()) {
    if (latched_depth(channel) == 0 || !filter.wants(channel.topic)) continue;
    depths[channel.topic] = std::max(depths[channel.topic], latched_depth(channel));
  }
  if (depths.empty() || time == 0) return {};
  for (const auto& [topic, depth] : depths) before.topics.push_back(topic);
  before.end_time = time - 1;

  std::map<std::string, std::deque<std::pair<std::uint64_t, McapMessage>>> kept;
  auto cursor = reader.messages(before);
  for (std::uint64_t order = 0; auto message = cursor.next(); ++order) {
    const std::string& topic = reader.channels().at(message->channel_id).topic;
    auto& last = kept[topic];
    last.emplace_back(order, std::move(*message));
    if (last.size() > depths.at(topic)) last.pop_front();
  }
  std::vector<std::pair<std::uint64_t, McapMessage>> all;
  for (auto& [topic, last] : kept) std::move(last.begin(), last.end(), std::back_inserter(all));
  std::sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<McapMessage> messages;
  for (auto& [order, message] : all) messages.push_back(std::move(message));
  return messages;
}

}  // namespace prehend::recording
