#include "prehend/robot/preshape_names.h"

#include <yaml-cpp/yaml.h>

namespace prehend::robot {

std::vector<std::string> preshape_names(const std::filesystem::path& platform) {
  std::vector<std::string> names;
  try {
    const YAML::Node file = YAML::LoadFile(platform.string());
    const std::filesystem::path hand = platform.parent_path() / file["hand"].as<std::string>();
    for (const auto& entry : YAML::LoadFile(hand.string())["preshapes"]) {
      names.push_back(entry.first.as<std::string>());
    }
  } catch (const YAML::Exception&) {
    return {};  // whoever names it is told what is wrong with it
  }
  return names;
}

}  // namespace prehend::robot
