#include <cinttypes>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <map>
#include <memory>

#include "prehend/graph/recording/mcap_reader.h"
#include "prehend/graph/recording/mcap_writer.h"
#include "tools/commands.h"
#include "tools/table.h"

namespace prehend::tools {
namespace {

namespace recording = prehend::graph::recording;

std::string megabytes(std::uint64_t bytes) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2f MB", static_cast<double>(bytes) * 1e-6);
  return text;
}

// Seconds, and the date when the time is one of the Unix epoch.
std::string time_text(std::uint64_t nanoseconds) {
  char text[64];
  std::snprintf(text, sizeof text, "%.3f s", static_cast<double>(nanoseconds) * 1e-9);
  std::string result = text;
  const auto seconds = static_cast<std::time_t>(nanoseconds / 1000000000u);
  std::tm utc{};
  if (seconds > 1000000000 && ::gmtime_r(&seconds, &utc) != nullptr) {
    std::strftime(text, sizeof text, " (%Y-%m-%d %H:%M:%S UTC)", &utc);
    result += text;
  }
  return result;
}

void print_channels(const recording::McapReader& reader) {
  std::vector<std::vector<std::string>> rows{{"TOPIC", "TYPE", "MESSAGES", "LATCHED"}};
  const auto& counts = reader.statistics().channel_message_counts;
  for (const auto& [id, channel] : reader.channels()) {
    const auto* schema = reader.schema_of(channel);
    const auto count = counts.find(id);
    rows.push_back({channel.topic, schema ? schema->name : channel.message_encoding,
                    std::to_string(count == counts.end() ? 0 : count->second),
                    channel.metadata.count("latched") > 0 ? "yes" : ""});
  }
  print_table(rows);
}

int print_info(const std::string& path) {
  const recording::McapReader reader(path);
  const auto& statistics = reader.statistics();
  std::map<std::string, int> compressions;
  std::uint64_t stored = 0, unpacked = 0;
  for (const auto& chunk : reader.chunks()) {
    ++compressions[chunk.compression.empty() ? "none" : chunk.compression];
    stored += chunk.compressed_size;
    unpacked += chunk.uncompressed_size;
  }
  std::printf("file:      %s, %s, written by %s%s\n", path.c_str(),
              megabytes(reader.file_size()).c_str(), reader.library().c_str(),
              reader.complete() ? "" : ", NOT CLOSED PROPERLY (prehend bag recover mends it)");
  std::printf("messages:  %" PRIu64 "\n", statistics.message_count);
  std::printf(
      "time:      %s .. %s, %.3f s\n", time_text(statistics.message_start_time).c_str(),
      time_text(statistics.message_end_time).c_str(),
      static_cast<double>(statistics.message_end_time - statistics.message_start_time) * 1e-9);
  std::printf("chunks:    %u", statistics.chunk_count);
  if (unpacked > 0) {
    for (const auto& [name, count] : compressions) std::printf(", %d %s", count, name.c_str());
    std::printf("; %s from %s", megabytes(stored).c_str(), megabytes(unpacked).c_str());
  }
  std::printf("\n");
  for (const auto& attachment : reader.attachments()) {
    std::printf("attached:  %s (%s, %" PRIu64 " bytes)\n", attachment.name.c_str(),
                attachment.media_type.c_str(), attachment.data_size);
  }
  for (const auto& item : reader.metadata()) {
    for (const auto& [key, value] : item.entries) {
      std::printf("metadata:  %s.%s = %s\n", item.name.c_str(), key.c_str(), value.c_str());
    }
  }
  for (const auto& problem : reader.problems()) std::printf("problem:   %s\n", problem.c_str());
  std::printf("\n");
  print_channels(reader);
  return 0;
}

int recover(const std::string& from, const std::string& to) {
  if (std::filesystem::exists(to)) throw std::runtime_error(to + " exists; give a new file");
  recording::McapReader reader(from);
  recording::McapWriter writer(to);
  std::map<std::uint16_t, std::uint16_t> channels;
  for (const auto& [id, channel] : reader.channels()) {
    const auto* schema = reader.schema_of(channel);
    const auto schema_id =
        schema ? writer.add_schema(schema->name, schema->encoding, schema->data) : 0;
    channels[id] = writer.add_channel(channel.topic, channel.message_encoding,
                                      static_cast<std::uint16_t>(schema_id), channel.metadata);
  }
  for (const auto& index : reader.attachments()) {
    try {
      writer.add_attachment(reader.read_attachment(index));
    } catch (const recording::McapError& error) {
      std::printf("problem: %s\n", error.what());
    }
  }
  for (const auto& item : reader.metadata()) writer.add_metadata(item);
  auto cursor = reader.messages();
  while (const auto message = cursor.next()) {
    writer.write(channels.at(message->channel_id), message->sequence, message->log_time,
                 message->publish_time, message->data);
  }
  writer.close();
  for (const auto& problem : reader.problems()) std::printf("problem: %s\n", problem.c_str());
  std::printf("%s: %" PRIu64 " messages recovered\n", to.c_str(),
              writer.statistics().message_count);
  return 0;
}

}  // namespace

void add_bag_commands(CLI::App& app, Outcome& outcome) {
  CLI::App* group = app.add_subcommand("bag", "Look at and mend recordings");
  group->require_subcommand(1);
  auto from = std::make_shared<std::string>();
  auto to = std::make_shared<std::string>();
  CLI::App* info = group->add_subcommand("info", "Say what a recording holds");
  info->add_option("file", *from, "The recording (MCAP)")->required();
  info->footer("Example:\n  prehend bag info run.mcap");
  info->callback([from, &outcome] { outcome.exit_code = print_info(*from); });
  CLI::App* mend = group->add_subcommand(
      "recover", "Copy what can be read of a damaged or unfinished recording to a new one");
  mend->add_option("file", *from, "The damaged recording")->required();
  mend->add_option("output", *to, "The new file")->required();
  mend->footer("Example:\n  prehend bag recover killed.mcap mended.mcap");
  mend->callback([from, to, &outcome] { outcome.exit_code = recover(*from, *to); });
}

}  // namespace prehend::tools
