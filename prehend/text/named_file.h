#pragma once

#include <filesystem>
#include <string>
#include <vector>

// YAML files of one kind that lie in a folder, by their names without .yaml.
namespace prehend::text {

/// Those whose top has `key`, sorted. Empty when there is no such folder.
std::vector<std::string> names_of_files(const std::filesystem::path& folder,
                                        const std::string& key);

/// The file that `name` means: NAME.yaml of `folder`, but a `name` that ends in .yaml or has a '/'
/// in it is a file's own path, from the working folder or, if it is not there, from `folder`.
/// Whether it is there is not asked.
std::filesystem::path file_meant(const std::filesystem::path& folder, const std::string& name);

/// The file of one of them, as file_meant() finds it. `kind`: what it is called in errors.
/// @throws InputError with the nearest name, or all there are.
std::filesystem::path named_file(const std::filesystem::path& folder, const std::string& name,
                                 const std::string& kind, const std::string& key);

}  // namespace prehend::text
