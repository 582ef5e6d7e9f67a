#include "prehend/robot/formats/collada_reader.h"

#include <cmath>
#include <functional>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "prehend/geometry/errors.h"
#include "prehend/robot/formats/collada_bodies.h"
#include "prehend/robot/formats/collada_elements.h"
#include "prehend/robot/formats/collada_extras.h"
#include "prehend/robot/formats/collada_joint.h"

namespace prehend::robot::formats {
namespace {

using geometry::InputError;
using geometry::RigidTransform;
using Kind = JointDescription::Kind;

class ColladaReader {
 public:
  explicit ColladaReader(TrackedXml& document) : document_(document) {}

  RobotDescription read(const std::string& name) {
    const XmlElement root = document_.root();
    root.attribute("version");
    if (const auto asset = root.child("asset")) read_asset(*asset);
    const auto library = root.child("library_kinematics_models");
    if (!library) {
      root.fail("the document has no kinematics: it is a mesh, or COLLADA 1.4",
                "Read a robot's, of version 1.5");
    }
    if (const auto joints = root.child("library_joints")) {
      for (const XmlElement& one : joints->children("joint")) {
        library_joints_.emplace(one.attribute("id").value_or(""), one);
      }
    }
    const auto models = library->children("kinematics_model");
    if (models.empty()) root.fail("there is no kinematics_model", "Name a file that has one");
    robot_.name = models[0].attribute("name").value_or(name);
    full_names_ = collada_names_in(models[0]);
    read_model(models[0]);
    for (std::size_t i = 1; i < models.size(); ++i) models[i].drop("one model is read of a file");
    ColladaExtras extras(
        document_, length_, [this](const auto& path) { return link_named(path); },
        [this](const std::string& path) { return joint_of(path); });
    read_systems(root, extras);
    for (const XmlElement& extra : models[0].children("extra")) extras.read(extra, robot_);
    read_collada_bodies(
        document_, length_, [this](const std::string& axis) { return joint_of(axis); }, robot_);
    for (LinkDescription& link : robot_.links) {
      if (extras.untouched().count(link.name) != 0) link.collisions.clear();
    }
    for (const auto& [element, why] : std::initializer_list<std::pair<const char*, const char*>>{
             {"library_images", "textures are not kept"},
             {"library_lights", "the scene's lights are not kept"},
             {"library_cameras", "the scene's cameras are not kept"}}) {
      for (const XmlElement& one : root.children(element)) one.drop(why);
    }
    if (const auto scene = root.child("scene")) {
      for (const XmlElement& one : scene->children("instance_physics_scene")) {
        one.attribute("url");
        const auto all = root.child("library_physics_scenes");
        if (all && all->children("physics_scene").size() > 1) {
          one.drop("bodies are tied to links by all physics scenes, whichever is shown");
        }
      }
    }
    for (const XmlElement& one : root.children("extra")) {
      const std::string type = one.attribute("type").value_or("");
      if (type == kColladaExtension) continue;
      if (type != "library_sensors" && type != "library_actuators") {
        one.drop("it is of its writer's own");
      } else if (const auto technique = one.child("technique")) {
        technique->attribute("profile");
      }
    }
    return std::move(robot_);
  }

 private:
  void read_asset(const XmlElement& asset) {
    if (const auto unit = asset.child("unit")) {
      length_ = unit->number("meter").value_or(1);
      unit->attribute("name");
      if (!(length_ > 0)) unit->fail("a unit of no length", "Write metres");
    }
    bool is_own = false;
    for (const XmlElement& one : asset.children("contributor")) {
      if (const auto tool = one.child("authoring_tool")) {
        // The first writers had radians for speeds, as their reader keeps to.
        const std::string name = tool->text();
        speeds_in_degrees_ = name.find("OpenHRP3") == std::string::npos &&
                             name.find("URDF") == std::string::npos &&
                             name != "OpenRAVE Collada Writer";
        is_own = name == "prehend";
      }
    }
    if (!is_own) return asset.drop("who wrote it, and when");
    for (const char* known : {"created", "modified", "up_axis"}) asset.child(known);
  }

