#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "prehend/geometry/errors.h"
#include "prehend/robot/at_line.h"
#include "prehend/robot/hand_model.h"
#include "prehend/robot/hand_pads_yaml.h"
#include "prehend/robot/pose_yaml.h"
#include "prehend/robot/yaml_entries.h"
#include "prehend/text/yaml_map.h"

namespace prehend::robot {
namespace {

using geometry::InputError;
using geometry::RigidTransform;

std::size_t place_of(int index) { return static_cast<std::size_t>(index); }

class HandReader {
 public:
  explicit HandReader(const std::filesystem::path& path) : path_(path) {}

  HandModel read() {
    const YAML::Node file = text::load_yaml_map(path_);
    if (!file["fingers"] && file["arm"]) {
      throw InputError(path_.string() + " is a platform, and no hand",
                       "Name the file that it names by `hand`");
    }
    if (!file["fingers"] && file["max_opening"]) {
      throw InputError(path_.string() + " is a gripper, and no hand",
                       "Write a hand's file that names it by `gripper`, as pg70.yaml does");
    }
    text::YamlMap map(file, path_, "hand");
    std::string palm, gripper;
    map.read("name", hand_.name);
    map.read("urdf", urdf_);
    map.read("palm", palm);
    map.read("friction", hand_.friction);
    map.read("gripper", gripper);
    map.read("closing", hand_.closing);
    const YAML::Node actuated = map.child("actuated"), fingers = map.child("fingers"),
                     pads = map.child("pads"), breakaway = map.child("breakaway"),
                     motor = map.child("motor"), tool = map.child("tool"),
                     preshapes = map.child("preshapes");
    map.finish();
    if (hand_.name.empty()) map.fail("name", "is missing", "Name the hand");
    if (urdf_.empty()) map.fail("urdf", "is missing", "Name the URDF file, relative to this one");
    if (palm.empty()) map.fail("palm", "is missing", "Name the palm's link");
    if (!(hand_.friction > 0)) map.fail("friction", "is not positive", "Give a coefficient");
    if (file["closing"] && hand_.closing.empty()) {
      map.fail("closing", "names no method", "Write pads, fingers or a plug-in's, or leave it out");
    }
    hand_.model = at_line(map, "urdf", [&] { return read_urdf(path_.parent_path() / urdf_); });
    hand_.palm = at_line(map, "palm", [&] { return hand_.model.link_index(palm); });
    set_palm_pose(map);
    read_actuated(map, actuated);
    if (!gripper.empty()) read_gripper(map, gripper);
    if (!fingers.IsDefined()) map.fail("fingers", "is missing", "List each finger's links");
    read_fingers(fingers);
    if (pads.IsDefined()) {
      read_hand_pads(pads, path_, path_.parent_path() / urdf_, hand_);
    }
    if (breakaway.IsDefined()) read_breakaways(breakaway);
    if (motor.IsDefined()) read_motors(motor);
    if (tool.IsDefined()) X_PG_ = read_pose(tool, path_, "hand.tool");
    if (!preshapes.IsDefined()) map.fail("preshapes", "is missing", "Give at least one");
    read_preshapes(preshapes);
    return std::move(hand_);
  }

 private:
  void read_gripper(const text::YamlMap& map, const std::string& file) {
    hand_.gripper =
        at_line(map, "gripper", [&] { return read_gripper_model(path_.parent_path() / file); });
    const auto fail = [&map](const std::string& what, const std::string& mend) {
      map.fail("gripper", ": " + what, mend);
    };
    if (hand_.size() != 1) {
      fail("a parallel gripper has one motor", "Actuate one joint, which the other finger mimics");
    }
    const Joint& joint = hand_.model.joints[place_of(hand_.actuated.front())];
    if (joint.kind != Joint::Kind::kPrismatic || joint.lower != 0 ||
        std::abs(2 * joint.upper - hand_.gripper->max_opening) > 1e-6) {
      fail("its max_opening of " + std::to_string(hand_.gripper->max_opening) +
               " m is not twice the way of joint '" + joint.name + "', which is 0 to " +
               std::to_string(joint.upper),
           "Give both the same opening: the joint is half of it");
    }
  }

  static std::vector<std::string> words(const text::YamlMap& map, const std::string& key,
                                        const YAML::Node& node) {
    std::vector<std::string> result;
    if (!node.IsSequence() || node.size() == 0) {
      map.fail(key, "is no list of names", "Write [one, other]");
    }
    for (const auto& entry : node) {
      if (!entry.IsScalar()) map.fail(key, "is no list of names", "Write [one, other]");
      result.push_back(entry.Scalar());
    }
    return result;
  }

  template <class Visit>
  void each(const YAML::Node& node, const std::string& place, Visit visit) {
    for_each_entry(node, path_, place, visit);
  }

