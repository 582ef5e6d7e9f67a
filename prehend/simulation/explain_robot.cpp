#include <algorithm>
#include <map>

#include "prehend/simulation/explain_parts.h"
#include "prehend/simulation/robot_scene.h"
#include "prehend/simulation/robot_world_implementation.h"

namespace prehend::simulation {
namespace {

constexpr double kSleepError = 1e-6;  // m, RobotWorld.WhatSleepsWouldHaveSettledLittle

// "3 boxes"
std::string counted(std::size_t count, const std::string& name) {
  const char* plural = name == "box" || name == "mesh" ? "es" : "s";
  return std::to_string(count) + " " + name + (count == 1 ? "" : plural);
}

std::string shapes_text(const RobotBodies& robot, const std::vector<bool>& chosen) {
  std::map<std::string, std::size_t> counts;
  for (const RobotBodies::Part& part : robot.parts) {
    if (!chosen[static_cast<std::size_t>(part.body)]) continue;
    using Kind = engines::EngineShape::Kind;
    ++counts[part.solid                         ? "mesh"
             : part.shape.kind == Kind::kBox    ? "box"
             : part.shape.kind == Kind::kSphere ? "ball"
                                                : "cylinder"];
  }
  std::string all;
  for (const auto& [name, count] : counts) all += (all.empty() ? "" : ", ") + counted(count, name);
  return all.empty() ? "no shapes" : all;
}

// "flat, 6 x 14 texels", "laid on its surface, 24 texels (7 x 4 without 4)", "of a mesh, 145
// texels"
std::string cells_text(const robot::HandPad& pad) {
  const contact::PadLayout& layout = *pad.layout;
  const std::string grid =
      std::to_string(pad.model.rows) + " x " + std::to_string(pad.model.columns);
  if (layout.is_flat()) return "flat, " + grid + " texels";
  const std::size_t cells = layout.cells();
  if (layout.rows() == 0) return "a mesh's surface, " + std::to_string(cells) + " texels";
  if (cells == layout.size()) return "laid on its surface, " + grid + " texels";
  return "laid on its surface, " + std::to_string(cells) + " texels (" + grid + " without " +
         std::to_string(layout.size() - cells) + ")";
}

}  // namespace

void RobotWorld::Implementation::explain_arm(Explanation& out) const {
  std::vector<bool> of_arm;
  for (std::size_t b = 0; b < robot.bodies.size(); ++b)
    of_arm.push_back(!is_hands(static_cast<int>(b)));
  if (!arm) {
    out.modelled.push_back({"carrier", "moves the palm along straight lines, whatever pushes it"});
    return;
  }
  out.modelled.push_back(
      {"arm",
       explained_text("%zu joints on prescribed paths, each within its speed and %g rad/s^2, by "
                      "position loops of %g rad/s; %s that touch objects and table",
                      arm->chain().joints().size(), options.arm.acceleration, options.arm.bandwidth,
                      shapes_text(robot, of_arm).c_str())});
  out.left_out.push_back({"the arm's yielding", "", kNoBound, "m", "not known",
                          "its servos are far stiffer than fingers and contacts, and inertias of "
                          "industrial arms are not published"});
}

void RobotWorld::Implementation::explain_hand(Explanation& out) const {
  std::vector<bool> of_hand;
  for (std::size_t b = 0; b < robot.bodies.size(); ++b)
    of_hand.push_back(is_hands(static_cast<int>(b)));
  out.modelled.push_back(
      {"hand",
       explained_text("%s: %s, %s, %s, friction %g; the palm is carried, "
                      "fingers give way and are pushed; grasps are planned to close by %s",
                      hand_model.name.c_str(), counted(hand_model.fingers.size(), "finger").c_str(),
                      counted(robot.motors.size(), "motor").c_str(),
                      shapes_text(robot, of_hand).c_str(), hand_model.friction,
                      hand_model.closing_method().c_str())});
  for (const RobotBodies::Motor& motor : robot.motors) {
    const char* unit = motor.slides ? "m" : "rad";
    const double yield = motor.slides ? options.hand.sliding_yield : options.hand.yield;
    if (motor.model) {
      out.modelled.push_back(
          {"motor " + motor.name,
           explained_text("at most %g %s and %g %s/s, by the actuator %s", motor.max_effort,
                          motor.slides ? "N" : "N m", motor.max_velocity, unit,
                          motor.model->actuator.c_str())});
      continue;
    }
    out.modelled.push_back(
        {"motor " + motor.name,
         explained_text("at most %g %s and %g %s/s; gives way by %g %s under that, holds %g times "
                        "it; gear that locks itself",
                        motor.max_effort, motor.slides ? "N" : "N m", motor.max_velocity, unit,
                        yield, unit, options.hand.holding)});
  }
  for (const robot::Breakaway& breakaway : hand_model.breakaways) {
    const auto& joints = hand_model.model.joints;
    out.modelled.push_back(
        {"clutch of " + joints[static_cast<std::size_t>(breakaway.joint)].name,
         explained_text("follows %s until contact holds that one with %g N m, then turns alone",
                        joints[static_cast<std::size_t>(breakaway.leader)].name.c_str(),
                        breakaway.torque)});
  }
  const bool all_known = std::all_of(robot.motors.begin(), robot.motors.end(),
                                     [](const auto& motor) { return motor.model.has_value(); });
  if (!all_known) {
    out.left_out.push_back({"the motors' currents", "", kNoBound, "N m", "not known",
                            "hands say what their joints can, not what their motors draw; where "
                            "the hand's file has no `motor`"});
  }
  out.left_out.push_back(
      {"surfaces between points", "", kNoBound, "m", "not known",
       explained_text("links and objects touch by points, %g mm apart on fingers, %g mm on the arm",
                      1e3 * RobotTouch::kPointSpacing, 1e3 * RobotTouch::kArmSpacing)});
}

void RobotWorld::Implementation::explain_sensors(Explanation& out) const {
  const std::string electronics = options.tactile.about();
  if (hand_model.pads.empty()) {
    out.modelled.push_back({"pads", "none: nothing is felt but at the wrist and by the motors"});
  }
  for (std::size_t i = 0; i < hand_model.pads.size(); ++i) {
    const robot::HandPad& pad = hand_model.pads[i];
    const contact::TexelLaw law = options.tactile.law_of(pad.model, static_cast<int>(i));
    out.modelled.push_back(
        {"pad " + pad.name,
         explained_text("on %s, %s of %.3g cm2, %g mm of foam: %s; electronics %s",
                        hand_model.model.links[static_cast<std::size_t>(pad.link)].name.c_str(),
                        cells_text(pad).c_str(), 1e4 * pad.layout->area(),
                        1e3 * pad.layout->thickness(), law_text(law).c_str(),
                        electronics.c_str())});
  }
  out.modelled.push_back({"wrist", options.wrench ? "force and torque sensor with its errors"
                                                  : "forces and torques as they are"});
}

void RobotWorld::Implementation::explain_objects(Explanation& out) const {
  out.modelled.push_back(
      {"table", explained_text("the plane z = 0, friction %g", options.table_friction)});
  out.modelled.push_back(
      {"contacts", explained_text("springs of %g N/m and dampers of %g N s/m at each point but the "
                                  "pads', elasto-plastic bristles for friction",
                                  options.contact_stiffness, options.contact_damping)});
  for (const Thing& thing : things) {
    const BodyModel& model = thing.model;
    const contact::Shape::Kind kind = model.felt.shape.kind();
    out.modelled.push_back(
        {model.name,
         explained_text("%s of %g kg; robot and pads meet %s; %zu points touch the table, %zu the "
                        "robot and others; mesh of %zu triangles",
                        model.is_static ? "fixed body" : "rigid body", model.mass, shape_text(kind),
                        model.hull_points.size(), model.surface_points.size(),
                        model.mesh->triangles.size())});
    explain_primitive(model, "robot and pads meet it as ", out);
  }
  if (options.sleep && !things.empty()) {
    out.left_out.push_back({"objects at rest", "sleep", kSleepError, "m",
                            explained_text("%g um of further settling, as measured; a slower roll "
                                           "is stopped",
                                           1e6 * kSleepError),
                            explained_text("once an object has stood still for %g s and nothing "
                                           "that moves touches it",
                                           kStillTime)});
  }
  out.left_out.push_back({"objects' and fingers' bending", "", kNoBound, "m", "not known",
                          "only the pads' foam gives way; all else is rigid but for springs at the "
                          "points that touch"});
  if (!options.sleep) out.rules_off.emplace_back("sleep");
  if (!options.primitives) out.rules_off.emplace_back("primitives");
}

Explanation RobotWorld::explained() const {
  const Implementation& world = *implementation_;
  Explanation out;
  out.modelled.push_back(
      {"engine", "native (multibody): fingers, objects, pads and contacts in one system"});
  out.modelled.push_back(
      {"time", explained_text("implicit steps of %g ms, first order (backward Euler); at most %d "
                              "solutions each",
                              1e3 * world.options.step, engines::Multibody::kMostIterations)});
  world.explain_arm(out);
  world.explain_hand(out);
  world.explain_sensors(out);
  world.explain_objects(out);
  return out;
}

Explanation explain_robot(const Scene& scene) {
  const robot::Platform platform = robot::read_platform(scene.robot);
  Explanation out = RobotWorld(platform, scene, scene.robot_home).explained();
  for (const std::string& remark : platform.model.remarks) out.remarks.push_back(remark);
  for (const SceneRemark& remark : check_for_robot(scene, platform)) {
    out.remarks.push_back(remark.text);
  }
  return out;
}

}  // namespace prehend::simulation
