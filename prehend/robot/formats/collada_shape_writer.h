#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "prehend/robot/formats/collada_text.h"
#include "prehend/robot/formats/robot_description.h"

namespace prehend::robot::formats {

/// Whether a shape can be in a COLLADA document: meshes must have been loaded, solids have a size,
/// planes are of bodies alone.
bool is_in_collada(const Shape& shape, bool is_seen);

/// Whether a link has a mass that is not read as none.
bool is_heavy(const LinkDescription& link);

/// A robot's shapes in COLLADA. What is seen stands in the links' nodes; what is touched is the
/// rigid bodies' shapes, and is in the node, too, of a link that is not seen: OpenRAVE looks for
/// nothing else. Boxes, balls, cylinders and capsules in nodes are meshes of which OpenRAVE's extra
/// "geometry_info" says what they are. Points are written as floats are.
class ColladaShapeWriter {
 public:
  explicit ColladaShapeWriter(const RobotDescription& robot) : robot_(robot) {}

  /// The nodes of a link's shapes, within its own node.
  void write_nodes(const LinkDescription& link, ColladaText& text);
  /// <rigid_body> of each link with a mass or something to touch, in the frame of the root, as
  /// OpenRAVE has them. @pre write_nodes() of all links
  /// @param X_RL where links are, all joints at 0
  void write_bodies(const std::map<std::string, geometry::RigidTransform>& X_RL, ColladaText& text);
  /// Links of which write_bodies() wrote a body, by its sid.
  const std::vector<std::pair<std::string, std::string>>& bodies() const { return bodies_; }
  /// The libraries of geometries, effects and materials. @pre all else
  std::string libraries();

 private:
  using GeometryKey = std::tuple<int, const void*, std::array<double, 3>, std::array<double, 3>,
                                 double, double, bool>;

  static GeometryKey key_of(const Shape& shape, bool is_seen);
  std::string geometry(const Shape& shape, bool is_seen);
  void write_geometry(const std::string& id, const Shape& shape, bool is_seen);
  void write_instance(const Shape& shape, const std::string& geometry, ColladaText& text);
  std::string material(const Shape& shape);
  void write_touched_mesh(const LinkDescription& link, const Shape& shape, ColladaText& text);
  void write_shape(const LinkDescription& link, const Shape& shape,
                   const geometry::RigidTransform& X_RL, ColladaText& text);

  const RobotDescription& robot_;
  ColladaText geometries_{2}, effects_{2}, materials_{2};
  std::map<GeometryKey, std::string> ids_;
  std::map<std::tuple<std::string, std::optional<std::array<double, 4>>>, std::string>
      material_ids_;
  /// Geometries of what is seen that a body may share, since they are once in the link.
  std::map<std::string, std::map<std::string, const Shape*>> once_;
  std::vector<std::pair<std::string, std::string>> bodies_;
};

}  // namespace prehend::robot::formats