  void set_palm_pose(const text::YamlMap& map) {
    for (int link = hand_.palm; const auto above = hand_.model.joint_above(link);) {
      const Joint& joint = hand_.model.joints[place_of(*above)];
      if (joint.kind != Joint::Kind::kFixed) {
        map.fail("palm", "moves by joint '" + joint.name + "'",
                 "Name a link that stands with the root");
      }
      hand_.X_HP = joint.X_PJ * hand_.X_HP;
      link = joint.parent;
    }
  }

  void read_actuated(const text::YamlMap& map, const YAML::Node& node) {
    if (!node.IsDefined()) map.fail("actuated", "is missing", "List the joints with a motor");
    for (const std::string& name : words(map, "actuated", node)) {
      const int joint = at_line(map, "actuated", [&] { return hand_.model.joint_index(name); });
      const Joint& moved = hand_.model.joints[place_of(joint)];
      if (moved.kind == Joint::Kind::kFixed || moved.mimic) {
        map.fail("actuated", "names '" + name + "', which does not move by itself",
                 "Name joints that are neither fixed nor mimic another");
      }
      if (!std::isfinite(moved.max_effort) || !std::isfinite(moved.max_velocity)) {
        const bool effort = !std::isfinite(moved.max_effort);
        map.fail(
            "actuated",
            "names '" + name + "', which has no " + (effort ? "effort" : "velocity") + " in " +
                urdf_,
            effort ? "Give its limit there, in N m or N" : "Give its limit there, in rad/s or m/s");
      }
      if (std::count(hand_.actuated.begin(), hand_.actuated.end(), joint) > 0) {
        map.fail("actuated", "names '" + name + "' twice", "Name it once");
      }
      hand_.actuated.push_back(joint);
    }
    for (std::size_t i = 0; i < hand_.model.joints.size(); ++i) {
      const Joint& joint = hand_.model.joints[i];
      const bool listed = std::count(hand_.actuated.begin(), hand_.actuated.end(), i) > 0;
      if (joint.kind != Joint::Kind::kFixed && !std::isfinite(joint.upper - joint.lower)) {
        map.fail("actuated",
                 ": joint '" + joint.name + "' of " + urdf_ +
                     " turns without end, and so would the hand",
                 "Give it type=\"revolute\" and a lower and an upper limit");
      }
      if (joint.kind != Joint::Kind::kFixed && !joint.mimic && !listed) {
        map.fail("actuated", "leaves out '" + joint.name + "', which moves",
                 "Name it too, or fix it in the URDF");
      }
    }
  }

  void read_fingers(const YAML::Node& node) {
    each(node, "hand.fingers",
         [&](text::YamlMap& map, const std::string& name, const YAML::Node& value) {
           Finger finger;
           finger.name = name;
           for (const std::string& link : words(map, name, value)) {
             const int index = at_line(map, name, [&] { return hand_.model.link_index(link); });
             const auto above = hand_.model.joint_above(index);
             const int parent = above ? hand_.model.joints[place_of(*above)].parent : -1;
             const bool follows =
                 finger.links.empty() ? may_begin_on(parent) : parent == finger.links.back();
             if (!follows) {
               map.fail(name, "lists '" + link + "', which does not follow on the link before",
                        "List the links from the palm's child to the tip");
             }
             for (const Finger& other : hand_.fingers) {
               if (std::count(other.links.begin(), other.links.end(), index) == 0) continue;
               map.fail(name, "lists '" + link + "', which '" + other.name + "' has already",
                        "A link is of one finger");
             }
             finger.links.push_back(index);
           }
           if (std::all_of(finger.links.begin(), finger.links.end(), [&](int link) {
                 return hand_.model.links[place_of(link)].shapes.empty();
               })) {
             map.fail(name, "could touch nothing: no link of it has a collision shape",
                      "Give its links <collision> in the URDF");
           }
           hand_.fingers.push_back(std::move(finger));
         });
  }

  /// Whether a finger may begin on `link`: the palm, or a link beneath it that several fingers
  /// share, as a metacarpal that moves.
  bool may_begin_on(int link) const {
    if (link == hand_.palm) return true;
    const auto& joints = hand_.model.joints;
    const auto children = std::count_if(joints.begin(), joints.end(),
                                        [&](const Joint& joint) { return joint.parent == link; });
    const auto above = hand_.model.joint_above(link);
    if (children < 2 || !above) return false;
    return may_begin_on(joints[place_of(*above)].parent);
  }

