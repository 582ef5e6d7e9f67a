// The step: contacts, the linear system and its solution.

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

#include "prehend/contact/texel.h"
#include "prehend/simulation/engines/multibody.h"
#include "prehend/simulation/engines/twist_rows.h"

namespace prehend::simulation::engines {
namespace {

using geometry::RigidTransform;

constexpr double kSlack = 1e-4;       // m, looked ahead beyond what speeds say
constexpr double kSamePoint = 0.003;  // m, within which a contact is known again

}  // namespace

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

}  // namespace prehend::simulation::engines
