#include "tests/system/recording.h"

#include <gtest/gtest.h>

namespace prehend::testing {

std::map<std::string, std::vector<Recorded>> read_recording(const std::string& path) {
  recording::McapReader reader(path);
  EXPECT_TRUE(reader.complete()) << path << " was not closed";
  std::map<std::string, std::vector<Recorded>> out;
  auto cursor = reader.messages();
  while (const auto message = cursor.next()) {
    const auto& channel = reader.channels().at(message->channel_id);
    out[channel.topic].push_back(
        {message->sequence, message->publish_time, std::string(message->data)});
  }
  for (const auto& problem : reader.problems()) ADD_FAILURE() << path << ": " << problem;
  return out;
}

}  // namespace prehend::testing
