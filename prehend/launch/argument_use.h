#pragma once

#include <yaml-cpp/yaml.h>

#include <map>
#include <set>
#include <string>

// Which arguments of a launch file have an effect, found out while it is read.
namespace prehend::launch {

/// The names that stand as `$(name)` anywhere in `node`, values and keys.
std::set<std::string> names_in(const YAML::Node& node);

/// The arguments of one launch file: an argument is used where its value is substituted, and where
/// it is handed to an included file that uses it.
class ArgumentUse {
 public:
  void use(const std::string& name) { used_.insert(name); }
  /// `part` is left out because of `condition`, e.g. "a.yaml:3 (if: $(gripper) == pg70)".
  void leave_out(const YAML::Node& part, const std::string& condition);
  /// `arguments` (names to texts) were handed to an included file, whose use of them is `inner`.
  void hand_on(const YAML::Node& arguments, const ArgumentUse& inner);
  /// `declared` are the file's `arguments:`; the default of one that is used and was not `given`
  /// uses what it names.
  void use_defaults(const YAML::Node& declared, const std::map<std::string, std::string>& given);

  bool is_used(const std::string& name) const { return used_.count(name) > 0; }
  /// The condition that left out what `name` is for; "" when nothing names it.
  std::string left_out_by(const std::string& name) const;

 private:
  std::set<std::string> used_;
  std::map<std::string, std::string> left_out_;  // name -> condition, the first one
};

}  // namespace prehend::launch
