#pragma once

#include <cstdio>
#include <string>

#include "prehend/simulation/explain.h"

// What the explanations of both worlds share.
namespace prehend::simulation {

/// As printf.
template <class... Values>
std::string explained_text(const char* format, Values... values) {
  const int length = std::snprintf(nullptr, 0, format, values...);
  std::string result(static_cast<std::size_t>(length) + 1, '\0');
  std::snprintf(result.data(), result.size(), format, values...);
  result.pop_back();
  return result;
}

std::string law_text(const contact::TexelLaw& law);
/// "a box", "its mesh".
const char* shape_text(contact::Shape::Kind kind);
/// What meeting the object as a box, ball or can leaves out of its mesh; nothing of a mesh.
/// @param who "pads feel"
void explain_primitive(const BodyModel& model, const std::string& who, Explanation& out);

/// Of a scene with a robot.
Explanation explain_robot(const Scene& scene);

}  // namespace prehend::simulation
