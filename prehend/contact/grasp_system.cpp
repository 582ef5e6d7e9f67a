#include "prehend/contact/grasp_system.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include <Eigen/Cholesky>

#include "prehend/contact/rotation.h"
#include "prehend/contact/texel.h"

namespace prehend::contact {
GraspSystem::GraspSystem(GraspModel model, const SolveOptions& options)
    : model_(std::move(model)), options_(options) {
  validate(model_);
  for (const PadMount& pad : model_.pads) {
    pad_work_.emplace_back(pad.layout);
    gap_states_.emplace_back(pad.layout);
  }
  for (const SlideModel& slide : model_.slides) slide_work_.emplace_back(slide);
  if (!model_.shape.bounds().isEmpty()) {
    body_radius_ = model_.shape.bounds()
                       .min()
                       .cwiseAbs()
                       .cwiseMax(model_.shape.bounds().max().cwiseAbs())
                       .norm();
  }
  if (model_.ground) {
    ground_work_.resize(model_.ground->points_B.size());
    for (const Eigen::Vector3d& p : model_.ground->points_B) {
      ground_radius_ = std::max(ground_radius_, p.norm());
    }
  }
  const auto size = static_cast<Eigen::Index>(6 + model_.slides.size());
  matrix_.resize(size, size);
  right_.resize(size);
  solution_.resize(size);
}

GraspState GraspSystem::initial_state() const {
  GraspState state;
  state.p_WB = model_.X_WB.translation();
  state.q_WB = Eigen::Quaterniond(model_.X_WB.linear()).normalized();
  for (const SlideModel& slide : model_.slides) state.slide_position.push_back(slide.start);
  state.slide_velocity.resize(model_.slides.size(), 0.0);
  state.slide_bristle = state.slide_force = state.slide_velocity;
  for (const PadMount& pad : model_.pads) state.pads.emplace_back(pad.layout, pad.law);
  state.ground_bristles.resize(ground_work_.size(), Eigen::Vector3d::Zero());
  state.ground_forces.resize(ground_work_.size(), 0.0);
  return state;
}

void GraspSystem::set_command(int slide, const SlideCommand& command, double time) {
  if (slide < 0 || slide >= static_cast<int>(model_.slides.size())) {
    throw std::invalid_argument("GraspSystem: there is no slide " + std::to_string(slide));
  }
  slide_work_[slide].set_command(command, time);
}

void GraspSystem::set_gripper_motion(const GripperMotion& motion) {
  if (!motion.X_WG.matrix().allFinite() || !motion.velocity.allFinite() ||
      !motion.acceleration.allFinite() || !motion.angular_velocity.allFinite() ||
      !std::isfinite(motion.time)) {
    throw std::invalid_argument("GripperMotion must be finite");
  }
  motion_ = motion;
}

void GraspSystem::set_body_wrench(const Vector6& wrench) {
  if (!wrench.allFinite()) throw std::invalid_argument("the body's wrench must be finite");
  body_wrench_ = wrench;
}

GraspSystem::Guess GraspSystem::guess_from(const GraspState& state) {
  Guess guess{state.velocity, state.angular_velocity, {}};
  std::copy(state.slide_velocity.begin(), state.slide_velocity.end(), guess.slides.begin());
  return guess;
}

GraspSystem::Guess GraspSystem::guess_from(const Vector& u) const {
  Guess guess{u.segment<3>(0), u.segment<3>(3), {}};
  for (std::size_t i = 0; i < model_.slides.size(); ++i) guess.slides[i] = u[6 + i];
  return guess;
}

double GraspSystem::change(const Guess& a, const Guess& b) const {
  double most = (a.velocity - b.velocity).norm() +
                body_radius_ * (a.angular_velocity - b.angular_velocity).norm();
  for (std::size_t i = 0; i < model_.slides.size(); ++i) {
    most = std::max(most, std::abs(a.slides[i] - b.slides[i]));
  }
  return most;
}

void GraspSystem::place_pads(const GraspState& base, double h, double t_end) {
  const geometry::RigidTransform X_WG = motion_.pose_at(t_end);
  const Eigen::Vector3d velocity = motion_.velocity_at(t_end);
  for (std::size_t k = 0; k < pad_work_.size(); ++k) {
    const PadMount& mount = model_.pads[k];
    pad_work_[k].place = place_pad(mount, X_WG, velocity, motion_.angular_velocity,
                                   mount.slide >= 0 ? base.slide_position[mount.slide] : 0.0, h);
  }
}

double GraspSystem::approach_speed(const GraspState& state) const {
  double speed = (state.velocity - motion_.velocity_at(state.time)).norm() +
                 body_radius_ * (state.angular_velocity - motion_.angular_velocity).norm() +
                 motion_.angular_velocity.norm() *
                     (state.p_WB - motion_.pose_at(state.time).translation()).norm();
  double slides = 0;
  for (const double v : state.slide_velocity) slides = std::max(slides, std::abs(v));
  return speed + slides;
}

void GraspSystem::find_all_depths(const GraspState& base, double h, const Guess& guess,
                                  GraspState& end) {
  const geometry::RigidTransform X_WB = base.X_WB();
  for (std::size_t k = 0; k < pad_work_.size(); ++k) {
    PadWork& work = pad_work_[k];
    const PadMount& mount = model_.pads[k];
    // As far as speeds, gravity and the drive can bring it within the step. What one pad's touch
    // adds to the approach to another is met in the next step.
    const Vector6 twist = twist_on(k, guess, base.p_WB);
    double acceleration = model_.gravity.norm();
    if (mount.slide >= 0) {
      acceleration += slide_work_[mount.slide].most_force(
                          base.time, base.slide_position[mount.slide], guess.slides[mount.slide]) /
                      model_.slides[mount.slide].mass * work.place.direction_W.norm();
    }
    const double look_ahead =
        2 * h * (twist.head<3>().norm() + twist.tail<3>().norm() * body_radius_ + h * acceleration);
    work.near =
        find_depths(mount.layout, work.reach, model_.shape, work.place.X_PW() * X_WB, look_ahead,
                    end.pads[k], options_.gated, options_.reuse_triangles ? &work.hits : nullptr);
  }
}

bool GraspSystem::moves_too_far(double h, double t_end, const Guess& guess) const {
  const double turn = h * (guess.angular_velocity - motion_.angular_velocity).norm();
  double beyond = turn * turn * body_radius_;
  double radius = std::numeric_limits<double>::infinity();  // of curvature
  switch (model_.shape.kind()) {
    case Shape::Kind::kBox:
    case Shape::Kind::kHalfSpace:
      break;
    case Shape::Kind::kMesh:
      radius = 0.2 * body_radius_;
      break;
    default:
      radius = model_.shape.radius();
  }
  const double shift = h * (guess.velocity - motion_.velocity_at(t_end)).norm();
  beyond += shift * shift / radius;
  return beyond > options_.geometry_tolerance;
}

// Depths at the guessed end of the step, less what the linear term adds in the step.
void GraspSystem::correct_depths(const GraspState& base, double h, double t_end, const Guess& guess,
                                 GraspState& end) {
  geometry::RigidTransform X_WB = geometry::RigidTransform::Identity();
  X_WB.linear() = (rotation_by(h * guess.angular_velocity) * base.q_WB).toRotationMatrix();
  X_WB.translation() = base.p_WB + h * guess.velocity;
  const Eigen::Matrix3d R_WG = motion_.pose_at(t_end).linear();
  for (std::size_t k = 0; k < pad_work_.size(); ++k) {
    PadWork& work = pad_work_[k];
    const PadMount& mount = model_.pads[k];
    const geometry::RigidTransform X_WP =
        work.place.X_WP_at_end(mount, R_WG, h, slide_velocity(mount, guess));
    const Vector6 twist = twist_on(k, guess, base.p_WB);
    PadState& pad = end.pads[k];
    const double look_ahead =
        2 * h * (twist.head<3>().norm() + twist.tail<3>().norm() * body_radius_);
    work.near = find_depths(mount.layout, work.reach, model_.shape,
                            X_WP.inverse(Eigen::Isometry) * X_WB, look_ahead, pad, options_.gated,
                            options_.reuse_triangles ? &work.end_hits : nullptr);
    const PadLayout& layout = mount.layout;
    for (std::size_t i = 0; work.near && i < layout.padded_size(); ++i) {
      const double vx = twist[0] + twist[4] * layout.z[i] - twist[5] * layout.y[i];
      const double vy = twist[1] + twist[5] * layout.x[i] - twist[3] * layout.z[i];
      const double vz = twist[2] + twist[3] * layout.y[i] - twist[4] * layout.x[i];
      pad.depth[i] += h * (layout.nx[i] * vx + layout.ny[i] * vy + layout.nz[i] * vz);
    }
  }
}

Vector6 GraspSystem::twist_on(std::size_t pad, const Guess& guess,
                              const Eigen::Vector3d& p_WB) const {
  const PadMount& mount = model_.pads[pad];
  return relative_twist(mount, pad_work_[pad].place, slide_velocity(mount, guess), guess.velocity,
                        guess.angular_velocity, p_WB);
}

void GraspSystem::prepare_ground(const GraspState& base, double h, const Guess& guess) {
  ground_near_ = false;
  if (!model_.ground || model_.body_is_fixed) return;
  const double reach =
      h * (guess.velocity.norm() + base.velocity.norm() +
           ground_radius_ * guess.angular_velocity.norm() + h * model_.gravity.norm());
  if (base.p_WB.z() > ground_radius_ + reach) return;
  ground_near_ = true;
  const Eigen::Matrix3d R = base.q_WB.toRotationMatrix();
  for (std::size_t i = 0; i < ground_work_.size(); ++i) {
    ground_work_[i].arm = R * model_.ground->points_B[i];
    ground_work_[i].depth = -(base.p_WB.z() + ground_work_[i].arm.z());
  }
}

void GraspSystem::linearise_ground(const GraspState& base, double h, const Guess& guess) {
  for (std::size_t i = 0; ground_near_ && i < ground_work_.size(); ++i) {
    GroundWork& work = ground_work_[i];
    const Eigen::Vector3d v = guess.velocity + guess.angular_velocity.cross(work.arm);
    const LinearisedContact contact =
        linearise(model_.ground->law, h, work.depth, -v.z(),
                  Eigen::Vector2d(base.ground_bristles[i].head<2>()), Eigen::Vector2d(v.head<2>()));
    work.offset = contact.presses ? contact.normal_offset : 0;
    work.normal = contact.presses ? contact.normal_damping : 0;
    work.gain = contact.bristle_gain;
    work.drag = contact.tangential_damping;
    work.inverse_decay = contact.presses ? 1 / contact.decay : 0;
  }
}

// Whether the servos' forces are cut, judged at `guess`; true when that has changed.
bool GraspSystem::update_saturation(const GraspState& base, double h, double t_end,
                                    const Guess& guess, bool first) {
  bool changed = false;
  for (std::size_t i = 0; i < slide_work_.size(); ++i) {
    changed = slide_work_[i].update_saturation(base.slide_position[i], h, t_end, guess.slides[i],
                                               first) ||
              changed;
  }
  return changed;
}

void GraspSystem::implicit_euler(const GraspState& base, double h, double t_end,
                                 const GraspState& guess_state, GraspState& end) {
  for (std::size_t k = 0; k < pad_work_.size(); ++k) {
    end.pads[k].bristle_u = base.pads[k].bristle_u;
    end.pads[k].bristle_v = base.pads[k].bristle_v;
    end.pads[k].foam = base.pads[k].foam;
    end.pads[k].foam_due = base.pads[k].foam_due;
  }
  base_bristles_ = &base.ground_bristles;
  Guess guess = guess_from(guess_state);
  place_pads(base, h, t_end);
  find_all_depths(base, h, guess, end);
  prepare_ground(base, h, guess);
  bool corrected = false;
  update_saturation(base, h, t_end, guess, true);
  for (iterations_ = 1;; ++iterations_) {
    if (corrected || moves_too_far(h, t_end, guess)) {
      correct_depths(base, h, t_end, guess, end);
      corrected = true;
    }
    linearise_ground(base, h, guess);
    for (std::size_t i = 0; i < slide_work_.size(); ++i) {
      slide_work_[i].linearise(base.slide_position[i], base.slide_bristle[i], h, t_end,
                               guess.slides[i]);
    }
    start_equations(base, h, guess);
    for (std::size_t k = 0; k < pad_work_.size(); ++k) {
      PadWork& work = pad_work_[k];
      if (!work.near) continue;
      const PadMount& mount = model_.pads[k];
      respond(mount.layout, mount.law, h, twist_on(k, guess, base.p_WB), end.pads[k], work.scratch,
              work.response);
      if (work.response.pressing > 0) add_pad(work, mount.slide, h, base.p_WB);
    }
    add_ground(h);
    solution_ = matrix_.llt().solve(right_);
    const Guess solved = guess_from(solution_);
    const double moved = change(solved, guess);
    guess = solved;
    const bool cut_changed = update_saturation(base, h, t_end, guess, false);
    if (cut_changed && iterations_ < options_.most_iterations + SlideStep::kMostCutChanges)
      continue;
    if (moved < options_.velocity_tolerance || iterations_ >= options_.most_iterations) break;
  }
  finish(base, h, t_end, guess, end);
}

void GraspSystem::finish(const GraspState& base, double h, double t_end, const Guess& solved,
                         GraspState& end) {
  end.time = t_end;
  end.velocity = solved.velocity;
  end.angular_velocity = solved.angular_velocity;
  end.p_WB = base.p_WB + h * solved.velocity;
  end.q_WB = (rotation_by(h * solved.angular_velocity) * base.q_WB).normalized();
  for (std::size_t k = 0; k < pad_work_.size(); ++k) {
    PadState& pad = end.pads[k];
    if (!pad_work_[k].near || pad_work_[k].response.pressing == 0) {
      release(model_.pads[k].layout, model_.pads[k].law, h, pad);
      continue;
    }
    advance(model_.pads[k].layout, model_.pads[k].law, h, twist_on(k, solved, base.p_WB), pad,
            pad_work_[k].scratch);
  }
  for (std::size_t i = 0; i < ground_work_.size(); ++i) {
    const GroundWork& work = ground_work_[i];
    end.ground_forces[i] = 0;
    end.ground_bristles[i].setZero();
    if (!ground_near_ || work.inverse_decay == 0) continue;
    const Eigen::Vector3d v = solved.velocity + solved.angular_velocity.cross(work.arm);
    end.ground_forces[i] = std::max(0.0, work.offset - work.normal * v.z());
    Eigen::Vector3d z = work.inverse_decay * (base.ground_bristles[i] + h * v);
    z.z() = 0;
    end.ground_bristles[i] = return_mapped(model_.ground->law, end.ground_forces[i], z);
  }
  for (std::size_t i = 0; i < slide_work_.size(); ++i) {
    const double v = solved.slides[i];
    end.slide_velocity[i] = v;
    end.slide_position[i] = base.slide_position[i] + h * v;
    end.slide_bristle[i] = slide_work_[i].advanced_bristle(base.slide_bristle[i], h, v);
    end.slide_force[i] = slide_work_[i].drive_force(t_end, end.slide_position[i], v);
  }
}

}  // namespace prehend::contact
