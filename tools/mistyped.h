#pragma once

#include <CLI/CLI.hpp>

#include <string>
#include <vector>

namespace prehend::tools {

/// What is wrong with the first of `words` (a command line without the program) that is no command
/// where one must stand, or no option of its command, with the nearest there is; "" when all are
/// known. Values are not looked at.
std::string mistyped(const CLI::App& app, const std::vector<std::string>& words);

}  // namespace prehend::tools
