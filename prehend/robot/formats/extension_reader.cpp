#include <algorithm>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "prehend/geometry/errors.h"
#include "prehend/robot/formats/extension.h"
#include "prehend/robot/formats/extension_parts.h"
#include "prehend/text/nearest_match.h"

namespace prehend::robot::formats {
namespace {

using geometry::InputError;

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

template <class Record>
Record* record_named(std::vector<Record>& records, const std::string& name) {
  const auto found = std::find_if(records.begin(), records.end(),
                                  [&](const Record& one) { return one.name == name; });
  return found == records.end() ? nullptr : &*found;
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
    for (const LinkPair& pair : without.disabled_collisions) {
      std::erase_if(robot_.disabled_collisions,
                    [&](const LinkPair& one) { return is_same_pair(one, pair); });
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
    std::vector<LinkPair> pairs;
    reader_.list("disabled_collisions", pairs);
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      const std::string path = "disabled_collisions[" + std::to_string(i) + "]";
      needs_link(pairs[i].first, path);
      needs_link(pairs[i].second, path);
      const auto& known = robot_.disabled_collisions;
      if (std::none_of(known.begin(), known.end(),
                       [&](const LinkPair& one) { return is_same_pair(one, pairs[i]); })) {
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