  void read_breakaways(const YAML::Node& node) {
    each(node, "hand.breakaway",
         [&](text::YamlMap& names, const std::string& name, const YAML::Node& value) {
           Breakaway breakaway;
           breakaway.joint = at_line(names, name, [&] { return hand_.model.joint_index(name); });
           const Joint& joint = hand_.model.joints[place_of(breakaway.joint)];
           if (!joint.mimic) {
             names.fail(name, "follows no joint in the URDF", "Give it a mimic there");
           }
           breakaway.leader = joint.mimic->joint;
           text::YamlMap map(value, path_, "hand.breakaway." + name);
           map.read("torque", breakaway.torque);
           map.read("rate", breakaway.rate);
           map.finish();
           if (!(breakaway.torque > 0)) map.fail("torque", "is not positive", "Give it in N m");
           if (!(breakaway.rate > 0)) map.fail("rate", "is not positive", "Give the ratio");
           hand_.breakaways.push_back(breakaway);
         });
  }

  int actuated_at(const text::YamlMap& map, const std::string& key,
                  const std::string& joint) const {
    return at_line(map, key, [&] { return hand_.actuated_index(joint); });
  }

  void read_motors(const YAML::Node& node) {
    each(node, "hand.motor",
         [&](text::YamlMap& names, const std::string& name, const YAML::Node& value) {
           const int joint = actuated_at(names, name, name);
           const std::string place = "hand.motor." + name;
           JointMotor motor;
           motor.place =
               path_.string() + ":" + std::to_string(value.Mark().line + 1) + ": " + place;
           text::YamlMap map(value, path_, place);
           map.read("actuator", motor.actuator);
           for (const auto& entry : value) {
             const std::string key = entry.first.IsScalar() ? entry.first.Scalar() : "";
             if (key == "actuator") continue;
             double number = 0;
             map.read(key, number);
             if (!std::isfinite(number)) map.fail(key, "is not finite", "Give a number");
             motor.values[key] = number;
           }
           map.finish();
           if (!hand_.motors.emplace(joint, std::move(motor)).second) {
             names.fail(name, "is there twice", "Describe its motor once");
           }
         });
  }

  Preshape::Closing read_closing(text::YamlMap& map, const std::string& name,
                                 const YAML::Node& value, const std::string& place) {
    Preshape::Closing closing;
    if (value.IsScalar()) {
      map.read(name, closing.rate);
      return closing;
    }
    text::YamlMap entry(value, path_, place + "." + name);
    std::string with;
    entry.read("rate", closing.rate);
    entry.read("with", with);
    entry.finish();
    if (!with.empty()) closing.with = actuated_at(entry, "with", with);
    return closing;
  }

  void read_preshapes(const YAML::Node& node) {
    each(node, "hand.preshapes",
         [&](text::YamlMap& names, const std::string& name, const YAML::Node& value) {
           const std::string place = "hand.preshapes." + name;
           text::YamlMap map(value, path_, place);
           Preshape preshape;
           preshape.name = name;
           preshape.X_PG = X_PG_;
           preshape.open = Eigen::VectorXd::Zero(hand_.size());
           preshape.closing.resize(hand_.actuated.size());
           const YAML::Node open = map.child("open"), closing = map.child("closing"),
                            tool = map.child("tool");
           map.finish();
           if (!open.IsDefined()) map.fail("open", "is missing", "Give the joints' positions");
           if (!closing.IsDefined()) map.fail("closing", "is missing", "Give the joints' rates");
           each(open, place + ".open",
                [&](text::YamlMap& joints, const std::string& joint, const YAML::Node&) {
                  joints.read(joint, preshape.open[actuated_at(joints, joint, joint)]);
                });
           each(closing, place + ".closing",
                [&](text::YamlMap& joints, const std::string& joint, const YAML::Node& entry) {
                  preshape.closing[place_of(actuated_at(joints, joint, joint))] =
                      read_closing(joints, joint, entry, place + ".closing");
                });
           if (tool.IsDefined()) preshape.X_PG = read_pose(tool, path_, place + ".tool");
           const std::string problem = hand_.limit_problem(hand_.all_positions(preshape.open));
           if (!problem.empty()) map.fail("open", ": " + problem, "Stay within the URDF's limits");
           const bool closes = std::any_of(preshape.closing.begin(), preshape.closing.end(),
                                           [](const auto& joint) { return joint.rate != 0; });
           if (!closes) map.fail("closing", "moves no joint", "Give a rate other than 0");
           if (std::any_of(hand_.preshapes.begin(), hand_.preshapes.end(),
                           [&](const Preshape& other) { return other.name == name; })) {
             names.fail(name, "is there twice", "Give it another name");
           }
           hand_.preshapes.push_back(std::move(preshape));
         });
  }

  std::filesystem::path path_;
  std::string urdf_;  // as the file names it
  HandModel hand_;
  RigidTransform X_PG_ = RigidTransform::Identity();
};

}  // namespace

HandModel read_hand_model(const std::filesystem::path& path) { return HandReader(path).read(); }

}  // namespace prehend::robot
