#include <google/protobuf/struct.pb.h>
#include <google/protobuf/util/json_util.h>

#include <cinttypes>
#include <cstdio>
#include <ctime>
#include <map>

#include "prehend/recording/latched_messages.h"
#include "prehend/recording/mcap_reader.h"
#include "prehend/recording/recording_check.h"
#include "tools/bag_tools.h"
#include "tools/table.h"

namespace prehend::tools {
namespace {

namespace recording = prehend::recording;
using google::protobuf::Struct;
using google::protobuf::Value;

std::string megabytes(std::uint64_t bytes) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2f MB", static_cast<double>(bytes) * 1e-6);
  return text;
}

double seconds(std::uint64_t nanoseconds) { return static_cast<double>(nanoseconds) * 1e-9; }

// Seconds, and the date when the time is one of the Unix epoch.
std::string time_text(std::uint64_t nanoseconds) {
  char text[64];
  std::snprintf(text, sizeof text, "%.3f s", seconds(nanoseconds));
  std::string result = text;
  const auto time = static_cast<std::time_t>(nanoseconds / 1000000000u);
  std::tm utc{};
  if (time > 1000000000 && ::gmtime_r(&time, &utc) != nullptr) {
    std::strftime(text, sizeof text, " (%Y-%m-%d %H:%M:%S UTC)", &utc);
    result += text;
  }
  return result;
}

struct ChannelInfo {
  std::string topic, type;
  std::uint64_t messages = 0;
  double rate = 0;  // messages a second over the whole recording
  std::size_t latched = 0;
};

std::vector<ChannelInfo> channels_of(const recording::McapReader& reader) {
  std::vector<ChannelInfo> infos;
  const auto& statistics = reader.statistics();
  const double length = seconds(statistics.message_end_time - statistics.message_start_time);
  for (const auto& [id, channel] : reader.channels()) {
    const auto* schema = reader.schema_of(channel);
    const auto count = statistics.channel_message_counts.find(id);
    ChannelInfo info{channel.topic, schema ? schema->name : channel.message_encoding, 0, 0,
                     recording::latched_depth(channel)};
    if (count != statistics.channel_message_counts.end()) info.messages = count->second;
    if (length > 0) info.rate = static_cast<double>(info.messages) / length;
    infos.push_back(info);
  }
  return infos;
}

struct ChunkSums {
  std::map<std::string, int> compressions;
  std::uint64_t stored = 0, unpacked = 0;
};

ChunkSums chunks_of(const recording::McapReader& reader) {
  ChunkSums sums;
  for (const auto& chunk : reader.chunks()) {
    ++sums.compressions[chunk.compression.empty() ? "none" : chunk.compression];
    sums.stored += chunk.compressed_size;
    sums.unpacked += chunk.uncompressed_size;
  }
  return sums;
}

void print_channels(const recording::McapReader& reader) {
  std::vector<std::vector<std::string>> rows{{"TOPIC", "TYPE", "MESSAGES", "RATE", "LATCHED"}};
  for (const ChannelInfo& info : channels_of(reader)) {
    char rate[32];
    std::snprintf(rate, sizeof rate, "%.1f Hz", info.rate);
    rows.push_back({info.topic, info.type, std::to_string(info.messages), rate,
                    info.latched > 0 ? "yes" : ""});
  }
  print_table(rows);
}

void print_chunks(const recording::McapReader& reader) {
  const ChunkSums sums = chunks_of(reader);
  std::printf("chunks:    %u", reader.statistics().chunk_count);
  if (sums.unpacked > 0) {
    for (const auto& [name, count] : sums.compressions) std::printf(", %d %s", count, name.c_str());
    std::printf("; %s from %s", megabytes(sums.stored).c_str(), megabytes(sums.unpacked).c_str());
  }
  std::printf("\n");
}

void print_text(const recording::McapReader& reader) {
  const auto& statistics = reader.statistics();
  std::printf("file:      %s, %s, written by %s%s\n", reader.path().c_str(),
              megabytes(reader.file_size()).c_str(), reader.library().c_str(),
              reader.complete() ? "" : ", NOT CLOSED PROPERLY (prehend bag recover mends it)");
  std::printf("messages:  %" PRIu64 "\n", statistics.message_count);
  std::printf("time:      %s .. %s, %.3f s\n", time_text(statistics.message_start_time).c_str(),
              time_text(statistics.message_end_time).c_str(),
              seconds(statistics.message_end_time - statistics.message_start_time));
  print_chunks(reader);
  for (const auto& attachment : reader.attachments()) {
    std::printf("attached:  %s (%s, %" PRIu64 " bytes)\n", attachment.name.c_str(),
                attachment.media_type.c_str(), attachment.data_size);
  }
  for (const auto& item : reader.metadata()) {
    for (const auto& [key, value] : item.entries) {
      std::printf("metadata:  %s %s = %s\n", item.name.c_str(), key.c_str(), value.c_str());
    }
  }
  for (const auto& problem : reader.problems()) std::printf("problem:   %s\n", problem.c_str());
  std::printf("\n");
  print_channels(reader);
}

// --- JSON ---------------------------------------------------------------------------------------

Value text_value(const std::string& text) {
  Value value;
  value.set_string_value(text);
  return value;
}

Value number_value(double number) {
  Value value;
  value.set_number_value(number);
  return value;
}

void set(Struct& object, const std::string& key, const std::string& text) {
  (*object.mutable_fields())[key] = text_value(text);
}
void set(Struct& object, const std::string& key, double number) {
  (*object.mutable_fields())[key] = number_value(number);
}
void set(Struct& object, const std::string& key, bool flag) {
  (*object.mutable_fields())[key].set_bool_value(flag);
}
void set(Struct& object, const std::string& key, const std::vector<std::string>& texts) {
  auto& list = *(*object.mutable_fields())[key].mutable_list_value();
  for (const std::string& text : texts) *list.add_values() = text_value(text);
}

void print(const Struct& object) {
  google::protobuf::util::JsonPrintOptions options;
  options.add_whitespace = true;
  std::string text;
  const auto status = google::protobuf::util::MessageToJsonString(object, &text, options);
  if (!status.ok()) throw std::runtime_error("cannot write JSON: " + status.ToString());
  std::printf("%s\n", text.c_str());
}

void print_json(const recording::McapReader& reader) {
  const auto& statistics = reader.statistics();
  Struct info;
  set(info, "file", reader.path());
  set(info, "bytes", static_cast<double>(reader.file_size()));
  set(info, "library", reader.library());
  set(info, "complete", reader.complete());
  set(info, "messages", static_cast<double>(statistics.message_count));
  set(info, "chunks", static_cast<double>(statistics.chunk_count));
  // Nanoseconds do not fit into a double: text, as protobuf's JSON has it for int64.
  set(info, "start_time", std::to_string(statistics.message_start_time));
  set(info, "end_time", std::to_string(statistics.message_end_time));
  set(info, "problems", reader.problems());
  auto& fields = *info.mutable_fields();
  auto& topics = *fields["topics"].mutable_list_value();
  for (const ChannelInfo& channel : channels_of(reader)) {
    Struct& topic = *topics.add_values()->mutable_struct_value();
    set(topic, "topic", channel.topic);
    set(topic, "type", channel.type);
    set(topic, "messages", static_cast<double>(channel.messages));
    set(topic, "rate", channel.rate);
    set(topic, "latched", static_cast<double>(channel.latched));
  }
  auto& attachments = *fields["attachments"].mutable_list_value();
  for (const auto& item : reader.attachments()) {
    Struct& attachment = *attachments.add_values()->mutable_struct_value();
    set(attachment, "name", item.name);
    set(attachment, "media_type", item.media_type);
    set(attachment, "bytes", static_cast<double>(item.data_size));
  }
  Struct& metadata = *fields["metadata"].mutable_struct_value();
  for (const auto& item : reader.metadata()) {
    Struct& entries = *(*metadata.mutable_fields())[item.name].mutable_struct_value();
    for (const auto& [key, value] : item.entries) set(entries, key, value);
  }
  print(info);
}

}  // namespace

