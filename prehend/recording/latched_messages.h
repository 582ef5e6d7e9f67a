#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "prehend/recording/mcap_reader.h"
#include "prehend/recording/topic_filter.h"

namespace prehend::recording {

/// Metadata key of a channel whose topic was latched; its value is the number of messages that late
/// subscribers got.
inline constexpr const char* kLatchedKey = "latched";

/// How many messages of the channel late subscribers got, at most 10000; 0: it was not latched.
std::size_t latched_depth(const McapChannel& channel);

/// What a subscriber that came at `time` [ns] would have got of the wanted latched topics: of each
/// topic the last messages before it, as many as its depth, all in order of log_time. Reads the
/// chunks before `time` that have such messages; damaged ones are skipped and reported by the
/// reader.
std::vector<McapMessage> latched_before(McapReader& reader, const TopicFilter& filter,
                                        std::uint64_t time);

}  // namespace prehend::recording
