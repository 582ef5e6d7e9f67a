#include <algorithm>
#include <array>
#include <set>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "prehend/geometry/errors.h"
#include "prehend/robot/formats/extension.h"
#include "prehend/robot/formats/extension_parts.h"
#include "prehend/robot/formats/extension_rounding.h"

namespace prehend::robot::formats {
namespace {

using geometry::InputError;
JsonValue keys_between(const JsonValue& plain, const JsonValue& wanted) {
  JsonValue patch = JsonValue::object();
  for (const auto& item : wanted.items()) {
    const auto found = plain.find(item.key());
    if (found == plain.end() || *found != item.value()) patch[item.key()] = item.value();
  }
  for (const auto& item : plain.items()) {
    if (!wanted.contains(item.key())) patch[item.key()] = nullptr;
  }
  return patch;
}

template <class Record>
std::ptrdiff_t count_of(const std::vector<Record>& records, const std::string& name) {
  return std::count_if(records.begin(), records.end(),
                       [&](const Record& one) { return one.name == name; });
}

/// Makes the block.
class ExtensionMaker {
 public:
  ExtensionMaker(const RobotDescription& robot, RobotDescription plain)
      : robot_(robot), plain_(std::move(plain)) {}

  /// Empty: there is nothing to say.
  JsonValue block() {
    if (robot_.name != plain_.name) block_["name"] = robot_.name;
    take_frames();
    take_others();
    links();
    joints();
    list("loops", plain_.loops, robot_.loops, without_.loops, false);
    list("actuators", plain_.actuators, robot_.actuators, without_.actuators, false);
    list("sensors", plain_.sensors, robot_.sensors, without_.sensors, false);
    // Whole, since files beside it that say the rest may be gone.
    list("manipulators", plain_.manipulators, robot_.manipulators, without_.manipulators, true);
    list("postures", plain_.postures, robot_.postures, without_.postures, true);
    pairs();
    const JsonValue without = json_of_record(without_);
    if (!without.empty()) block_["without"] = without;
    return std::move(block_);
  }

 private:
  /// Joints that URDF needs for frames beside their links'.
  void take_frames() {
    std::vector<std::string> merged;
    for (const std::string& name : names_in(plain_.joints)) {
      if (robot_.joint(name) || robot_.link(plain_.joint(name)->parent)) continue;
      if (merge_joint(plain_, name).empty()) merged.push_back(name);
    }
    if (!merged.empty()) block_["merged"] = merged;
  }

  const JointDescription* wanted_joint(const JointDescription& plain) const {
    if (const JointDescription* found = robot_.joint(plain.name)) return found;
    const JointDescription* above = robot_.joint_above(plain.child);
    return above && !plain_.joint(above->name) ? above : nullptr;
  }

  void take_others() {
    for (const JointDescription& joint : plain_.joints) {
      if (!wanted_joint(joint)) without_.joints.push_back(joint.name);
    }
    for (const LinkDescription& link : plain_.links) {
      if (!robot_.link(link.name)) without_.links.push_back(link.name);
    }
  }

  void links() {
    JsonValue all = JsonValue::array();
    for (const LinkDescription& link : robot_.links) {
      const LinkDescription* found = plain_.link(link.name);
      if (!found) {
        throw InputError("link '" + link.name + "' is not read again", "Call it another name");
      }
      std::optional<Inertial> inertial = found->inertial;
      take_rounded(inertial, link.inertial);
      JsonValue patch = JsonValue::object();
      if (link.inertial) {
        const JsonValue wanted = json_of_record(*link.inertial);
        if (!inertial || json_of_record(*inertial) != wanted) patch["inertial"] = wanted;
      } else if (inertial) {
        patch["inertial"] = nullptr;
      }
      shapes(patch, "visuals", found->visuals, link.visuals);
      shapes(patch, "collisions", found->collisions, link.collisions);
      add(all, link.name, patch);
    }
    if (!all.empty()) block_["links"] = std::move(all);
  }

