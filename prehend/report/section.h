#pragma once

#include <string>
#include <vector>

#include "prehend/geometry/image.h"
#include "prehend/geometry/triangle_mesh.h"

namespace prehend::report {

/// A surface in a picture of a section.
struct SectionOutline {
  std::string name;  // for its legend
  geometry::Rgb color{0, 0, 0};
  const geometry::TriangleMesh* mesh = nullptr;
};

/// A plane through `origin` that `right` and `up` span, unit vectors across one another.
struct SectionPlane {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::UnitX();
  Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
};

/// Where a plane cuts the mesh: the ends of a segment for each triangle that it cuts, as (right,
/// up) from the plane's origin [m]. A vertex in the plane counts as above it.
std::vector<std::pair<Eigen::Vector2d, Eigen::Vector2d>> section_of(
    const geometry::TriangleMesh& mesh, const SectionPlane& plane);

/// The meshes' outlines where a plane cuts them, one over the other, as an SVG element with a
/// scale; in words when the plane cuts none. @throws std::invalid_argument for a plane whose
/// vectors are not unit vectors across one another.
std::string draw_section(const std::string& title, const std::vector<SectionOutline>& outlines,
                         const SectionPlane& plane);

}  // namespace prehend::report