  void read_model(const XmlElement& model) {
    model.attribute("id");
    const auto technique = model.child("technique_common");
    if (!technique) model.fail("the kinematics_model has no technique_common", "Mend it");
    for (const XmlElement& one : technique->children("joint")) {
      const std::string sid = one.attribute("sid").value_or("");
      ColladaJoint joint = read_collada_joint(one, length_);
      if (full_names_.count(sid) != 0) joint.name = full_names_.at(sid);
      joints_[sid] = std::move(joint);
    }
    for (const XmlElement& one : technique->children("instance_joint")) {
      std::string url = one.attribute("url").value_or("");
      if (url.starts_with("#")) url.erase(0, 1);
      const auto found = library_joints_.find(url);
      if (found == library_joints_.end()) one.fail("joint '" + url + "' is not there", "Mend it");
      joints_[one.attribute("sid").value_or(url)] = read_collada_joint(found->second, length_);
    }
    for (const XmlElement& link : technique->children("link")) read_link(link, "", {}, 0);
    for (const XmlElement& one : technique->children("formula")) read_formula(one);
  }

  /// @param above the link that it hangs on, by `joint`; none: a root
  void read_link(const XmlElement& element, const std::string& above,
                 const std::pair<std::string, RigidTransform>& hung, int depth) {
    if (depth > 200) element.fail("links are too deep in one another", "Mend it");
    refuse_many_links(robot_.links.size() + 1, element.place());
    std::string name = element.attribute("name").value_or("");
    const std::string sid = element.attribute("sid").value_or("");
    if (full_names_.count(sid) != 0) name = full_names_.at(sid);
    if (name.empty()) name = sid.empty() ? fmt::format("link{}", robot_.links.size()) : sid;
    if (robot_.link(name)) {
      element.approximate("a second link '" + name + "' is called by its sid, too");
      name += "_" + sid;
    }
    if (!sid.empty()) link_of_sid_.emplace(sid, name);
    const RigidTransform X_own = collada_steps(element, length_);
    std::string parent = above;
    if (above.empty()) {
      robot_.links.push_back({name, {}, {}, {}});
    } else {
      const auto found = joints_.find(hung.first);
      if (found == joints_.end())
        element.fail("joint '" + hung.first + "' is not there", "Mend it");
      const ColladaJoint& joint = found->second;
      RigidTransform X = hung.second;
      if (joint.is_ball()) {
        JointDescription ball;
        ball.name = joint.name;
        if (robot_.joint(ball.name)) ball.name += "_" + hung.first;
        ball.kind = Kind::kBall;
        ball.parent = parent;
        ball.child = name;
        ball.X_PJ = X;
        ball.X_JC = X_own;
        for (const ColladaJoint::Axis& axis : joint.axes)
          of_axis_[hung.first + "/" + axis.sid] = ball.name;
        robot_.links.push_back({name, {}, {}, {}});
        robot_.joints.push_back(std::move(ball));
        return read_attachments(element, name, depth);
      }
      for (std::size_t i = 0; i < std::max<std::size_t>(joint.axes.size(), 1); ++i) {
        JointDescription one;
        const bool is_last = i + 1 >= joint.axes.size();
        one.name = joint.axes.size() > 1 ? fmt::format("{}_{}", joint.name, i) : joint.name;
        if (robot_.joint(one.name)) one.name += "_" + hung.first;
        one.parent = parent;
        one.child = is_last ? name : fmt::format("{}_between{}", name, i);
        one.X_PJ = X;
        X = RigidTransform::Identity();
        if (is_last) one.X_JC = X_own;
        if (!joint.axes.empty()) {
          const ColladaJoint::Axis& axis = joint.axes[i];
          one.kind = axis.turns ? Kind::kRevolute : Kind::kPrismatic;
          if (axis.lower == 0.0 && axis.upper == 0.0) {
            one.kind = Kind::kFixed;
          } else {
            one.axis_J = axis.direction;
            one.lower = axis.lower;
            one.upper = axis.upper;
          }
          of_axis_[hung.first + "/" + axis.sid] = one.name;
        }
        robot_.links.push_back({one.child, {}, {}, {}});
        parent = one.child;
        robot_.joints.push_back(std::move(one));
      }
    }
    read_attachments(element, name, depth);
  }

