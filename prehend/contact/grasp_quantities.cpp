// What is measured of a grasp, and the paper's explicit step.

#include <algorithm>
#include <cmath>

#include "prehend/contact/foam.h"
#include "prehend/contact/grasp_system.h"
#include "prehend/contact/pad_readings.h"
#include "prehend/contact/rotation.h"
#include "prehend/contact/texel.h"

namespace prehend::contact {

geometry::RigidTransform GraspSystem::pad_pose(const GraspState& state, int pad) const {
  const PadMount& mount = model_.pads.at(pad);
  geometry::RigidTransform X_GP = mount.X_GP;
  if (mount.slide >= 0) X_GP.translation() += state.slide_position[mount.slide] * mount.direction_G;
  return motion_.pose_at(state.time) * X_GP;
}

double GraspSystem::pad_force(const GraspState& state, int pad) const {
  return total_normal_force(model_.pads.at(pad).layout, state.pads.at(pad));
}

double GraspSystem::gap(const GraspState& state, double horizon) {
  double least = horizon;
  for (std::size_t k = 0; k < pad_work_.size(); ++k) {
    PadState& scratch = gap_states_[k];
    const geometry::RigidTransform X_PB =
        pad_pose(state, static_cast<int>(k)).inverse(Eigen::Isometry) * state.X_WB();
    if (!find_depths(model_.pads[k].layout, pad_work_[k].reach, model_.shape, X_PB, horizon,
                     scratch, options_.gated)) {
      continue;
    }
    for (std::size_t i = 0; i < model_.pads[k].layout.size(); ++i) {
      least = std::min(least, std::max(0.0, -scratch.depth[i]));
    }
  }
  return least;
}

double GraspSystem::energy(const GraspState& state) const {
  const Eigen::Vector3d w_B = state.q_WB.conjugate() * state.angular_velocity;
  double sum = 0.5 * model_.mass * state.velocity.squaredNorm() +
               0.5 * w_B.dot(model_.inertia * w_B) - model_.mass * model_.gravity.dot(state.p_WB);
  for (std::size_t i = 0; i < model_.slides.size(); ++i) {
    sum += 0.5 * model_.slides[i].mass * state.slide_velocity[i] * state.slide_velocity[i];
  }
  for (std::size_t k = 0; k < model_.pads.size(); ++k) {
    const PadMount& mount = model_.pads[k];
    PadState pad = state.pads[k];
    find_depths(mount.layout, pad_work_[k].reach, model_.shape,
                pad_pose(state, static_cast<int>(k)).inverse(Eigen::Isometry) * state.X_WB(), 0,
                pad);
    for (std::size_t i = 0; i < mount.layout.size(); ++i) {
      const double depth = std::max(0.0, pad.depth[i]);
      sum += 0.5 * mount.layout.scale[i] *
             (mount.law.stiffness * depth * depth +
              mount.law.bristle_stiffness *
                  (pad.bristle_u[i] * pad.bristle_u[i] + pad.bristle_v[i] * pad.bristle_v[i]));
      sum += mount.layout.scale[i] * foam_energy(mount.layout, mount.law, pad, i);
    }
  }
  for (std::size_t i = 0; model_.ground && i < state.ground_bristles.size(); ++i) {
    const Eigen::Vector3d p = state.X_WB() * model_.ground->points_B[i];
    const double depth = std::max(0.0, -p.z());
    sum += 0.5 * model_.ground->law.stiffness * depth * depth +
           0.5 * model_.ground->law.bristle_stiffness * state.ground_bristles[i].squaredNorm();
  }
  return sum;
}

void GraspSystem::explicit_euler(const GraspState& base, double h, GraspState& end) {
  end = base;
  end.time = base.time + h;
  Vector6 wrench = body_wrench_;  // about the centre of mass
  wrench.head<3>() += model_.mass * model_.gravity;
  const Guess now = guess_from(base);
  for (std::size_t i = 0; i < slide_work_.size(); ++i) {
    end.slide_force[i] =
        slide_work_[i].drive_force(base.time, base.slide_position[i], base.slide_velocity[i]);
    const Eigen::Vector2d z(base.slide_bristle[i], 0), v(base.slide_velocity[i], 0);
    const TexelLaw& law = slide_work_[i].friction();
    double friction = law.viscous_friction * v.x();
    if (law.static_friction > 0) {
      const Eigen::Vector2d rate = bristle_rate(law, z, v, 1);
      friction = friction_force(law, z, rate, v).x();
      end.slide_bristle[i] += h * rate.x();
    }
    end.slide_velocity[i] += h * (end.slide_force[i] - friction) / model_.slides[i].mass;
  }
  place_pads(base, 0, base.time);
  for (std::size_t k = 0; k < pad_work_.size(); ++k) {
    const PadMount& mount = model_.pads[k];
    PadWork& work = pad_work_[k];
    find_depths(mount.layout, work.reach, model_.shape, work.place.X_PW() * base.X_WB(), 0,
                end.pads[k], options_.gated);
    const Vector6 felt =
        explicit_step(mount.layout, mount.law, h, twist_on(k, now, base.p_WB), end.pads[k]);
    const Eigen::Vector3d force = work.place.R_WP * felt.head<3>();
    wrench.head<3>() += force;
    wrench.tail<3>() +=
        work.place.R_WP * felt.tail<3>() + (work.place.p_WP - base.p_WB).cross(force);
    if (mount.slide >= 0) {
      end.slide_velocity[mount.slide] -=
          h * work.place.direction_W.dot(force) / model_.slides[mount.slide].mass;
    }
  }
  const Eigen::Matrix3d R = base.q_WB.toRotationMatrix();
  for (std::size_t i = 0; i < ground_work_.size(); ++i) {
    const Eigen::Vector3d arm = R * model_.ground->points_B[i];
    const Eigen::Vector3d v = base.velocity + base.angular_velocity.cross(arm);
    const double normal = normal_force(model_.ground->law, -(base.p_WB.z() + arm.z()), -v.z());
    end.ground_forces[i] = normal;
    Eigen::Vector2d z = base.ground_bristles[i].head<2>(), friction = Eigen::Vector2d::Zero();
    if (normal > 0) {
      const Eigen::Vector2d slip = v.head<2>();
      const Eigen::Vector2d rate = bristle_rate(model_.ground->law, z, slip, normal);
      friction = friction_force(model_.ground->law, z, rate, slip);
      z += h * rate;
    } else {
      z.setZero();
    }
    end.ground_bristles[i].head<2>() = z;
    const Eigen::Vector3d force(-friction.x(), -friction.y(), normal);
    wrench.head<3>() += force;
    wrench.tail<3>() += arm.cross(force);
  }
  if (!model_.body_is_fixed) {
    const Eigen::Matrix3d inertia = R * model_.inertia * R.transpose();
    const Eigen::Vector3d gyroscopic = base.angular_velocity.cross(inertia * base.angular_velocity);
    end.velocity += h * wrench.head<3>() / model_.mass;
    end.angular_velocity += h * inertia.inverse() * (wrench.tail<3>() - gyroscopic);
  }
  end.p_WB += h * end.velocity;
  end.q_WB = (rotation_by(h * end.angular_velocity) * base.q_WB).normalized();
  for (std::size_t i = 0; i < slide_work_.size(); ++i) {
    end.slide_position[i] += h * end.slide_velocity[i];
  }
}

}  // namespace prehend::contact
