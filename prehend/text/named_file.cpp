#include "prehend/text/named_file.h"

#include <algorithm>

#include <yaml-cpp/yaml.h>

#include "prehend/text/input_error.h"
#include "prehend/text/nearest_match.h"

namespace prehend::text {

std::vector<std::string> names_of_files(const std::filesystem::path& folder,
                                        const std::string& key) {
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

std::filesystem::path file_meant(const std::filesystem::path& folder, const std::string& name) {
  if (!name.ends_with(".yaml") && name.find('/') == std::string::npos) {
    return folder / (name + ".yaml");
  }
  std::error_code ignored;
  const bool of_folder = !std::filesystem::is_regular_file(name, ignored) &&
                         std::filesystem::is_regular_file(folder / name, ignored);
  return of_folder ? folder / name : std::filesystem::path(name);
}

std::filesystem::path named_file(const std::filesystem::path& folder, const std::string& name,
                                 const std::string& kind, const std::string& key) {
  const std::filesystem::path file = file_meant(folder, name);
  std::error_code ignored;
  if (!name.empty() && std::filesystem::is_regular_file(file, ignored)) return file;
  if (name.ends_with(".yaml") || name.find('/') != std::string::npos) {
    throw InputError("There is no file '" + name + "' of a " + kind,
                     "Check the path, or name one of '" + folder.string() + "'");
  }
  throw InputError("There is no " + kind + " '" + name + "' in '" + folder.string() + "'",
                   nearest_match_mend(name, names_of_files(folder, key)));
}

}  // namespace prehend::text
