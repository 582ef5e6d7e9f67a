#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "prehend/robot/formats/tracked_xml.h"

namespace prehend::robot::formats {

/// A <joint> of a kinematics model or of a library: its axes move one after the other.
struct ColladaJoint {
  struct Axis {
    std::string sid;
    bool turns = true;  // else it slides
    Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();
    std::optional<double> lower, upper;  // rad or m
  };
  std::string name;
  std::vector<Axis> axes;

  /// Three axes without limits that are at right angles, as OpenRAVE writes it.
  bool is_ball() const;
};

/// @param length metres of the document's unit
/// @throws geometry::InputError with the place of what is no number
ColladaJoint read_collada_joint(const XmlElement& element, double length);

/// A limit or a speed, in radians where the joint turns, else in metres; none: there is none.
/// @param length metres of the document's unit
/// @throws geometry::InputError with the place of what is no number
std::optional<double> collada_limit(const std::optional<XmlElement>& element, bool turns,
                                    double length);

}  // namespace prehend::robot::formats
