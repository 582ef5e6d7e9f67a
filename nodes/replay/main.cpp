// Publishes a recording again. See recording_player.h.

#include <malloc.h>

#include <chrono>
#include <functional>
#include <memory>
#include <stdexcept>
#include <thread>

#include "nodes/replay/recording_player.h"
#include "prehend/graph/node_program.h"
#include "prehend/recording/word_list.h"

namespace {

using prehend::graph::Node;
using prehend::recording::joined_words;
using prehend::recording::split_words;

constexpr auto kLastMessages = std::chrono::seconds(2);  // for subscribers to take them

prehend::RecordingPlayerOptions declare_options(Node& node,
                                                std::function<void(const double&)> on_rate) {
  prehend::RecordingPlayerOptions options;
  options.topics = split_words(node.declare_parameter<std::string>(
      {.name = "topics",
       .description = "topics to replay, separated by spaces, * for any text; empty: all",
       .read_only = true}));
  options.rate = node.declare_parameter<double>(
      {.name = "rate",
       .default_value = 1,
       .minimum = 0,
       .description = "recorded seconds per second; 0: as fast as the subscribers' callbacks",
       .on_change = std::move(on_rate)});
  options.start = node.declare_parameter<double>(
      {.name = "start",
       .default_value = 0,
       .unit = "s",
       .minimum = 0,
       .description = "where to begin, after the recording's beginning; what was latched before "
                      "comes first",
       .read_only = true});
  options.end = node.declare_parameter<double>(
      {.name = "end",
       .default_value = 0,
       .unit = "s",
       .minimum = 0,
       .description = "where to end, after the recording's beginning; 0: at its end",
       .read_only = true});
  options.paused =
      node.declare_parameter<bool>({.name = "paused",
                                    .default_value = false,
                                    .description = "begin with the clock paused, see prehend clock",
                                    .read_only = true});
  options.publish_clock =
      node.declare_parameter<bool>({.name = "clock",
                                    .default_value = true,
                                    .description = "publish the recorded time on /clock",
                                    .read_only = true});
  return options;
}

// What waited for a slow reader is free by now, but the warm heap (graph/warm_heap.h) keeps it.
void give_memory_back() {
  constexpr std::size_t kWorthIt = std::size_t{64} << 20;
  if (::mallinfo2().fordblks > kWorthIt) ::malloc_trim(kWorthIt / 2);
}

void sleep_while(Node& node, bool condition) {
  while (condition && node.ok()) std::this_thread::sleep_for(std::chrono::milliseconds(50));
}

void replay(Node& node) {
  const auto file = node.declare_parameter<std::string>({.name = "file",
                                                         .description = "the recording (MCAP)",
                                                         .read_only = true,
                                                         .reads_file = true});
  const auto pacer = std::make_shared<prehend::graph::ClockPacer>();
  prehend::RecordingPlayerOptions options =
      declare_options(node, [pacer](const double& rate) { pacer->set_speed(rate); });
  const bool loop = node.declare_parameter<bool>({.name = "loop",
                                                  .default_value = false,
                                                  .description = "begin again at the end",
                                                  .read_only = true});
  const bool hold = node.declare_parameter<bool>(
      {.name = "hold",
       .default_value = false,
       .description = "stay at the end, with the last message of each topic for late subscribers",
       .read_only = true});
  const double wait = node.declare_parameter<double>(
      {.name = "wait_for_subscribers",
       .default_value = 2,
       .unit = "s",
       .minimum = 0,
       .description = "longest wait for a subscriber of each topic before it begins",
       .read_only = true});
  options.latch_all = hold;

  // First of all on the graph, so that --help opens no file.
  const auto idle = node.create_timer(3600, [] {});
  if (file.empty()) throw std::invalid_argument("give the recording: --param file:=FILE.mcap");
  prehend::RecordingPlayer player(node, file, options, pacer);
  node.spin_in_background();
  const auto lonely =
      player.wait_for_subscribers(std::chrono::nanoseconds(static_cast<std::int64_t>(wait * 1e9)));
  if (!lonely.empty() && node.ok()) node.log_info("nobody listens to {}", joined_words(lonely));
  while (player.play() && loop && player.published() > 0) {
    node.log_info("beginning again");
    give_memory_back();
  }
  // Messages on their way get to their readers only while this node lives.
  if (node.ok() && !node.wait_until_delivered(kLastMessages) && node.ok()) {
    node.log_warning("subscribers have not taken the last messages within 2 s");
  }
  node.log_info("replayed {} messages of {}", player.published(), file);
  sleep_while(node, hold);
  node.shutdown();
}

const prehend::graph::RegisteredNodeProgram registered(
    {"replay",
     "Publishes a recording again: the same messages with the same stamps, and the recorded time "
     "on /clock, which the service /clock/control pauses, steps and speeds up. Ends when "
     "everything was published, unless told to hold or to loop. The topics /log, /diagnostics and "
     "/statistics, which every node has of its own, and /emergency_stop are left out."},
    replay);

}  // namespace
