#pragma once

#include <filesystem>
#include <string>

namespace prehend::eval {

/// Makes the folder and those above it. @throws text::InputError when that cannot be.
void make_folder(const std::filesystem::path& folder);

/// Writes `text`, making the file's folder. @throws text::InputError naming the file.
void write_text(const std::filesystem::path& file, const std::string& text);

}  // namespace prehend::eval
