#pragma once

#include <CLI/CLI.hpp>

#include <string>
#include <vector>

namespace prehend::tools {

/// The words that can stand in place of the last of `words`, which may be unfinished or empty:
/// commands, options, and names of the running graph (nothing where none runs). Never throws for
/// what the user typed.
std::vector<std::string> completions(const CLI::App& app, const std::vector<std::string>& words);

/// The script that makes bash or zsh ask `prehend __complete`. Throws std::invalid_argument for
/// other shells.
std::string completion_script(const std::string& shell);

}  // namespace prehend::tools
