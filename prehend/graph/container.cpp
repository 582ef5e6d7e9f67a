#include <fmt/format.h>
#include <pthread.h>

#include <algorithm>
#include <memory>
#include <mutex>
#include <set>
#include <stdexcept>
#include <thread>

#include "prehend/graph/node_command_line.h"
#include "prehend/graph/node_program.h"
#include "prehend/graph/stop_signals.h"
#include "prehend/graph/warm_heap.h"
#include "prehend/text/nearest_match.h"

namespace prehend::graph {
namespace {

std::vector<NodeProgram>& registered_programs() {
  static std::vector<NodeProgram> programs;
  return programs;
}

// One node of the container, until its program has ended.
struct Inhabitant {
  const NodeProgram* program = nullptr;
  NodeCommandLine command;
  std::unique_ptr<Node> node;  // by Container's mutex
};

class Container {
 public:
  explicit Container(std::vector<Inhabitant> inhabitants) : inhabitants_(std::move(inhabitants)) {}

  int run() {
    for (Inhabitant& inhabitant : inhabitants_) {
      if (!join(inhabitant)) return 1;
    }
    const StopSignals signals([this] { shut_down(); }, longest_stop_time());
    std::vector<std::thread> threads;
    for (Inhabitant& inhabitant : inhabitants_) {
      threads.emplace_back([this, &inhabitant] { live(inhabitant); });
    }
    for (std::thread& thread : threads) thread.join();
    return exit_code_;
  }

 private:
  std::chrono::milliseconds longest_stop_time() const {
    std::chrono::milliseconds longest{0};
    for (const Inhabitant& inhabitant : inhabitants_) {
      longest = std::max(longest, stop_time_of(inhabitant.program->description));
    }
    return longest;
  }

  static bool join(Inhabitant& inhabitant) {
    try {
      inhabitant.node = std::make_unique<Node>(inhabitant.command.options);
      return true;
    } catch (const std::exception& error) {
      fmt::print(stderr, "{}: {}\n", inhabitant.command.options.name, error.what());
      return false;
    }
  }

  void live(Inhabitant& inhabitant) {
    const std::string& name = inhabitant.command.options.name;
    ::pthread_setname_np(::pthread_self(), name.substr(0, 15).c_str());
    int code = 1;
    try {
      code = inhabitant.program->run(*inhabitant.node);
    } catch (const std::exception& error) {
      code = report_end(name, error);
    }
    leave(inhabitant, code);
  }

  void leave(Inhabitant& inhabitant, int code) {
    std::unique_ptr<Node> node;
    {
      const std::lock_guard lock(mutex_);
      node = std::move(inhabitant.node);
      if (exit_code_ == 0) exit_code_ = code;
    }
    if (code != 0) request_stop();
  }

  void shut_down() {
    const std::lock_guard lock(mutex_);
    for (const Inhabitant& inhabitant : inhabitants_) {
      if (inhabitant.node && !inhabitant.program->stops_itself) inhabitant.node->shutdown();
    }
  }

  std::mutex mutex_;
  std::vector<Inhabitant> inhabitants_;
  int exit_code_ = 0;
};

std::vector<std::string> program_names() {
  std::vector<std::string> names;
  for (const NodeProgram* program : node_programs()) names.push_back(program->description.name);
  return names;
}

const NodeProgram& program_named(const std::string& name) {
  for (const NodeProgram* program : node_programs()) {
    if (program->description.name == name) return *program;
  }
  throw std::invalid_argument("no node program '" + name + "'" +
                              text::nearest_match_hint(name, program_names()));
}

void print_help() {
  fmt::print(
      "Runs nodes in one process, each in a thread of its own; they hand each other messages by\n"
      "pointer.\n"
      "Usage: container -- PROGRAM [OPTIONS] [-- PROGRAM [OPTIONS]] ...\n"
      "  --help  print this   --list  print the programs' names\n"
      "Each PROGRAM takes the options it has alone (-- PROGRAM --help). Programs:\n");
  for (const NodeProgram* program : node_programs()) {
    const std::string& summary = program->description.summary;
    fmt::print("  {:<20} {}\n", program->description.name,
               summary.substr(0, std::min(summary.find(". "), summary.size() - 1)));
  }
}

// The words between "--"; the first group is what stands before all of them.
std::vector<std::vector<std::string>> groups_of(int argc, char** argv) {
  std::vector<std::vector<std::string>> groups(1);
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--") {
      groups.emplace_back();
    } else {
      groups.back().push_back(word);
    }
  }
  return groups;
}

// True when that was all that was asked for.
bool answer_own_options(const std::vector<std::string>& words) {
  bool answered = false;
  for (const std::string& word : words) {
    answered = word == "--help" || word == "-h" || word == "--list";
    if (!answered) {
      throw std::invalid_argument("'" + word + "': write container -- PROGRAM ... (see --help)");
    }
    if (word != "--list") print_help();
    if (word == "--list") fmt::print("{}\n", fmt::join(program_names(), "\n"));
  }
  return answered;
}

}  // namespace

void RegisteredNodeProgram::add(NodeProgram program) {
  registered_programs().push_back(std::move(program));
}

std::vector<const NodeProgram*> node_programs() {
  std::vector<const NodeProgram*> programs;
  for (const NodeProgram& program : registered_programs()) programs.push_back(&program);
  std::sort(programs.begin(), programs.end(),
            [](const auto* a, const auto* b) { return a->description.name < b->description.name; });
  return programs;
}

int run_container(int argc, char** argv) {
  try {
    const auto groups = groups_of(argc, argv);
    if (answer_own_options(groups[0])) return 0;
    if (groups.size() == 1) throw std::invalid_argument("no nodes to run (see --help)");
    std::vector<Inhabitant> inhabitants;
    std::set<std::string> names;
    for (std::size_t i = 1; i < groups.size(); ++i) {
      if (groups[i].empty()) throw std::invalid_argument("a program must follow '--'");
      Inhabitant inhabitant;
      inhabitant.program = &program_named(groups[i][0]);
      const NodeDescription& description = inhabitant.program->description;
      try {
        inhabitant.command =
            read_node_command_line({groups[i].begin() + 1, groups[i].end()}, description);
      } catch (const std::invalid_argument& error) {
        throw std::invalid_argument(description.name + ": " + error.what());
      }
      if (print_what_is_asked(inhabitant.command, description, inhabitant.program->run)) return 0;
      const std::string& name = inhabitant.command.options.name;
      if (!names.insert(name).second) {
        throw std::invalid_argument("two nodes are named '" + name + "'; give one another --name");
      }
      inhabitants.push_back(std::move(inhabitant));
    }
    keep_heap_warm();
    return Container(std::move(inhabitants)).run();
  } catch (const std::exception& error) {
    fmt::print(stderr, "container: {}\n", error.what());
    return 1;
  }
}

}  // namespace prehend::graph