int bag_info(const std::string& path, bool json) {
  const recording::McapReader reader(path);
  json ? print_json(reader) : print_text(reader);
  return 0;
}

int bag_check(const std::string& path, bool json) {
  const recording::RecordingCheck check = recording::check_recording(path);
  if (json) {
    Struct result;
    set(result, "file", path);
    set(result, "messages", static_cast<double>(check.messages));
    set(result, "chunks", static_cast<double>(check.chunks));
    set(result, "attachments", static_cast<double>(check.attachments));
    set(result, "problems", check.problems);
    set(result, "further_problems", static_cast<double>(check.further_problems));
    set(result, "notes", check.notes);
    print(result);
    return check.problems.empty() ? 0 : 1;
  }
  for (const std::string& problem : check.problems) std::printf("problem: %s\n", problem.c_str());
  if (check.further_problems > 0) {
    std::printf("and %" PRIu64 " more problems\n", check.further_problems);
  }
  for (const std::string& note : check.notes) std::printf("note: %s\n", note.c_str());
  const char* verdict = !check.problems.empty() ? "NOT SOUND"
                        : check.notes.empty()   ? "all is well"
                                                : "nothing wrong where there are checksums";
  std::printf("%s: %" PRIu64 " messages, %" PRIu64 " chunks, %" PRIu64 " attachments: %s\n",
              path.c_str(), check.messages, check.chunks, check.attachments, verdict);
  return check.problems.empty() ? 0 : 1;
}

}  // namespace prehend::tools
