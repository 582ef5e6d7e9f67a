// Steps as long as a tolerance allows.

#include <algorithm>
#include <cmath>

#include "prehend/contact/foam.h"
#include "prehend/simulation/world_implementation.h"

namespace prehend::simulation {
namespace {

constexpr double kLongest = 0.1;          // s
constexpr double kLeastShare = 1.0 / 64;  // of the scene's step
constexpr double kOneStep = 0.1;          // of the tolerance: what one step may add
constexpr double kInstant = 1e-9;         // s, shorter than that is nothing

}  // namespace

// The longest step up to `h` [s] in which carrier, drive and electronics do one thing.
double World::Implementation::most_steady(double h) {
  h = std::min(h, std::max(scene.step, state.gripper.steady_time(state.motion.slide)));
  h = std::min(h, std::max(kInstant, state.carrier.time_to_bend()));
  if (!scene.tactile.is_ideal()) {
    const double to_frame = scene.tactile.period - state.frame_age;
    if (to_frame > kInstant) h = std::min(h, to_frame);
  }
  return h;
}

void World::Implementation::exact_step(double h) {
  state.carrier.begin_exact_step();
  slide_step.set_command(
      state.gripper.begin_step(h, state.motion.slide, state.motion.slide_velocity), 0);
  second_order(h);
  if (scene.drive.thread) state.gripper.observe_load(load_on_slide());
  state.gripper.end_step(h, state.motion.slide, state.motion.slide_velocity);
  state.carrier.end_exact_step(h);
}

// Largest distance between two ends of a step [m], of the jaws, of bodies' points and, as a depth,
// of what the pads' foam remembers.
double World::Implementation::difference(const Motion& a, const Motion& b) const {
  double worst = std::abs(a.slide - b.slide);
  for (std::size_t i = 0; i < models.size(); ++i) {
    if (!moves(static_cast<int>(i))) continue;
    const BodyState &x = a.bodies[i], &y = b.bodies[i];
    worst = std::max(
        worst, (x.p_WBcm - y.p_WBcm).norm() + models[i].radius * x.q_WB.angularDistance(y.q_WB));
    for (const std::size_t k : {0, 1}) {
      worst =
          std::max(worst, contact::foam_difference(mounts[k].layout, mounts[k].law,
                                                   a.touches[i][k].texels, b.touches[i][k].texels));
    }
  }
  return worst;
}

std::int64_t World::Implementation::advance_adaptively(std::int64_t ticks,
                                                       const std::function<bool()>& ends) {
  const double allowed = kOneStep * scene.physics.tolerance, least = kLeastShare * scene.step;
  if (!step_start) {
    step_start = std::make_unique<State>(state);
    whole_step = std::make_unique<State>(state);
  }
  double left = static_cast<double>(ticks) * scene.step;
  bool ended = false;
  while (left > kInstant) {
    double h = std::min(most_steady(std::min(state.next_step, kLongest)), left);
    if (left - h < kInstant) h = left;
    *step_start = state;
    double error = 0, growth = 0;
    while (true) {
      exact_step(h);
      std::swap(*whole_step, state);
      state = *step_start;
      exact_step(0.5 * h);
      exact_step(0.5 * h);
      error = difference(whole_step->motion, state.motion);
      growth = 0.9 * std::cbrt(allowed / std::max(error, 1e-30));
      if (error <= allowed || h <= least) break;
      h = std::max(least, h * std::clamp(growth, 0.1, 0.5));
      state = *step_start;
      state.next_step = h;
    }
    // What an event cut short says nothing against longer ones.
    const double next = h * std::clamp(growth, 0.3, 3.0);
    state.next_step = std::max(least, h < state.next_step ? std::max(next, state.next_step) : next);
    read_sensors(h);
    fall_asleep(h);
    left -= h;
    if (ended || !ends()) continue;
    ended = true;
    const double steps_left = std::floor(left / scene.step + kInstant);
    ticks -= static_cast<std::int64_t>(steps_left);
    left -= steps_left * scene.step;
  }
  state.steps += ticks;
  return ticks;
}

}  // namespace prehend::simulation