  void read_attachments(const XmlElement& element, const std::string& name, int depth) {
    for (const XmlElement& one : element.children("attachment_full")) {
      const std::string joint = part_of(one.needed("joint"), 0);
      const RigidTransform X = collada_steps(one, length_);
      const auto child = one.child("link");
      if (!child) {
        one.drop("nothing hangs on it");
        continue;
      }
      read_link(*child, name, {joint, X}, depth + 1);
    }
    for (const char* loop : {"attachment_start", "attachment_end"}) {
      for (const XmlElement& one : element.children(loop)) one.drop("closed loops are not read");
    }
  }

  JointDescription* joint_of(const std::string& axis_path) {
    // "kmodel/joint0/axis0", or a joint alone.
    for (const auto& key :
         {part_of(axis_path, 1) + "/" + part_of(axis_path, 0), part_of(axis_path, 0) + "/axis0"}) {
      const auto found = of_axis_.find(key);
      if (found == of_axis_.end()) continue;
      for (JointDescription& joint : robot_.joints) {
        if (joint.name == found->second) return &joint;
      }
    }
    return nullptr;
  }

  void read_formula(const XmlElement& element) {
    const auto target = element.child("target");
    const auto technique = element.child("technique_common");
    std::optional<XmlElement> param = target ? target->child("param") : std::nullopt;
    if (!param || !technique || technique->children().empty()) {
      return element.drop("the formula has no target, or says nothing");
    }
    JointDescription* driven = joint_of(param->text());
    if (!driven) return element.drop("its joint '" + param->text() + "' is not there");
    std::set<std::string> variables;
    const XmlElement math = technique->children()[0];
    const auto at = [&](double q) {
      return evaluated(math, [&](const std::string& name) {
        variables.insert(name);
        return FormulaValue{q, 1};
      });
    };
    const auto [zero, slope] = at(0);
    const double one = at(1).value, two = at(2).value;
    // Negated, since what is not finite is no line.
    const bool is_line = std::abs(two - 2 * one + zero) <= 1e-9 * (1 + std::abs(two));
    if (variables.size() != 1 || !is_line) {
      return element.drop("it is no linear formula of one joint");
    }
    JointDescription* leader = joint_of(*variables.begin() + "/axis0");
    if (!leader) leader = joint_of(*variables.begin());
    if (!leader) return element.drop("'" + *variables.begin() + "' in it is not there");
    // Constants are in radians and metres, whatever limits are in.
    driven->follows = Follows{leader->name, slope, zero};
    element.attribute("sid");
    for (const XmlElement& other : element.children("technique")) {
      if (!says_the_same(other, *driven->follows)) other.drop("its derivatives follow from it");
    }
  }

  /// Whether OpenRAVE's own technique of a formula has its line and that line's derivatives.
  static bool says_the_same(const XmlElement& technique, const Follows& line) {
    if (technique.attribute("profile").value_or("") != "OpenRAVE") return false;
    for (const XmlElement& equation : technique.children()) {
      const auto parts = equation.children();
      if (equation.name() != "equation" || parts.size() != 1) return false;
      const std::string type = equation.attribute("type").value_or("");
      equation.attribute("target");
      for (const double q : {0.0, 1.0}) {
        const auto at = [&](const std::string&) { return FormulaValue{q, 1}; };
        const double value = evaluated(parts[0], at).value;
        const double expected = type == "position"        ? line.at(q)
                                : type == "first_partial" ? line.multiplier()
                                                          : 0;
        if (!(std::abs(value - expected) <= 1e-9 * (1 + std::abs(expected)))) return false;
      }
    }
    return true;
  }

