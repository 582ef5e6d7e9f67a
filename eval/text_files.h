#pragma once

#include <filesystem>
#include <string>

namespace prehend::eval {

/// Writes `text`, making the file's folder. @throws std::runtime_error naming the file.
void write_text(const std::filesystem::path& file, const std::string& text);

}  // namespace prehend::eval
