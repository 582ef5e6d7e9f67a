#pragma once

#include <array>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "prehend/geometry/rigid_transform.h"
#include "prehend/geometry/triangle_mesh.h"

// A robot as files of many formats describe it: all that any of them can say, in SI units.
namespace prehend::robot::formats {

/// Mass and how it is spread. Frame I has its origin at the centre of mass.
struct Inertial {
  double mass = 0;                                                       // kg
  geometry::RigidTransform X_LI = geometry::RigidTransform::Identity();  // in the link's frame
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();                     // kg m^2, in I
};

struct Shape {
  enum class Kind { kBox, kSphere, kCylinder, kCapsule, kPlane, kMesh };
  std::string name;
  Kind kind = Kind::kBox;
  geometry::RigidTransform X_LS = geometry::RigidTransform::Identity();
  Eigen::Vector3d size = Eigen::Vector3d::Zero();  // m, full sides of a box
  double radius = 0, length = 0;  // m; of a cylinder and a capsule's middle, along z
  std::string mesh;               // a file, as the robot's names it
  /// Of a mesh that came within the robot's file, which `mesh` then names; null: that is a file's.
  std::shared_ptr<const geometry::TriangleMesh> surface;
  Eigen::Vector3d scale = Eigen::Vector3d::Ones();  // of a mesh, in m per unit of its file
  std::string material;
  std::optional<std::array<double, 4>> color;  // red, green, blue, alpha in [0, 1]
};

struct LinkDescription {
  std::string name;
  std::optional<Inertial> inertial;
  std::vector<Shape> visuals, collisions;
};

/// A joint's position follows another's, q: Σ coefficients[i] qⁱ, mostly a line.
struct Follows {
  Follows() = default;
  Follows(std::string leader, double multiplier, double offset)
      : joint(std::move(leader)), coefficients{offset, multiplier} {}

  std::string joint;
  std::vector<double> coefficients{0, 1};  // at least two; rad or m per (rad or m)ⁱ

  double offset() const { return coefficients[0]; }      // at 0, rad or m
  double multiplier() const { return coefficients[1]; }  // the slope there
  bool is_linear() const;
  double at(double q) const;
};

struct JointDescription {
  enum class Kind { kFixed, kRevolute, kPrismatic, kBall, kFloating, kPlanar };
  std::string name;
  Kind kind = Kind::kFixed;
  std::string parent, child;                                             // links
  geometry::RigidTransform X_PJ = geometry::RigidTransform::Identity();  // J at 0, in the parent
  geometry::RigidTransform X_JC = geometry::RigidTransform::Identity();  // the child in J
  Eigen::Vector3d axis_J = Eigen::Vector3d::UnitX();                     // unit
  std::optional<double> lower, upper;  // rad or m; none: without a limit
  std::optional<double> velocity;      // rad/s or m/s, at most
  std::optional<double> effort;        // N m or N, at most
  double damping = 0;                  // N m s/rad or N s/m
  double friction = 0;                 // N m or N, Coulomb
  std::optional<double> stiffness;     // N m/rad or N/m, of a spring
  double rest = 0;                     // rad or m, of that spring
  std::optional<Follows> follows;
  /// Of a joint that follows by a clutch: torque at which it stays behind [N m], as BarrettHand's.
  std::optional<double> break_away;
  bool passive = false;  // no motor moves it
};

/// Two links that are held together besides the tree: a closed loop.
struct Loop {
  std::string name;
  enum class Kind { kPoint, kWeld } kind = Kind::kPoint;
  std::string first, second;  // links
  geometry::RigidTransform X_FirstLoop = geometry::RigidTransform::Identity();
};

struct Actuator {
  std::string name, joint;
  double gear = 1;               // motor turns, or effort, for one of the joint
  std::optional<double> effort;  // N m or N at the joint, at most
  std::string control;           // position, velocity, effort; empty: not said
};

struct Sensor {
  std::string name, kind, link;  // kind as the file has it: camera, force_torque, touch, ...
  geometry::RigidTransform X_LS = geometry::RigidTransform::Identity();
  Eigen::Vector3d size = Eigen::Vector3d::Zero();  // m, of a tactile cell's box; 0: none
};

/// An arm with what it holds with, or a gripper alone, as programs for planning call it.
struct Manipulator {
  std::string name, base, tip;  // links; a gripper alone may have one for both
  geometry::RigidTransform X_TipTool = geometry::RigidTransform::Identity();  // tool, in the tip
  /// The gripper's joints, each with the direction in which it closes: 1, -1; 0: it stays.
  std::vector<std::pair<std::string, double>> closing;
};

/// Positions of a group's joints that have a name, as "open".
struct Posture {
  std::string name, group;
  std::map<std::string, double> positions;  // rad or m, by joint
};

struct RobotDescription {
  std::string name;
  std::vector<LinkDescription> links;
  std::vector<JointDescription> joints;
  std::vector<Loop> loops;
  std::vector<Actuator> actuators;
  std::vector<Sensor> sensors;
  std::vector<Manipulator> manipulators;
  std::vector<Posture> postures;
  std::vector<std::pair<std::string, std::string>> disabled_collisions;  // links