  /// As how many of the file's each of the robot's shapes stands there.
  static std::vector<std::size_t> parts_of(const std::vector<Shape>& plain,
                                           const std::vector<Shape>& robot) {
    std::vector<std::size_t> parts(robot.size(), 1);
    if (plain.size() == robot.size()) return parts;
    constexpr std::size_t kOfCapsule = 3;  // URDF's: a cylinder and two balls
    std::size_t at = 0;
    for (std::size_t i = 0; i < robot.size(); ++i) {
      const bool is_there = at < plain.size() && plain[at].kind == robot[i].kind;
      const bool is_capsule = robot[i].kind == Shape::Kind::kCapsule &&
                              at + kOfCapsule <= plain.size() &&
                              plain[at].kind == Shape::Kind::kCylinder;
      parts[i] = is_there ? 1 : is_capsule ? kOfCapsule : 0;
      at += parts[i];
    }
    if (at == plain.size()) return parts;
    std::fill(parts.begin(), parts.end(), std::size_t{0});
    if (!parts.empty()) parts[0] = plain.size();
    return parts;
  }

  static void shapes(JsonValue& patch, const char* key, const std::vector<Shape>& plain,
                     const std::vector<Shape>& robot) {
    const std::vector<std::size_t> parts = parts_of(plain, robot);
    JsonValue all = JsonValue::array();
    bool is_same = true;
    std::size_t at = 0;
    for (std::size_t i = 0; i < robot.size(); ++i) {
      JsonValue one = JsonValue::object();
      if (parts[i] != 1) one["parts"] = parts[i];
      JsonValue base = JsonValue::object();
      if (parts[i] > 0) {
        Shape rounded = plain[at];
        take_rounded(rounded, robot[i]);
        base = json_of_record(rounded);
      }
      one.update(keys_between(base, json_of_record(robot[i])));
      is_same = is_same && one.empty();
      all.push_back(std::move(one));
      at += parts[i];
    }
    if (!is_same) patch[key] = std::move(all);
  }

  void joints() {
    JsonValue all = JsonValue::array();
    std::set<std::string> said;
    for (JointDescription joint : plain_.joints) {
      const JointDescription* wanted = wanted_joint(joint);
      if (!wanted) continue;
      said.insert(wanted->name);
      take_rounded(joint, *wanted);
      JsonValue patch = JsonValue::object();
      if (joint.name != wanted->name) patch["was"] = joint.name;
      joint.name = wanted->name;
      patch.update(keys_between(json_of_record(joint), json_of_record(*wanted)));
      add(all, wanted->name, patch);
    }
    for (const JointDescription& joint : robot_.joints) {
      if (said.count(joint.name) == 0) all.push_back(json_of_record(joint));
    }
    if (!all.empty()) block_["joints"] = std::move(all);
  }

  static void add(JsonValue& all, const std::string& name, const JsonValue& patch) {
    if (patch.empty()) return;
    JsonValue one = JsonValue::object();
    one["name"] = name;
    one.update(patch);
    all.push_back(std::move(one));
  }

  template <class Record>
  void list(const char* key, const std::vector<Record>& plain, const std::vector<Record>& robot,
            std::vector<std::string>& without, bool are_whole) {
    JsonValue all = JsonValue::array();
    std::set<std::string> told;
    for (const Record& one : plain) {
      if (count_of(robot, one.name) == 0) without.push_back(one.name);
    }
    for (const Record& one : robot) {
      std::vector<Record> its;
      std::copy_if(plain.begin(), plain.end(), std::back_inserter(its),
                   [&](const Record& other) { return other.name == one.name; });
      if (its.size() == 1 && count_of(robot, one.name) == 1) {
        take_rounded(its.front(), one);
        const JsonValue wanted = json_of_record(one);
        const JsonValue patch = keys_between(json_of_record(its.front()), wanted);
        add(all, one.name, are_whole && !patch.empty() ? wanted : patch);
        continue;
      }
      // Several of a name are said anew.
      if (!its.empty() && told.insert(one.name).second) without.push_back(one.name);
      all.push_back(json_of_record(one));
    }
    if (!all.empty()) block_[key] = std::move(all);
  }

