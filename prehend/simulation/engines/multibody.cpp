#include "prehend/simulation/engines/multibody.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>

#include "prehend/contact/rotation.h"
#include "prehend/contact/texel.h"
#include "prehend/simulation/engines/inertia.h"

namespace prehend::simulation::engines {
namespace {

using contact::rotation_by;
using contact::rotation_vector;
using geometry::RigidTransform;
using PointRows = Eigen::Matrix<double, 3, 6>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

constexpr double kStandardGravity = 9.81;  // m/s^2, of the weight that kSink speaks of
constexpr double kSlack = 1e-4;            // m, looked ahead beyond what speeds say
constexpr double kSamePoint = 0.003;       // m, within which a contact is known again

Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

// From a twist about the body's origin to the velocity of a point at `arm` from it.
PointRows point_rows(const Eigen::Vector3d& arm) {
  PointRows rows;
  rows << Eigen::Matrix3d::Identity(), -cross_matrix(arm);
  return rows;
}

// The same, with the angular velocity, and into axes of R's frame.
Matrix6 frame_rows(const Eigen::Vector3d& arm, const Eigen::Matrix3d& R) {
  Matrix6 rows = Matrix6::Zero();
  rows.topRows<3>() = R.transpose() * point_rows(arm);
  rows.bottomRightCorner<3, 3>() = R.transpose();
  return rows;
}

}  // namespace

Multibody::Multibody(const EngineScene& scene) : scene_(scene), pads_(PadTouch::all(scene)) {
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
  joint_force_.assign(scene.joints.size(), 0.0);
  wrench_.assign(count, Vector6::Zero());
  pad_places_.resize(pads_.size());
  pad_near_.assign(pads_.size(), 0);
  matrix_.resize(size_, size_);
  right_.resize(size_);
}

void Multibody::set_joint_force(int joint, double force) { joint_force_.at(joint) = force; }
void Multibody::set_body_wrench(int body, const Vector6& wrench) { wrench_.at(body) = wrench; }

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
  for (const PadTouch& touch : pads_) state.pads.emplace_back(touch.layout);
  complete(state);
  return state;
}

