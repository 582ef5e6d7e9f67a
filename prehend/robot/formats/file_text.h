#pragma once

#include <filesystem>
#include <string>

namespace prehend::robot::formats {

/// A file's bytes. @throws geometry::InputError naming one that cannot be read, is empty, or is
/// larger than 64 MiB
std::string whole_file(const std::filesystem::path& file);
/// Its first bytes, at most `most`; empty where it cannot be read.
std::string head_of_file(const std::filesystem::path& file, std::size_t most = 4096);

}  // namespace prehend::robot::formats
