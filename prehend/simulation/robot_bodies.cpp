#include "prehend/simulation/robot_bodies.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <Eigen/Eigenvalues>

#include "prehend/geometry/errors.h"
#include "prehend/simulation/engines/inertia.h"

namespace prehend::simulation {
namespace {

using engines::EngineShape;
using geometry::RigidTransform;
using robot::CollisionShape;
using robot::Joint;

constexpr double kDensity = 1500;     // kg/m^3, of a link whose mass the file does not say
constexpr double kLeastMass = 0.005;  // kg
constexpr double kOnFace = 0.002;     // m, between a pad's face and the link's
constexpr double kAlongNormal = 0.999;
constexpr double kNoArea = 1e-12;  // m^2, of a triangle

EngineShape engine_shape(const CollisionShape& shape) {
  EngineShape result;
  switch (shape.kind) {
    case CollisionShape::Kind::kBox:
      result.kind = EngineShape::Kind::kBox;
      result.size = shape.size;
      break;
    case CollisionShape::Kind::kSphere:
      result.kind = EngineShape::Kind::kSphere;
      result.radius = shape.radius;
      break;
    case CollisionShape::Kind::kCylinder:
      result.kind = EngineShape::Kind::kCylinder;
      result.radius = shape.radius;
      result.length = shape.length;
      break;
    case CollisionShape::Kind::kMesh:
      break;  // RobotBodies::Part::solid
  }
  return result;
}

// Of the box at X_BS, what is behind the foam of a pad on one of its faces.
void cut_foam(const RigidTransform& X_BP, double thickness, EngineShape& box,
              RigidTransform& X_BS) {
  const Eigen::Vector3d normal_S = X_BS.linear().transpose() * X_BP.linear().col(2);
  Eigen::Index axis = 0;
  if (normal_S.cwiseAbs().maxCoeff(&axis) < kAlongNormal) return;
  const double side = normal_S[axis] > 0 ? 1 : -1;
  const Eigen::Vector3d p_SP = X_BS.inverse(Eigen::Isometry) * X_BP.translation();
  const double out = side * p_SP[axis] - 0.5 * box.size[axis];  // of the pad's face over the box's
  const double cut = thickness - out;
  if (std::abs(out) > kOnFace || cut <= 0 || cut >= box.size[axis]) return;
  box.size[axis] -= cut;
  X_BS.translation() -= X_BS.linear() * (0.5 * side * cut * Eigen::Vector3d::Unit(axis));
}

// Of a solid that a pad is outermost on, what is behind its foam: what stands before the plane
// there is pressed flat onto it.
std::shared_ptr<const geometry::TriangleMesh> behind_foam(
    const std::shared_ptr<const geometry::TriangleMesh>& solid, const RigidTransform& X_PS,
    double thickness) {
  geometry::TriangleMesh mesh = geometry::transformed(*solid, X_PS);
  const Eigen::AlignedBox3d box = geometry::bounds(mesh);
  if (std::abs(box.max().z()) > kOnFace || box.min().z() >= -thickness) return solid;
  for (Eigen::Vector3d& p : mesh.vertices) p.z() = std::min(p.z(), -thickness);
  std::erase_if(mesh.triangles, [&](const Eigen::Vector3i& t) {
    const Eigen::Vector3d& a = mesh.vertices[t[0]];
    return (mesh.vertices[t[1]] - a).cross(mesh.vertices[t[2]] - a).norm() < kNoArea;
  });
  return std::make_shared<const geometry::TriangleMesh>(
      geometry::transformed(mesh, X_PS.inverse(Eigen::Isometry)));
}

double volume_of(const EngineShape& shape) {
  switch (shape.kind) {
    case EngineShape::Kind::kBox:
      return shape.size.prod();
    case EngineShape::Kind::kSphere:
      return 4.0 / 3 * M_PI * std::pow(shape.radius, 3);
    case EngineShape::Kind::kCylinder:
    case EngineShape::Kind::kCapsule:
      return M_PI * shape.radius * shape.radius * shape.length;
    case EngineShape::Kind::kConvexPieces:
      break;  // links have primitives and meshes
  }
  return 0;
}

/// What a part weighs with, if it were solid and alike all through; frame B of its body.
struct PartMass {
  double volume;                    // m^3
  Eigen::Vector3d center;           // m
  Eigen::Matrix3d inertia_of_unit;  // m^2, of 1 kg about the centre
};

PartMass part_mass(const RobotBodies::Part& part) {
  const Eigen::Matrix3d R = part.X_BS.linear();
  if (part.solid) {
    const geometry::MassProperties of = geometry::mass_properties(*part.solid);
    return {of.volume, part.X_BS * of.center_of_mass,
            R * (of.unit_density_inertia / of.volume) * R.transpose()};
  }
  return {volume_of(part.shape), part.X_BS.translation(),
          R * engines::principal_inertia(part.shape, 1).asDiagonal() * R.transpose()};
}

class Builder {
 public:
  Builder(const robot::RobotModel& model, const robot::HandModel& hand, const std::string& prefix,
          const RigidTransform& X_WR, const Eigen::VectorXd& all, const HandMechanics& mechanics)
      : hand_(hand), prefix_(prefix), mechanics_(mechanics) {
    out_.model = model;
    out_.hand_root = model.link_index(prefix + hand.model.links.front().name);
    Eigen::VectorXd start = all;
    for (std::size_t j = 0; j < model.joints.size(); ++j) {
      moves_hand_.push_back(is_hands(model.joints[j]));
      if (moves_hand_.back()) start[static_cast<Eigen::Index>(j)] = 0;
    }
    out_.link_poses(X_WR, start, X_WL_);
  }