void Multibody::complete(MultibodyState& state) const {
  Configuration at;
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
  for (std::size_t b = 0; b < count; ++b) {
    const int j = joint_of_[b];
    Matrix6X& J = out.jacobian[b];
    J.setZero(6, static_cast<Eigen::Index>(columns_[b].size()));
    if (j < 0) {
      out.X_WB[b] = free[b];
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
    if (joint.parent >= 0) {
      const Matrix6X& parent = out.jacobian[joint.parent];
      const Eigen::Vector3d arm = p - out.X_WB[joint.parent].translation();
      J.topLeftCorner(3, parent.cols()) = point_rows(arm) * parent;
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
    X_WB[b] = base.X_WB[b];
    if (free_[b] < 0) continue;
    X_WB[b].translation() += h * u.segment<3>(free_[b]);
    const Eigen::Quaterniond q =
        rotation_by(h * u.segment<3>(free_[b] + 3)) * Eigen::Quaterniond(base.X_WB[b].linear());
    X_WB[b].linear() = q.normalized().toRotationMatrix();
  }
}

Vector6 Multibody::twist_of(int body, const Configuration& at, const Eigen::VectorXd& u) const {
  Vector6 twist = Vector6::Zero();
  const std::vector<int>& columns = columns_[body];
  for (std::size_t k = 0; k < columns.size(); ++k) {
    twist += at.jacobian[body].col(static_cast<Eigen::Index>(k)) * u[columns[k]];
  }
  return twist;
}

Eigen::Matrix3d Multibody::inertia_W(int body, const RigidTransform& X_WB) const {
  return X_WB.linear() * moments_[body].asDiagonal() * X_WB.linear().transpose();
}

contact::TexelLaw Multibody::contact_law(int a, int b) const {
  contact::TexelLaw law = law_;
  law.static_friction = law.dynamic_friction = std::min(
      scene_.bodies[a].friction, b < 0 ? scene_.ground_friction : scene_.bodies[b].friction);
  return law;
}

void Multibody::find_touches(const MultibodyState& base, double h, const Eigen::VectorXd& u,
                             MultibodyState& end) {
  const int count = static_cast<int>(scene_.bodies.size());
  // How far each can come in the step.
  std::vector<double> travel(count, 0.0);
  for (int b = 0; b < count; ++b) {
    if (columns_[b].empty()) continue;
    const Vector6 twist = twist_of(b, at_, u);
    double acceleration =
        scene_.gravity.norm() + wrench_[b].head<3>().norm() / scene_.bodies[b].mass;
    if (joint_of_[b] >= 0 && scene_.joints[joint_of_[b]].kind == EngineJoint::Kind::kPrismatic) {
      acceleration += std::abs(joint_force_[joint_of_[b]]) / scene_.bodies[b].mass;
    }
    travel[b] =
        2 * h * (twist.head<3>().norm() + reach_[b] * twist.tail<3>().norm() + h * acceleration);
  }
  std::vector<ConvexContact> found;
  const auto keep = [&](int a, int b) {
    const RigidTransform X_AW = base.X_WB[a].inverse(Eigen::Isometry);
    double borne = 0;
    for (const TouchPoint& before : base.touches) {
      if (before.a == a && before.b == b) borne = std::max(borne, before.foreseen - before.unborne);
    }
    borne += std::max(kSurprise, h * kPushOut);
    for (const ConvexContact& at : found) {
      TouchPoint touch;
      touch.a = a;
      touch.b = b;
      touch.at = at;
      touch.p_A = X_AW * at.p_W;
      touch.unborne = std::max(0.0, at.depth - borne);
      double nearest = kSamePoint * kSamePoint;
      for (const TouchPoint& before : base.touches) {
        const double distance = (before.p_A - touch.p_A).squaredNorm();
        if (before.a != a || before.b != b || distance >= nearest) continue;
        nearest = distance;
        touch.bristle_at_start = before.bristle - before.bristle.dot(at.n_W) * at.n_W;
      }
      end.touches.push_back(touch);
    }
    found.clear();
  };
  end.touches.clear();
  for (int a = 0; a < count; ++a) {
    const EngineBody& body = scene_.bodies[a];
    if (!body.collides || padded_[a]) continue;
    const RigidTransform X_WA = base.X_WB[a] * body.X_BS;
    if (scene_.ground && !columns_[a].empty()) {
      find_ground_contacts(body.shape, X_WA, travel[a] + kSlack, found);
      keep(a, -1);
    }
    for (int b = a + 1; b < count; ++b) {
      const EngineBody& other = scene_.bodies[b];
      if (!other.collides || padded_[b] || (columns_[a].empty() && columns_[b].empty())) continue;
      if (joint_of_[b] >= 0 && scene_.joints[joint_of_[b]].parent == a) continue;
      find_contacts(body.shape, X_WA, other.shape, base.X_WB[b] * other.X_BS,
                    travel[a] + travel[b] + kSlack, found);
      keep(a, b);
    }
  }
}

template <class Rows>
void Multibody::add(int a, const Rows& rows_a, int b, const Rows& rows_b,
                    const Eigen::MatrixXd& resistance, const Eigen::VectorXd& constant, double h) {
  const Eigen::MatrixXd Qa = rows_a * at_.jacobian[a];
  const Eigen::MatrixXd Qb = b < 0 ? Eigen::MatrixXd(rows_b.rows(), 0) : rows_b * at_.jacobian[b];
  const auto scatter = [&](int i, const Eigen::MatrixXd& Qi, int j, const Eigen::MatrixXd& Qj,
                           double factor) {
    if (i < 0 || j < 0) return;
    const Eigen::MatrixXd block = factor * Qi.transpose() * resistance * Qj;
    for (std::size_t r = 0; r < columns_[i].size(); ++r) {
      for (std::size_t c = 0; c < columns_[j].size(); ++c) {
        matrix_(columns_[i][r], columns_[j][c]) +=
            block(static_cast<Eigen::Index>(r), static_cast<Eigen::Index>(c));
      }
    }
  };
  const auto scatter_force = [&](int i, const Eigen::MatrixXd& Qi, double factor) {
    if (i < 0) return;
    const Eigen::VectorXd force = factor * Qi.transpose() * constant;
    for (std::size_t r = 0; r < columns_[i].size(); ++r) {
      right_[columns_[i][r]] += force[static_cast<Eigen::Index>(r)];
    }
  };
  scatter(a, Qa, a, Qa, h);
  scatter(a, Qa, b, Qb, -h);
  scatter(b, Qb, a, Qa, -h);
  scatter(b, Qb, b, Qb, h);
  scatter_force(a, Qa, h);
  scatter_force(b, Qb, -h);
}

void Multibody::add_inertia(const MultibodyState& base, double h) {
  for (std::size_t j = 0; j < scene_.joints.size(); ++j) {
    const EngineJoint& joint = scene_.joints[j];
    right_[coordinate_[j]] += h * (joint.follows >= 0 ? joint.ratio : 1.0) * joint_force_[j];
  }
  for (std::size_t b = 0; b < scene_.bodies.size(); ++b) {
    if (columns_[b].empty()) continue;
    Matrix6 inertia = Matrix6::Zero();
    inertia.diagonal().head<3>().setConstant(scene_.bodies[b].mass);
    inertia.bottomRightCorner<3, 3>() = inertia_W(static_cast<int>(b), at_.X_WB[b]);
    Vector6 wrench = wrench_[b];
    wrench.head<3>() += scene_.bodies[b].mass * scene_.gravity;
    const Matrix6 identity = Matrix6::Identity();
    // As an interaction with the world over a step of one second.
    add(static_cast<int>(b), identity, -1, identity, inertia, base.momenta[b] + h * wrench, 1);
  }
}

void Multibody::add_touch(const MultibodyState& base, TouchPoint& touch, double h,
                          const Eigen::VectorXd& u) {
  const Eigen::Vector3d n = touch.at.n_W;
  const PointRows rows_a = point_rows(touch.at.p_W - base.X_WB[touch.a].translation());
  PointRows rows_b = PointRows::Zero();
  Eigen::Vector3d v = rows_a * twist_of(touch.a, at_, u);
  if (touch.b >= 0) {
    rows_b = point_rows(touch.at.p_W - base.X_WB[touch.b].translation());
    v -= rows_b * twist_of(touch.b, at_, u);
  }
  const Eigen::Vector3d slip = v - v.dot(n) * n;
  linearised_.push_back(contact::linearise(contact_law(touch.a, touch.b), h,
                                           touch.at.depth - touch.unborne, -v.dot(n),
                                           touch.bristle_at_start, slip));
  const contact::LinearisedContact& contact = linearised_.back();
  if (!contact.presses) return;
  const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - n * n.transpose();
  add(touch.a, rows_a, touch.b, rows_b,
      contact.normal_damping * n * n.transpose() + contact.tangential_damping * across,
      contact.normal_offset * n - contact.bristle_gain * touch.bristle_at_start, h);
}

Vector6 Multibody::pad_twist(std::size_t index, const Eigen::VectorXd& u) const {
  const PadTouch& touch = pads_[index];
  const PadTouch::Place& place = pad_places_[index];
  const Eigen::Matrix3d R = place.X_WP.linear();
  return frame_rows(place.arm_body, R) * twist_of(touch.body, at_, u) -
         frame_rows(place.arm_carrier, R) * twist_of(touch.carrier, at_, u);
}

void Multibody::add_pad(std::size_t index, const MultibodyState& base, double h,
                        const Eigen::VectorXd& u, contact::PadState& state) {
  PadTouch& touch = pads_[index];
  state.bristle_u = base.pads[index].bristle_u;
  state.bristle_v = base.pads[index].bristle_v;
  contact::respond(touch.layout, touch.law, h, pad_twist(index, u), state, touch.scratch,
                   touch.response);
  if (touch.response.pressing == 0) return;
  const Eigen::Matrix3d R = pad_places_[index].X_WP.linear();
  add(touch.body, frame_rows(pad_places_[index].arm_body, R), touch.carrier,
      frame_rows(pad_places_[index].arm_carrier, R), touch.response.resistance,
      touch.response.constant, h);
}

double Multibody::surface_speed(const Configuration& at, const Eigen::VectorXd& u) const {
  double most = 0;
  for (std::size_t b = 0; b < scene_.bodies.size(); ++b) {
    const Vector6 twist = twist_of(static_cast<int>(b), at, u);
    most = std::max(most, twist.head<3>().norm() + reach_[b] * twist.tail<3>().norm());
  }
  return most;
}

void Multibody::implicit_euler(const MultibodyState& base, double h, const MultibodyState& guess,
                               MultibodyState& end) {
  Eigen::VectorXd u = guess.velocities;
  std::vector<RigidTransform> free;
  place(base.positions, base.X_WB, at_);
  find_touches(base, h, u, end);
  end.pads = base.pads;
  for (std::size_t k = 0; k < pads_.size(); ++k) {
    PadTouch& touch = pads_[k];
    pad_places_[k] = touch.place(base.X_WB[touch.carrier], base.X_WB[touch.body]);
    const double speed =
        pad_twist(k, u).head<3>().norm() + reach_[touch.body] * pad_twist(k, u).tail<3>().norm();
    double acceleration = scene_.gravity.norm();
    const int joint = joint_of_[touch.carrier];
    if (joint >= 0)
      acceleration += std::abs(joint_force_[joint]) / scene_.bodies[touch.carrier].mass;
    touch.response.pressing = 0;
    pad_near_[k] = touch.find_depths(pad_places_[k], base.X_WB[touch.body],
                                     2 * h * (speed + h * acceleration), end.pads[k]);
  }
  for (int iteration = 0; iteration < kMostIterations; ++iteration) {
    advance_free(base, h, u, free);
    place(base.positions + h * u.head(joint_coordinates_), free, at_);
    matrix_.setZero();
    right_.setZero();
    linearised_.clear();
    add_inertia(base, h);
    for (TouchPoint& touch : end.touches) add_touch(base, touch, h, u);
    for (std::size_t k = 0; k < pads_.size(); ++k) {
      if (pad_near_[k]) add_pad(k, base, h, u, end.pads[k]);
    }
    const Eigen::VectorXd solved = matrix_.llt().solve(right_);
    const double change = surface_speed(at_, solved - u);
    u = solved;
    if (change < kTolerance) break;
  }
  finish(base, h, u, end);
}

void Multibody::finish(const MultibodyState& base, double h, const Eigen::VectorXd& u,
                       MultibodyState& end) {
  for (std::size_t i = 0; i < end.touches.size(); ++i) {
    TouchPoint& touch = end.touches[i];
    const contact::LinearisedContact& contact = linearised_[i];
    touch.normal_force = 0;
    touch.bristle.setZero();
    const Eigen::Vector3d n = touch.at.n_W;
    Eigen::Vector3d v =
        point_rows(touch.at.p_W - base.X_WB[touch.a].translation()) * twist_of(touch.a, at_, u);
    if (touch.b >= 0) {
      v -= point_rows(touch.at.p_W - base.X_WB[touch.b].translation()) * twist_of(touch.b, at_, u);
    }
    touch.foreseen = touch.at.depth - h * v.dot(n);
    if (!contact.presses) continue;
    touch.normal_force = std::max(0.0, contact.normal_offset - contact.normal_damping * v.dot(n));
    const Eigen::Vector3d slip = v - v.dot(n) * n;
    touch.bristle =
        contact::return_mapped(contact_law(touch.a, touch.b), touch.normal_force,
                               contact::advanced_bristle(contact, h, touch.bristle_at_start, slip));
  }
  for (std::size_t k = 0; k < pads_.size(); ++k) {
    if (pad_near_[k] && pads_[k].response.pressing > 0) {
      contact::advance(pads_[k].layout, pads_[k].law, h, pad_twist(k, u), end.pads[k],
                       pads_[k].scratch);
    } else {
      release(end.pads[k]);
    }
  }
  end.time = base.time + h;
  end.velocities = u;
  end.positions = base.positions + h * u.head(joint_coordinates_);
  advance_free(base, h, u, end.X_WB);
  complete(end);
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
  // What ceased to touch has lost its bristle; there is nothing to extrapolate.
  for (TouchPoint& touch : out.touches) {
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
  if (columns_[body].empty()) return motion;
  motion.velocity = momentum.head<3>() / scene_.bodies[body].mass;
  const Eigen::Matrix3d R = motion.X_WB.linear();
  motion.angular_velocity = R * (R.transpose() * momentum.tail<3>()).cwiseQuotient(moments_[body]);
  return motion;
}

double Multibody::energy(const MultibodyState& state) const {
  double energy = 0;
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
