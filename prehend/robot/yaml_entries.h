#pragma once

#include <filesystem>
#include <string>

#include <yaml-cpp/yaml.h>

#include "prehend/geometry/errors.h"
#include "prehend/text/yaml_map.h"

namespace prehend::robot {

/// visit(map, name, value) for every entry of a map whose names are free, in their order; `map` is
/// asked for none of them. @throws geometry::InputError "file:line: ..." for no map, an empty one,
/// or a key that is no word.
template <class Visit>
void for_each_entry(const YAML::Node& node, const std::filesystem::path& path,
                    const std::string& place, Visit visit) {
  text::YamlMap map(node, path, place);
  if (node.size() == 0) {
    throw geometry::InputError(
        path.string() + ":" + std::to_string(node.Mark().line + 1) + ": " + place + " is empty",
        "Write `name: value` lines");
  }
  for (const auto& entry : node) {
    const std::string name = entry.first.IsScalar() ? entry.first.Scalar() : "";
    if (name.empty()) {
      throw geometry::InputError(path.string() + ":" + std::to_string(entry.first.Mark().line + 1) +
                                     ": " + place + " has a key that is no name",
                                 "Write a word");
    }
    visit(map, name, entry.second);
  }
}

}  // namespace prehend::robot
