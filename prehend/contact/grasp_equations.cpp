// The linear system of one implicit step: rows of the body's twist, then of the slides.

#include <Eigen/Geometry>

#include "prehend/contact/grasp_system.h"
#include "prehend/contact/rotation.h"

namespace prehend::contact {

// Momentum at the start, gravity, drives. Angular momentum is what is conserved: the inertia at the
// end multiplies the solved angular velocity.
void GraspSystem::start_equations(const GraspState& base, double h, const Guess& guess) {
  matrix_.setZero();
  if (model_.body_is_fixed) {
    matrix_.topLeftCorner<6, 6>().setIdentity();
    right_.head<6>() << base.velocity, base.angular_velocity;
  } else {
    const Eigen::Matrix3d R0 = base.q_WB.toRotationMatrix();
    const Eigen::Matrix3d R1 =
        (rotation_by(h * guess.angular_velocity) * base.q_WB).toRotationMatrix();
    matrix_.topLeftCorner<3, 3>().diagonal().setConstant(model_.mass);
    matrix_.block<3, 3>(3, 3) = R1 * model_.inertia * R1.transpose();
    right_.segment<3>(0) =
        model_.mass * (base.velocity + h * model_.gravity) + h * body_wrench_.head<3>();
    right_.segment<3>(3) = R0 * (model_.inertia * (R0.transpose() * base.angular_velocity)) +
                           h * body_wrench_.tail<3>();
  }
  for (std::size_t i = 0; i < slide_work_.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(6 + i);
    matrix_(row, row) = model_.slides[i].mass + h * slide_work_[i].slope();
    right_[row] = model_.slides[i].mass * base.slide_velocity[i] + h * slide_work_[i].offset();
  }
}

void GraspSystem::add_pad(const PadWork& work, int slide, double h, const Eigen::Vector3d& p_WB) {
  const PadBlocks blocks = pad_blocks(work.place, work.response, h, p_WB);
  if (!model_.body_is_fixed) {
    matrix_.topLeftCorner<6, 6>() += blocks.body_body;
    right_.head<6>() += blocks.body_right;
  }
  if (slide < 0) return;
  const Eigen::Index row = 6 + slide;
  matrix_(row, row) += blocks.slide_slide;
  right_[row] -= blocks.slide_right;
  if (model_.body_is_fixed) return;
  matrix_.block<1, 6>(row, 0) -= blocks.slide_body;
  matrix_.block<6, 1>(0, row) -= blocks.slide_body.transpose();
}

void GraspSystem::add_ground(double h) {
  for (std::size_t i = 0; ground_near_ && i < ground_work_.size(); ++i) {
    const GroundWork& work = ground_work_[i];
    if (work.inverse_decay == 0) continue;
    const Eigen::Matrix3d S = cross_matrix(work.arm);
    const Eigen::Vector3d resistance(h * work.drag, h * work.drag, h * work.normal);
    const Eigen::Matrix3d RS = resistance.asDiagonal() * S;
    matrix_.topLeftCorner<3, 3>().diagonal() += resistance;
    matrix_.block<3, 3>(0, 3) -= RS;
    matrix_.block<3, 3>(3, 0) -= RS.transpose();
    matrix_.block<3, 3>(3, 3) += S.transpose() * RS;
    const Eigen::Vector3d force =
        h * Eigen::Vector3d(-work.gain * ground_bristle(i).x(), -work.gain * ground_bristle(i).y(),
                            work.offset);
    right_.segment<3>(0) += force;
    right_.segment<3>(3) += work.arm.cross(force);
  }
}

}  // namespace prehend::contact