  RobotBodies build() {
    find_bodies();
    for (std::size_t body = 0; body < links_.size(); ++body) add_body(static_cast<int>(body));
    add_pads();
    add_joints();
    add_breakaways();
    add_motors();
    return std::move(out_);
  }

 private:
  bool is_hands(const Joint& joint) const {
    if (joint.kind == Joint::Kind::kFixed) return false;
    for (const Joint& own : hand_.model.joints) {
      if (prefix_ + own.name == joint.name) return true;
    }
    return false;
  }

  // Links in an order in which parents come before their children.
  void find_bodies() {
    const robot::RobotModel& model = out_.model;
    out_.body_of_link.assign(model.links.size(), -1);
    out_.X_BL.assign(model.links.size(), RigidTransform::Identity());
    const auto begin = [&](int link, int joint) {
      out_.body_of_link[link] = static_cast<int>(links_.size());
      links_.push_back({link});
      joint_of_.push_back(joint);
    };
    begin(0, -1);
    for (std::size_t j = 0; j < model.joints.size(); ++j) {
      const Joint& joint = model.joints[j];
      if (joint.kind != Joint::Kind::kFixed) {
        begin(joint.child, static_cast<int>(j));
        continue;
      }
      out_.body_of_link[joint.child] = out_.body_of_link[joint.parent];
      links_[out_.body_of_link[joint.parent]].push_back(joint.child);
    }
    out_.finger_of_body.assign(links_.size(), -1);
    out_.rank_of_body.assign(links_.size(), 0);
    for (std::size_t f = 0; f < hand_.fingers.size(); ++f) {
      int rank = 0;
      for (const int link : hand_.fingers[f].links) {
        const int body =
            out_.body_of_link[model.link_index(prefix_ + hand_.model.links[link].name)];
        // A knuckle that is fixed to the palm is the palm's.
        if (body != out_.body_of_link[out_.hand_root]) {
          out_.finger_of_body[body] = static_cast<int>(f);
        }
        out_.rank_of_body[body] = rank++;
      }
    }
  }

  void add_body(int index) {
    const bool driven = joint_of_[index] >= 0 && moves_hand_[joint_of_[index]];
    const RigidTransform X_WO = X_WL_[links_[index].front()];
    engines::EngineBody body;
    body.name = out_.model.links[links_[index].front()].name;
    body.friction = mechanics_.friction > 0 ? mechanics_.friction : hand_.friction;
    const std::size_t first_part = out_.parts.size();
    double mass = 0, volume = 0;
    Eigen::Vector3d center = Eigen::Vector3d::Zero();
    std::vector<PartMass> masses;
    for (const int link : links_[index]) {
      const RigidTransform X_OL = X_WO.inverse(Eigen::Isometry) * X_WL_[link];
      mass += out_.model.links[link].mass;
      out_.X_BL[link] = X_OL;
      for (const CollisionShape& shape : out_.model.links[link].shapes) {
        const RobotBodies::Part part{index, link, engine_shape(shape), X_OL * shape.X_LS,
                                     shape.solid};
        masses.push_back(part_mass(part));
        volume += masses.back().volume;
        center += masses.back().volume * masses.back().center;
        out_.parts.push_back(part);
      }
    }
    if (!driven) {
      body.is_fixed = true;
      body.mass = 1;
      body.moments.setOnes();
      body.X_WB = X_WO;
      out_.carried.push_back({index, links_[index].front()});
      out_.bodies.push_back(body);
      return;
    }
    // As solid as its shapes; a link without shapes is a small ball.
    if (mass <= 0) mass = kDensity * volume;
    body.mass = std::max(mass, kLeastMass);
    if (volume > 0) center /= volume;
    Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
    for (const PartMass& part : masses) {
      const double share = body.mass * part.volume / volume;
      const Eigen::Vector3d arm = part.center - center;
      inertia += share * (part.inertia_of_unit + arm.squaredNorm() * Eigen::Matrix3d::Identity() -
                          arm * arm.transpose());
    }
    if (first_part == out_.parts.size()) inertia.diagonal().setConstant(body.mass * 1e-4);
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(inertia);
    RigidTransform X_OB = RigidTransform::Identity();
    X_OB.linear() = axes.eigenvectors();
    if (X_OB.linear().determinant() < 0) X_OB.linear().col(0) *= -1;
    X_OB.translation() = center;
    body.moments = axes.eigenvalues();
    body.X_WB = X_WO * X_OB;
    const RigidTransform X_BO = X_OB.inverse(Eigen::Isometry);
    for (std::size_t p = first_part; p < out_.parts.size(); ++p) {
      out_.parts[p].X_BS = X_BO * out_.parts[p].X_BS;
    }
    for (const int link : links_[index]) out_.X_BL[link] = X_BO * out_.X_BL[link];
    out_.bodies.push_back(body);
  }

