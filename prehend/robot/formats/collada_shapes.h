#pragma once

#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "prehend/robot/formats/collada_geometries.h"
#include "prehend/robot/formats/collada_materials.h"
#include "prehend/robot/formats/robot_description.h"
#include "prehend/robot/formats/tracked_xml.h"

namespace prehend::robot::formats {

/// Where the links of a document's kinematics are, and which of them an axis moves.
struct ColladaLinks {
  std::string root;
  std::map<std::string, geometry::RigidTransform> X_RL;  // in the root, all joints at 0
  /// The link below the joint of "kmodel/joint0/axis0"; empty: there is none.
  std::function<std::string(const std::string& axis)> moved_by;
};

/// Shapes of a COLLADA document (Khronos' specification 1.5, chapters 5 and 6). A visual scene's
/// node is of the link that <bind_joint_axis> or <bind_kinematics_model> tie to it, else of that
/// whose name it has, else of that of the node above it. Elements that are bound to a joint count
/// as at 0, whatever angle they have, and so does the link: its shapes stand in its frame.
class ColladaShapes {
 public:
  /// @param length metres of the document's unit
  ColladaShapes(TrackedXml& document, double length)
      : document_(document), length_(length), geometries_(document, length), materials_(document) {}

  /// The shapes of the scene that the document shows, or of its first, as what is seen of the
  /// links. @throws geometry::InputError with the place: a source, geometry or node that is not
  /// there, an index beyond its points, nodes in a ring or more than 100,000
  void read_visuals(const ColladaLinks& links, RobotDescription& robot);

  /// The shapes of a rigid body in its technique_common. A geometry that the link's node has, too,
  /// is where it is there: OpenRAVE's writer says that place in the root's frame, OpenHRP3's in the
  /// scene's. @param X_LR the root's frame in
  /// the link. @throws as read_visuals()
  std::vector<Shape> read_body(const XmlElement& technique, const geometry::RigidTransform& X_LR,
                               const std::string& link);

  /// The link of the node of that id, as read_visuals() found it; empty: none.
  std::string link_of_node(const std::string& id) const;

 private:
  struct Binding {
    std::vector<std::string> path;  // ids and sids, that of the bound one last
    std::string link;
  };
  struct Instance {
    XmlElement element;
    std::string link;
    Eigen::Affine3d X_SG;  // in the scene
  };
  struct Place {
    Eigen::Affine3d X_S = Eigen::Affine3d::Identity();
    std::string link;
    std::vector<std::string> labels;      // ids and sids of the nodes above
    std::vector<std::string> own_labels;  // of the node itself, by which it is instanced
  };

  void read_bindings(const ColladaLinks& links);
  std::map<std::string, std::string> read_parameters(const XmlElement& root) const;
  std::optional<XmlElement> shown_scene();
  const Binding* bound(const std::vector<Binding>& bindings, const std::vector<std::string>& labels,
                       const std::string& label) const;
  void visit(const XmlElement& node, Place place, int depth, const ColladaLinks& links);
  void move(const XmlElement& step, Eigen::Affine3d& X) const;
  std::vector<Shape> shapes_of(const XmlElement& instance, const Eigen::Affine3d& X_LG,
                               const std::string& link);

  TrackedXml& document_;
  const double length_;
  ColladaGeometries geometries_;
  ColladaMaterials materials_;
  std::vector<Binding> axes_, roots_;
  std::set<std::string> bound_links_;
  std::map<std::string, Eigen::Affine3d> X_SN_;        // of the first node of each link
  std::map<std::string, std::string> links_of_nodes_;  // by id
  std::map<std::string, int> counts_;                  // of named surfaces, by link
  std::vector<Instance> instances_;
  /// What is seen of a link, by its name and the geometry's id: once for each time.
  std::map<std::pair<std::string, std::string>, std::vector<std::vector<Shape>>> placed_;
  std::size_t nodes_ = 0;
  std::size_t baked_points_ = 0;
};

}  // namespace prehend::robot::formats
