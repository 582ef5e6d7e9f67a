#include "prehend/graph/names.h"

#include <stdexcept>

namespace prehend::graph {
namespace {

bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_word(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || is_digit(c) || c == '_';
}
bool is_of_all_below(const std::string& name) { return name.ends_with("/*"); }

}  // namespace

void check_node_name(const std::string& name) {
  bool good = !name.empty() && name.size() <= 100 && !is_digit(name[0]);
  for (const char c : name) good = good && is_word(c);
  if (!good) {
    throw std::invalid_argument("node name '" + name +
                                "': use 1 to 100 letters, digits and '_', no digit first");
  }
}

void check_resource_name(const std::string& name) {
  bool good = name.size() >= 2 && name.size() <= 200 && name[0] == '/' && name.back() != '/';
  for (std::size_t i = 1; i < name.size() && good; ++i) {
    good = is_word(name[i]) || (name[i] == '/' && name[i - 1] != '/');
  }
  if (!good) {
    throw std::invalid_argument("name '" + name +
                                "': use '/' and letters, digits and '_' in each part, as in "
                                "'/camera/left'");
  }
}

void check_remap(const std::string& from, const std::string& to) {
  for (const std::string& name : {from, to}) {
    check_resource_name(is_of_all_below(name) ? name.substr(0, name.size() - 2) : name);
  }
  if (is_of_all_below(from) != is_of_all_below(to)) {
    throw std::invalid_argument("'" + from + "' to '" + to +
                                "': both must end with '/*', which renames all below, or none");
  }
}

Remaps::const_iterator remap_of(const Remaps& remaps, const std::string& name) {
  auto remap = remaps.find(name);
  for (std::size_t end = name.rfind('/'); remap == remaps.end() && end > 0 && end != name.npos;
       end = name.rfind('/', end - 1)) {
    remap = remaps.find(name.substr(0, end + 1) + "*");
  }
  return remap;
}

std::string renamed(const Remaps::value_type& remap, const std::string& name) {
  const auto& [from, to] = remap;
  if (!is_of_all_below(from)) return to;
  return to.substr(0, to.size() - 1) + name.substr(from.size() - 1);
}

void check_name_space(const std::string& name_space) {
  if (name_space.empty()) return;
  try {
    check_resource_name(name_space);
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(std::string("namespace: ") + error.what());
  }
}

bool is_global_name(const std::string& name) {
  for (const std::string& global :
       {std::string("/clock"), std::string("/log"), std::string("/diagnostics"),
        std::string("/parameter_events"), std::string("/statistics")}) {
    if (name == global || name.starts_with(global + "/")) return true;
  }
  return false;
}

std::string in_name_space(const std::string& name_space, const std::string& name) {
  return is_global_name(name) ? name : name_space + name;
}

}  // namespace prehend::graph
