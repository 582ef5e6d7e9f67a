#include "prehend/robot/formats/collada_losses.h"

#include <string>

#include <fmt/format.h>

#include "prehend/robot/formats/collada_shape_writer.h"

namespace prehend::robot::formats {
namespace {

using Kind = JointDescription::Kind;

void tell_losses_of_extras(const RobotDescription& robot, LossReport& loss) {
  const std::string gone = "what it names is not there";
  for (const Actuator& one : robot.actuators) {
    if (robot.joint(one.joint) && !one.name.empty()) {
      loss.keep("actuator");
    } else {
      loss.drop("actuator '" + one.name + "'", "actuator",
                one.name.empty() ? "it has no name" : gone);
    }
  }
  for (const Sensor& one : robot.sensors) {
    if (robot.link(one.link)) {
      loss.keep("sensor");
    } else {
      loss.drop("sensor '" + one.name + "'", one.kind, gone);
    }
  }
  for (const Manipulator& one : robot.manipulators) {
    if (!robot.link(one.base) || !robot.link(one.tip)) {
      loss.drop("manipulator '" + one.name + "'", "manipulator", gone);
      continue;
    }
    loss.keep("manipulator");
    for (const auto& [joint, direction] : one.closing) {
      if (!robot.joint(joint)) {
        loss.drop("manipulator '" + one.name + "'", "joint '" + joint + "'", gone);
      }
    }
  }
  for (const auto& [first, second] : robot.disabled_collisions) {
    if (!robot.link(first) || !robot.link(second)) {
      loss.drop("robot", "pair '" + first + "', '" + second + "' that may touch", gone);
    }
  }
}

}  // namespace

bool has_axis(const JointDescription& joint) {
  return joint.kind == Kind::kRevolute || joint.kind == Kind::kPrismatic;
}

bool is_held(const JointDescription& joint) {
  return has_axis(joint) && joint.lower == 0.0 && joint.upper == 0.0;
}

void tell_collada_losses(const RobotDescription& robot, LossReport& loss) {
  for (const LinkDescription& link : robot.links) {
    const std::string place = "link '" + link.name + "'";
    loss.keep("link");
    for (const bool is_seen : {true, false}) {
      for (const Shape& shape : is_seen ? link.visuals : link.collisions) {
        const char* what = is_seen ? "visual" : "collision";
        if (shape.kind == Shape::Kind::kPlane && is_seen) {
          loss.drop(place, "visual (plane)", "a mesh has an end");
        } else if (!is_in_collada(shape, is_seen)) {
          const bool is_mesh = shape.kind == Shape::Kind::kMesh;
          loss.drop(place, is_mesh ? fmt::format("{} (mesh '{}')", what, shape.mesh) : what,
                    is_mesh ? "it could not be read" : "it has no size");
        } else {
          loss.keep(what);
          if (!is_seen && shape.kind != Shape::Kind::kMesh &&
              (shape.color || !shape.material.empty())) {
            loss.drop(place, "material of a solid that is touched", "meshes alone have some there");
          }
        }
      }
    }
    if (link.inertial && !is_heavy(link)) {
      loss.drop(place, "inertial of no mass", "1e-9 kg and less is read as none");
    }
  }
  for (const JointDescription& joint : robot.joints) {
    const std::string place = "joint '" + joint.name + "'";
    loss.keep("joint");
    if (joint.kind == Kind::kFloating || joint.kind == Kind::kPlanar) {
      loss.drop(place, joint.kind == Kind::kPlanar ? "planar joint" : "floating joint",
                "programs that read COLLADA know none: it is fixed");
    } else if (is_held(joint)) {
      loss.approximate(place, "limits of 0", "fixed: they leave it no way");
    }
    if (has_axis(joint) && joint.lower.has_value() != joint.upper.has_value()) {
      loss.approximate(place, "limit on one side", "none: programs that read COLLADA need both");
    }
    if (joint.follows && !joint.follows->is_linear()) {
      loss.approximate(place, "follows by a polynomial",
                       words_of_line(coupling_line(robot, joint), joint));
    }
    if (joint.follows && !robot.joint(joint.follows->joint)) {
      loss.drop(place, "follows '" + joint.follows->joint + "'", "that joint is not there");
    }
  }
  for (const Loop& one : robot.loops) {
    loss.drop("loop '" + one.name + "'", "closed loop", "programs that read COLLADA leave it open");
  }
  for (const Posture& one : robot.postures) {
    loss.drop("posture '" + one.name + "'", "posture", "COLLADA has none");
  }
  tell_losses_of_extras(robot, loss);
}

}  // namespace prehend::robot::formats
