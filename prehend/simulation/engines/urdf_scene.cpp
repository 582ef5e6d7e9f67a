#include "prehend/simulation/engines/urdf_scene.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include <fmt/format.h>
#include <urdf_model/model.h>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include "prehend/robot/urdf_document.h"

namespace prehend::simulation::engines {
namespace {

using geometry::InputError;
using geometry::RigidTransform;

// Links that fixed joints make one. Everything in frame G, the first link's.
struct Group {
  std::string name;
  RigidTransform X_WG = RigidTransform::Identity();
  double mass = 0;                                           // kg
  Eigen::Vector3d moment_of_mass = Eigen::Vector3d::Zero();  // kg m
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();         // kg m^2, about G's origin
  std::optional<EngineShape> shape;
  RigidTransform X_GS = RigidTransform::Identity();
  urdf::JointConstSharedPtr joint;  // to its parent; null: the root
  int parent = -1;
};

class Reader {
 public:
  Reader(const urdf::ModelInterface& model, const std::string& file, const UrdfOptions& options)
      : model_(model), file_(file), options_(options) {}

  UrdfScene read() {
    Group root;
    root.name = model_.getRoot()->name;
    root.X_WG = options_.X_WR;
    groups_.push_back(root);
    add_link(*model_.getRoot(), 0, RigidTransform::Identity());
    for (std::size_t i = 0; i < groups_.size(); ++i) {
      result_.scene.bodies.push_back(body_of(groups_[i], i == 0));
    }
    add_joints();
    validate(result_.scene);
    return std::move(result_);
  }

 private:
  [[noreturn]] void fail(const std::string& what, const std::string& mend) const {
    throw InputError("'" + file_ + "': " + what, mend);
  }

  void add_link(const urdf::Link& link, int group, const RigidTransform& X_GL) {
    add_inertial(link, groups_[group], X_GL);
    add_collision(link, groups_[group], X_GL);
    for (const auto& joint : link.child_joints) {
      const urdf::LinkConstSharedPtr child = model_.getLink(joint->child_link_name);
      const RigidTransform X_GC =
          X_GL * robot::to_transform(joint->parent_to_joint_origin_transform);
      switch (joint->type) {
        case urdf::Joint::FIXED:
          add_link(*child, group, X_GC);
          break;
        case urdf::Joint::PRISMATIC:
        case urdf::Joint::REVOLUTE:
        case urdf::Joint::CONTINUOUS: {
          Group next;
          next.name = child->name;
          next.X_WG = groups_[group].X_WG * X_GC;
          next.joint = joint;
          next.parent = group;
          groups_.push_back(next);
          add_link(*child, static_cast<int>(groups_.size()) - 1, RigidTransform::Identity());
          break;
        }
        default:
          fail("joint '" + joint->name + "' is neither prismatic, revolute, continuous nor fixed",
               "Compose it of joints of these types");
      }
    }
  }

  void add_inertial(const urdf::Link& link, Group& group, const RigidTransform& X_GL) const {
    if (!link.inertial) return;
    const urdf::Inertial& given = *link.inertial;
    const RigidTransform X_GI = X_GL * robot::to_transform(given.origin);
    Eigen::Matrix3d inertia;
    inertia << given.ixx, given.ixy, given.ixz, given.ixy, given.iyy, given.iyz, given.ixz,
        given.iyz, given.izz;
    if (!std::isfinite(given.mass) || given.mass < 0 || !inertia.allFinite()) {
      fail("link '" + link.name + "' has a mass or inertia that is negative or no number",
           "Give a mass in kg and moments in kg m^2");
    }
    const Eigen::Vector3d p = X_GI.translation();
    group.mass += given.mass;
    group.moment_of_mass += given.mass * p;
    group.inertia +=
        X_GI.linear() * inertia * X_GI.linear().transpose() +
        given.mass * (p.squaredNorm() * Eigen::Matrix3d::Identity() - p * p.transpose());
  }

  void add_collision(const urdf::Link& link, Group& group, const RigidTransform& X_GL) {
    for (const auto& collision : link.collision_array) {
      if (!collision || !collision->geometry) continue;
      EngineShape shape;
      switch (collision->geometry->type) {
        case urdf::Geometry::BOX: {
          const auto& box = static_cast<const urdf::Box&>(*collision->geometry);
          shape.size = {box.dim.x, box.dim.y, box.dim.z};
          break;
        }
        case urdf::Geometry::SPHERE:
          shape.kind = EngineShape::Kind::kSphere;
          shape.radius = static_cast<const urdf::Sphere&>(*collision->geometry).radius;
          break;
        case urdf::Geometry::CYLINDER: {
          const auto& cylinder = static_cast<const urdf::Cylinder&>(*collision->geometry);
          shape.kind = EngineShape::Kind::kCylinder;
          shape.radius = cylinder.radius;
          shape.length = cylinder.length;
          break;
        }
        case urdf::Geometry::MESH:
          if (!options_.meshes_pass_through) {
            fail("link '" + link.name + "' has a mesh as collision geometry",
                 "Put a box, sphere or cylinder in its place, or let meshes pass through others");
          }
          remark("link '" + link.name + "' passes through everything: its geometry is a mesh");
          continue;
      }
      if (group.shape) {
        fail("link '" + link.name + "' and those fixed to it have several collision geometries",
             "Leave one box, sphere or cylinder to all of them");
      }
      group.shape = shape;
      group.X_GS = X_GL * robot::to_transform(collision->origin);
    }
  }

