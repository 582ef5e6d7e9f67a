#include "prehend/robot/formats/xml_text.h"

#include <array>
#include <charconv>
#include <cmath>

namespace prehend::robot::formats {

std::string escaped(const std::string& text) {
  std::string result;
  for (const char c : text) {
    switch (c) {
      case '<':
        result += "&lt;";
        break;
      case '>':
        result += "&gt;";
        break;
      case '&':
        result += "&amp;";
        break;
      case '"':
        result += "&quot;";
        break;
      case '\n':  // a reader makes a blank of it, where it is not said so
        result += "&#10;";
        break;
      case '\r':
        result += "&#13;";
        break;
      case '\t':
        result += "&#9;";
        break;
      default:
        result += c;
    }
  }
  return result;
}

std::string escaped_text(const std::string& text) {
  std::string result;
  for (const char c : text) {
    if (c == '<' || c == '>' || c == '&') {
      result += c == '<' ? "&lt;" : c == '>' ? "&gt;" : "&amp;";
    } else {
      result += c;
    }
  }
  return result;
}

std::string number_text(double number) {
  std::array<char, 32> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), number == 0 ? 0 : number);
  return {text.data(), end.ptr};
}

std::string numbers_text(const Eigen::Vector3d& numbers) {
  return number_text(numbers.x()) + " " + number_text(numbers.y()) + " " + number_text(numbers.z());
}

Eigen::Vector3d roll_pitch_yaw(const Eigen::Matrix3d& R) {
  const double pitch = std::atan2(-R(2, 0), std::hypot(R(0, 0), R(1, 0)));
  // Pointing straight up or down, roll and yaw are about one axis: all of it is roll.
  constexpr double kStraight = 1e-12;
  if (std::hypot(R(0, 0), R(1, 0)) < kStraight) {
    return {std::atan2(R(2, 0) > 0 ? -R(0, 1) : R(0, 1), R(1, 1)), pitch, 0};
  }
  return {std::atan2(R(2, 1), R(2, 2)), pitch, std::atan2(R(1, 0), R(0, 0))};
}

geometry::RigidTransform from_roll_pitch_yaw(const Eigen::Vector3d& place,
                                             const Eigen::Vector3d& angles) {
  geometry::RigidTransform X = geometry::RigidTransform::Identity();
  X.translation() = place;
  X.rotate(Eigen::AngleAxisd(angles.z(), Eigen::Vector3d::UnitZ()));
  X.rotate(Eigen::AngleAxisd(angles.y(), Eigen::Vector3d::UnitY()));
  X.rotate(Eigen::AngleAxisd(angles.x(), Eigen::Vector3d::UnitX()));
  return X;
}

std::string pose_text(const geometry::RigidTransform& X) {
  return numbers_text(X.translation()) + " " + numbers_text(roll_pitch_yaw(X.linear()));
}

}  // namespace prehend::robot::formats
