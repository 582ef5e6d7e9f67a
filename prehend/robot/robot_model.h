#pragma once

#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "prehend/geometry/rigid_transform.h"
#include "prehend/geometry/triangle_mesh.h"

namespace prehend::robot {

/// What a link can be hit at. Frame S of the shape in its link's frame L.
struct CollisionShape {
  enum class Kind { kBox, kSphere, kCylinder, kMesh };
  Kind kind = Kind::kBox;
  geometry::RigidTransform X_LS = geometry::RigidTransform::Identity();
  Eigen::Vector3d size = Eigen::Vector3d::Zero();  // m, full sides of a box; scale of a mesh
  double radius = 0;                               // m
  double length = 0;                               // m, of a cylinder, along z
  std::string mesh;                                // as the file names it
  /// Of a mesh, and then never null: what it bounds, closed, triangles outward, `size` applied [m,
  /// in S].
  std::shared_ptr<const geometry::TriangleMesh> solid;
};

struct Link {
  std::string name;
  double mass = 0;  // kg; 0: unknown
  std::vector<CollisionShape> shapes;
};

/// A joint follows another one: position = multiplier * that one's + offset. Of a polynomial that
/// stands in prehend's extension of the URDF (formats/extension.h) this is the line.
struct Mimic {
  int joint = -1;
  double multiplier = 1;
  double offset = 0;  // rad or m
};

/// Joins `child` to `parent`. Its frame J is the child's at position 0.
struct Joint {
  enum class Kind { kFixed, kRevolute, kPrismatic };
  std::string name;
  Kind kind = Kind::kFixed;
  int parent = -1, child = -1;                                           // links
  geometry::RigidTransform X_PJ = geometry::RigidTransform::Identity();  // in the parent
  Eigen::Vector3d axis_J = Eigen::Vector3d::UnitX();                     // unit
  double lower = -std::numeric_limits<double>::infinity();               // rad or m
  double upper = std::numeric_limits<double>::infinity();
  double max_velocity = std::numeric_limits<double>::infinity();  // rad/s or m/s
  double max_effort = std::numeric_limits<double>::infinity();    // N m or N
  std::optional<Mimic> mimic;

  /// Pose of the child in the parent at `position` [rad or m].
  geometry::RigidTransform pose_at(double position) const;
};

/// A tree of links. Joints stand in an order in which parents come before their children.
struct RobotModel {
  std::string name;
  std::vector<Link> links;  // the first is the root
  std::vector<Joint> joints;
  /// What is taken otherwise than the file may mean it, each naming a link, for the user to read.
  std::vector<std::string> remarks;

  /// @throws geometry::InputError naming the nearest link (joint) there is.
  int link_index(const std::string& name) const;
  int joint_index(const std::string& name) const;
  /// The joint that moves `link`; none for the root.
  std::optional<int> joint_above(int link) const;
};

/// Reads a URDF: links with their collision shapes (visual parts have no part in it) and masses,
/// joints fixed, revolute, continuous (without limits) and prismatic, with limits and mimics.
/// Meshes are found by find_mesh_file() and become solids by read_solid_mesh() (mesh_shape.h).
/// @throws geometry::InputError naming file, link or joint, and the mend: a joint of another kind,
/// an axis without length, limits that cross, a mimic of a joint that is not there or in a circle,
/// a shape without size, a mesh that is not there or bounds no solid.
RobotModel read_urdf(const std::filesystem::path& file);
/// The same of a text: `name` stands for the file in messages, meshes are found from `folder`.
RobotModel parse_urdf(const std::string& text, const std::string& name,
                      const std::filesystem::path& folder = ".");

}  // namespace prehend::robot