  EngineBody body_of(const Group& group, bool is_root) const {
    EngineBody body;
    body.name = group.name;
    body.friction = options_.friction;
    body.is_fixed = is_root && options_.base_is_fixed;
    body.collides = group.shape.has_value();
    RigidTransform X_GB = RigidTransform::Identity();
    if (body.is_fixed) {
      // It never moves: its mass has no effect.
      body.mass = 1;
      body.moments.setOnes();
    } else {
      if (!(group.mass > 0)) {
        fail("link '" + group.name + "' moves and has no mass", "Give it an inertial part");
      }
      body.mass = group.mass;
      const Eigen::Vector3d centre = group.moment_of_mass / group.mass;
      const Eigen::Matrix3d about_centre =
          group.inertia - group.mass * (centre.squaredNorm() * Eigen::Matrix3d::Identity() -
                                        centre * centre.transpose());
      const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> principal(about_centre);
      body.moments = principal.eigenvalues();
      if (!(body.moments.minCoeff() > 0)) {
        fail("the inertia of link '" + group.name + "' is not positive definite",
             "Give its moments about the centre of mass, all above zero");
      }
      Eigen::Matrix3d axes = principal.eigenvectors();
      if (axes.determinant() < 0) axes.col(0) *= -1;
      X_GB.linear() = axes;
      X_GB.translation() = centre;
    }
    body.X_WB = group.X_WG * X_GB;
    if (group.shape) {
      body.shape = *group.shape;
      body.X_BS = X_GB.inverse(Eigen::Isometry) * group.X_GS;
    }
    return body;
  }

  // Joints that follow others stand after them.
  void add_joints() {
    for (const bool following : {false, true}) {
      for (std::size_t i = 1; i < groups_.size(); ++i) {
        if ((groups_[i].joint->mimic != nullptr) == following) add_joint(static_cast<int>(i));
      }
    }
  }

  void add_joint(int index) {
    const Group& group = groups_[index];
    const urdf::Joint& given = *group.joint;
    EngineJoint joint;
    joint.kind = given.type == urdf::Joint::PRISMATIC ? EngineJoint::Kind::kPrismatic
                                                      : EngineJoint::Kind::kRevolute;
    joint.parent = group.parent;
    joint.body = index;
    const Eigen::Vector3d axis(given.axis.x, given.axis.y, given.axis.z);
    if (!(axis.norm() > 0)) {
      fail("joint '" + given.name + "' has no axis", "Give it an axis of length 1");
    }
    joint.axis_W = (group.X_WG.linear() * axis.normalized()).normalized();
    joint.anchor_W = group.X_WG.translation();
    if (given.mimic) {
      const auto& names = result_.joint_names;
      const auto leader = std::find(names.begin(), names.end(), given.mimic->joint_name);
      if (leader == names.end()) {
        fail("joint '" + given.name + "' mimics '" + given.mimic->joint_name +
                 "', which does not move by itself",
             "Let it mimic a moving joint that mimics none");
      }
      joint.follows = static_cast<int>(leader - names.begin());
      if (result_.scene.joints[joint.follows].follows >= 0) {
        fail("joint '" + given.name + "' mimics one that mimics another",
             "Let it mimic a joint that mimics none");
      }
      if (given.mimic->offset != 0) {
        fail("joint '" + given.name + "' mimics with an offset",
             "Move the offset into the joint's origin");
      }
      joint.ratio = given.mimic->multiplier;
    }
    if (given.limits && given.type != urdf::Joint::CONTINUOUS) {
      remark(fmt::format("joint '{}': its limits {} to {} are not kept", given.name,
                         given.limits->lower, given.limits->upper));
    }
    if (given.dynamics && (given.dynamics->damping != 0 || given.dynamics->friction != 0)) {
      remark(fmt::format("joint '{}': its damping {} and friction {} are left out", given.name,
                         given.dynamics->damping, given.dynamics->friction));
    }
    result_.scene.joints.push_back(joint);
    result_.joint_names.push_back(given.name);
  }

  void remark(const std::string& text) { result_.remarks.push_back(text); }

  const urdf::ModelInterface& model_;
  const std::string& file_;
  const UrdfOptions& options_;
  std::vector<Group> groups_;
  UrdfScene result_;
};

}  // namespace

UrdfScene parse_urdf(const std::string& text, const std::string& name, const UrdfOptions& options) {
  return Reader(*robot::parse_urdf_document(text, name), name, options).read();
}

UrdfScene load_urdf(const std::filesystem::path& file, const UrdfOptions& options) {
  return Reader(*robot::read_urdf_document(file), file.string(), options).read();
}

}  // namespace prehend::simulation::engines
