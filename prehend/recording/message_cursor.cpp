#include <algorithm>
#include <utility>

#include "prehend/recording/mcap_reader.h"

namespace prehend::recording {

McapMessageCursor McapReader::messages(const McapMessageFilter& filter) {
  return McapMessageCursor(*this, filter);
}

McapMessageCursor::McapMessageCursor(McapReader& reader, McapMessageFilter filter)
    : reader_(&reader), filter_(std::move(filter)) {
  const auto is_wanted = [&](std::uint16_t channel) {
    const auto known = reader.channels_.find(channel);
    return known != reader.channels_.end() &&
           std::find(filter_.topics.begin(), filter_.topics.end(), known->second.topic) !=
               filter_.topics.end();
  };
  for (const McapReader::Block& block : reader.blocks_) {
    const bool overlaps =
        block.start_time <= filter_.end_time && block.end_time >= filter_.start_time;
    const bool has_topics = filter_.topics.empty() || block.channels.empty() ||
                            std::any_of(block.channels.begin(), block.channels.end(), is_wanted);
    if (overlaps && has_topics) blocks_.push_back(block);
  }
  std::stable_sort(blocks_.begin(), blocks_.end(), [](const auto& a, const auto& b) {
    return std::pair(a.start_time, a.offset) < std::pair(b.start_time, b.offset);
  });
}

bool McapMessageCursor::later(const Pending& a, const Pending& b) {
  return std::tuple(a.message.log_time, a.block_offset, a.position) >
         std::tuple(b.message.log_time, b.block_offset, b.position);
}

bool McapMessageCursor::wanted(const McapMessage& message) const {
  if (message.log_time < filter_.start_time || message.log_time > filter_.end_time) return false;
  if (filter_.topics.empty()) return true;
  const std::string& topic = reader_->channels_.at(message.channel_id).topic;
  return std::find(filter_.topics.begin(), filter_.topics.end(), topic) != filter_.topics.end();
}

void McapMessageCursor::load(const McapReader::Block& block) {
  std::vector<McapMessage> messages = reader_->block_messages(block);
  for (std::size_t i = 0; i < messages.size(); ++i) {
    if (!wanted(messages[i])) continue;
    pending_.push_back({std::move(messages[i]), block.offset, i});
    std::push_heap(pending_.begin(), pending_.end(), later);
  }
}

std::optional<McapMessage> McapMessageCursor::next() {
  // A chunk that begins before the earliest waiting message may hold an earlier one.
  while (
      next_block_ < blocks_.size() &&
      (pending_.empty() || blocks_[next_block_].start_time <= pending_.front().message.log_time)) {
    load(blocks_[next_block_++]);
  }
  if (pending_.empty()) return std::nullopt;
  std::pop_heap(pending_.begin(), pending_.end(), later);
  McapMessage message = std::move(pending_.back().message);
  pending_.pop_back();
  return message;
}

}  // namespace prehend::recording
