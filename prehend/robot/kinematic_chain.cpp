#include "prehend/robot/kinematic_chain.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "prehend/geometry/errors.h"

namespace prehend::robot {
namespace {

using geometry::InputError;
using geometry::RigidTransform;

constexpr double kDegrees = 57.29577951308232;

void move(const ChainJoint& joint, double position, RigidTransform& X) {
  X = X * joint.X_PJ;
  if (joint.is_revolute) {
    X.rotate(Eigen::AngleAxisd(position, joint.axis_J));
  } else {
    X.translate(position * joint.axis_J);
  }
}

}  // namespace

KinematicChain::KinematicChain(const RobotModel& model, const std::string& base,
                               const std::string& tip) {
  const int first = model.link_index(base);
  std::vector<const Joint*> path;
  for (int link = model.link_index(tip); link != first;) {
    const std::optional<int> above = model.joint_above(link);
    if (!above) {
      throw InputError(
          "Link '" + tip + "' of robot '" + model.name + "' is not below '" + base + "'",
          "Name a base between the root and the tip");
    }
    path.push_back(&model.joints[static_cast<std::size_t>(*above)]);
    link = path.back()->parent;
  }
  std::reverse(path.begin(), path.end());
  RigidTransform before = RigidTransform::Identity();
  for (const Joint* joint : path) {
    if (joint->kind == Joint::Kind::kFixed) {
      before = before * joint->X_PJ;
      continue;
    }
    if (joint->mimic) {
      throw InputError(
          "Joint '" + joint->name + "' between '" + base + "' and '" + tip + "' mimics another",
          "A chain's joints must move by themselves");
    }
    joints_.push_back({joint->name, joint->kind == Joint::Kind::kRevolute, before * joint->X_PJ,
                       joint->axis_J, joint->lower, joint->upper, joint->max_velocity});
    before = RigidTransform::Identity();
  }
  X_JT_ = before;
  if (joints_.empty()) {
    throw InputError("No joint moves between '" + base + "' and '" + tip + "'",
                     "Name links of an arm");
  }
  if (size() > kMostChainJoints) {
    throw InputError(
        std::to_string(size()) + " joints move between '" + base + "' and '" + tip + "'",
        "Name links with at most " + std::to_string(kMostChainJoints));
  }
}

RigidTransform KinematicChain::forward(const Eigen::Ref<const Eigen::VectorXd>& q) const {
  RigidTransform X = RigidTransform::Identity();
  for (int i = 0; i < size(); ++i) move(joints_[static_cast<std::size_t>(i)], q[i], X);
  return X * X_JT_;
}

void KinematicChain::forward(const Eigen::Ref<const Eigen::VectorXd>& q,
                             std::vector<RigidTransform>& poses) const {
  poses.resize(joints_.size());
  RigidTransform X = RigidTransform::Identity();
  for (int i = 0; i < size(); ++i) {
    move(joints_[static_cast<std::size_t>(i)], q[i], X);
    poses[static_cast<std::size_t>(i)] = X;
  }
}

Eigen::Matrix<double, 6, Eigen::Dynamic> KinematicChain::jacobian(
    const Eigen::Ref<const Eigen::VectorXd>& q) const {
  Eigen::Matrix<double, 6, Eigen::Dynamic> result(6, size());
  const Eigen::Vector3d tip = forward(q).translation();
  RigidTransform X = RigidTransform::Identity();
  for (int i = 0; i < size(); ++i) {
    const ChainJoint& joint = joints_[static_cast<std::size_t>(i)];
    move(joint, q[i], X);
    const Eigen::Vector3d axis = X.linear() * joint.axis_J;
    if (joint.is_revolute) {
      result.col(i) << axis.cross(tip - X.translation()), axis;
    } else {
      result.col(i) << axis, Eigen::Vector3d::Zero();
    }
  }
  return result;
}

bool KinematicChain::within_limits(const Eigen::Ref<const Eigen::VectorXd>& q,
                                   double tolerance) const {
  for (int i = 0; i < size(); ++i) {
    const ChainJoint& joint = joints_[static_cast<std::size_t>(i)];
    if (!(q[i] >= joint.lower - tolerance && q[i] <= joint.upper + tolerance)) return false;
  }
  return true;
}

std::string KinematicChain::limit_problem(const Eigen::Ref<const Eigen::VectorXd>& q) const {
  for (int i = 0; i < size(); ++i) {
    const ChainJoint& joint = joints_[static_cast<std::size_t>(i)];
    const bool low = !(q[i] >= joint.lower - 1e-9);
    if (!low && q[i] <= joint.upper + 1e-9) continue;
    const double scale = joint.is_revolute ? kDegrees : 1e3;
    const char* unit = joint.is_revolute ? "deg" : "mm";
    char text[160];
    std::snprintf(text, sizeof text, "joint '%.60s' at %.1f %s is beyond %.1f %s",
                  joint.name.c_str(), scale * q[i], unit, scale * (low ? joint.lower : joint.upper),
                  unit);
    return text;
  }
  return {};
}

Positions KinematicChain::middle() const {
  Positions q(size());
  for (int i = 0; i < size(); ++i) {
    const ChainJoint& joint = joints_[static_cast<std::size_t>(i)];
    const double middle = 0.5 * (joint.lower + joint.upper);
    q[i] = std::isfinite(middle) ? middle : 0;
  }
  return q;
}

}  // namespace prehend::robot
