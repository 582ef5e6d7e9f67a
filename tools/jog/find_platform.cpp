#include "tools/jog/find_platform.h"

#include <map>
#include <stdexcept>
#include <system_error>

#include <fmt/format.h>

#include "prehend/robot/robot_files.h"
#include "prehend/text/tree_file.h"

namespace prehend::tools {
namespace {

constexpr const char* kDefault = "stage_pg70";

std::string robots() { return text::tree_file("config/robots"); }

}  // namespace

FoundPlatform find_platform(graph::Introspection& graph, const std::string& given) {
  if (!given.empty()) return {robot::platform_file(robots(), given), "--platform"};
  std::map<std::filesystem::path, FoundPlatform> said;
  for (const msgs::graph::NodeRecord& node : graph.nodes()) {
    std::string name, folder = robots();
    try {
      for (const msgs::graph::ParameterRecord& parameter : graph.parameters(node.name())) {
        const std::string& text = parameter.value().string_value();
        if (parameter.name() == "platforms" && !text.empty()) folder = text;
        if (parameter.name() == "platform" || (parameter.name() == "robot" && name.empty())) {
          name = text;
        }
      }
    } catch (const std::runtime_error&) {
      continue;  // it has just ended, or does not answer: it says nothing
    }
    if (name.empty()) continue;
    std::filesystem::path file;
    try {
      file = robot::platform_file(folder, name);
    } catch (const std::runtime_error&) {
      continue;  // another kind of robot, or of another host
    }
    std::error_code ignored;
    const auto same = std::filesystem::weakly_canonical(file, ignored);
    said.try_emplace(same, FoundPlatform{file, "node " + node.name()});
  }
  if (said.empty()) return {robot::platform_file(robots(), kDefault), "no node says which"};
  const FoundPlatform& first = said.begin()->second;
  if (said.size() > 1) {
    const FoundPlatform& second = std::next(said.begin())->second;
    throw std::runtime_error(
        fmt::format("{} says the robot is {}, {} says {}: name yours by --platform", first.said_by,
                    first.file.string(), second.said_by, second.file.string()));
  }
  return first;
}

}  // namespace prehend::tools