  void pairs() {
    const auto missing = [](const std::vector<LinkPair>& of, const std::vector<LinkPair>& in) {
      std::vector<LinkPair> all;
      std::copy_if(of.begin(), of.end(), std::back_inserter(all), [&](const LinkPair& one) {
        return std::none_of(in.begin(), in.end(),
                            [&](const LinkPair& other) { return is_same_pair(one, other); });
      });
      return all;
    };
    without_.disabled_collisions = missing(plain_.disabled_collisions, robot_.disabled_collisions);
    JsonValue all = JsonValue::array();
    for (const auto& [first, second] :
         missing(robot_.disabled_collisions, plain_.disabled_collisions)) {
      all.push_back(JsonValue::array({first, second}));
    }
    if (!all.empty()) block_["disabled_collisions"] = std::move(all);
  }

  const RobotDescription& robot_;
  RobotDescription plain_;
  Without without_;
  JsonValue block_ = JsonValue::object();
};

/// "3 sensors, 2 joints (break_away, passive)"
std::string words_of(const JsonValue& block) {
  const std::array<std::pair<const char*, const char*>, 8> kinds{
      {{"sensors", "sensor"},
       {"actuators", "actuator"},
       {"loops", "closed loop"},
       {"manipulators", "manipulator"},
       {"postures", "posture"},
       {"disabled_collisions", "pair of links that may touch"},
       {"joints", "joint"},
       {"links", "link"}}};
  std::string words;
  for (const auto& [key, kind] : kinds) {
    const auto found = block.find(key);
    if (found == block.end()) continue;
    const std::string name = kind;
    std::string many = name + 's';
    if (name.starts_with("pair ")) many = "pairs" + name.substr(4);
    words += fmt::format("{}{} {}", words.empty() ? "" : ", ", found->size(),
                         found->size() == 1 ? name : many);
    if (name != "joint" && name != "link") continue;
    std::set<std::string> keys;
    for (const JsonValue& one : *found) {
      for (const auto& item : one.items()) {
        if (item.key() != "name") keys.insert(item.key() == "was" ? "name" : item.key());
      }
    }
    words += fmt::format(" ({})", fmt::join(keys, ", "));
  }
  if (block.contains("name")) words += std::string(words.empty() ? "" : ", ") + "the robot's name";
  return words.empty() ? "which links and joints are the format's alone" : words;
}

}  // namespace

std::string extension_text(const RobotDescription& robot,
                           const std::function<RobotDescription()>& read_again,
                           const LossReport& written, LossReport& loss) {
  using Fate = LossReport::Entry::Fate;
  for (const auto& [what, count] : written.kept()) loss.keep(what, count);
  JsonValue block = JsonValue::object();
  block["version"] = kExtensionVersion;
  std::string text;
  try {
    RobotDescription plain = read_again();
    const JsonValue said = ExtensionMaker(robot, plain).block();
    said.dump();  // refuses what is no UTF-8
    block.update(said);
    text = json_text(block, loss);
    // A robot that names what is not there has a block that is refused, and with it its file.
    LossReport unused;
    apply_extension(text, "The robot's file", plain, unused);
    for (const auto& entry : written.entries()) {
      if (entry.fate == Fate::kApproximated) loss.extend(entry.place, entry.what, entry.why);
    }
    if (said.empty()) return {};
    loss.extend("robot", words_of(said), "");
  } catch (const std::exception& error) {
    for (const auto& entry : written.entries()) {
      entry.fate == Fate::kApproximated ? loss.approximate(entry.place, entry.what, entry.why)
                                        : loss.drop(entry.place, entry.what, entry.why);
    }
    loss.drop("robot", "prehend's extension", error.what());
    return {};
  }
  return text;
}

std::string on_one_line(const std::string& block) { return JsonValue::parse(block).dump(); }

}  // namespace prehend::robot::formats
