#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace prehend::testing {

/// What a file of the source tree includes although it must not: docs/architecture.md, "Who may
/// depend on whom". `file` is relative to the source tree, with `/`; `text` is what it holds. One
/// line for each, "FILE:LINE: includes X, ...".
std::vector<std::string> wrong_includes(const std::filesystem::path& file, const std::string& text);

}  // namespace prehend::testing
