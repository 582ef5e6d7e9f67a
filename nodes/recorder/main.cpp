// Records topics to an MCAP file until it is stopped. See topic_recorder.h.

#include <signal.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <stdexcept>
#include <thread>
#include <utility>

#include "msgs/views/views.h"
#include "nodes/platform_source/platform_source.h"
#include "nodes/recorder/run_facts.h"
#include "nodes/recorder/topic_recorder.h"
#include "prehend/graph/node_program.h"
#include "prehend/graph/stop_signals.h"
#include "prehend/recording/word_list.h"
#include "prehend/robot/robot_files.h"

namespace {

using prehend::graph::Node;
using prehend::recording::split_words;

// What is on its way may take 10 s to come (TopicRecorder::drain), and a full queue some to write.
constexpr double kStopTime = 30;  // s

struct Settings {
  std::string output;
  std::vector<std::string> topics, attachments;
  prehend::recording::McapWriterOptions writer;
  prehend::recording::SplitOptions split;
  double duration = 0;
  std::optional<std::vector<prehend::views::View>> views;
};

// What is recorded, as viewers draw it; nothing without `foxglove`.
std::optional<std::vector<prehend::views::View>> declare_views(Node& node) {
  namespace views = prehend::views;
  const bool shown = node.declare_parameter<bool>(
      {.name = "foxglove",
       .description = "also as types that Foxglove and Lichtblick draw, on /viewer/...",
       .read_only = true});
  const std::string platforms = prehend::nodes::declare_platforms(node);
  const auto platform = node.declare_parameter<std::string>(
      {.name = "platform",
       .description = "with `foxglove`: robot that is drawn, of `platforms` without .yaml, or a "
                      "file; empty: none",
       .read_only = true});
  const bool images = node.declare_parameter<bool>(
      {.name = "foxglove_images",
       .default_value = true,
       .description = "with `foxglove`: pictures of cameras once more, too, as they are",
       .read_only = true});
  if (!shown) {
    if (platform.empty() && images) return std::nullopt;
    throw std::invalid_argument("platform and foxglove_images go with foxglove:=true only");
  }
  std::shared_ptr<const prehend::robot::Platform> robot;
  if (!platform.empty()) {
    robot = std::make_shared<const prehend::robot::Platform>(
        prehend::robot::read_platform(prehend::robot::platform_file(platforms, platform)));
  }
  return views::standard_views(std::move(robot), {.shown = images, .compress = {}});
}

Settings declare_settings(Node& node) {
  Settings s;
  s.output = node.declare_parameter<std::string>(
      {.name = "output",
       .default_value = "recording.mcap",
       .description = "file to write: FILE.partial until it is whole; the one before is kept as "
                      "FILE.1",
       .read_only = true});
  s.topics = split_words(node.declare_parameter<std::string>(
      {.name = "topics",
       .description = "topics to record, separated by spaces, * for any text; empty: all",
       .read_only = true}));
  s.attachments = split_words(node.declare_parameter<std::string>(
      {.name = "attachment",
       .description = "files to keep in the recording, separated by spaces, in double quotes where "
                      "they have some; the launch file of the graph always is",
       .read_only = true}));
  s.writer.compression = prehend::recording::compression_named(
      node.declare_parameter<std::string>({.name = "compression",
                                           .default_value = "lz4",
                                           .choices = {"none", "lz4", "zstd"},
                                           .description = "of the recording's chunks",
                                           .read_only = true}));
  s.duration = node.declare_parameter<double>(
      {.name = "duration",
       .default_value = 0,
       .unit = "s",
       .minimum = 0,
       .description = "wall time after which it ends; 0: when it is stopped",
       .read_only = true});
  s.split.size = static_cast<std::uint64_t>(node.declare_parameter<std::int64_t>(
      {.name = "split_size",
       .default_value = 0,
       .unit = "B",
       .minimum = 0,
       .description = "size at which it goes on in another file, OUTPUT_0001.mcap; 0: never",
       .read_only = true}));
  s.split.duration = static_cast<std::uint64_t>(
      1e9 * node.declare_parameter<double>(
                {.name = "split_duration",
                 .default_value = 0,
                 .unit = "s",
                 .minimum = 0,
                 .maximum = 1e9,
                 .description = "recorded time after which it goes on in another file; 0: never",
                 .read_only = true}));
  s.views = declare_views(node);
  return s;
}

std::vector<prehend::recording::McapAttachment> read_attachments(std::vector<std::string> paths) {
  const char* launch_file = std::getenv("PREHEND_LAUNCH_FILE");
  if (launch_file != nullptr && *launch_file != '\0') paths.emplace_back(launch_file);
  std::vector<prehend::recording::McapAttachment> attachments;
  std::set<std::filesystem::path> attached;
  for (const std::string& path : paths) {
    if (!attached.insert(std::filesystem::weakly_canonical(path)).second) continue;
    attachments.push_back(prehend::attachment_of(path));
  }
  return attachments;
}

void record(Node& node) {
  Settings settings = declare_settings(node);
  ::signal(SIGXFSZ, SIG_IGN);  // a file at the process' size limit is an error to be told, no death
  prehend::TopicRecorder recorder(node, settings.topics);
  auto attachments = read_attachments(settings.attachments);  // all that can fail, before the file
  const auto folder = std::filesystem::path(settings.output).parent_path();
  if (!folder.empty()) std::filesystem::create_directories(folder);
  recorder.open(settings.output, settings.writer, settings.split);
  if (settings.views) recorder.show(std::move(*settings.views));
  recorder.add(prehend::run_facts());
  for (auto& attachment : attachments) recorder.add(std::move(attachment));

  node.spin_in_background();
  node.log_info("recording to {}", settings.output);
  const auto start = std::chrono::steady_clock::now();
  const auto is_over = [&] {
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
    return prehend::graph::stop_requested() || !node.ok() ||
           (settings.duration > 0 && elapsed.count() >= settings.duration);
  };
  bool writes = true;
  while (!is_over() && writes) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    writes = recorder.keep_up();
  }
  if (writes) {
    node.log_info("stopping: writing what is on its way");
    recorder.drain();
  }
  recorder.finish();
  node.shutdown();
}

// It stops itself: after a signal it goes on for a moment, to write what has arrived.
const prehend::graph::RegisteredNodeProgram registered(
    {"recorder",
     "Records chosen or all topics of the graph to an MCAP file with protobuf schemas, until it is "
     "stopped, and says what it recorded and what it missed. A full disk ends it with an error; "
     "what it wrote before can be read.",
     kStopTime},
    record, true);

}  // namespace
