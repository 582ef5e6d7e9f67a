#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace prehend::robot::formats {

/// Whether a file's bytes are those of a zip.
bool is_archive(std::string_view bytes);

/// A file of a zip, whole. @throws geometry::InputError naming both when it is not there, damaged,
/// or larger than 64 MiB, whatever the archive says of its size
std::string file_of_archive(const std::filesystem::path& archive, const std::string& name);

/// A zip's bytes with files of those names and texts, deflated, in that order: the same for the
/// same files, since each has the date of 1980-01-01, the first that a zip knows.
/// @throws geometry::InputError where minizip does not pack them
std::string archive_of(const std::vector<std::pair<std::string, std::string>>& files);

}  // namespace prehend::robot::formats
