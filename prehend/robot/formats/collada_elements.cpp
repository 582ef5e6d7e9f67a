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

/// @param element for words
FormulaValue applied(const XmlElement& element, const std::string& operation,
                     const std::vector<FormulaValue>& values) {
  const auto need = [&](std::size_t count) {
    if (values.size() != count)
      element.fail("<" + operation + "> has another count of parts", "Mend it");
  };
  FormulaValue result{operation == "times" ? 1.0 : 0.0, 0};
  if (operation == "plus") {
    for (const auto& [value, slope] : values) {
      result = {result.value + value, result.slope + slope};
    }
    return result;
  }
  if (operation == "times") {
    for (const auto& [value, slope] : values) {
      result = {result.value * value, result.slope * value + result.value * slope};
    }
    return result;
  }
  if (operation == "minus" && values.size() == 1) return {-values[0].value, -values[0].slope};
  if (operation == "minus") {
    need(2);
    return {values[0].value - values[1].value, values[0].slope - values[1].slope};
  }
  if (operation == "divide") {
    need(2);
    const double quotient = values[0].value / values[1].value;
    return {quotient, (values[0].slope - quotient * values[1].slope) / values[1].value};
  }
  if (operation == "sin" || operation == "cos") {
    need(1);
    const double sine = std::sin(values[0].value), cosine = std::cos(values[0].value);
    return operation == "sin" ? FormulaValue{sine, cosine * values[0].slope}
                              : FormulaValue{cosine, -sine * values[0].slope};
  }
  element.fail("the operator <" + operation + "> is not read", "Write plus, minus, times, divide");
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

FormulaValue evaluated(const XmlElement& element,
                       const std::function<FormulaValue(const std::string&)>& value) {
  const std::string name = local_name(element);
  if (name == "cn") return {element.text_number(), 0};
  if (name == "csymbol" || name == "ci") {
    element.attribute("encoding");
    return value(part_of(element.text(), 0));
  }
  if (name == "pi") return {std::numbers::pi, 0};
  const auto parts = element.children();
  if (name == "math") {
    if (parts.empty()) element.fail("the formula is empty", "Write one");
    return evaluated(parts[0], value);
  }
  if (name != "apply" || parts.empty()) {
    element.fail("<" + name + "> is none that is read in formulas", "Write apply, cn, csymbol");
  }
  std::vector<FormulaValue> values;
  for (std::size_t i = 1; i < parts.size(); ++i) values.push_back(evaluated(parts[i], value));
  return applied(element, local_name(parts[0]), values);
}

}  // namespace prehend::robot::formats
