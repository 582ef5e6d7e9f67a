#include "prehend/launch/parameter_check.h"

#include <fmt/core.h>
#include <google/protobuf/util/json_util.h>
#include <poll.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <sstream>

#include "msgs/graph.pb.h"
#include "prehend/graph/link/parameter_store.h"
#include "prehend/graph/parameter.h"
#include "prehend/graph/parameter_file.h"
#include "prehend/launch/child_process.h"
#include "prehend/launch/launch_values.h"
#include "prehend/text/nearest_match.h"

namespace prehend::launch {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::seconds kLongestAnswer{10};
constexpr std::size_t kMostOutput = std::size_t{1} << 20;
constexpr std::size_t kMostNames = 1000;  // of a folder that are looked at for the nearest

std::string container_beside(const std::string& executable) {
  return (std::filesystem::path(executable).parent_path() / "container").string();
}

// Commands that run at the same time; what each wrote, if it ended with exit code 0 in time.
class Questions {
 public:
  void ask(const std::vector<std::string>& command) {
    if (running_.count(command[0]) > 0) return;
    try {
      running_[command[0]].child =
          std::make_unique<ChildProcess>(command, std::map<std::string, std::string>{});
    } catch (const std::system_error& error) {
      running_[command[0]].output = error.what();
    }
  }

  void wait() {
    const auto deadline = Clock::now() + kLongestAnswer;
    while (take_output() && Clock::now() < deadline) {
      std::vector<pollfd> files;
      for (auto& [program, question] : running_) {
        if (question.child) files.push_back({question.child->output(), POLLIN, 0});
      }
      ::poll(files.data(), files.size(), 10);
      const bool only_closed = std::none_of(files.begin(), files.end(), [](const pollfd& file) {
        return (file.revents & POLLIN) != 0;
      });
      if (only_closed) ::poll(nullptr, 0, 2);
    }
    for (auto& [program, question] : running_) question.child.reset();
  }

  // Empty when the program failed or was too slow.
  std::optional<std::string> answer(const std::string& program) const {
    const Question& question = running_.at(program);
    return question.succeeded ? std::optional(question.output) : std::nullopt;
  }

 private:
  struct Question {
    std::unique_ptr<ChildProcess> child;
    std::string output;
    bool succeeded = false;
  };

  // False once all have ended.
  bool take_output() {
    bool some_run = false;
    for (auto& [program, question] : running_) {
      if (!question.child) continue;
      const auto status = question.child->status();
      question.output += question.child->read_output();
      if (status || question.output.size() > kMostOutput) {
        question.succeeded = status && is_success(*status);
        question.child.reset();
      } else {
        some_run = true;
      }
    }
    return some_run;
  }

  std::map<std::string, Question> running_;
};

// What is in the folder where the file was looked for, with the nearest name.
std::string near_files_hint(const std::filesystem::path& file) {
  std::vector<std::string> names;
  std::error_code error;
  const auto folder = file.has_parent_path() ? file.parent_path() : std::filesystem::path(".");
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    names.push_back(entry.path().filename().string());
    if (names.size() == kMostNames) break;
  }
  if (error) return "; there is no folder " + short_path(folder.string()) + " either";
  std::sort(names.begin(), names.end());
  return text::nearest_match_hint(file.filename().string(), names);
}

// What a program declares.
struct Declared {
  std::map<std::string, graph::ParameterInfo> parameters;
  bool complete = false;
};

class Check {
 public:
  Check(const LaunchGraph& graph, const std::string& host) : graph_(graph), host_(host) {}

  ParameterFindings run() {
    for (const LaunchNode& node : graph_.nodes) {
      questions_.ask({node.executable, "--describe"});
      if (!node.process.empty()) questions_.ask({container_beside(node.executable), "--list"});
    }
    questions_.wait();
    for (const LaunchNode& node : graph_.nodes) {
      if (!node.process.empty()) check_composable(node);
      check(node);
    }
    return findings_;
  }

 private:
  void check_composable(const LaunchNode& node) {
    const auto list = questions_.answer(container_beside(node.executable));
    std::istringstream lines(list.value_or(""));
    std::vector<std::string> programs;
    for (std::string line; std::getline(lines, line);) programs.push_back(line);
    if (std::find(programs.begin(), programs.end(), node.program) != programs.end()) return;
    findings_.errors.push_back(
        fmt::format("{}: {} cannot be composed: the container has no program \"{}\"{}", node.place,
                    node.name, node.program, text::nearest_match_hint(node.program, programs)));
  }

  const Declared* declared_by(const LaunchNode& node) {
    const auto known = declared_.find(node.executable);
    if (known != declared_.end()) return known->second ? &*known->second : nullptr;
    std::optional<Declared>& declared = declared_[node.executable];
    const auto json = questions_.answer(node.executable);
    msgs::graph::NodeProgramDescription description;
    if (!json || !google::protobuf::util::JsonStringToMessage(*json, &description).ok()) {
      findings_.notes.push_back(node.place + ": parameters of " + node.program +
                                " are not checked: it does not answer --describe");
      return nullptr;
    }
    declared.emplace();
    declared->complete = description.failure().empty();
    if (description.stop_time() > 0) {
      findings_.stop_times[node.executable] = description.stop_time();
    }
    for (const auto& record : description.parameters()) {
      declared->parameters[record.name()] = graph::from_record(record);
    }
    return &*declared;
  }

  void check(const LaunchNode& node) {
    const Declared* declared = declared_by(node);
    if (!declared) return;
    std::map<std::string, graph::FileParameter> in_file;
    try {
      if (!node.parameter_file.empty()) {
        in_file = graph::read_parameter_file(short_path(node.parameter_file));
      }
    } catch (const std::invalid_argument& error) {
      findings_.errors.push_back(error.what());
    }
    for (const auto& [name, value] : in_file) {
      check(node, *declared, name, value.text,
            fmt::format("{}:{}", short_path(node.parameter_file), value.line));
    }
    for (const auto& [name, text] : node.parameters) {
      check(node, *declared, name, text, node.parameter_places.at(name));
    }
  }

  void check(const LaunchNode& node, const Declared& declared, const std::string& name,
             const std::string& text, const std::string& place) {
    const auto found = declared.parameters.find(name);
    if (found == declared.parameters.end()) {
      if (!declared.complete) return;  // the node itself will know
      std::vector<std::string> known;
      for (const auto& [other, info] : declared.parameters) known.push_back(other);
      findings_.errors.push_back(fmt::format("{}: {} has no parameter \"{}\"{}", place,
                                             node.program, name,
                                             text::nearest_match_hint(name, known)));
      return;
    }
    if (is_open(text)) return;
    try {
      graph::parse_parameter(found->second, text);
      if (found->second.reads_file && node.host == host_) check_file(node, name, text, place);
    } catch (const std::invalid_argument& error) {
      findings_.errors.push_back(fmt::format("{}: {} of {}", place, error.what(), node.name));
    }
  }

  void check_file(const LaunchNode& node, const std::string& name, const std::string& file,
                  const std::string& place) {
    std::error_code error;
    if (file.empty() || std::filesystem::exists(file, error)) return;
    findings_.errors.push_back(fmt::format("{}: {} of {}: there is no {}{}", place, name, node.name,
                                           short_path(file), near_files_hint(file)));
  }

  const LaunchGraph& graph_;
  const std::string host_;
  Questions questions_;
  std::map<std::string, std::optional<Declared>> declared_;  // by executable
  ParameterFindings findings_;
};

}  // namespace

ParameterFindings check_parameters(const LaunchGraph& graph, const std::string& host) {
  return Check(graph, host).run();
}

}  // namespace prehend::launch
