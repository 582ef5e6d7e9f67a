#include "prehend/robot/formats/collada_elements.h"

#include <charconv>
#include <cmath>
#include <numbers>
#include <vector>

#include <Eigen/Geometry>

namespace prehend::robot::formats {
namespace {

using geometry::RigidTransform;

constexpr double kDegreeInRadians = std::numbers::pi / 180;

std::string local_name(const XmlElement& element) {
  const std::string name = element.name();
  return name.substr(name.find(':') == std::string::npos ? 0 : name.find(':') + 1);
}

}  // namespace

std::string part_of(const std::string& path, std::size_t from_end) {
  std::string rest = path;
  for (; from_end > 0; --from_end) {
    const std::size_t slash = rest.rfind('/');
    if (slash == std::string::npos) return {};
    rest.erase(slash);
  }
  return rest.substr(rest.rfind('/') + 1);
}

void know_names(const XmlElement& element) {
  for (const char* name : {"id", "sid", "name", "url"}) element.attribute(name);
}

std::optional<double> number_in(const std::optional<XmlElement>& element) {
  if (!element) return std::nullopt;
  if (const auto value = element->child("float")) return value->text_number();
  if (element->text().empty()) return std::nullopt;
  return element->text_number();
}

double radians_of_degrees(std::string_view degrees) {
  if (degrees.starts_with('+')) degrees.remove_prefix(1);
  long double number = 0;
  std::from_chars(degrees.data(), degrees.data() + degrees.size(), number);
  return static_cast<double>(number * (std::numbers::pi_v<long double> / 180));
}

std::optional<double> angle_in(const std::optional<XmlElement>& element) {
  if (!number_in(element)) return std::nullopt;
  const auto value = element->child("float");
  return radians_of_degrees(value ? value->text() : element->text());
}

bool bool_in(const std::optional<XmlElement>& element, bool otherwise) {
  const auto value = element ? element->child("bool") : std::nullopt;
  return value ? value->text() == "true" || value->text() == "1" : otherwise;
}

RigidTransform collada_steps(const XmlElement& element, double length) {
  RigidTransform X = RigidTransform::Identity();
  for (const XmlElement& one : element.children()) {
    if (one.name() == "translate") {
      const auto n = one.text_numbers(3);
      X.translate(length * Eigen::Vector3d(n[0], n[1], n[2]));
    } else if (one.name() == "rotate") {
      const auto n = one.text_numbers(4);
      const Eigen::Vector3d axis(n[0], n[1], n[2]);
      if (axis.norm() > 1e-9)
        X.rotate(Eigen::AngleAxisd(kDegreeInRadians * n[3], axis.normalized()));
    } else if (one.name() == "matrix") {
      const auto n = one.text_numbers(16);
      const Eigen::Matrix4d given =
          Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(n.data());
      X = X *
          geometry::make_transform(Eigen::Quaterniond(Eigen::Matrix3d(given.topLeftCorner<3, 3>())),
                                   length * given.topRightCorner<3, 1>());
    }
  }
  return X;
}

double evaluated(const XmlElement& element,
                 const std::function<double(const std::string&)>& value) {
  const std::string name = local_name(element);
  if (name == "cn") return element.text_number();
  if (name == "csymbol" || name == "ci") {
    element.attribute("encoding");
    return value(part_of(element.text(), 0));
  }
  if (name == "pi") return std::numbers::pi;
  const auto parts = element.children();
  if (name == "math") {
    if (parts.empty()) element.fail("the formula is empty", "Write one");
    return evaluated(parts[0], value);
  }
  if (name != "apply" || parts.empty()) {
    element.fail("<" + name + "> is none that is read in formulas", "Write apply, cn, csymbol");
  }
  const std::string operation = local_name(parts[0]);
  std::vector<double> numbers;
  for (std::size_t i = 1; i < parts.size(); ++i) numbers.push_back(evaluated(parts[i], value));
  const auto need = [&](std::size_t count) {
    if (numbers.size() != count)
      element.fail("<" + operation + "> has another count of parts", "Mend it");
  };
  if (operation == "plus" || operation == "times") {
    double result = operation == "plus" ? 0 : 1;
    for (const double number : numbers) {
      result = operation == "plus" ? result + number : result * number;
    }
    return result;
  }
  if (operation == "minus" && numbers.size() == 1) return -numbers[0];
  if (operation == "minus") {
    need(2);
    return numbers[0] - numbers[1];
  }
  if (operation == "divide") {
    need(2);
    return numbers[0] / numbers[1];
  }
  if (operation == "sin" || operation == "cos") {
    need(1);
    return operation == "sin" ? std::sin(numbers[0]) : std::cos(numbers[0]);
  }
  element.fail("the operator <" + operation + "> is not read", "Write plus, minus, times, divide");
}

}  // namespace prehend::robot::formats
