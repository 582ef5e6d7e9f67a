#include "prehend/robot/formats/collada_text.h"

#include <cmath>
#include <numbers>

#include "prehend/robot/formats/xml_text.h"

namespace prehend::robot::formats {

std::string xml_attribute(std::string_view name, std::string_view value) {
  return " " + std::string(name) + "=\"" + escaped(std::string(value)) + "\"";
}

std::string degrees_text(double angle) {
  constexpr double kInRadians = std::numbers::pi / 180;
  const double nearest = angle / kInRadians;
  for (const double one :
       {nearest, std::nextafter(nearest, -INFINITY), std::nextafter(nearest, INFINITY)}) {
    if (kInRadians * one == angle) return number_text(one);
  }
  return number_text(nearest);
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
  leaf("rotate", "", numbers_text(turn.axis()) + " " + degrees_text(turn.angle()));
}

}  // namespace prehend::robot::formats
