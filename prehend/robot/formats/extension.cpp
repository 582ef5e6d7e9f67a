#include "prehend/robot/formats/extension.h"

#include <algorithm>
#include <set>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "prehend/geometry/errors.h"
#include "prehend/robot/formats/robot_record.h"
#include "prehend/text/nearest_match.h"

namespace prehend::robot::formats {
namespace {

using geometry::InputError;
using geometry::RigidTransform;
using Pair = std::pair<std::string, std::string>;

constexpr int kExtensionVersion = 1;

/// Names of what the format needed besides, and the robot does not have.
struct Without {
  std::vector<std::string> links, joints, loops, actuators, sensors, manipulators, postures;
  std::vector<Pair> disabled_collisions;
};

template <class Visitor>
void fields(Visitor& v, Part<Visitor, Without>& without) {
  v.list("links", without.links);
  v.list("joints", without.joints);
  v.list("loops", without.loops);
  v.list("actuators", without.actuators);
  v.list("sensors", without.sensors);
  v.list("manipulators", without.manipulators);
  v.list("postures", without.postures);
  v.list("disabled_collisions", without.disabled_collisions);
}

template <class Record>
JsonValue json_of_record(const Record& record) {
  LossReport unused;
  JsonWriter writer("", unused);
  fields(writer, record);
  return std::move(writer.object());
}

/// Keys of `patch` onto an object's; null takes one away.
void merge_keys(JsonValue& object, const JsonValue& patch) {
  for (const auto& item : patch.items()) {
    if (item.value().is_null()) {
      object.erase(item.key());
    } else {
      object[item.key()] = item.value();
    }
  }
}

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
std::vector<std::string> names_in(const std::vector<Record>& records) {
  std::vector<std::string> names;
  for (const Record& one : records) names.push_back(one.name);
  return names;
}

template <class Record>
std::ptrdiff_t count_of(const std::vector<Record>& records, const std::string& name) {
  return std::count_if(records.begin(), records.end(),
                       [&](const Record& one) { return one.name == name; });
}

template <class Record>
Record* record_named(std::vector<Record>& records, const std::string& name) {
  const auto found = std::find_if(records.begin(), records.end(),
                                  [&](const Record& one) { return one.name == name; });
  return found == records.end() ? nullptr : &*found;
}

bool is_same_pair(const Pair& one, const Pair& other) {
  return one == other || (one.first == other.second && one.second == other.first);
}

/// A fixed joint that only says where the child of the one above it stands goes into that.
/// @returns why it cannot; empty: it did
std::string merge_joint(RobotDescription& robot, const std::string& name) {
  const JointDescription* found = robot.joint(name);
  if (!found || found->kind != JointDescription::Kind::kFixed) return "is no fixed joint";
  const JointDescription fixed = *found;
  const LinkDescription* between = robot.link(fixed.parent);
  if (!between || between->inertial || !between->visuals.empty() || !between->collisions.empty()) {
    return "hangs on a link that is more than a frame";
  }
  JointDescription* above = nullptr;
  for (JointDescription& joint : robot.joints) {
    if (joint.child == fixed.parent) above = &joint;
    if (joint.parent == fixed.parent && joint.name != name) return "is not alone on its link";
  }
  if (!above) return "has no joint above it";
  above->X_JC = above->X_JC * fixed.X_PJ * fixed.X_JC;
  above->child = fixed.child;
  std::erase_if(robot.joints, [&](const auto& joint) { return joint.name == name; });
  std::erase_if(robot.links, [&](const auto& link) { return link.name == fixed.parent; });
  return {};
}

// What a file's text says but for rounding is as the robot has it, and so not in the block.

bool is_near(const RigidTransform& one, const RigidTransform& other) {
  constexpr double kRounding = 1e-11;
  const double size = std::max(1.0, other.translation().cwiseAbs().maxCoeff());
  return (one.matrix() - other.matrix()).cwiseAbs().maxCoeff() <= kRounding * size;
}

void take_rounded(Shape& plain, const Shape& robot) {
  if (is_near(plain.X_LS, robot.X_LS)) plain.X_LS = robot.X_LS;
  if (!plain.color || !robot.color) return;
  constexpr double kOfFloats = 1e-6;
  double most = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    most = std::max(most, std::abs((*plain.color)[i] - (*robot.color)[i]));
  }
  if (most <= kOfFloats) plain.color = robot.color;
}

void take_rounded(std::optional<Inertial>& plain, const std::optional<Inertial>& robot) {
  if (!plain || !robot) return;
  const auto in_link = [](const Inertial& one) -> Eigen::Matrix3d {
    return one.X_LI.linear() * one.inertia * one.X_LI.linear().transpose();
  };
  constexpr double kRounding = 1e-9, kPlace = 1e-12;
  const Eigen::Matrix3d its = in_link(*robot);
  const bool is_same = std::abs(plain->mass - robot->mass) <= kPlace * robot->mass &&
                       (plain->X_LI.translation() - robot->X_LI.translation()).norm() <= kPlace &&
                       (in_link(*plain) - its).norm() <= kRounding * its.norm();
  if (is_same) plain = robot;
}

/// A joint's frame as far as it matters: turned as the child is, or at the child.
JointDescription as_it_moves(JointDescription joint) {
  using Kind = JointDescription::Kind;
  const bool has_place = joint.kind != Kind::kFixed && joint.kind != Kind::kFloating;
  const RigidTransform X_JK =
      has_place ? geometry::make_transform(Eigen::Quaterniond(joint.X_JC.linear()),
                                           Eigen::Vector3d::Zero())
                : joint.X_JC;
  joint.X_PJ = joint.X_PJ * X_JK;
  joint.X_JC = X_JK.inverse() * joint.X_JC;
  joint.axis_J = X_JK.linear().transpose() * joint.axis_J;
  return joint;
}

void take_rounded(JointDescription& plain, const JointDescription& robot) {
  using Kind = JointDescription::Kind;
  const bool has_axis =
      robot.kind != Kind::kFixed && robot.kind != Kind::kFloating && robot.kind != Kind::kBall;
  const JointDescription one = as_it_moves(plain), other = as_it_moves(robot);
  constexpr double kRounding = 1e-11;
  const bool is_same_axis =
      !has_axis || (one.axis_J - other.axis_J).cwiseAbs().maxCoeff() <= kRounding;
  if (plain.kind == robot.kind && is_same_axis && is_near(one.X_PJ, other.X_PJ) &&
      is_near(one.X_JC, other.X_JC)) {
    plain.X_PJ = robot.X_PJ;
    plain.X_JC = robot.X_JC;
    plain.axis_J = robot.axis_J;
    return;
  }
  if (is_near(plain.X_PJ, robot.X_PJ)) plain.X_PJ = robot.X_PJ;
  if (is_near(plain.X_JC, robot.X_JC)) plain.X_JC = robot.X_JC;
  if (!has_axis || (plain.axis_J - robot.axis_J).cwiseAbs().maxCoeff() <= kRounding) {
    plain.axis_J = robot.axis_J;
  }
}

void take_rounded(Loop& plain, const Loop& robot) {
  if (is_near(plain.X_FirstLoop, robot.X_FirstLoop)) plain.X_FirstLoop = robot.X_FirstLoop;
}
void take_rounded(Sensor& plain, const Sensor& robot) {
  if (is_near(plain.X_LS, robot.X_LS)) plain.X_LS = robot.X_LS;
}
void take_rounded(Actuator&, const Actuator&) {}
void take_rounded(Manipulator&, const Manipulator&) {}
void take_rounded(Posture&, const Posture&) {}

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
    const auto missing = [](const std::vector<Pair>& of, const std::vector<Pair>& in) {
      std::vector<Pair> all;
      std::copy_if(of.begin(), of.end(), std::back_inserter(all), [&](const Pair& one) {
        return std::none_of(in.begin(), in.end(),
                            [&](const Pair& other) { return is_same_pair(one, other); });
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

/// Applies a block, path by path.
class ExtensionReader {
 public:
  ExtensionReader(const JsonValue& block, const std::string& file, RobotDescription& robot,
                  LossReport& loss)
      : reader_(block, "", file, loss), file_(file), robot_(robot), loss_(loss) {}

  void apply() {
    int version = 0;
    reader_.field("version", version);
    if (version != kExtensionVersion) {
      reader_.fail("version", std::to_string(version) + " is none that is known",
                   "This reads version " + std::to_string(kExtensionVersion));
    }
    reader_.field("name", robot_.name, std::string(robot_.name));
    std::vector<std::string> merged;
    reader_.list("merged", merged);
    std::optional<Without> without;
    reader_.field("without", without);
    for (std::size_t i = 0; i < merged.size(); ++i) {
      const std::string wrong = merge_joint(robot_, merged[i]);
      if (!wrong.empty()) {
        reader_.fail("merged[" + std::to_string(i) + "]", "joint '" + merged[i] + "' " + wrong,
                     "Take it out of the list");
      }
    }
    if (without) take_away(*without);
    records("links",
            [&](const JsonValue& entry, const std::string& path) { apply_link(entry, path); });
    records("joints",
            [&](const JsonValue& entry, const std::string& path) { apply_joint(entry, path); });
    check_couplings();
    list("loops", robot_.loops, [&](const Loop& loop, const std::string& path) {
      needs_link(loop.first, path + ".first");
      needs_link(loop.second, path + ".second");
    });
    list("actuators", robot_.actuators, [&](const Actuator& actuator, const std::string& path) {
      // One that pulls at a tendon is of no joint.
      if (!actuator.joint.empty()) needs_joint(actuator.joint, path + ".joint");
    });
    list("sensors", robot_.sensors, [&](const Sensor& sensor, const std::string& path) {
      needs_link(sensor.link, path + ".link");
    });
    list("manipulators", robot_.manipulators, [&](const Manipulator& one, const std::string& path) {
      needs_link(one.base, path + ".base");
      needs_link(one.tip, path + ".tip");
      for (const auto& [joint, way] : one.closing) needs_joint(joint, path + ".closing");
    });
    list("postures", robot_.postures, [&](const Posture& posture, const std::string& path) {
      for (const auto& [joint, at] : posture.positions) needs_joint(joint, path + ".positions");
    });
    apply_pairs();
    reader_.finish();
  }

 private:
  void needs_link(const std::string& name, const std::string& path) const {
    if (robot_.link(name)) return;
    reader_.fail(path, "there is no link '" + name.substr(0, 80) + "'",
                 text::nearest_match_mend(name.substr(0, 80), names_in(robot_.links)));
  }
  void needs_joint(const std::string& name, const std::string& path) const {
    if (robot_.joint(name)) return;
    reader_.fail(path, "there is no joint '" + name.substr(0, 80) + "'",
                 text::nearest_match_mend(name.substr(0, 80), names_in(robot_.joints)));
  }

  template <class Record>
  Record parsed(const JsonValue& value, const std::string& path) {
    Record record;
    LossReport its;  // what is kept is counted once
    JsonReader reader(value, path, file_, its);
    fields(reader, record);
    reader.finish();
    for (const auto& entry : its.entries()) loss_.approximate(entry.place, entry.what, entry.why);
    return record;
  }

  template <class Record>
  void take_away(const char* key, std::vector<Record>& records,
                 const std::vector<std::string>& names) {
    for (std::size_t i = 0; i < names.size(); ++i) {
      const std::string& name = names[i];
      if (std::erase_if(records, [&](const Record& one) { return one.name == name; }) == 0) {
        reader_.fail(std::string("without.") + key + "[" + std::to_string(i) + "]",
                     "there is none called '" + name.substr(0, 80) + "'",
                     text::nearest_match_mend(name.substr(0, 80), names_in(records)));
      }
    }
  }

  void take_away(const Without& without) {
    take_away("links", robot_.links, without.links);
    take_away("joints", robot_.joints, without.joints);
    take_away("loops", robot_.loops, without.loops);
    take_away("actuators", robot_.actuators, without.actuators);
    take_away("sensors", robot_.sensors, without.sensors);
    take_away("manipulators", robot_.manipulators, without.manipulators);
    take_away("postures", robot_.postures, without.postures);
    for (const Pair& pair : without.disabled_collisions) {
      std::erase_if(robot_.disabled_collisions,
                    [&](const Pair& one) { return is_same_pair(one, pair); });
    }
  }

  /// Calls `apply` with each object of a list that has a name.
  template <class Apply>
  void records(const char* key, const Apply& apply) {
    std::vector<JsonValue> entries;
    reader_.list(key, entries);
    for (std::size_t i = 0; i < entries.size(); ++i) {
      const std::string path = std::string(key) + "[" + std::to_string(i) + "]";
      if (!entries[i].is_object()) reader_.fail(path, "is no object", "Write { ... }");
      const auto name = entries[i].find("name");
      if (name == entries[i].end() || !name->is_string()) {
        reader_.fail(path, "has no 'name'", "Say of which it is");
      }
      apply(entries[i], path);
    }
  }

  /// Removes and returns a key.
  static JsonValue taken_out(JsonValue& object, const char* key) {
    const auto found = object.find(key);
    if (found == object.end()) return nullptr;
    JsonValue value = *found;
    object.erase(key);
    return value;
  }

  void apply_link(JsonValue entry, const std::string& path) {
    const auto name = entry["name"].get<std::string>();
    LinkDescription* link = record_named(robot_.links, name);
    if (!link) return needs_link(name, path);
    const JsonValue visuals = taken_out(entry, "visuals");
    const JsonValue collisions = taken_out(entry, "collisions");
    // Shapes are apart: what surface a mesh has, no text says.
    LinkDescription without_shapes = *link;
    without_shapes.visuals.clear();
    without_shapes.collisions.clear();
    JsonValue merged = json_of_record(without_shapes);
    merge_keys(merged, entry);
    auto patched = parsed<LinkDescription>(merged, path);
    patched.visuals = shapes(visuals, link->visuals, path + ".visuals");
    patched.collisions = shapes(collisions, link->collisions, path + ".collisions");
    *link = std::move(patched);
  }

  std::vector<Shape> shapes(const JsonValue& patches, const std::vector<Shape>& plain,
                            const std::string& path) {
    if (patches.is_null()) return plain;
    if (!patches.is_array()) reader_.fail(path, "is no list", "Write [ ... ]");
    std::vector<Shape> all;
    std::size_t at = 0;
    for (std::size_t i = 0; i < patches.size(); ++i) {
      const std::string its = path + "[" + std::to_string(i) + "]";
      JsonValue patch = patches[i];
      if (!patch.is_object()) reader_.fail(its, "is no object", "Write { ... }");
      const JsonValue count = taken_out(patch, "parts");
      if (!count.is_null() && !count.is_number_unsigned()) {
        reader_.fail(its + ".parts", "is no whole number", "Write how many shapes it is there");
      }
      const std::size_t parts = count.is_null() ? 1 : count.get<std::size_t>();
      if (parts > plain.size() - at) refuse_count(path, plain.size());
      JsonValue merged = parts > 0 ? json_of_record(plain[at]) : JsonValue::object();
      merge_keys(merged, patch);
      all.push_back(parsed<Shape>(merged, its));
      if (parts > 0 && all.back().mesh == plain[at].mesh) all.back().surface = plain[at].surface;
      at += parts;
    }
    if (at != plain.size()) refuse_count(path, plain.size());
    return all;
  }
  [[noreturn]] void refuse_count(const std::string& path, std::size_t count) const {
    reader_.fail(path,
                 fmt::format("is not of as many shapes as the file has there, which is {}", count),
                 "Mend the list, or take it away");
  }

  void apply_joint(JsonValue entry, const std::string& path) {
    const auto name = entry["name"].get<std::string>();
    const JsonValue was = taken_out(entry, "was");
    if (!was.is_null() && !was.is_string()) {
      reader_.fail(path + ".was", "is no text", "Write the joint's name in the file");
    }
    const std::string before = was.is_null() ? name : was.get<std::string>();
    JointDescription* joint = record_named(robot_.joints, before);
    const bool is_whole = entry.contains("parent") && entry.contains("child");
    if (!joint && (!is_whole || !was.is_null())) return needs_joint(before, path);
    JsonValue merged = joint ? json_of_record(*joint) : JsonValue::object();
    merge_keys(merged, entry);
    auto patched = parsed<JointDescription>(merged, path);
    needs_link(patched.parent, path + ".parent");
    needs_link(patched.child, path + ".child");
    if (patched.follows) followers_.emplace_back(patched.follows->joint, path + ".follows.joint");
    (joint ? *joint : robot_.joints.emplace_back()) = std::move(patched);
  }

  void check_couplings() const {
    for (const auto& [leader, path] : followers_) needs_joint(leader, path);
  }

  /// Merged with the file's of that name, or put behind them.
  template <class Record, class Check>
  void list(const char* key, std::vector<Record>& all, const Check& check) {
    const std::size_t of_file = all.size();
    records(key, [&](const JsonValue& entry, const std::string& path) {
      const auto name = entry["name"].get<std::string>();
      Record* found = nullptr;
      for (std::size_t i = 0; i < of_file; ++i) {
        if (all[i].name != name) continue;
        if (found) {
          reader_.fail(path, "the file has several that are called '" + name.substr(0, 80) + "'",
                       "Give each a name of its own");
        }
        found = &all[i];
      }
      JsonValue merged = found ? json_of_record(*found) : JsonValue::object();
      merge_keys(merged, entry);
      auto patched = parsed<Record>(merged, path);
      check(patched, path);
      (found ? *found : all.emplace_back()) = std::move(patched);
    });
  }

  void apply_pairs() {
    std::vector<Pair> pairs;
    reader_.list("disabled_collisions", pairs);
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      const std::string path = "disabled_collisions[" + std::to_string(i) + "]";
      needs_link(pairs[i].first, path);
      needs_link(pairs[i].second, path);
      const auto& known = robot_.disabled_collisions;
      if (std::none_of(known.begin(), known.end(),
                       [&](const Pair& one) { return is_same_pair(one, pairs[i]); })) {
        robot_.disabled_collisions.push_back(std::move(pairs[i]));
      }
    }
  }

  JsonReader reader_;
  const std::string& file_;
  RobotDescription& robot_;
  LossReport& loss_;
  std::vector<std::pair<std::string, std::string>> followers_;  // leader, path in the block
};

}  // namespace

std::string extension_text(const RobotDescription& robot,
                           const std::function<RobotDescription()>& read_again,
                           const LossReport& written, LossReport& loss) {
  using Fate = LossReport::Entry::Fate;
  for (const auto& [what, count] : written.kept()) loss.keep(what, count);
  JsonValue block = JsonValue::object();
  block["version"] = kExtensionVersion;
  try {
    const JsonValue said = ExtensionMaker(robot, read_again()).block();
    said.dump();  // refuses what is no UTF-8
    block.update(said);
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
  return json_text(block, loss);
}

std::string on_one_line(const std::string& block) { return JsonValue::parse(block).dump(); }

void apply_extension(const std::string& text, const std::string& place, RobotDescription& robot,
                     LossReport& loss) {
  const std::string file = place + ", prehend's extension";
  const JsonValue block = parse_json(text, file);
  ExtensionReader(block, file, robot, loss).apply();
  try {
    tree_order(robot);
  } catch (const InputError& error) {
    throw InputError(file + ": with it, the links are no tree: " + error.what(), "Mend it");
  }
}

void apply_extension(const std::vector<XmlElement>& blocks, RobotDescription& robot,
                     LossReport& loss) {
  if (blocks.empty()) return;
  if (blocks.size() > 1) {
    blocks[1].fail("<" + blocks[1].name() + "> is there twice", "Take one of them away");
  }
  apply_extension(blocks[0].text(), blocks[0].place(), robot, loss);
}

}  // namespace prehend::robot::formats
