#pragma once

#include <filesystem>
#include <string>

namespace prehend::eval {

/// Writes `text`, making the file's folder. @throws std::runtime_error naming the file.
void write_text(const std::filesystem::path& file, const std::string& text);

/// `text` as a JSON string with its quotes.
std::string json_string(const std::string& text);

/// A number in JSON; NaN and infinity, which JSON cannot say, become null.
std::string json_number(double value);

}  // namespace prehend::eval
