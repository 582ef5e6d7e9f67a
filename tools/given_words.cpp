#include "tools/given_words.h"

namespace prehend::tools {

std::vector<std::string> given_words(const CLI::App& command) {
  std::vector<std::string> words;
  for (const CLI::Option* option : command.get_options()) {
    if (option->count() == 0) continue;
    if (option->get_positional()) {
      words.insert(words.end(), option->results().begin(), option->results().end());
      continue;
    }
    const std::string name = "--" + option->get_lnames().front();
    if (name == "--keys" || name == "--bind") continue;  // are in the environment by now
    if (option->get_expected_max() == 0) {
      words.push_back(name);
      continue;
    }
    std::string joined;  // of an option that takes several values at once
    for (const std::string& value : option->results()) {
      if (option->get_expected_min() > 1) {
        joined += (joined.empty() ? "" : ",") + value;
      } else {
        words.push_back(name + "=" + value);
      }
    }
    if (!joined.empty()) words.push_back(name + "=" + joined);
  }
  return words;
}

}  // namespace prehend::tools