  const LinkDescription* link(const std::string& link_name) const;
  const JointDescription* joint(const std::string& joint_name) const;
  /// The joint that `link_name` hangs on; null: it is a root.
  const JointDescription* joint_above(const std::string& link_name) const;
};

/// Robots have tens of links, chains that stand for ropes hundreds; much here looks at pairs of
/// them.
constexpr std::size_t kMostLinks = 10000;
/// @throws geometry::InputError where there are more links, or joints, than that
/// @param place for the words: the file, the robot
void refuse_many_links(std::size_t count, const std::string& place);

/// Links that no joint holds, in their order: the first is the root, others are beside it, as in
/// formats whose links stand in the robot's frame.
std::vector<std::string> roots(const RobotDescription& robot);

/// A coupling as formats have it that know lines alone.
struct CouplingLine {
  Follows line;          // through the ends of the leader's range
  double deviation = 0;  // of the polynomial from it within that range, at most; rad or m
};

/// The line of a joint that follows. Where its leader has no limit, the range ends at -π or π rad,
/// -1 or 1 m. @pre joint.follows
CouplingLine coupling_line(const RobotDescription& robot, const JointDescription& joint);
/// "the line through its ends, at most 0.012 rad beside it"
std::string words_of_line(const CouplingLine& coupling, const JointDescription& joint);

/// The links in an order in which parents come first, by joints that make a tree.
/// @throws geometry::InputError naming link or joint: none at all, more than kMostLinks, two of a
/// name, a joint of a link that is not there, a link with two joints above it, none without one, or
/// several, links in a ring.
std::vector<std::string> tree_order(const RobotDescription& robot);

/// For formats that have a link's element within that of the link above it: programs that read XML
/// do so to a depth of 99 elements (tinyxml2, by which prehend and MuJoCo read), or 256 (libxml2).
/// @throws geometry::InputError naming the first link that has more than `most` links above it, one
/// above the other; as tree_order()
/// @param format for the words, as "COLLADA"
void refuse_deep_links(const RobotDescription& robot, std::size_t most, const std::string& format);

/// A joint that follows one that follows one, and so on: at most so many, else it is a circle.
constexpr int kMostLeaders = 64;

/// Where links are at many positions: what is the same of them is found once.
class LinkPoses {
 public:
  /// @throws as tree_order(), and for a joint that follows one that is not there, or itself
  explicit LinkPoses(const RobotDescription& robot);

  /// By link, in the robot's order, in the first root's frame.
  /// @param positions [rad or m] by joint, in the robot's order; of those that follow unused. Ball,
  /// floating and planar joints are at 0.
  std::vector<geometry::RigidTransform> at(const std::vector<double>& positions) const;
  /// Of the joint by which each link hangs, -1 at the root; and of each joint's parent link.
  const std::vector<int>& joint_above() const { return joint_above_; }
  const std::vector<int>& parent() const { return parent_; }
  const std::vector<int>& order() const { return order_; }
  /// By joint: whose position it takes (its own where it follows none), and how.
  struct Leader {
    int joint = 0;
    Follows by;  // its `joint` is empty
  };
  const std::vector<Leader>& leaders() const { return leaders_; }

 private:
  std::vector<JointDescription> joints_;
  std::vector<int> order_, joint_above_, parent_;
  std::vector<Leader> leaders_;
};

/// Where each link is, in the first link's frame, with joints at `positions` [rad or m]; those that
/// are not named are at 0, those that follow where they follow to. Ball, floating and planar joints
/// are at 0. @throws as tree_order()
std::map<std::string, geometry::RigidTransform> link_poses(
    const RobotDescription& robot, const std::map<std::string, double>& positions);

}  // namespace prehend::robot::formats
