#include <algorithm>
#include <cinttypes>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "prehend/recording/latched_messages.h"
#include "prehend/recording/mcap_reader.h"
#include "prehend/recording/recording_file.h"
#include "prehend/recording/topic_filter.h"
#include "prehend/text/nearest_match.h"
#include "prehend/text/quantities.h"
#include "tools/bag_tools.h"
#include "tools/recording_copy.h"

namespace prehend::tools {
namespace {

namespace fs = std::filesystem;
namespace recording = prehend::recording;

std::vector<std::string> topics_of(const recording::McapReader& reader) {
  std::vector<std::string> topics;
  for (const auto& [id, channel] : reader.channels()) topics.push_back(channel.topic);
  return topics;
}

recording::McapMessageFilter time_range(const BagFilter& filter,
                                        const recording::McapReader& reader) {
  recording::McapMessageFilter range;
  const std::uint64_t begin = reader.statistics().message_start_time;
  const auto after = [&](const std::string& text) {
    return begin + static_cast<std::uint64_t>(text::parse_duration(text));
  };
  if (!filter.start.empty()) range.start_time = after(filter.start);
  if (!filter.end.empty()) range.end_time = after(filter.end);
  if (range.end_time < range.start_time) {
    throw std::invalid_argument("--end must be later than --start");
  }
  return range;
}

}  // namespace

int bag_recover(const std::string& from, const std::string& to) {
  const std::string partial = recording::partial_path(from);
  const bool is_left = fs::exists(partial);
  const std::string file = is_left && !fs::exists(from) ? partial : from;
  if (file == partial) {
    std::printf("%s does not exist: recovering %s, which its recorder left\n", from.c_str(),
                partial.c_str());
  } else if (is_left) {
    std::printf(
        "there is %s, too, of a recorder that was killed or still runs; recover it by that "
        "name\n",
        partial.c_str());
  }
  recording::McapReader reader(file);
  RecordingCopy copy(reader, to, {});
  copy.declare({});
  copy.copy_attachments();
  copy.copy_messages({});
  std::printf("%s: %" PRIu64 " messages recovered\n", to.c_str(), copy.finish());
  return 0;
}

int bag_filter(const BagFilter& filter) {
  recording::McapReader reader(filter.from);
  const recording::TopicFilter topics{filter.topics, filter.without};
  const auto recorded = topics_of(reader);
  if (const auto pattern = topics.unmatched(recorded)) {
    throw std::invalid_argument(filter.from + " has no topic " + *pattern +
                                text::nearest_match_hint(*pattern, recorded));
  }
  auto range = time_range(filter, reader);
  for (const std::string& topic : recorded) {
    if (topics.wants(topic)) range.topics.push_back(topic);
  }
  if (range.topics.empty()) throw std::invalid_argument("no topic is left over");
  recording::McapWriterOptions options;
  options.compression = recording::compression_named(filter.compression);
  RecordingCopy copy(reader, filter.to, options);
  copy.declare(topics);
  copy.copy_attachments();
  copy.writer().add_metadata({"prehend.filter", {{"from", filter.from}}});
  if (range.start_time > 0) {
    for (const auto& message : recording::latched_before(reader, topics, range.start_time)) {
      copy.write(message, range.start_time);
    }
  }
  copy.copy_messages(range);
  std::printf("%s: %" PRIu64 " of %" PRIu64 " messages\n", filter.to.c_str(), copy.finish(),
              reader.statistics().message_count);
  return 0;
}

int bag_attachments(const std::string& path, const std::string& folder, const std::string& name) {
  const recording::McapReader reader(path);
  std::vector<std::string> names;
  for (const auto& index : reader.attachments()) names.push_back(index.name);
  if (!name.empty() && std::find(names.begin(), names.end(), name) == names.end()) {
    throw std::invalid_argument(path + " has no attachment " + name +
                                text::nearest_match_hint(name, names));
  }
  for (const auto& index : reader.attachments()) {
    if (!name.empty() && index.name != name) continue;
    if (folder.empty()) {
      std::printf("%s  %s  %" PRIu64 " bytes\n", index.name.c_str(), index.media_type.c_str(),
                  index.data_size);
      continue;
    }
    // Only the last part of the name: a recording must not write outside of the folder.
    const fs::path file = fs::path(index.name).filename();
    if (file.empty() || file == "." || file == "..") {
      throw std::runtime_error("the attachment '" + index.name + "' has no usable file name");
    }
    const fs::path target = fs::path(folder) / file;
    if (fs::exists(target)) throw std::runtime_error(target.string() + " exists");
    fs::create_directories(folder);
    const auto attachment = reader.read_attachment(index);
    std::ofstream out(target, std::ios::binary);
    out << attachment.data;
    out.close();
    if (!out) throw std::runtime_error("cannot write " + target.string());
    std::printf("%s\n", target.c_str());
  }
  return 0;
}

}  // namespace prehend::tools
