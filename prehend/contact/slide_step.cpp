#include "prehend/contact/slide_step.h"

#include <algorithm>
#include <cmath>

#include "prehend/contact/texel.h"

namespace prehend::contact {

SlideStep::SlideStep(const SlideModel& slide)
    : static_friction_(slide.static_friction), dynamic_friction_(slide.dynamic_friction) {
  friction_.static_friction = slide.static_friction;
  friction_.dynamic_friction = slide.dynamic_friction;
  friction_.viscous_friction = slide.viscous_friction;
  friction_.stribeck_velocity = slide.stribeck_velocity;
  friction_.bristle_stiffness = slide.bristle_stiffness;
  friction_.bristle_damping = 2 * std::sqrt(slide.bristle_stiffness * slide.mass);
  friction_.bristle_law = BristleLaw::kElastoPlastic;
  friction_.return_map = true;
}

void SlideStep::set_command(const SlideCommand& command, double time) {
  validate(command);
  command_ = command;
  command_time_ = time;
  friction_.static_friction = static_friction_ + command.more_friction;
  friction_.dynamic_friction = dynamic_friction_ + command.more_friction;
}

double SlideStep::servo_force(double t, double q, double v) const {
  const double reference = command_.reference + (t - command_time_) * command_.speed;
  return command_.stiffness * (reference - q) + command_.damping * (command_.speed - v);
}

double SlideStep::drive_force(double t, double q, double v) const {
  return command_.force + std::clamp(servo_force(t, q, v), -command_.limit, command_.limit);
}

double SlideStep::most_force(double t, double q, double v) const {
  return std::abs(command_.force) + std::min(command_.limit, std::abs(servo_force(t, q, v)));
}

bool SlideStep::update_saturation(double q, double h, double t_end, double v, bool first) {
  const double servo = servo_force(t_end, q + h * v, v);
  int next = servo > command_.limit ? 1 : servo < -command_.limit ? -1 : 0;
  if (!first && next * saturation_ < 0) next = 0;
  const bool changed = next != saturation_;
  saturation_ = next;
  return changed;
}

void SlideStep::linearise(double q, double bristle, double h, double t_end, double v) {
  slope_ = 0;
  offset_ = command_.force;
  if (saturation_ != 0) {
    offset_ += saturation_ * command_.limit;
  } else {
    offset_ += servo_force(t_end, q, 0);
    slope_ = h * command_.stiffness + command_.damping;
  }
  const double trial = bristle + h * v;
  LinearisedContact friction;
  friction.tangential_damping = friction_.viscous_friction;
  linearise_friction(friction_, h, 1, std::abs(v), std::abs(trial), trial * v > 0, friction);
  offset_ -= friction.bristle_gain * bristle;
  slope_ += friction.tangential_damping;
  inverse_decay_ = 1 / friction.decay;
}

}  // namespace prehend::contact
