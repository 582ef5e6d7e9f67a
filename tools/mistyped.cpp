#include "tools/mistyped.h"

#include <utility>

#include "prehend/text/nearest_match.h"

namespace prehend::tools {
namespace {

const CLI::App* command_of(const CLI::App& group, const std::string& name) {
  for (const CLI::App* command : group.get_subcommands([](const CLI::App*) { return true; })) {
    if (command->get_name() == name) return command;
  }
  return nullptr;
}

std::string no_such_command(const CLI::App& group, const std::string& path,
                            const std::string& word) {
  std::vector<std::string> known;
  for (const CLI::App* command : group.get_subcommands([](const CLI::App*) { return true; })) {
    known.push_back(command->get_name());
  }
  // All of them: people look for what they cannot name.
  std::string all;
  if (!text::nearest_match(word, known)) {
    for (const std::string& name : known) all += (all.empty() ? "; there are: " : ", ") + name;
  }
  return path + " has no command \"" + word + "\"" +
         (all.empty() ? text::nearest_match_hint(word, known) : all);
}

std::string no_such_option(const CLI::App& command, const std::string& path,
                           const std::string& word) {
  std::vector<std::string> known;
  for (const CLI::Option* option : command.get_options()) {
    for (const std::string& name : option->get_lnames()) known.push_back("--" + name);
  }
  return path + " has no option \"" + word + "\"" + text::nearest_match_hint(word, known);
}

}  // namespace

std::string mistyped(const CLI::App& app, const std::vector<std::string>& words) {
  const CLI::App* at = &app;
  std::string path = app.get_name();
  bool is_value = false;  // of the option before
  for (const std::string& word : words) {
    if (word == "--") return "";
    if (std::exchange(is_value, false)) continue;
    if (word.starts_with('-')) {
      const bool is_long = word.starts_with("--");
      const std::size_t equals = word.find('=');
      const CLI::Option* option = at->get_option_no_throw(word.substr(0, equals));
      if (!option && is_long) return no_such_option(*at, path, word.substr(0, equals));
      is_value = option && equals == std::string::npos && option->get_items_expected_min() > 0;
      continue;
    }
    const CLI::App* command = command_of(*at, word);
    if (!command && at->get_require_subcommand_min() == 0) continue;
    if (!command) return no_such_command(*at, path, word);
    at = command;
    path += " " + word;
  }
  return "";
}

}  // namespace prehend::tools
