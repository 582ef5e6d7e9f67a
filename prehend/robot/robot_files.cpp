#include "prehend/robot/robot_files.h"

#include "prehend/text/named_file.h"

namespace prehend::robot {
namespace {

constexpr const char* kPlatformKey = "arm";
constexpr const char* kHandKey = "fingers";

}  // namespace

std::vector<std::string> platform_names(const std::filesystem::path& folder) {
  return text::names_of_files(folder, kPlatformKey);
}

std::vector<std::string> hand_names(const std::filesystem::path& folder) {
  return text::names_of_files(folder, kHandKey);
}

std::filesystem::path platform_file(const std::filesystem::path& folder, const std::string& name) {
  return text::named_file(folder, name, "platform", kPlatformKey);
}

std::filesystem::path hand_file(const std::filesystem::path& folder, const std::string& name) {
  return text::named_file(folder, name, "hand", kHandKey);
}

}  // namespace prehend::robot
