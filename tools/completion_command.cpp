#include <cstdio>
#include <memory>

#include "tools/commands.h"
#include "tools/completion.h"

namespace prehend::tools {

void add_completion_command(CLI::App& app) {
  auto shell = std::make_shared<std::string>();
  CLI::App* command = app.add_subcommand(
      "completion", "Print the script that completes commands and names of the running graph");
  command->add_option("shell", *shell, "bash or zsh")->required();
  command->footer("Example, also for ~/.bashrc:\n  source <(prehend completion bash)");
  command->callback([shell] { std::fputs(completion_script(*shell).c_str(), stdout); });
}

void print_completions(CLI::App& app, int argc, char** argv) {
  for (const std::string& word : completions(app, {argv + 2, argv + argc})) {
    std::printf("%s\n", word.c_str());
  }
}

}  // namespace prehend::tools