  void add_pads() {
    for (std::size_t i = 0; i < hand_.pads.size(); ++i) {
      const robot::HandPad& pad = hand_.pads[i];
      const int link = out_.model.link_index(
          prefix_ + hand_.model.links[static_cast<std::size_t>(pad.link)].name);
      const int body = out_.body_of_link[link];
      const RigidTransform X_BP = out_.X_BL[link] * pad.X_LP;
      out_.pads.push_back({static_cast<int>(i), body, X_BP});
      if (!pad.layout->is_flat()) continue;
      for (RobotBodies::Part& part : out_.parts) {
        if (part.link != link) continue;
        if (part.solid) {
          const RigidTransform X_PS = X_BP.inverse(Eigen::Isometry) * part.X_BS;
          part.solid = behind_foam(part.solid, X_PS, pad.model.thickness);
          continue;
        }
        if (part.shape.kind != EngineShape::Kind::kBox) continue;
        cut_foam(X_BP, pad.model.thickness, part.shape, part.X_BS);
      }
    }
  }

  void add_joints() {
    const robot::RobotModel& model = out_.model;
    out_.engine_joint.assign(model.joints.size(), -1);
    // Those that follow come after those that lead, wherever the file has them.
    std::vector<std::size_t> order;
    for (const bool follows : {false, true}) {
      for (std::size_t j = 0; j < model.joints.size(); ++j) {
        if (moves_hand_[j] && model.joints[j].mimic.has_value() == follows) order.push_back(j);
      }
    }
    for (const std::size_t j : order) {
      const Joint& joint = model.joints[j];
      engines::EngineJoint engine;
      engine.kind = joint.kind == Joint::Kind::kRevolute ? engines::EngineJoint::Kind::kRevolute
                                                         : engines::EngineJoint::Kind::kPrismatic;
      engine.parent = out_.body_of_link[joint.parent];
      engine.body = out_.body_of_link[joint.child];
      const RigidTransform X_WJ = X_WL_[joint.parent] * joint.X_PJ;
      engine.axis_W = (X_WJ.linear() * joint.axis_J).normalized();
      engine.anchor_W = X_WJ.translation();
      engines::JointMechanics own;
      own.lower = joint.lower;
      own.upper = joint.upper;
      const bool slides = joint.kind == Joint::Kind::kPrismatic;
      own.damping = slides ? mechanics_.sliding_damping : mechanics_.damping;
      own.rotor_inertia = slides ? mechanics_.sliding_mass : mechanics_.rotor_inertia;
      if (joint.mimic && !breakaway_of(joint.name)) {
        if (joint.mimic->offset != 0) {
          throw geometry::InputError("joint '" + joint.name + "' mimics with an offset",
                                     "Put the offset into the joint's origin");
        }
        engine.follows = out_.engine_joint[joint.mimic->joint];
        engine.ratio = joint.mimic->multiplier;
        own = {};
      }
      out_.engine_joint[j] = static_cast<int>(out_.joints.size());
      out_.coordinate.push_back(engine.follows >= 0
                                    ? out_.coordinate[static_cast<std::size_t>(engine.follows)]
                                    : coordinates_++);
      out_.joints.push_back(engine);
      out_.mechanics.push_back(own);
    }
  }

  const robot::Breakaway* breakaway_of(const std::string& joint) const {
    for (const robot::Breakaway& breakaway : hand_.breakaways) {
      if (prefix_ + hand_.model.joints[breakaway.joint].name == joint) return &breakaway;
    }
    return nullptr;
  }

