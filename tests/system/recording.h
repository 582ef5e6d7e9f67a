#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "prehend/recording/mcap_reader.h"

namespace prehend::testing {

/// A recorded message's bytes and stamp [ns].
struct Recorded {
  std::uint32_t sequence = 0;
  std::uint64_t stamp = 0;
  std::string bytes;
};

/// All messages of a recording by topic, in order. Fails the running test when the file is damaged.
std::map<std::string, std::vector<Recorded>> read_recording(const std::string& path);

/// Decodes all messages of one topic. Missing topic: empty.
template <class Message>
std::vector<Message> decode_all(const std::map<std::string, std::vector<Recorded>>& recording,
                                const std::string& topic) {
  std::vector<Message> out;
  const auto it = recording.find(topic);
  if (it == recording.end()) return out;
  for (const auto& recorded : it->second) {
    if (!out.emplace_back().ParseFromString(recorded.bytes)) out.pop_back();
  }
  return out;
}

}  // namespace prehend::testing