  void read_systems(const XmlElement& root, ColladaExtras& extras) {
    const auto library = root.child("library_articulated_systems");
    if (!library) return;
    std::map<std::string, JointDescription*> by_info;
    for (const XmlElement& system : library->children("articulated_system")) {
      if (const auto kinematics = system.child("kinematics")) {
        if (const auto technique = kinematics->child("technique_common")) {
          for (const XmlElement& info : technique->children("axis_info")) {
            JointDescription* joint = joint_of(info.attribute("axis").value_or(""));
            by_info[info.attribute("sid").value_or("")] = joint;
            if (joint) read_axis_info(info, *joint);
          }
        }
        for (const XmlElement& one : kinematics->children("formula")) read_formula(one);
      }
      for (const XmlElement& extra : system.children("extra")) extras.read(extra, robot_);
    }
    for (const XmlElement& system : library->children("articulated_system")) {
      const auto motion = system.child("motion");
      if (!motion) continue;
      const auto technique = motion->child("technique_common");
      if (!technique) continue;
      for (const XmlElement& info : technique->children("axis_info")) {
        const auto found = by_info.find(part_of(info.attribute("axis").value_or(""), 0));
        if (found == by_info.end() || !found->second) continue;
        const bool turns = found->second->kind != Kind::kPrismatic;
        const auto speed = info.child("speed");
        if (number_in(speed)) {
          const bool is_radians = turns && !speeds_in_degrees_;
          found->second->velocity =
              is_radians ? number_in(speed) : collada_limit(speed, turns, length_);
        }
        for (const char* other : {"acceleration", "deceleration", "jerk"}) {
          if (const auto one = info.child(other)) one->drop("accelerations are not kept");
        }
      }
    }
  }

  void read_axis_info(const XmlElement& info, JointDescription& joint) {
    const bool turns = joint.kind != Kind::kPrismatic;
    if (const auto limits = info.child("limits")) {
      // Soft limits, where they are numbers and not names.
      if (const auto min = limits->child("min"); min && min->child("float")) {
        joint.lower = collada_limit(min, turns, length_);
      }
      if (const auto max = limits->child("max"); max && max->child("float")) {
        joint.upper = collada_limit(max, turns, length_);
      }
    }
    for (const XmlElement& one : info.children("formula")) read_formula(one);
    const bool is_active = bool_in(info.child("active"), true);
    const bool is_locked = bool_in(info.child("locked"), false);
    if (joint.kind == Kind::kFixed) return;
    // What follows another is written so, too.
    joint.passive = !is_active && !joint.follows;
    if (is_locked) info.child("locked")->drop("where it is locked is not kept");
  }

  /// The link of "kmodel1/link0"; empty: it is not there.
  std::string link_named(const std::optional<std::string>& path) const {
    const auto found = link_of_sid_.find(part_of(path.value_or(""), 0));
    return found == link_of_sid_.end() ? std::string() : found->second;
  }

  TrackedXml& document_;
  RobotDescription robot_;
  double length_ = 1;  // m of the file's unit
  bool speeds_in_degrees_ = true;
  std::map<std::string, XmlElement> library_joints_;  // by id
  std::map<std::string, ColladaJoint> joints_;        // by sid
  std::map<std::string, std::string> of_axis_;        // joint's name by "joint/axis"
  std::map<std::string, std::string> link_of_sid_;
  std::map<std::string, std::string> full_names_;  // by sid, of names with spaces
};

}  // namespace

RobotDescription read_collada(TrackedXml& document, const std::string& name) {
  return ColladaReader(document).read(name);
}

}  // namespace prehend::robot::formats