  int engine_joint(int hand_joint) const {
    return out_.engine_joint[out_.model.joint_index(prefix_ + hand_.model.joints[hand_joint].name)];
  }

  // Motor position f = (1 - m/r) q_inner + q_outer / r: with q_outer = m q_inner it is q_inner, and
  // with q_inner held the outer moves r times as fast. A clutch of torque T between motor and inner
  // joint bears (q_inner' - f') T = (m/r) (q_inner' - q_outer'/m) T.
  void add_breakaways() {
    for (const robot::Breakaway& breakaway : hand_.breakaways) {
      const double m = hand_.model.joints[breakaway.joint].mimic->multiplier;
      engines::JointCoupling coupling;
      coupling.first = engine_joint(breakaway.leader);
      coupling.second = engine_joint(breakaway.joint);
      coupling.ratio = 1 / m;
      coupling.breakaway = breakaway.torque * m / breakaway.rate;
      out_.couplings.push_back(coupling);
      // One motor, one rotor: at the outer joint.
      out_.mechanics[coupling.first].rotor_inertia = 0.1 * mechanics_.rotor_inertia;
    }
  }

  void add_motors() {
    for (std::size_t i = 0; i < hand_.actuated.size(); ++i) {
      const int own = hand_.actuated[i];
      const Joint& joint = hand_.model.joints[own];
      if (!(std::isfinite(joint.max_velocity) && joint.max_velocity > 0 &&
            std::isfinite(joint.max_effort) && joint.max_effort > 0)) {
        throw geometry::InputError("joint '" + joint.name + "' has no velocity or effort",
                                   "Write both into its <limit>");
      }
      RobotBodies::Motor motor;
      motor.name = prefix_ + joint.name;
      motor.model_joint = out_.model.joint_index(motor.name);
      motor.joint = engine_joint(own);
      motor.max_velocity = joint.max_velocity;
      motor.max_effort = joint.max_effort;
      motor.lower = joint.lower;
      motor.upper = joint.upper;
      motor.slides = joint.kind == Joint::Kind::kPrismatic;
      if (const auto known = hand_.motors.find(static_cast<int>(i)); known != hand_.motors.end()) {
        motor.model = known->second;
      }
      for (const robot::Breakaway& breakaway : hand_.breakaways) {
        if (breakaway.leader != own) continue;
        const double m = hand_.model.joints[breakaway.joint].mimic->multiplier;
        motor.inner = motor.joint;
        motor.joint = engine_joint(breakaway.joint);
        motor.along = motor.inner;
        motor.gear = 1 / breakaway.rate;
        motor.share = (1 - m / breakaway.rate) * breakaway.rate;
      }
      motor.coordinate = out_.coordinate[static_cast<std::size_t>(motor.joint)];
      if (motor.along >= 0) {
        motor.along_coordinate = out_.coordinate[static_cast<std::size_t>(motor.along)];
      }
      bool several = false;
      for (const Joint& other : hand_.model.joints) {
        several = several || (other.mimic && other.mimic->joint == own && motor.inner < 0);
      }
      if (!several) {
        motor.finger = out_.finger_of_body[out_.body_of_link[out_.model.link_index(
            prefix_ + hand_.model.links[joint.child].name)]];
      }
      out_.motors.push_back(motor);
    }
  }

  const robot::HandModel& hand_;
  const std::string& prefix_;
  const HandMechanics& mechanics_;
  RobotBodies out_;
  std::vector<char> moves_hand_;         // of each joint of the model
  std::vector<RigidTransform> X_WL_;     // at the start, the hand's joints at 0
  std::vector<std::vector<int>> links_;  // of each body, the first gives it its frame
  std::vector<int> joint_of_;            // of each body in the model
  int coordinates_ = 0;
};

}  // namespace

void RobotBodies::link_poses(const RigidTransform& X_WR, const Eigen::VectorXd& all,
                             std::vector<RigidTransform>& X_WL) const {
  X_WL.resize(model.links.size());
  X_WL[0] = X_WR;
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    const robot::Joint& joint = model.joints[j];
    X_WL[joint.child] = X_WL[joint.parent] * joint.pose_at(all[static_cast<Eigen::Index>(j)]);
  }
}

RobotBodies make_robot_bodies(const robot::RobotModel& model, const robot::HandModel& hand,
                              const std::string& prefix, const RigidTransform& X_WR,
                              const Eigen::VectorXd& all, const HandMechanics& mechanics) {
  return Builder(model, hand, prefix, X_WR, all, mechanics).build();
}

}  // namespace prehend::simulation
