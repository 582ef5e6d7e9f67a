#include "prehend/robot/robot_files.h"

#include <algorithm>

#include <yaml-cpp/yaml.h>

#include "prehend/text/input_error.h"
#include "prehend/text/nearest_match.h"

namespace prehend::robot {
namespace {

std::vector<std::string> files_with(const std::filesystem::path& folder, const char* key) {
  std::vector<std::string> names;
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator(folder, ignored)) {
    if (entry.path().extension() != ".yaml") continue;
    try {
      const YAML::Node file = YAML::LoadFile(entry.path().string());
      if (file.IsMap() && file[key]) names.push_back(entry.path().stem().string());
    } catch (const YAML::Exception&) {
      continue;  // whoever names it is told what is wrong with it
    }
  }
  std::sort(names.begin(), names.end());
  return names;
}

std::filesystem::path file_of(const std::filesystem::path& folder, const std::string& name,
                              const std::string& kind, const char* key) {
  std::error_code ignored;
  if (name.ends_with(".yaml") || name.find('/') != std::string::npos) {
    for (const std::filesystem::path& own : {std::filesystem::path(name), folder / name}) {
      if (std::filesystem::is_regular_file(own, ignored)) return own;
    }
    throw text::InputError("There is no file '" + name + "' of a " + kind,
                           "Check the path, or name one of '" + folder.string() + "'");
  }
  const std::filesystem::path file = folder / (name + ".yaml");
  if (!name.empty() && std::filesystem::is_regular_file(file, ignored)) return file;
  throw text::InputError("There is no " + kind + " '" + name + "' in '" + folder.string() + "'",
                         text::nearest_match_mend(name, files_with(folder, key)));
}

constexpr const char* kPlatformKey = "arm";
constexpr const char* kHandKey = "fingers";

}  // namespace

std::vector<std::string> platform_names(const std::filesystem::path& folder) {
  return files_with(folder, kPlatformKey);
}

std::vector<std::string> hand_names(const std::filesystem::path& folder) {
  return files_with(folder, kHandKey);
}

std::filesystem::path platform_file(const std::filesystem::path& folder, const std::string& name) {
  return file_of(folder, name, "platform", kPlatformKey);
}

std::filesystem::path hand_file(const std::filesystem::path& folder, const std::string& name) {
  return file_of(folder, name, "hand", kHandKey);
}

}  // namespace prehend::robot
