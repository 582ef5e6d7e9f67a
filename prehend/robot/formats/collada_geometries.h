#pragma once

#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "prehend/geometry/triangle_mesh.h"
#include "prehend/robot/formats/robot_description.h"
#include "prehend/robot/formats/tracked_xml.h"

namespace prehend::robot::formats {

/// The geometries of a COLLADA document (Khronos' specification 1.5, chapter 5), each read once, in
/// metres. Polygons become fans of triangles, as of convex ones.
class ColladaGeometries {
 public:
  /// Triangles of one material.
  struct Part {
    std::string symbol;  // of its material, to be bound
    std::shared_ptr<const geometry::TriangleMesh> surface;
    std::string name;  // by the link that has it first
  };
  struct Geometry {
    std::vector<Part> parts;
    bool is_seen = true;
    std::optional<Shape> primitive;  // that the mesh is, as OpenRAVE's "geometry_info" says
  };

  /// @param length metres of the document's unit
  ColladaGeometries(TrackedXml& document, double length) : document_(document), length_(length) {}

  /// That of an <instance_geometry>; without parts where it is in another document.
  /// @throws geometry::InputError with the place: a source or geometry that is not there, an index
  /// beyond its points
  Geometry& of(const XmlElement& instance);

 private:
  std::vector<Part> read_mesh(const XmlElement& mesh, double length);
  std::vector<Eigen::Vector3d> read_points(const XmlElement& mesh, double length);
  std::vector<Eigen::Vector3d> read_source(const std::string& url, const XmlElement& user,
                                           double length);
  void read_triangles(const XmlElement& primitive, std::size_t points,
                      std::vector<Eigen::Vector3i>& triangles);

  TrackedXml& document_;
  const double length_;
  std::map<std::string, Geometry> geometries_;  // by url
  std::set<std::string> told_;                  // sources that are not kept, by url
};

}  // namespace prehend::robot::formats
