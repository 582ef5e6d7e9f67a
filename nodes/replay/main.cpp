// Publishes a recording again. See recording_player.h.

#include <chrono>
#include <iterator>
#include <sstream>
#include <thread>

#include "nodes/replay/recording_player.h"

namespace {

using prehend::graph::Node;

std::vector<std::string> words_of(const std::string& text) {
  std::istringstream stream(text);
  return {std::istream_iterator<std::string>(stream), {}};
}

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : " ") + word;
  return text;
}

void replay(Node& node) {
  const auto file =
      node.declare_parameter<std::string>({.name = "file", .description = "the recording (MCAP)"});
  prehend::RecordingPlayerOptions options;
  options.topics = words_of(node.declare_parameter<std::string>(
      {.name = "topics", .description = "topics to replay, separated by spaces; empty: all"}));
  options.rate = node.declare_parameter<double>(
      {.name = "rate",
       .default_value = 1,
       .minimum = 0,
       .description = "recorded seconds per second; 0: as fast as possible"});
  options.start = node.declare_parameter<double>(
      {.name = "start",
       .default_value = 0,
       .unit = "s",
       .minimum = 0,
       .description = "where to begin, after the recording's beginning"});
  options.publish_clock =
      node.declare_parameter<bool>({.name = "clock",
                                    .default_value = true,
                                    .description = "publish the recorded time on /clock"});
  const bool loop = node.declare_parameter<bool>(
      {.name = "loop", .default_value = false, .description = "begin again at the end"});
  const bool hold = node.declare_parameter<bool>(
      {.name = "hold",
       .default_value = false,
       .description = "stay at the end, with the last message of each topic for late subscribers"});
  const double wait = node.declare_parameter<double>(
      {.name = "wait_for_subscribers",
       .default_value = 2,
       .unit = "s",
       .minimum = 0,
       .description = "longest wait for a subscriber of each topic before it begins"});
  options.latch_all = hold;

  // First of all on the graph, so that --help opens no file.
  const auto idle = node.create_timer(3600, [] {});
  if (file.empty()) throw std::invalid_argument("give the recording: --param file:=FILE.mcap");
  prehend::RecordingPlayer player(node, file, options);
  node.spin_in_background();
  const auto lonely =
      player.wait_for_subscribers(std::chrono::nanoseconds(static_cast<std::int64_t>(wait * 1e9)));
  if (!lonely.empty() && node.ok()) node.log_info("nobody listens to {}", joined(lonely));
  while (player.play() && loop && player.published() > 0) node.log_info("beginning again");
  node.log_info("replayed {} messages of {}", player.published(), file);
  // A reader that is slow just now gets the last messages only while this node lives.
  const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds(500);
  while (!hold && node.ok() && std::chrono::steady_clock::now() < end) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  while (hold && node.ok()) std::this_thread::sleep_for(std::chrono::milliseconds(50));
}

}  // namespace

int main(int argc, char** argv) {
  return prehend::graph::run_node(
      argc, argv,
      {"replay",
       "Publishes a recording again: the same messages with the same stamps, and the recorded time "
       "on /clock. Ends when everything was published, unless told to hold or to loop. The topics "
       "/log and /diagnostics, which every node has of its own, are left out."},
      replay);
}
