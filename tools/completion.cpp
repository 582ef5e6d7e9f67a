#include "tools/completion.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <stdexcept>

#include "prehend/graph/introspection.h"
#include "prehend/robot/preshape_names.h"
#include "prehend/robot/robot_files.h"
#include "prehend/text/tree_file.h"
#include "tools/jog/find_platform.h"

namespace prehend::tools {
namespace {

using Words = std::vector<std::string>;

constexpr std::chrono::milliseconds kCompletionPatience{300};  // of who pressed the Tab key

// The command line so far.
struct Position {
  const CLI::App* command = nullptr;
  Words arguments;                        // positional ones before the last word
  const CLI::Option* awaiting = nullptr;  // whose value the last word is
  std::string registry;
};

bool takes_value(const CLI::Option& option) { return option.get_items_expected_max() > 0; }

const CLI::Option* option_named(const CLI::App& command, const std::string& name) {
  return name.size() > 1 && name[0] == '-' ? command.get_option_no_throw(name) : nullptr;
}

std::vector<const CLI::App*> all_commands(const CLI::App& command) {
  return command.get_subcommands([](const CLI::App*) { return true; });
}

const CLI::App* subcommand_named(const CLI::App& command, const std::string& name) {
  for (const CLI::App* sub : all_commands(command)) {
    if (sub->get_name() == name) return sub;
  }
  return nullptr;
}

Position position_of(const CLI::App& app, const Words& words) {
  Position at;
  at.command = &app;
  for (std::size_t i = 0; i + 1 < words.size(); ++i) {
    const std::string& word = words[i];
    if (at.awaiting) {
      if (at.awaiting->get_single_name() == "registry") at.registry = word;
      at.awaiting = nullptr;
    } else if (word.rfind("--registry=", 0) == 0) {
      at.registry = word.substr(word.find('=') + 1);
    } else if (const auto* option = option_named(*at.command, word)) {
      if (takes_value(*option) && option->get_items_expected_min() > 0) at.awaiting = option;
    } else if (const auto* sub = subcommand_named(*at.command, word)) {
      at.command = sub;
    } else {
      at.arguments.push_back(word);
    }
  }
  return at;
}

Words commands_of(const CLI::App& command) {
  Words names;
  for (const CLI::App* sub : all_commands(command)) {
    if (!sub->get_name().empty() && !sub->get_group().empty()) names.push_back(sub->get_name());
  }
  return names;
}

Words options_of(const CLI::App& command) {
  Words names;
  for (const CLI::Option* option : command.get_options()) {
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  }
  return names;
}

// Name of the argument that comes after `given` others; the last one may be repeated.
std::string argument_name(const CLI::App& command, std::size_t given) {
  Words names;
  for (const CLI::Option* option : command.get_options()) {
    if (option->get_positional()) names.push_back(option->get_name(true));
  }
  if (given < names.size()) return names[given];
  return names.empty() ? "" : names.back();
}

// Launch files in the folder that the word begins with; by default the ones in ./launch, too.
Words launch_files(const std::string& word) {
  namespace fs = std::filesystem;
  const std::size_t slash = word.rfind('/');
  const std::string typed = slash == std::string::npos ? "" : word.substr(0, slash + 1);
  Words files;
  for (const std::string& folder : typed.empty() ? Words{"", "launch/"} : Words{typed}) {
    std::error_code ignored;  // a folder that is not there has no files
    for (const auto& entry : fs::directory_iterator(folder.empty() ? "." : folder, ignored)) {
      const std::string name = entry.path().filename();
      if (entry.path().extension() == ".yaml") files.push_back(folder + name);
      if (entry.is_directory(ignored)) files.push_back(folder + name + "/");
    }
  }
  return files;
}

template <class Entries, class Name>
void add_names(Words& names, const Entries& entries, Name name) {
  for (const auto& entry : entries) names.push_back(name(entry));
}

// Names of the running graph of one kind: "topic", "node", "service", "action".
Words live_names(graph::Introspection& graph, const std::string& kind) {
  Words names;
  for (const auto& node : graph.nodes()) {
    if (kind == "node") names.push_back(node.name());
    const auto topic = [](const msgs::graph::TopicEnd& end) { return end.topic(); };
    if (kind == "topic") add_names(names, node.publishers(), topic);
    if (kind == "topic") add_names(names, node.subscribers(), topic);
    const auto offer = [](const msgs::graph::Offer& entry) { return entry.name(); };
    if (kind == "service") add_names(names, node.services(), offer);
    if (kind == "action") add_names(names, node.actions(), offer);
  }
  return names;
}

// Of the running graph's robot, or of all there are.
Words preshapes_of(const std::string& registry) {
  try {
    graph::Introspection graph(registry, kCompletionPatience);
    return robot::preshape_names(find_platform(graph, "").file);
  } catch (const std::exception&) {
    Words all;  // no graph runs, or its nodes do not agree
    const std::string folder = text::tree_file("config/robots");
    for (const std::string& platform : robot::platform_names(folder)) {
      const Words names = robot::preshape_names(robot::platform_file(folder, platform));
      all.insert(all.end(), names.begin(), names.end());
    }
    return all;
  }
}

Words values_of(const std::string& name, const Position& at, const std::string& word) {
  static const std::map<std::string, Words> kChoices{
      {"level", {"debug", "info", "warning", "error"}},
      {"shell", {"bash", "zsh"}},
      {"clock", {"wall", "simulated"}},
      {"compression", {"lz4", "zstd", "none"}}};
  if (const auto found = kChoices.find(name); found != kChoices.end()) return found->second;
  if (name == "file" && at.command->get_name() == "launch") return launch_files(word);
  if (name == "platform") return robot::platform_names(text::tree_file("config/robots"));
  if (name == "preshape") return preshapes_of(at.registry);
  if (name == "motion") {
    Words names = preshapes_of(at.registry);
    names.insert(names.end(), {"open", "close", "list"});
    return names;
  }
  try {
    graph::Introspection graph(at.registry, kCompletionPatience);
    if (name == "topics") return live_names(graph, "topic");
    if (name == "parameter" && !at.arguments.empty()) {
      Words names;
      add_names(names, graph.parameters(at.arguments[0]),
                [](const msgs::graph::ParameterRecord& parameter) { return parameter.name(); });
      return names;
    }
    return live_names(graph, name);
  } catch (const std::exception&) {
    return {};  // no graph runs, or no such node
  }
}

constexpr const char* kBash = R"(# Completion of prehend for bash: source <(prehend completion bash)
_prehend() {
  local IFS=$'\n'
  COMPREPLY=($("${COMP_WORDS[0]}" __complete "${COMP_WORDS[@]:1:COMP_CWORD}" 2>/dev/null))
  if [[ ${#COMPREPLY[@]} -eq 1 && ${COMPREPLY[0]} == */ ]]; then
    compopt -o nospace 2>/dev/null
  fi
}
complete -o default -F _prehend prehend
)";

constexpr const char* kZsh = R"(#compdef prehend
# Completion of prehend for zsh: source <(prehend completion zsh)
_prehend() {
  local -a found
  found=("${(@f)$("${words[1]}" __complete "${(@)words[2,CURRENT]}" 2>/dev/null)}")
  if [[ -n "${found[*]}" ]]; then
    compadd -a found
  else
    _files
  fi
}
compdef _prehend prehend
)";

}  // namespace

std::vector<std::string> completions(const CLI::App& app, const std::vector<std::string>& words) {
  const std::string word = words.empty() ? "" : words.back();
  const Position at = position_of(app, words);
  Words found;
  if (at.awaiting) {
    found = values_of(at.awaiting->get_single_name(), at, word);
  } else if (!word.empty() && word[0] == '-') {
    found = options_of(*at.command);
  } else if (at.command->get_require_subcommand_min() > 0) {
    found = commands_of(*at.command);
  } else {
    found = values_of(argument_name(*at.command, at.arguments.size()), at, word);
  }
  std::erase_if(found, [&](const std::string& name) { return name.rfind(word, 0) != 0; });
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  return found;
}

std::string completion_script(const std::string& shell) {
  if (shell == "bash") return kBash;
  if (shell == "zsh") return kZsh;
  throw std::invalid_argument("no completion for '" + shell + "'; there is one for bash and zsh");
}

}  // namespace prehend::tools
