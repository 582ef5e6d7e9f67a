#pragma once

#include <filesystem>
#include <string>

namespace prehend::robot::formats {

/// Whether a file's bytes are those of a zip.
bool is_archive(const std::string& bytes);

/// A file of a zip, whole. @throws geometry::InputError naming both when it is not there, damaged,
/// or larger than 64 MiB, whatever the archive says of its size
std::string file_of_archive(const std::filesystem::path& archive, const std::string& name);

}  // namespace prehend::robot::formats
