#include "prehend/simulation/contact_solver.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "prehend/contact/rotation.h"
#include "prehend/geometry/symmetric_solve.h"

namespace prehend::simulation {
namespace {

using contact::Matrix6;
using contact::Vector6;
using MatrixMap = Eigen::Map<Eigen::MatrixXd>;
using VectorMap = Eigen::Map<Eigen::VectorXd>;

constexpr double kStopStiffness = 1e6;  // N/m, of the mechanical end stops

// Velocity of the point r from the centre of mass, as a matrix on (v, w): [1, -[r]x].
Eigen::Matrix<double, 3, 6> point_jacobian(const Eigen::Vector3d& r) {
  Eigen::Matrix<double, 3, 6> jacobian;
  jacobian << Eigen::Matrix3d::Identity(), -contact::cross_matrix(r);
  return jacobian;
}

// Force on body a = constant - resistance (relative velocity).
void affine_force(const ContactPoint& contact, const contact::LinearisedContact& law,
                  Eigen::Vector3d& constant, Eigen::Matrix3d& resistance) {
  const Eigen::Matrix3d along = contact.normal * contact.normal.transpose();
  constant = law.normal_offset * contact.normal - law.bristle_gain * contact.bristle;
  resistance =
      law.normal_damping * along + law.tangential_damping * (Eigen::Matrix3d::Identity() - along);
}

}  // namespace

int ContactSolver::root(int i) {
  while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
  return i;
}

// The smaller index becomes the root, so that the result does not depend on the order.
void ContactSolver::join(int i, int j) {
  const int a = root(i), b = root(j);
  parent_[std::max(a, b)] = std::min(a, b);
}

void ContactSolver::find_islands() {
  const int jaws = static_cast<int>(bodies_->size());
  const auto is_free = [&](int i) { return i >= 0 && (*bodies_)[i].is_free; };
  parent_.resize(bodies_->size() + 1);
  std::iota(parent_.begin(), parent_.end(), 0);
  for (const ContactPoint& contact : *contacts_) {
    if (is_free(contact.a) && is_free(contact.b)) join(contact.a, contact.b);
    const int any = is_free(contact.a) ? contact.a : is_free(contact.b) ? contact.b : -1;
    if (any >= 0 && !contact.slide_motion.isZero(0)) join(any, jaws);
  }
  for (const PadContact& pad : *pads_) {
    if (is_free(pad.body)) join(pad.body, jaws);
  }
}

void ContactSolver::solve(double h, SolverSlide& slide, std::vector<SolverBody>& bodies,
                          std::vector<ContactPoint>& contacts, std::vector<PadContact>& pads) {
  h_ = h;
  slide_ = &slide;
  bodies_ = &bodies;
  contacts_ = &contacts;
  pads_ = &pads;
  const int jaws = static_cast<int>(bodies.size());
  first_row_.assign(bodies.size(), -1);
  find_islands();
  for (int i = 0; i <= jaws; ++i) {
    const bool is_root = parent_[i] == i && (i == jaws || bodies[i].is_free || root(jaws) == i);
    if (is_root) solve_island(i);
  }
}

void ContactSolver::solve_island(int island) {
  const int jaws = static_cast<int>(bodies_->size());
  members_.clear();
  points_.clear();
  touched_pads_.clear();
  int size = 0;
  for (int i = 0; i < jaws; ++i) {
    if (!(*bodies_)[i].is_free || root(i) != island) continue;
    members_.push_back(i);
    first_row_[i] = size;
    size += 6;
  }
  const bool with_slide = root(jaws) == island;
  slide_row_ = with_slide ? size++ : -1;
  size_ = size;
  for (std::size_t c = 0; c < contacts_->size(); ++c) {
    const ContactPoint& contact = (*contacts_)[c];
    const bool a = first_row_[contact.a] >= 0;
    const bool b = contact.b >= 0 && first_row_[contact.b] >= 0;
    // A fixed body that a finger pushes holds up the slide.
    const bool jaw = with_slide && !contact.slide_motion.isZero(0);
    if (a || b || jaw) points_.push_back(static_cast<int>(c));
  }
  for (std::size_t k = 0; with_slide && k < pads_->size(); ++k) {
    touched_pads_.push_back(static_cast<int>(k));
  }
  lines_.resize(points_.size());
  solve_equations();
  finish_points();
  finish_pads();
  for (const int i : members_) {
    SolverBody& body = (*bodies_)[i];
    body.velocity = body.velocity_guess;
    body.angular_velocity = body.angular_velocity_guess;
    first_row_[i] = -1;
  }
  if (with_slide) slide_->velocity = slide_->velocity_guess;
}

void ContactSolver::solve_equations() {
  const auto size = static_cast<std::size_t>(size_);
  const bool with_slide = slide_row_ >= 0;
  const auto update_cut = [&](bool first) {
    return with_slide && slide_->step->update_saturation(slide_->position, h_, slide_->end_time,
                                                         slide_->velocity_guess, first);
  };
  update_cut(true);
  for (int iteration = 1;; ++iteration) {
    matrix_.assign(size * size, 0.0);
    right_.assign(size, 0.0);
    for (const int i : members_) add_body(i);
    if (with_slide) add_slide();
    for (const int k : touched_pads_) add_pad((*pads_)[k]);
    for (std::size_t c = 0; c < points_.size(); ++c) {
      const ContactPoint& contact = (*contacts_)[points_[c]];
      lines_[c] = linearised(contact);
      if (lines_[c].presses) add_point(contact, lines_[c]);
    }
    const double moved = take_solution();
    const bool cut_changed = update_cut(false);
    if (cut_changed && iteration < most_iterations_ + contact::SlideStep::kMostCutChanges) continue;
    if (moved < tolerance_ || iteration >= most_iterations_) break;
  }
}

double ContactSolver::take_solution() {
  MatrixMap matrix(matrix_.data(), size_, size_);
  VectorMap solution(right_.data(), size_);
  geometry::cholesky_solve_in_place(matrix, solution);
  double moved = 0;
  for (const int i : members_) {
    SolverBody& body = (*bodies_)[i];
    const Vector6 u = solution.segment<6>(first_row_[i]);
    moved = std::max(moved, (u.head<3>() - body.velocity_guess).norm() +
                                body.radius * (u.tail<3>() - body.angular_velocity_guess).norm());
    body.velocity_guess = u.head<3>();
    body.angular_velocity_guess = u.tail<3>();
  }
  if (slide_row_ >= 0) {
    moved = std::max(moved, std::abs(solution[slide_row_] - slide_->velocity_guess));
    slide_->velocity_guess = solution[slide_row_];
  }
  return moved;
}

Eigen::Vector3d ContactSolver::point_velocity(int body, const Eigen::Vector3d& point) const {
  const SolverBody& b = (*bodies_)[body];
  if (!b.is_free) return Eigen::Vector3d::Zero();
  return b.velocity_guess + b.angular_velocity_guess.cross(point - b.center);
}

Eigen::Vector3d ContactSolver::relative_velocity(const ContactPoint& contact) const {
  Eigen::Vector3d v = point_velocity(contact.a, contact.point) - contact.partner_velocity -
                      slide_->velocity_guess * contact.slide_motion;
  if (contact.b >= 0) v -= point_velocity(contact.b, contact.point);
  return v;
}

Vector6 ContactSolver::pad_twist(const PadContact& pad) const {
  const SolverBody& body = (*bodies_)[pad.body];
  const Eigen::Vector3d zero = Eigen::Vector3d::Zero();
  return contact::relative_twist(*pad.mount, *pad.place, slide_->velocity_guess,
                                 body.is_free ? body.velocity_guess : zero,
                                 body.is_free ? body.angular_velocity_guess : zero, body.center);
}

contact::LinearisedContact ContactSolver::linearised(const ContactPoint& contact) const {
  const Eigen::Vector3d v = relative_velocity(contact);
  const double normal_speed = contact.normal.dot(v);
  return contact::linearise(*contact.law, h_, contact.depth, -normal_speed, contact.bristle,
                            Eigen::Vector3d(v - normal_speed * contact.normal));
}

// Angular momentum is what is conserved: the inertia at the end multiplies the solved velocity.
void ContactSolver::add_body(int i) {
  MatrixMap matrix(matrix_.data(), size_, size_);
  VectorMap right(right_.data(), size_);
  const SolverBody& body = (*bodies_)[i];
  const int row = first_row_[i];
  const Eigen::Matrix3d R0 = body.q_WB.toRotationMatrix();
  const Eigen::Matrix3d R1 =
      (contact::rotation_by(h_ * body.angular_velocity_guess) * body.q_WB).toRotationMatrix();
  matrix.block<3, 3>(row, row).diagonal().setConstant(body.mass);
  matrix.block<3, 3>(row + 3, row + 3) = R1 * body.inertia * R1.transpose();
  right.segment<3>(row) = body.mass * body.velocity + h_ * body.force;
  right.segment<3>(row + 3) =
      R0 * (body.inertia * (R0.transpose() * body.angular_velocity)) + h_ * body.torque;
}

void ContactSolver::add_slide() {
  MatrixMap matrix(matrix_.data(), size_, size_);
  VectorMap right(right_.data(), size_);
  SolverSlide& slide = *slide_;
  slide.step->linearise(slide.position, slide.bristle, h_, slide.end_time, slide.velocity_guess);
  matrix(slide_row_, slide_row_) += slide.mass + h_ * slide.step->slope();
  right[slide_row_] += slide.mass * slide.velocity + h_ * slide.step->offset();
  contact::TexelLaw stop;
  stop.stiffness = kStopStiffness;
  stop.damping = 2 * std::sqrt(kStopStiffness * slide.mass);
  const Eigen::Vector2d none = Eigen::Vector2d::Zero();
  for (const double side : {1.0, -1.0}) {
    const double depth = side > 0 ? slide.position - slide.upper : slide.lower - slide.position;
    const contact::LinearisedContact line =
        contact::linearise(stop, h_, depth, side * slide.velocity_guess, none, none);
    if (!line.presses) continue;
    matrix(slide_row_, slide_row_) += h_ * line.normal_damping;
    right[slide_row_] -= side * h_ * line.normal_offset;
  }
}

void ContactSolver::add_pad(PadContact& pad) {
  contact::respond(pad.mount->layout, *pad.law, h_, pad_twist(pad), *pad.state, *pad.scratch,
                   *pad.response);
  if (pad.response->pressing == 0) return;
  MatrixMap matrix(matrix_.data(), size_, size_);
  VectorMap right(right_.data(), size_);
  const contact::PadBlocks blocks =
      contact::pad_blocks(*pad.place, *pad.response, h_, (*bodies_)[pad.body].center);
  const int row = first_row_[pad.body];
  matrix(slide_row_, slide_row_) += blocks.slide_slide;
  right[slide_row_] -= blocks.slide_right;
  if (row < 0) return;
  matrix.block<6, 6>(row, row) += blocks.body_body;
  right.segment<6>(row) += blocks.body_right;
  matrix.block<1, 6>(slide_row_, row) -= blocks.slide_body;
  matrix.block<6, 1>(row, slide_row_) -= blocks.slide_body.transpose();
}

void ContactSolver::add_point(const ContactPoint& contact, const contact::LinearisedContact& line) {
  MatrixMap matrix(matrix_.data(), size_, size_);
  VectorMap right(right_.data(), size_);
  Eigen::Vector3d constant;
  Eigen::Matrix3d resistance;
  affine_force(contact, line, constant, resistance);
  constant += resistance * contact.partner_velocity;
  const int row_a = first_row_[contact.a];
  const int row_b = contact.b >= 0 ? first_row_[contact.b] : -1;
  const Matrix36 jacobian_a = point_jacobian(contact.point - (*bodies_)[contact.a].center);
  const Matrix36 weighted = h_ * resistance * jacobian_a;
  if (row_a >= 0) {
    matrix.block<6, 6>(row_a, row_a).noalias() += jacobian_a.transpose() * weighted;
    right.segment<6>(row_a).noalias() += h_ * jacobian_a.transpose() * constant;
  }
  if (row_b >= 0) {
    const Matrix36 jacobian_b = point_jacobian(contact.point - (*bodies_)[contact.b].center);
    matrix.block<6, 6>(row_b, row_b).noalias() +=
        h_ * jacobian_b.transpose() * resistance * jacobian_b;
    right.segment<6>(row_b).noalias() -= h_ * jacobian_b.transpose() * constant;
    if (row_a >= 0) {
      const Matrix6 coupling = jacobian_b.transpose() * weighted;
      matrix.block<6, 6>(row_b, row_a) -= coupling;
      matrix.block<6, 6>(row_a, row_b) -= coupling.transpose();
    }
  }
  if (slide_row_ < 0 || contact.slide_motion.isZero(0)) return;
  const Eigen::Vector3d& motion = contact.slide_motion;
  matrix(slide_row_, slide_row_) += h_ * motion.dot(resistance * motion);
  right[slide_row_] -= h_ * motion.dot(constant);
  if (row_a < 0) return;
  const Eigen::Matrix<double, 1, 6> coupling = motion.transpose() * weighted;
  matrix.block<1, 6>(slide_row_, row_a) -= coupling;
  matrix.block<6, 1>(row_a, slide_row_) -= coupling.transpose();
}

// Forces and the bristles at the step's end, from the solution and the law it was solved with.
void ContactSolver::finish_points() {
  for (std::size_t c = 0; c < points_.size(); ++c) {
    ContactPoint& contact = (*contacts_)[points_[c]];
    const contact::LinearisedContact& line = lines_[c];
    contact.force.setZero();
    contact.normal_force = 0;
    if (line.presses) {
      Eigen::Vector3d constant;
      Eigen::Matrix3d resistance;
      affine_force(contact, line, constant, resistance);
      contact.force = constant - resistance * relative_velocity(contact);
      contact.normal_force = std::max(0.0, contact.normal.dot(contact.force));
    }
    if (contact.normal_force == 0) {
      contact.bristle.setZero();
      continue;
    }
    const Eigen::Vector3d v = relative_velocity(contact);
    const Eigen::Vector3d tangential = v - contact.normal.dot(v) * contact.normal;
    contact.bristle =
        contact::return_mapped(*contact.law, contact.normal_force,
                               contact::advanced_bristle(line, h_, contact.bristle, tangential));
  }
}

void ContactSolver::finish_pads() {
  for (const int k : touched_pads_) {
    PadContact& pad = (*pads_)[k];
    pad.wrench_W.setZero();
    const Vector6 twist = pad_twist(pad);
    contact::advance(pad.mount->layout, *pad.law, h_, twist, *pad.state, *pad.scratch);
    if (pad.response->pressing == 0) continue;
    const Vector6 wrench_P = pad.response->constant - pad.response->resistance * twist;
    pad.wrench_W.head<3>() = pad.place->R_WP * wrench_P.head<3>();
    pad.wrench_W.tail<3>() = pad.place->R_WP * wrench_P.tail<3>();
  }
}

}  // namespace prehend::simulation
