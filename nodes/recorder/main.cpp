// Records topics to an MCAP file until it is stopped. See topic_recorder.h.

#include <signal.h>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <iterator>
#include <sstream>
#include <thread>

#include "nodes/recorder/topic_recorder.h"

namespace {

using prehend::graph::Node;

std::atomic<bool> stop_asked{false};

// Unlike other nodes the recorder goes on for a moment after a signal, to write what has arrived.
void take_over_signals() {
  struct sigaction action = {};
  action.sa_handler = [](int) { stop_asked = true; };
  action.sa_flags = static_cast<int>(SA_RESETHAND | SA_RESTART);
  ::sigaction(SIGINT, &action, nullptr);
  ::sigaction(SIGTERM, &action, nullptr);
}

std::vector<std::string> words_of(const std::string& text) {
  std::istringstream stream(text);
  return {std::istream_iterator<std::string>(stream), {}};
}

void record(Node& node) {
  const auto output = node.declare_parameter<std::string>(
      {.name = "output", .default_value = "recording.mcap", .description = "file to write"});
  const auto topics = node.declare_parameter<std::string>(
      {.name = "topics", .description = "topics to record, separated by spaces; empty: all"});
  const auto attachment = node.declare_parameter<std::string>(
      {.name = "attachment", .description = "files to keep in the recording, separated by spaces"});
  const auto compression =
      node.declare_parameter<std::string>({.name = "compression",
                                           .default_value = "lz4",
                                           .choices = {"none", "lz4", "zstd"},
                                           .description = "of the recording's chunks"});
  const auto duration = node.declare_parameter<double>(
      {.name = "duration",
       .default_value = 0,
       .unit = "s",
       .minimum = 0,
       .description = "wall time after which it ends; 0: when it is stopped"});

  prehend::TopicRecorder recorder(node, words_of(topics));
  prehend::graph::recording::McapWriterOptions options;
  options.compression = prehend::graph::recording::compression_named(compression);
  const auto folder = std::filesystem::path(output).parent_path();
  if (!folder.empty()) std::filesystem::create_directories(folder);
  recorder.open(output, options);
  for (const std::string& path : words_of(attachment)) recorder.attach(path);

  take_over_signals();
  node.spin_in_background();
  node.log_info("recording to {}", output);
  const auto start = std::chrono::steady_clock::now();
  const auto is_over = [&] {
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
    return stop_asked || !node.ok() || (duration > 0 && elapsed.count() >= duration);
  };
  while (!is_over()) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    recorder.keep_up();
  }
  recorder.drain();
  recorder.finish();
  node.shutdown();
}

}  // namespace

int main(int argc, char** argv) {
  return prehend::graph::run_node(argc, argv,
                                  {"recorder",
                                   "Records chosen or all topics of the graph to an MCAP file with "
                                   "protobuf schemas, until it is "
                                   "stopped, and says what it recorded and what it missed."},
                                  record);
}
