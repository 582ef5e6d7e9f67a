#include "prehend/contact/grasp_stepper.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "prehend/contact/foam.h"
#include "prehend/contact/require.h"
#include "prehend/contact/sdirk.h"

namespace prehend::contact {
namespace {

constexpr double kGamma = kSdirkGamma;
// The step that ends at a time must not leave a remainder of rounding behind.
constexpr double kTimeRounding = 1e-12;  // s

// An error of velocity moves what is grasped for about this long [s].
constexpr double kDecayTime = 0.01;

// Velocities as one vector; turning counts as the motion of the body's rim.
void put_velocities(const GraspState& state, double radius, Eigen::VectorXd& out) {
  out.segment<3>(0) = state.velocity;
  out.segment<3>(3) = radius * state.angular_velocity;
  for (std::size_t i = 0; i < state.slide_velocity.size(); ++i) {
    out[static_cast<Eigen::Index>(6 + i)] = state.slide_velocity[i];
  }
}

}  // namespace

Integration integration_from_name(const std::string& name) {
  if (name == "explicit") return Integration::kExplicit;
  if (name == "first_order") return Integration::kFirstOrder;
  if (name == "second_order") return Integration::kSecondOrder;
  if (name == "adaptive") return Integration::kAdaptive;
  throw std::invalid_argument("integration '" + name +
                              "' is none of explicit, first_order, second_order, adaptive");
}

GraspStepper::GraspStepper(GraspModel model, const StepOptions& options, const SolveOptions& solve)
    : options_(options),
      system_(std::move(model), solve),
      state_(system_.initial_state()),
      first_(state_),
      extrapolated_(state_),
      next_(state_),
      proposed_(options.step) {
  require_positive(options.step, "StepOptions::step");
  require_positive(options.tolerance, "StepOptions::tolerance");
  require_positive(options.least_step, "StepOptions::least_step");
  require_positive(options.most_step, "StepOptions::most_step");
  const auto size = static_cast<Eigen::Index>(6 + state_.slide_velocity.size());
  slope_ = next_slope_ = middle_slope_ = Eigen::VectorXd::Zero(size);
  for (Eigen::VectorXd& v : velocities_) v = slope_;
}

void GraspStepper::set_state(const GraspState& state) {
  const auto same = [](const auto& a, const auto& b) { return a.size() == b.size(); };
  bool fits = same(state.pads, state_.pads) && same(state.slide_position, state_.slide_position) &&
              same(state.ground_bristles, state_.ground_bristles);
  for (std::size_t k = 0; fits && k < state.pads.size(); ++k) {
    fits = same(state.pads[k].depth, state_.pads[k].depth) &&
           same(state.pads[k].foam, state_.pads[k].foam);
  }
  if (!fits) throw std::invalid_argument("the state is of another model than the stepper's");
  state_ = state;
  restart();
}

void GraspStepper::restart() {
  has_slope_ = false;
  proposed_ = std::min(options_.step, options_.most_step);
}

double GraspStepper::step(double until) {
  const double left = until - state_.time;
  if (!(left > 0)) return 0;
  if (options_.integration == Integration::kAdaptive) return adaptive(until);
  const double h = left < options_.step + kTimeRounding ? left : options_.step;
  switch (options_.integration) {
    case Integration::kExplicit:
      system_.explicit_euler(state_, h, next_);
      break;
    case Integration::kSecondOrder:
      second_order(state_, h);
      break;
    default:
      system_.implicit_euler(state_, h, state_.time + h, state_, next_);
      solves_ += system_.last_iterations();
  }
  std::swap(state_, next_);
  if (h == left) state_.time = until;
  ++steps_;
  return h;
}

void GraspStepper::advance(double until) {
  while (step(until) > 0) {
  }
}

bool GraspStepper::advance_until(double until, const std::function<bool(const GraspState&)>& event,
                                 double resolution) {
  while (state_.time < until) {
    if (options_.integration != Integration::kAdaptive) {
      step(until);
      if (event(state_)) return true;
      continue;
    }
    const GraspState before = state_;
    const double h = step(until);
    if (!event(state_)) continue;
    if (h <= resolution) return true;
    state_ = before;
    has_slope_ = false;
    proposed_ = std::max(0.25 * h, 0.5 * resolution);
  }
  return event(state_);
}

void GraspStepper::extrapolate(const GraspState& base, GraspState& out) const {
  const auto motion = [](const GraspState& s) {
    return RigidMotion{s.p_WB, s.q_WB, s.velocity, s.angular_velocity};
  };
  const RigidMotion body =
      sdirk_extrapolated(motion(base), motion(first_), system_.model().inertia);
  out.p_WB = body.p_WB;
  out.q_WB = body.q_WB;
  out.velocity = body.velocity;
  out.angular_velocity = body.angular_velocity;
  const auto blend = [](const std::vector<double>& a, const std::vector<double>& b,
                        std::vector<double>& to) {
    for (std::size_t i = 0; i < a.size(); ++i) to[i] = sdirk_extrapolated(a[i], b[i]);
  };
  blend(base.slide_position, first_.slide_position, out.slide_position);
  blend(base.slide_velocity, first_.slide_velocity, out.slide_velocity);
  blend(base.slide_bristle, first_.slide_bristle, out.slide_bristle);
  for (std::size_t k = 0; k < base.pads.size(); ++k) {
    sdirk_extrapolate(base.pads[k], first_.pads[k], out.pads[k]);
  }
  for (std::size_t i = 0; i < base.ground_bristles.size(); ++i) {
    out.ground_bristles[i] = first_.ground_forces[i] > 0
                                 ? Eigen::Vector3d(sdirk_extrapolated(base.ground_bristles[i],
                                                                      first_.ground_bristles[i]))
                                 : Eigen::Vector3d::Zero();
  }
}

void GraspStepper::second_order(const GraspState& base, double h) {
  system_.implicit_euler(base, kGamma * h, base.time + kGamma * h, base, first_);
  solves_ += system_.last_iterations();
  extrapolate(base, extrapolated_);
  system_.implicit_euler(extrapolated_, kGamma * h, base.time + h, first_, next_);
  solves_ += system_.last_iterations();
}

double GraspStepper::error_of(double h) {
  // Slopes at 0, gamma h and h give y''' = 2 [s0, s1, s2].
  const double constant = 2 * 0.0404 * h * h * h;
  const double d1 = kGamma * h, d2 = (1 - kGamma) * h;
  const auto error = [&](const Eigen::VectorXd& s0, const Eigen::VectorXd& s1,
                         const Eigen::VectorXd& s2) {
    double worst = 0;
    for (Eigen::Index i = 0; i < s0.size(); ++i) {
      worst = std::max(worst, std::abs((s2[i] - s1[i]) / d2 - (s1[i] - s0[i]) / d1));
    }
    return constant * worst / h;
  };
  const double radius = system_.body_radius();
  put_velocities(state_, radius, velocities_[0]);
  put_velocities(first_, radius, velocities_[1]);
  put_velocities(next_, radius, velocities_[2]);
  put_velocities(extrapolated_, radius, next_slope_);
  next_slope_ = (velocities_[2] - next_slope_) / d1;
  middle_slope_ = (velocities_[1] - velocities_[0]) / d1;
  double worst = error(velocities_[0], velocities_[1], velocities_[2]);
  for (std::size_t k = 0; k < state_.pads.size(); ++k) {
    const PadMount& pad = system_.model().pads[k];
    worst = std::max(worst, foam_step_error(pad.layout, pad.law, h, state_.pads[k], next_.pads[k]));
  }
  if (has_slope_) worst = std::max(worst, kDecayTime * error(slope_, middle_slope_, next_slope_));
  return worst;
}

double GraspStepper::adaptive(double until) {
  // Touch-down: not further than to where the first texel can touch.
  double most = options_.most_step;
  const double left = until - state_.time;
  const double speed = system_.approach_speed(state_);
  double h = std::min({proposed_, most, left});
  if (speed * h > 1e-6) {
    const double gap = system_.gap(state_, 2 * speed * h);
    if (gap > 0 && gap < speed * h) {
      h = std::max(options_.step * 0.01, std::min(h, gap / speed * (1 + 1e-6)));
    }
  }
  while (true) {
    if (left - h < 0.1 * options_.least_step) h = left;
    second_order(state_, h);
    const double error = error_of(h);
    const double ratio = std::cbrt(options_.tolerance / std::max(error, 1e-30));
    if (error <= options_.tolerance || h <= options_.least_step) {
      proposed_ = std::clamp(h * std::clamp(0.9 * ratio, 0.2, 4.0), options_.least_step, most);
      break;
    }
    ++rejected_;
    h = std::max(options_.least_step, h * std::clamp(0.8 * ratio, 0.1, 0.7));
  }
  std::swap(state_, next_);
  std::swap(slope_, next_slope_);
  has_slope_ = true;
  if (h == left) state_.time = until;
  ++steps_;
  return h;
}

}  // namespace prehend::contact
