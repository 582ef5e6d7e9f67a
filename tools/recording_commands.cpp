#include <signal.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <memory>
#include <stdexcept>
#include <system_error>

#include "prehend/graph/introspection.h"
#include "prehend/graph/security.h"
#include "prehend/recording/word_list.h"
#include "prehend/text/command_line.h"
#include "prehend/text/quantities.h"
#include "tools/commands.h"
#include "tools/programs.h"

namespace prehend::tools {
namespace {

using recording::joined_words;

constexpr std::chrono::milliseconds kQuestionTime{500};

struct RecordChoices {
  std::string registry, output, compression = "lz4", clock = "wall";
  std::vector<std::string> topics, attachments;
  std::string split_size, split_duration, platform;
  bool all = false, foxglove = false, no_images = false;
  double duration = 0;
};

struct ReplayChoices {
  std::string registry, file;
  std::vector<std::string> topics, remaps;
  double rate = 1, start = 0, end = 0, wait = 2;
  bool loop = false, hold = false, no_clock = false, paused = false;
};

std::string default_output() {
  const std::time_t now = std::time(nullptr);
  std::tm local{};
  ::localtime_r(&now, &local);
  std::array<char, 64> name{};
  std::strftime(name.data(), name.size(), "recording-%Y%m%d-%H%M%S.mcap", &local);
  return name.data();
}

// The command line of a node that several people may start at a time.
std::vector<std::string> node_arguments(const std::string& name, const std::string& registry) {
  std::vector<std::string> words{"--name", name + "_" + std::to_string(::getpid())};
  if (!registry.empty()) words.insert(words.end(), {"--registry", registry});
  return words;
}

void add_parameter(std::vector<std::string>& words, const std::string& name,
                   const std::string& value) {
  words.insert(words.end(), {"--param", name + ":=" + value});
}

// Comes back exactly.
std::string number_text(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.17g", value);
  return text.data();
}

void record(const RecordChoices& choices) {
  if (choices.all && !choices.topics.empty()) {
    throw std::invalid_argument("give either --all or topics, not both");
  }
  auto words = node_arguments("recorder", choices.registry);
  words.insert(words.end(), {"--clock", choices.clock});
  add_parameter(words, "output", choices.output.empty() ? default_output() : choices.output);
  add_parameter(words, "topics", joined_words(choices.topics));
  add_parameter(words, "attachment", joined_words(choices.attachments));
  add_parameter(words, "compression", choices.compression);
  add_parameter(words, "duration", number_text(choices.duration));
  if (!choices.split_size.empty()) {
    add_parameter(words, "split_size", std::to_string(text::parse_bytes(choices.split_size)));
  }
  if (!choices.split_duration.empty()) {
    const auto nanoseconds = static_cast<double>(text::parse_duration(choices.split_duration));
    add_parameter(words, "split_duration", number_text(nanoseconds * 1e-9));
  }
  if (choices.foxglove) {
    add_parameter(words, "foxglove", "true");
    add_parameter(words, "platform", choices.platform);
    add_parameter(words, "foxglove_images", choices.no_images ? "false" : "true");
  }
  become_program("recorder", words);
}

// Where a registry of this host should answer and none does; "" else.
std::string missing_registry(const std::string& registry) {
  graph::Introspection introspection(registry, kQuestionTime);
  try {
    introspection.nodes();
    return "";
  } catch (const graph::KeyError&) {
    throw;
  } catch (const std::runtime_error&) {
    const std::string& endpoint = introspection.registry();
    return graph::is_local_endpoint(endpoint) ? endpoint : "";
  }
}

// A replay can be looked at without anything else: where no registry answers, one is started that
// ends with the replay, which this process becomes.
void ensure_registry(const std::string& registry) {
  const std::string endpoint = missing_registry(registry);
  if (endpoint.empty()) return;
  std::fprintf(stderr, "no graph is running; starting a registry at %s for this replay\n",
               endpoint.c_str());
  const pid_t replay = ::getpid(), child = ::fork();
  if (child < 0) throw std::system_error(errno, std::generic_category(), "fork");
  if (child > 0) return;
  ::prctl(PR_SET_PDEATHSIG, SIGTERM);
  ::setpgid(0, 0);  // Ctrl-C is for the replay, which needs the registry to its end
  if (::getppid() != replay) ::_exit(0);
  try {
    become_program("registry", {"--registry", endpoint});
  } catch (const std::exception& error) {
    std::fprintf(stderr, "prehend: %s\n", error.what());
  }
  ::_exit(1);
}

void replay(const ReplayChoices& choices) {
  ensure_registry(choices.registry);
  auto words = node_arguments("replay", choices.registry);
  add_parameter(words, "file", choices.file);
  for (const std::string& remap : choices.remaps) words.insert(words.end(), {"--remap", remap});
  add_parameter(words, "topics", joined_words(choices.topics));
  add_parameter(words, "rate", number_text(choices.rate));
  add_parameter(words, "start", number_text(choices.start));
  add_parameter(words, "end", number_text(choices.end));
  add_parameter(words, "paused", choices.paused ? "true" : "false");
  add_parameter(words, "wait_for_subscribers", number_text(choices.wait));
  add_parameter(words, "loop", choices.loop ? "true" : "false");
  add_parameter(words, "hold", choices.hold ? "true" : "false");
  add_parameter(words, "clock", choices.no_clock ? "false" : "true");
  become_program("replay", words);
}

void add_record(CLI::App& app) {
  auto choices = std::make_shared<RecordChoices>();
  CLI::App* command = app.add_subcommand(
      "record", "Record topics to an MCAP file until Ctrl-C; nothing that arrived is lost");
  command->add_option("topics", choices->topics,
                      "Topics to record, * for any text; default: all, also new ones");
  command->add_flag("-a,--all", choices->all, "All topics, which is the default");
  command->add_option("-o,--output", choices->output, "File; default: recording-DATE-TIME.mcap");
  command->add_option("-d,--duration", choices->duration, "Seconds after which it ends; 0: never")
      ->check(text::above_zero(true));
  command
      ->add_option("--attach", choices->attachments,
                   "A file to keep in the recording; may be repeated")
      ->allow_extra_args(false);
  command->add_option("--split-size", choices->split_size,
                      "Go on in another file at this size, e.g. 1GB: NAME_0000.mcap, ...");
  command->add_option("--split-duration", choices->split_duration,
                      "Go on in another file after this recorded time, e.g. 60s");
  command->add_option("--compression", choices->compression, "none, lz4 or zstd")
      ->check(CLI::IsMember({"none", "lz4", "zstd"}))
      ->capture_default_str();
  command->add_option("--clock", choices->clock, "Time of the recording: wall or simulated")
      ->check(CLI::IsMember({"wall", "simulated"}))
      ->capture_default_str();
  CLI::Option* foxglove =
      command->add_flag("--foxglove", choices->foxglove,
                        "Also as types that Foxglove and Lichtblick draw, on /viewer/...");
  command
      ->add_option("--platform", choices->platform,
                   "The robot that is drawn, of config/robots without .yaml, or a file")
      ->needs(foxglove);
  command->add_flag("--no-images", choices->no_images, "Pictures are not recorded a second time")
      ->needs(foxglove);
  add_registry_option(*command, choices->registry);
  command->footer(
      "Examples:\n"
      "  prehend record -o run.mcap\n"
      "  prehend record -o run.mcap --foxglove --platform kr5_sdh\n"
      "  prehend record /camera/stereo /camera/info --duration 10\n"
      "  prehend record --attach calibration.yaml --compression zstd\n"
      "  prehend record -o long.mcap --split-size 1GB");
  command->callback([choices] { record(*choices); });
}

void add_replay(CLI::App& app) {
  auto choices = std::make_shared<ReplayChoices>();
  CLI::App* command = app.add_subcommand(
      "replay", "Publish a recording again, with its stamps and its time on /clock");
  command->add_option("file", choices->file, "The recording")->required()->check(CLI::ExistingFile);
  command
      ->add_option("-r,--rate", choices->rate,
                   "Recorded seconds per second; 0: as fast as the subscribers, without loss")
      ->check(text::above_zero(true))
      ->capture_default_str();
  command->add_option("-s,--start", choices->start, "Seconds after its beginning to start at")
      ->check(text::above_zero(true));
  command->add_option("-e,--end", choices->end, "Seconds after its beginning to end at; 0: its end")
      ->check(text::above_zero(true));
  command->add_option("-t,--topics", choices->topics, "Only these topics, * for any text");
  command->add_option("--remap", choices->remaps, "FROM:=TO, publish a topic by another name")
      ->allow_extra_args(false);
  command->add_option("--wait", choices->wait, "Longest wait for subscribers before it begins [s]")
      ->check(text::above_zero(true))
      ->capture_default_str();
  command->add_flag("-l,--loop", choices->loop, "Begin again at the end");
  command->add_flag("--hold", choices->hold, "Stay at the end for late subscribers");
  command->add_flag("--no-clock", choices->no_clock, "Do not publish /clock");
  command->add_flag("--pause", choices->paused, "Begin paused; prehend clock resume goes on");
  add_registry_option(*command, choices->registry);
  command->footer(
      "Examples:\n"
      "  prehend replay run.mcap\n"
      "  prehend replay run.mcap --rate 0.5 --start 3 --topics '/camera/*'\n"
      "  prehend replay run.mcap --pause; prehend clock step 100ms\n"
      "Use a graph of its own, or the topics have two publishers. Where none is running, the "
      "replay "
      "brings a registry.");
  command->callback([choices] { replay(*choices); });
}

}  // namespace

void add_recording_commands(CLI::App& app) {
  add_record(app);
  add_replay(app);
}

}  // namespace prehend::tools
