#pragma once

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "prehend/geometry/rigid_transform.h"
#include "prehend/robot/formats/tracked_xml.h"

// Parts that COLLADA's kinematics and its shapes have in common.
namespace prehend::robot::formats {

/// The type and the profile of the <extra> that has prehend's extension.
inline constexpr const char* kColladaExtension = "prehend";

/// Kinds of sensors here, and OpenRAVE's types of them; others have one name.
inline constexpr std::array<std::pair<std::string_view, std::string_view>, 3> kColladaSensorTypes{
    {{"camera", "base_pinhole_camera"}, {"force_torque", "base_force6d"}, {"imu", "base_imu"}}};

/// "kmodel1/joint0/axis0" from its end: 0 is "axis0"; empty: there is none.
std::string part_of(const std::string& path, std::size_t from_end);

/// What an element is called, and what it is an instance of, count as kept: of those whose place
/// says it already.
void know_names(const XmlElement& element);

/// The number of an element, or of the <float> in it.
std::optional<double> number_in(const std::optional<XmlElement>& element);

/// The angle [rad] of degrees as they are written: COLLADA has angles in these. Each number of
/// radians is one of some text, since more digits count than a double has, where long double has
/// more; doubles alone miss 9 % of all radians. @pre `degrees` is a number
double radians_of_degrees(std::string_view degrees);
/// The angle [rad] of an element, or of the <float> in it.
std::optional<double> angle_in(const std::optional<XmlElement>& element);

/// An element's <bool>, or `otherwise`.
bool bool_in(const std::optional<XmlElement>& element, bool otherwise);

/// The steps <translate>, <rotate> and <matrix> in an element, in their order.
/// @param length metres of the file's unit
geometry::RigidTransform collada_steps(const XmlElement& element, double length);

/// A formula's value, and how much it changes for one of its variable: so a line's slope is the
/// number that is written, and no difference of two values.
struct FormulaValue {
  double value = 0, slope = 0;
};

/// A formula's MathML at values of joints, by their sids. @throws geometry::InputError for what is
/// none, or knows no such operator
FormulaValue evaluated(const XmlElement& element,
                       const std::function<FormulaValue(const std::string&)>& value);

}  // namespace prehend::robot::formats
