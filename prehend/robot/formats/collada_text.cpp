#include "prehend/robot/formats/collada_text.h"

#include <array>
#include <charconv>
#include <cmath>
#include <numbers>

#include "prehend/robot/formats/collada_elements.h"
#include "prehend/robot/formats/xml_text.h"

namespace prehend::robot::formats {

std::string xml_attribute(std::string_view name, std::string_view value) {
  return " " + std::string(name) + "=\"" + escaped(std::string(value)) + "\"";
}

std::string degrees_text(double angle) {
  const long double exact = angle / (std::numbers::pi_v<long double> / 180);
  const double nearest = static_cast<double>(exact);
  for (const double one :
       {nearest, std::nextafter(nearest, -INFINITY), std::nextafter(nearest, INFINITY)}) {
    std::string text = number_text(one);
    if (radians_of_degrees(text) == angle) return text;
  }
  std::array<char, 64> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), exact);
  return {text.data(), end.ptr};
}

void ColladaText::open(const std::string& name, const std::string& attributes) {
  indent();
  text_ += "<" + name + attributes + ">\n";
  names_.push_back(name);
  ++depth_;
}

void ColladaText::close() {
  --depth_;
  indent();
  text_ += "</" + names_.back() + ">\n";
  names_.pop_back();
}

void ColladaText::leaf(const std::string& name, const std::string& attributes,
                       const std::string& text) {
  indent();
  text_ += "<" + name + attributes;
  text_ += text.empty() ? "/>\n" : ">" + escaped(text) + "</" + name + ">\n";
}

void ColladaText::steps(const geometry::RigidTransform& X) {
  Eigen::AngleAxisd turn{Eigen::Quaterniond(X.linear())};
  constexpr double kRounding = 1e-15;  // rad
  if (std::abs(turn.angle()) < kRounding) turn = {0, Eigen::Vector3d::UnitX()};
  leaf("translate", "", numbers_text(X.translation()));
  leaf("rotate", "",
       numbers_text(turn.axis()) + " " + number_text(turn.angle() * (180 / std::numbers::pi)));
}

}  // namespace prehend::robot::formats
