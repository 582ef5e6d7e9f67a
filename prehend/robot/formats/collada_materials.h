#pragma once

#include <array>
#include <map>
#include <optional>
#include <set>
#include <string>

#include "prehend/robot/formats/tracked_xml.h"

namespace prehend::robot::formats {

/// Materials and effects of a COLLADA document (Khronos' specification 1.5, chapter 8), of which
/// colours are read.
class ColladaMaterials {
 public:
  explicit ColladaMaterials(TrackedXml& document) : document_(document) {}

  /// The <material> of each symbol that an <instance_geometry> binds.
  std::map<std::string, XmlElement> bound_by(const XmlElement& instance);
  /// A material's red, green, blue, alpha in 0 to 1; none: it has a texture, or nothing.
  /// @throws geometry::InputError with the place of what is no colour
  std::optional<std::array<double, 4>> color(const XmlElement& material);

 private:
  TrackedXml& document_;
  std::set<std::string> told_;  // effects of which it is told what is not kept, by id
};

}  // namespace prehend::robot::formats
