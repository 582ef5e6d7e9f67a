#pragma once

#include <string>
#include <vector>

#include <CLI/CLI.hpp>

namespace prehend::tools {

/// What was given to `command`, as words for the program that does it.
std::vector<std::string> given_words(const CLI::App& command);

}  // namespace prehend::tools
