#pragma once

#include <filesystem>
#include <string>
#include <vector>

// The robots that lie in a folder (config/robots), by their files' names without .yaml, sorted.
namespace prehend::robot {

/// What has an `arm`: read_platform() reads it. Empty when there is no such folder.
std::vector<std::string> platform_names(const std::filesystem::path& folder);
/// What has `fingers`: read_hand_model() reads it.
std::vector<std::string> hand_names(const std::filesystem::path& folder);

/// The file of one of them; a `name` that ends in .yaml or has a '/' in it is a file's own path,
/// from the working folder or from `folder`.
/// @throws InputError with the nearest name, or all there are.
std::filesystem::path platform_file(const std::filesystem::path& folder, const std::string& name);
std::filesystem::path hand_file(const std::filesystem::path& folder, const std::string& name);

}  // namespace prehend::robot
