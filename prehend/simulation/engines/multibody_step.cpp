// The step: contacts, the linear system and its solution.

#include <algorithm>
#include <cmath>

#include "prehend/contact/pad_readings.h"
#include "prehend/contact/rotation.h"
#include "prehend/contact/texel.h"
#include "prehend/geometry/symmetric_solve.h"
#include "prehend/simulation/engines/multibody.h"
#include "prehend/simulation/engines/twist_rows.h"

namespace prehend::simulation::engines {
namespace {

using geometry::RigidTransform;

constexpr double kSlack = 1e-4;       // m, looked ahead beyond what speeds say
constexpr double kSamePoint = 0.003;  // m, within which a contact is known again

}  // namespace

contact::TexelLaw Multibody::contact_law(int a, int b) const {
  contact::TexelLaw law = b < 0 && free_[a] >= 0 ? ground_law_ : law_;
  law.static_friction = law.dynamic_friction = std::min(
      scene_.bodies[a].friction, b < 0 ? scene_.ground_friction : scene_.bodies[b].friction);
  return law;
}

// Bristles and what was borne before, from the step before.
void Multibody::match_touches(const MultibodyState& base, double h, MultibodyState& end) const {
  const auto same_pair = [](const TouchPoint& x, const TouchPoint& y) {
    return x.a == y.a && x.b == y.b;
  };
  for (std::size_t first = 0, last; first < end.touches.size(); first = last) {
    const TouchPoint& pair = end.touches[first];
    for (last = first + 1; last < end.touches.size() && same_pair(end.touches[last], pair);) ++last;
    double borne = 0;
    for (const TouchPoint& before : base.touches) {
      if (same_pair(before, pair)) borne = std::max(borne, before.foreseen - before.unborne);
    }
    borne += std::max(kSurprise, h * kPushOut);
    for (std::size_t i = first; i < last; ++i) {
      TouchPoint& touch = end.touches[i];
      touch.unborne = std::max(0.0, touch.at.depth - borne);
      touch.bristle_at_start.setZero();
      double nearest = kSamePoint * kSamePoint;
      for (const TouchPoint& before : base.touches) {
        if (!same_pair(before, touch)) continue;
        const double distance = (before.p_A - touch.p_A).squaredNorm();
        if (distance >= nearest) continue;
        nearest = distance;
        const Eigen::Vector3d bristle = contact::rotation_by(before.turn) * before.bristle;
        touch.bristle_at_start = bristle - bristle.dot(touch.at.n_W) * touch.at.n_W;
      }
    }
  }
}

void Multibody::find_touches(const MultibodyState& base, double h, const Eigen::VectorXd& u,
                             MultibodyState& end) {
  end.touches.clear();
  if (finder_) {
    finder_->find(*this, base, h, u, end.touches);
    return match_touches(base, h, end);
  }
  const int count = static_cast<int>(scene_.bodies.size());
  // How far each can come in the step.
  for (int b = 0; b < count; ++b) {
    travel_[b] = 0;
    const Vector6 twist = twist_of(b, at_, u);
    if (columns_[b].empty() && twist.isZero(0)) continue;
    double acceleration =
        scene_.gravity.norm() + wrench_[b].head<3>().norm() / scene_.bodies[b].mass;
    if (joint_of_[b] >= 0 && scene_.joints[joint_of_[b]].kind == EngineJoint::Kind::kPrismatic) {
      acceleration += std::abs(joint_force_[joint_of_[b]]) / scene_.bodies[b].mass;
    }
    travel_[b] =
        2 * h * (twist.head<3>().norm() + reach_[b] * twist.tail<3>().norm() + h * acceleration);
  }
  const auto keep = [&](int a, int b) {
    const RigidTransform X_AW = base.X_WB[a].inverse(Eigen::Isometry);
    for (const ConvexContact& at : found_) {
      TouchPoint& touch = end.touches.emplace_back();
      touch.a = a;
      touch.b = b;
      touch.at = at;
      touch.p_A = X_AW * at.p_W;
    }
    found_.clear();
  };
  found_.clear();
  for (int a = 0; a < count; ++a) {
    const EngineBody& body = scene_.bodies[a];
    if (!body.collides || padded_[a]) continue;
    const RigidTransform X_WA = base.X_WB[a] * body.X_BS;
    if (scene_.ground && !columns_[a].empty()) {
      find_ground_contacts(body.shape, X_WA, travel_[a] + kSlack, found_);
      keep(a, -1);
    }
    for (int b = a + 1; b < count; ++b) {
      const EngineBody& other = scene_.bodies[b];
      if (!other.collides || padded_[b] || (columns_[a].empty() && columns_[b].empty())) continue;
      if (joint_of_[b] >= 0 && scene_.joints[joint_of_[b]].parent == a) continue;
      find_contacts(body.shape, X_WA, other.shape, base.X_WB[b] * other.X_BS,
                    travel_[a] + travel_[b] + kSlack, found_);
      keep(a, b);
    }
  }
  match_touches(base, h, end);
}

void Multibody::number_active() {
  active_size_ = 0;
  for (int k = 0; k < size_; ++k) active_[k] = active_size_++;
  for (std::size_t b = 0; b < scene_.bodies.size(); ++b) {
    if (!asleep_[b]) continue;
    active_size_ = 0;
    for (int k = 0; k < 6; ++k) active_[free_[b] + k] = -1;
    for (int& place : active_) {
      if (place >= 0) place = active_size_++;
    }
  }
}

void Multibody::clear_blocks() {
  for (Matrix6& block : block_) block.setZero();
  for (Vector6& force : block_force_) force.setZero();
  pairs_.clear();
}

template <class Rows, class Resistance, class Constant>
void Multibody::add(int a, const Rows& rows_a, int b, const Rows& rows_b,
                    const Resistance& resistance, const Constant& constant, double h) {
  const Rows pressed_a = h * resistance * rows_a;
  block_[a].noalias() += rows_a.transpose() * pressed_a;
  block_force_[a].noalias() += h * rows_a.transpose() * constant;
  if (b < 0) return;
  const Rows pressed_b = h * resistance * rows_b;
  block_[b].noalias() += rows_b.transpose() * pressed_b;
  block_force_[b].noalias() -= h * rows_b.transpose() * constant;
  if (pairs_.empty() || pairs_.back().a != a || pairs_.back().b != b) {
    pairs_.push_back({a, b, Matrix6::Zero()});
  }
  pairs_.back().resistance.noalias() += rows_a.transpose() * pressed_b;
}

// Adds J_a' (factor resistance) J_b, and to the right what prescribed motion of b does.
void Multibody::project(int a, const Matrix6& resistance, int b, double factor) {
  const Vector6 drifting = factor * (resistance * at_.drift[b]);
  for (std::size_t r = 0; r < columns_[a].size(); ++r) {
    const int row = active_[columns_[a][r]];
    if (row < 0) continue;
    const auto column = at_.jacobian[a].col(static_cast<Eigen::Index>(r));
    const Vector6 pulled = factor * (resistance.transpose() * column);
    right_[row] -= column.dot(drifting);
    for (std::size_t c = 0; c < columns_[b].size(); ++c) {
      const int place = active_[columns_[b][c]];
      if (place < 0) continue;
      matrix_(row, place) += pulled.dot(at_.jacobian[b].col(static_cast<Eigen::Index>(c)));
    }
  }
}

void Multibody::project_blocks() {
  for (std::size_t b = 0; b < block_.size(); ++b) {
    if (columns_[b].empty() || asleep_[b]) continue;
    const int body = static_cast<int>(b);
    project(body, block_[b], body, 1);
    for (std::size_t r = 0; r < columns_[b].size(); ++r) {
      right_[active_[columns_[b][r]]] +=
          at_.jacobian[b].col(static_cast<Eigen::Index>(r)).dot(block_force_[b]);
    }
  }
  for (const PairBlock& pair : pairs_) {
    project(pair.a, pair.resistance, pair.b, -1);
    project(pair.b, pair.resistance.transpose(), pair.a, -1);
  }
}

void Multibody::add_inertia(const MultibodyState& base, double h) {
  for (std::size_t b = 0; b < scene_.bodies.size(); ++b) {
    if (columns_[b].empty() || asleep_[b]) continue;
    Matrix6& inertia = block_[b];
    inertia.setZero();
    inertia.diagonal().head<3>().setConstant(scene_.bodies[b].mass);
    inertia.bottomRightCorner<3, 3>() = inertia_W(static_cast<int>(b), at_.X_WB[b]);
    block_force_[b] = base.momenta[b] + h * wrench_[b];
    block_force_[b].head<3>() += h * scene_.bodies[b].mass * scene_.gravity;
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
  const Eigen::Matrix3d resistance =
      contact.tangential_damping * Eigen::Matrix3d::Identity() +
      (contact.normal_damping - contact.tangential_damping) * n * n.transpose();
  const Eigen::Vector3d constant =
      contact.normal_offset * n - contact.bristle_gain * touch.bristle_at_start;
  add(touch.a, rows_a, touch.b, rows_b, resistance, constant, h);
}

Vector6 Multibody::pad_twist(std::size_t index, const Eigen::VectorXd& u) const {
  const PadOnBody& touch = pads_[index];
  const PadOnBody::Place& place = pad_places_[index];
  const Eigen::Matrix3d R = place.X_WP.linear();
  return frame_rows(place.arm_body, R) * twist_of(touch.body, at_, u) -
         frame_rows(place.arm_carrier, R) * twist_of(touch.carrier, at_, u);
}

void Multibody::add_pad(std::size_t index, const MultibodyState& base, double h,
                        const Eigen::VectorXd& u, contact::PadState& state) {
  PadOnBody& touch = pads_[index];
  state.bristle_u = base.pads[index].bristle_u;
  state.bristle_v = base.pads[index].bristle_v;
  state.foam = base.pads[index].foam;
  state.foam_due = base.pads[index].foam_due;
  contact::respond(touch.layout, touch.law, h, pad_twist(index, u), state, touch.scratch,
                   touch.response);
  if (touch.response.pressing == 0) return;
  const Eigen::Matrix3d R = pad_places_[index].X_WP.linear();
  add(touch.body, frame_rows(pad_places_[index].arm_body, R), touch.carrier,
      frame_rows(pad_places_[index].arm_carrier, R), touch.response.resistance,
      touch.response.constant, h);
}

double Multibody::surface_change(const Configuration& at, const Eigen::VectorXd& from,
                                 const Eigen::VectorXd& to) const {
  double most = 0;
  for (std::size_t b = 0; b < scene_.bodies.size(); ++b) {
    Vector6 twist = Vector6::Zero();
    for (std::size_t k = 0; k < columns_[b].size(); ++k) {
      const int c = columns_[b][k];
      twist += at.jacobian[b].col(static_cast<Eigen::Index>(k)) * (to[c] - from[c]);
    }
    most = std::max(most, twist.head<3>().norm() + reach_[b] * twist.tail<3>().norm());
  }
  return most;
}

void Multibody::implicit_euler(const MultibodyState& base, double h, const MultibodyState& guess,
                               MultibodyState& end) {
  for (std::size_t b = 0; b < drift_.size(); ++b) {
    drift_[b].setZero();
    if (!prescribed_[b]) continue;
    const RigidTransform& X = X_WPrescribed_[b];
    const Eigen::Matrix3d turned = X.linear() * base.X_WB[b].linear().transpose();
    drift_[b] << (X.translation() - base.X_WB[b].translation()) / h,
        contact::rotation_vector(Eigen::Quaterniond(turned)) / h;
  }
  number_active();
  u_ = guess.velocities;
  for (int k = 0; k < size_; ++k) {
    if (active_[k] < 0) u_[k] = 0;
  }
  place(base.positions, base.X_WB, at_);
  find_touches(base, h, u_, end);
  if (end.pads.size() != pads_.size()) {
    end.pads = base.pads;
    end.pad_loads = base.pad_loads;
  }
  for (std::size_t k = 0; k < pads_.size(); ++k) {
    PadOnBody& touch = pads_[k];
    pad_places_[k] = touch.place(base.X_WB[touch.carrier], base.X_WB[touch.body]);
    const Vector6 twist = pad_twist(k, u_);
    const double speed = twist.head<3>().norm() + reach_[touch.body] * twist.tail<3>().norm();
    double acceleration = scene_.gravity.norm();
    const int joint = joint_of_[touch.carrier];
    if (joint >= 0)
      acceleration += std::abs(joint_force_[joint]) / scene_.bodies[touch.carrier].mass;
    touch.response.pressing = 0;
    pad_near_[k] = touch.find_depths(pad_places_[k], base.X_WB[touch.body],
                                     2 * h * (speed + h * acceleration), end.pads[k]);
    // What was not near is released already, but for what its foam has still to do.
    const bool remembers = touch.law.memory.terms() > 0;
    if (!pad_near_[k] && (end.pad_loads[k].is_near || remembers)) {
      end.pads[k].foam = base.pads[k].foam;
      end.pads[k].foam_due = base.pads[k].foam_due;
      contact::release(touch.layout, touch.law, h, end.pads[k]);
    }
    end.pad_loads[k] = {};
    end.pad_loads[k].is_near = pad_near_[k] != 0;
  }
  solved_ = u_;
  for (int iteration = 0; iteration < kMostIterations; ++iteration) {
    advance_free(base, h, u_, free_poses_);
    positions_ = base.positions + h * u_.head(joint_coordinates_);
    place(positions_, free_poses_, at_);
    auto matrix = matrix_.topLeftCorner(active_size_, active_size_);
    auto right = right_.head(active_size_);
    matrix.setZero();
    right.setZero();
    linearised_.clear();
    clear_blocks();
    add_inertia(base, h);
    if (iteration == 0) {
      // Rows are as stiff as the inertia alone demands.
      project_blocks();
      add_joints(base, h);
      begin_rows(base, h, u_);
      matrix.setZero();
      right.setZero();
    }
    for (TouchPoint& touch : end.touches) add_touch(base, touch, h, u_);
    for (std::size_t k = 0; k < pads_.size(); ++k) {
      if (pad_near_[k]) add_pad(k, base, h, u_, end.pads[k]);
    }
    project_blocks();
    add_joints(base, h);
    add_rows(h);
    geometry::cholesky_solve_in_place(matrix, right);
    for (int k = 0; k < size_; ++k) {
      if (active_[k] >= 0) solved_[k] = right[active_[k]];
    }
    bool changed = false;
    for (JointRow& row : rows_) changed = row.choose(solved_) || changed;
    const double change = surface_change(at_, u_, solved_);
    u_.swap(solved_);
    if (change < kTolerance && !changed) break;
  }
  finish(base, h, u_, end);
  std::fill(prescribed_.begin(), prescribed_.end(), 0);
}

void Multibody::finish(const MultibodyState& base, double h, const Eigen::VectorXd& u,
                       MultibodyState& end) {
  for (std::size_t i = 0; i < end.touches.size(); ++i) {
    TouchPoint& touch = end.touches[i];
    const contact::LinearisedContact& contact = linearised_[i];
    touch.normal_force = 0;
    touch.bristle.setZero();
    touch.force.setZero();
    touch.turn.setZero();
    const Eigen::Vector3d n = touch.at.n_W;
    const Vector6 twist_a = twist_of(touch.a, at_, u);
    Eigen::Vector3d v = point_rows(touch.at.p_W - base.X_WB[touch.a].translation()) * twist_a;
    double spin = 0;
    if (touch.b >= 0) {
      const Vector6 twist_b = twist_of(touch.b, at_, u);
      v -= point_rows(touch.at.p_W - base.X_WB[touch.b].translation()) * twist_b;
      const double spin_a = twist_a.tail<3>().dot(n), spin_b = twist_b.tail<3>().dot(n);
      if (spin_a * spin_b > 0) spin = std::abs(spin_a) < std::abs(spin_b) ? spin_a : spin_b;
    }
    touch.foreseen = touch.at.depth - h * v.dot(n);
    if (!contact.presses) continue;
    touch.normal_force = std::max(0.0, contact.normal_offset - contact.normal_damping * v.dot(n));
    const Eigen::Vector3d slip = v - v.dot(n) * n;
    touch.force = touch.normal_force * n - contact.bristle_gain * touch.bristle_at_start -
                  contact.tangential_damping * slip;
    touch.bristle =
        contact::return_mapped(contact_law(touch.a, touch.b), touch.normal_force,
                               contact::advanced_bristle(contact, h, touch.bristle_at_start, slip));
    // What is held turns with what holds it; turns across the normal come with the next step's
    // normal. (Free bodies that tumble over one another keep a contact too briefly.)
    if (touch.b >= 0 && (free_[touch.a] < 0 || free_[touch.b] < 0)) touch.turn = h * spin * n;
  }
  for (std::size_t k = 0; k < pads_.size(); ++k) {
    if (!pad_near_[k]) continue;
    PadOnBody& touch = pads_[k];
    if (touch.response.pressing == 0) {
      contact::release(touch.layout, touch.law, h, end.pads[k]);
      continue;
    }
    const Vector6 twist = pad_twist(k, u);
    contact::advance(touch.layout, touch.law, h, twist, end.pads[k], touch.scratch);
    const Vector6 wrench_P = touch.response.constant - touch.response.resistance * twist;
    const Eigen::Matrix3d R = pad_places_[k].X_WP.linear();
    PadLoad& load = end.pad_loads[k];
    load.p_W = pad_places_[k].X_WP.translation();
    load.wrench_W << R * wrench_P.head<3>(), R * wrench_P.tail<3>();
    load.normal_force = contact::total_normal_force(touch.layout, end.pads[k]);
  }
  for (std::size_t j = 0; j < scene_.joints.size(); ++j) {
    drive_force_[j] = drive_row_[j] < 0 ? 0.0 : rows_[drive_row_[j]].force(u);
  }
  end.time = base.time + h;
  end.velocities = u;
  end.positions = base.positions + h * u.head(joint_coordinates_);
  advance_free(base, h, u, end.X_WB);
  complete(end);
}

}  // namespace prehend::simulation::engines
