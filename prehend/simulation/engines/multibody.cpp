// The system's coordinates: where bodies are and how they move.

#include "prehend/simulation/engines/multibody.h"

#include <algorithm>
#include <cmath>

#include "prehend/contact/require.h"
#include "prehend/contact/rotation.h"
#include "prehend/contact/sdirk.h"
#include "prehend/simulation/engines/inertia.h"
#include "prehend/simulation/engines/twist_rows.h"

namespace prehend::simulation::engines {
namespace {

using contact::rotation_by;
using contact::rotation_vector;
using geometry::RigidTransform;

constexpr double kStandardGravity = 9.81;  // m/s^2, of the weight that kSink speaks of

}  // namespace

Multibody::Multibody(const EngineScene& scene) : scene_(scene), pads_(PadOnBody::all(scene)) {
  const std::size_t count = scene.bodies.size();
  joint_of_.assign(count, -1);
  for (std::size_t j = 0; j < scene.joints.size(); ++j) {
    const EngineJoint& joint = scene.joints[j];
    joint_of_[joint.body] = static_cast<int>(j);
    coordinate_.push_back(joint.follows >= 0 ? coordinate_[joint.follows] : joint_coordinates_++);
  }
  size_ = joint_coordinates_;
  columns_.resize(count);
  free_.assign(count, -1);
  for (std::size_t b = 0; b < count; ++b) {
    const EngineBody& body = scene.bodies[b];
    moments_.push_back(principal_inertia(body));
    reach_.push_back(bounding_radius(body.shape) + body.X_BS.translation().norm());
    padded_.push_back(has_pads(scene, static_cast<int>(b)));
    if (joint_of_[b] >= 0) {
      const EngineJoint& joint = scene.joints[joint_of_[b]];
      if (joint.parent >= 0) columns_[b] = columns_[joint.parent];
      const int own = coordinate_[joint_of_[b]];
      if (std::find(columns_[b].begin(), columns_[b].end(), own) == columns_[b].end()) {
        columns_[b].push_back(own);
      }
    } else if (!body.is_fixed) {
      free_[b] = size_;
      for (int k = 0; k < 6; ++k) columns_[b].push_back(size_++);
    }
  }
  double heaviest = 0;
  for (std::size_t b = 0; b < count; ++b) {
    if (!columns_[b].empty()) heaviest = std::max(heaviest, scene.bodies[b].mass);
  }
  law_.stiffness = law_.bristle_stiffness = heaviest * kStandardGravity / kSink;
  law_.damping = law_.bristle_damping = 2 * std::sqrt(law_.stiffness * heaviest);
  law_.bristle_law = contact::BristleLaw::kElastoPlastic;
  law_.return_map = true;
  ground_law_ = law_;
  joint_force_.assign(scene.joints.size(), 0.0);
  drive_force_.assign(scene.joints.size(), 0.0);
  mechanics_.resize(scene.joints.size());
  drives_.resize(scene.joints.size());
  drive_row_.assign(scene.joints.size(), -1);
  rows_.reserve(4 * scene.joints.size());
  prescribed_.assign(count, 0);
  X_WPrescribed_.assign(count, RigidTransform::Identity());
  asleep_.assign(count, 0);
  drift_.assign(count, Vector6::Zero());
  travel_.assign(count, 0.0);
  block_.resize(count);
  block_force_.resize(count);
  active_.assign(size_, -1);
  wrench_.assign(count, Vector6::Zero());
  pad_places_.resize(pads_.size());
  pad_near_.assign(pads_.size(), 0);
  matrix_.resize(size_, size_);
  right_.resize(size_);
}

void Multibody::set_joint_force(int joint, double force) {
  contact::require(std::isfinite(force), "the force of joint " + std::to_string(joint), "finite");
  joint_force_.at(joint) = force;
}

void Multibody::set_body_wrench(int body, const Vector6& wrench) {
  contact::require(wrench.allFinite(), "the wrench on body " + std::to_string(body), "finite");
  wrench_.at(body) = wrench;
}

void Multibody::prescribe(int body, const RigidTransform& X_WB) {
  const std::string name = "prescribed body " + std::to_string(body);
  contact::require(columns_.at(body).empty(), name, "fixed");
  contact::require(X_WB.matrix().allFinite(), name + ": X_WB", "finite");
  prescribed_[body] = 1;
  X_WPrescribed_[body] = X_WB;
}

void Multibody::set_asleep(int body, bool asleep) {
  contact::require(free_.at(body) >= 0, "body " + std::to_string(body), "free to sleep");
  asleep_[body] = asleep ? 1 : 0;
}

void Multibody::set_contact_stiffness(double stiffness, double damping) {
  contact::require_positive(stiffness, "the stiffness of contacts");
  contact::require_positive(damping, "the damping of contacts");
  law_.stiffness = law_.bristle_stiffness = stiffness;
  law_.damping = law_.bristle_damping = damping;
  ground_law_ = law_;
}

void Multibody::set_ground_stiffness(double stiffness, double damping) {
  contact::require_positive(stiffness, "the stiffness of contacts with the ground");
  contact::require_positive(damping, "the damping of contacts with the ground");
  ground_law_.stiffness = ground_law_.bristle_stiffness = stiffness;
  ground_law_.damping = ground_law_.bristle_damping = damping;
}

MultibodyState Multibody::initial_state() const {
  MultibodyState state;
  state.positions = Eigen::VectorXd::Zero(joint_coordinates_);
  state.velocities = Eigen::VectorXd::Zero(size_);
  for (std::size_t b = 0; b < scene_.bodies.size(); ++b) {
    const EngineBody& body = scene_.bodies[b];
    state.X_WB.push_back(body.X_WB);
    if (free_[b] >= 0) {
      state.velocities.segment<3>(free_[b]) = body.velocity;
      state.velocities.segment<3>(free_[b] + 3) = body.angular_velocity;
    }
    const int j = joint_of_[b];
    if (j < 0 || scene_.joints[j].follows >= 0) continue;
    const EngineJoint& joint = scene_.joints[j];
    state.velocities[coordinate_[j]] = joint.axis_W.dot(
        joint.kind == EngineJoint::Kind::kPrismatic ? body.velocity : body.angular_velocity);
  }
  for (const PadOnBody& touch : pads_) state.pads.emplace_back(touch.layout, touch.law);
  state.pad_loads.resize(pads_.size());
  complete(state);
  return state;
}

void Multibody::complete(MultibodyState& state) const {
  Configuration& at = completed_;
  place(state.positions, state.X_WB, at);
  state.X_WB = at.X_WB;
  state.momenta.resize(scene_.bodies.size());
  for (std::size_t b = 0; b < scene_.bodies.size(); ++b) {
    const Vector6 twist = twist_of(static_cast<int>(b), at, state.velocities);
    state.momenta[b] << scene_.bodies[b].mass * twist.head<3>(),
        inertia_W(static_cast<int>(b), at.X_WB[b]) * twist.tail<3>();
  }
}

// Parents stand before their children.
void Multibody::place(const Eigen::VectorXd& positions, const std::vector<RigidTransform>& free,
                      Configuration& out) const {
  const std::size_t count = scene_.bodies.size();
  out.X_WB.resize(count);
  out.jacobian.resize(count);
  out.drift.resize(count);
  for (std::size_t b = 0; b < count; ++b) {
    const int j = joint_of_[b];
    Matrix6X& J = out.jacobian[b];
    J.setZero(6, static_cast<Eigen::Index>(columns_[b].size()));
    if (j < 0) {
      out.X_WB[b] = free[b];
      out.drift[b] = drift_[b];
      if (free_[b] >= 0) J.setIdentity();
      continue;
    }
    const EngineJoint& joint = scene_.joints[j];
    // How the parent has moved since the start.
    RigidTransform moved = RigidTransform::Identity();
    if (joint.parent >= 0) {
      moved = out.X_WB[joint.parent] * scene_.bodies[joint.parent].X_WB.inverse(Eigen::Isometry);
    }
    const double ratio = joint.follows >= 0 ? joint.ratio : 1.0;
    const double q = ratio * positions[coordinate_[j]];
    const Eigen::Vector3d axis = moved.linear() * joint.axis_W;
    RigidTransform step = RigidTransform::Identity();
    const bool slides = joint.kind == EngineJoint::Kind::kPrismatic;
    if (slides) {
      step.translation() = q * joint.axis_W;
    } else {
      step.linear() = Eigen::AngleAxisd(q, joint.axis_W).toRotationMatrix();
      step.translation() = joint.anchor_W - step.linear() * joint.anchor_W;
    }
    out.X_WB[b] = moved * step * scene_.bodies[b].X_WB;
    const Eigen::Vector3d p = out.X_WB[b].translation();
    out.drift[b].setZero();
    if (joint.parent >= 0) {
      const Matrix6X& parent = out.jacobian[joint.parent];
      const Eigen::Vector3d arm = p - out.X_WB[joint.parent].translation();
      const Vector6& carried = out.drift[joint.parent];
      out.drift[b] << carried.head<3>() + carried.tail<3>().cross(arm), carried.tail<3>();
      J.topLeftCorner(3, parent.cols()).noalias() = point_rows(arm) * parent;
      J.bottomLeftCorner(3, parent.cols()) = parent.bottomRows<3>();
    }
    const auto own = std::find(columns_[b].begin(), columns_[b].end(), coordinate_[j]);
    auto column = J.col(own - columns_[b].begin());
    if (slides) {
      column.head<3>() += ratio * axis;
    } else {
      column.head<3>() += ratio * axis.cross(p - moved * joint.anchor_W);
      column.tail<3>() += ratio * axis;
    }
  }
}

void Multibody::advance_free(const MultibodyState& base, double h, const Eigen::VectorXd& u,
                             std::vector<RigidTransform>& X_WB) const {
  X_WB.resize(base.X_WB.size());
  for (std::size_t b = 0; b < X_WB.size(); ++b) {
    X_WB[b] = prescribed_[b] ? X_WPrescribed_[b] : base.X_WB[b];
    if (free_[b] < 0 || asleep_[b]) continue;
    X_WB[b].translation() += h * u.segment<3>(free_[b]);
    const Eigen::Quaterniond q =
        rotation_by(h * u.segment<3>(free_[b] + 3)) * Eigen::Quaterniond(base.X_WB[b].linear());
    X_WB[b].linear() = q.normalized().toRotationMatrix();
  }
}

Vector6 Multibody::twist_of(int body, const Configuration& at, const Eigen::VectorXd& u) const {
  Vector6 twist = at.drift[body];
  const std::vector<int>& columns = columns_[body];
  for (std::size_t k = 0; k < columns.size(); ++k) {
    twist += at.jacobian[body].col(static_cast<Eigen::Index>(k)) * u[columns[k]];
  }
  return twist;
}

Eigen::Matrix3d Multibody::inertia_W(int body, const RigidTransform& X_WB) const {
  return X_WB.linear() * moments_[body].asDiagonal() * X_WB.linear().transpose();
}

void Multibody::extrapolate(const MultibodyState& y0, const MultibodyState& y1, double share,
                            MultibodyState& out) const {
  out = y1;
  out.time = y0.time + share * (y1.time - y0.time);
  out.positions = y0.positions + share * (y1.positions - y0.positions);
  for (std::size_t b = 0; b < out.X_WB.size(); ++b) {
    if (free_[b] < 0) continue;
    const Eigen::Vector3d p0 = y0.X_WB[b].translation();
    out.X_WB[b].translation() = p0 + share * (y1.X_WB[b].translation() - p0);
    const Eigen::Quaterniond q0(y0.X_WB[b].linear()), q1(y1.X_WB[b].linear());
    out.X_WB[b].linear() =
        (rotation_by(share * rotation_vector(q1 * q0.conjugate())) * q0).toRotationMatrix();
  }
  complete(out);
  for (std::size_t b = 0; b < out.momenta.size(); ++b) {
    out.momenta[b] = y0.momenta[b] + share * (y1.momenta[b] - y0.momenta[b]);
  }
  // Of joints' velocities those of rotors count.
  out.velocities = y0.velocities + share * (y1.velocities - y0.velocities);
  // What ceased to touch has lost its bristle; there is nothing to extrapolate.
  for (TouchPoint& touch : out.touches) {
    touch.turn *= share;
    touch.foreseen = touch.at.depth + share * (touch.foreseen - touch.at.depth);
    if (touch.normal_force > 0) {
      touch.bristle = touch.bristle_at_start + share * (touch.bristle - touch.bristle_at_start);
    }
  }
  for (std::size_t k = 0; k < out.pads.size(); ++k) {
    const contact::PadState &a = y0.pads[k], &b = y1.pads[k];
    for (std::size_t i = 0; i < b.normal_force.size(); ++i) {
      const bool presses = b.normal_force[i] > 0;
      out.pads[k].bristle_u[i] =
          presses ? a.bristle_u[i] + share * (b.bristle_u[i] - a.bristle_u[i]) : 0.0;
      out.pads[k].bristle_v[i] =
          presses ? a.bristle_v[i] + share * (b.bristle_v[i] - a.bristle_v[i]) : 0.0;
    }
    contact::sdirk_keep_foam(b, out.pads[k]);
  }
}

double Multibody::joint_position(const MultibodyState& state, int joint) const {
  const EngineJoint& j = scene_.joints.at(joint);
  return (j.follows >= 0 ? j.ratio : 1.0) * state.positions[coordinate_[joint]];
}

BodyMotion Multibody::motion(const MultibodyState& state, int body) const {
  BodyMotion motion;
  motion.X_WB = state.X_WB.at(body);
  const Vector6& momentum = state.momenta[body];
  motion.velocity = momentum.head<3>() / scene_.bodies[body].mass;
  const Eigen::Matrix3d R = motion.X_WB.linear();
  motion.angular_velocity = R * (R.transpose() * momentum.tail<3>()).cwiseQuotient(moments_[body]);
  return motion;
}

double Multibody::energy(const MultibodyState& state) const {
  double energy = 0;
  for (std::size_t j = 0; j < scene_.joints.size(); ++j) {
    const double velocity = state.velocities[coordinate_[j]];
    energy += 0.5 * mechanics_[j].rotor_inertia * velocity * velocity;
  }
  for (std::size_t b = 0; b < scene_.bodies.size(); ++b) {
    if (columns_[b].empty()) continue;
    const BodyMotion motion = this->motion(state, static_cast<int>(b));
    energy += 0.5 * (motion.velocity.dot(state.momenta[b].head<3>()) +
                     motion.angular_velocity.dot(state.momenta[b].tail<3>())) -
              scene_.bodies[b].mass * scene_.gravity.dot(motion.X_WB.translation());
  }
  return energy;
}

}  // namespace prehend::simulation::engines
