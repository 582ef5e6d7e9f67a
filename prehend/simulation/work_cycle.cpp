#include "prehend/simulation/work_cycle.h"

#include <algorithm>
#include <cmath>
#include <ctime>

#include "prehend/contact/require.h"

namespace prehend::simulation {
namespace {

using contact::GraspState;
using contact::GraspStepper;

constexpr std::array<double, kCyclePhases> kPhaseEnds{5, 9, 12, 17, 27, 32, 34, 39, 45};  // s
constexpr double kClearance = 0.08;     // m, of the gripper over its grasping height at first
constexpr double kVelocityGain = 2000;  // N s/m of the velocity servo
constexpr double kRampSteps = 40;       // of the force, until it is whole

double thread_time() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

contact::GraspModel make_model(const WorkCycleOptions& options) {
  using contact::require;
  using contact::require_not_negative;
  using contact::require_positive;
  require(options.coverage > 0 && options.coverage <= 1, "WorkCycleOptions::coverage",
          "above 0 and at most 1");
  require_positive(options.close_speed, "WorkCycleOptions::close_speed");
  require_positive(options.touch_force, "WorkCycleOptions::touch_force");
  require_not_negative(options.grip_force, "WorkCycleOptions::grip_force");
  require_positive(options.lift_height, "WorkCycleOptions::lift_height");
  require_positive(options.speed, "WorkCycleOptions::speed");
  require_positive(options.acceleration, "WorkCycleOptions::acceleration");
  require_not_negative(options.stiction, "WorkCycleOptions::stiction");
  require_not_negative(options.sample_period, "WorkCycleOptions::sample_period");
  contact::ParallelGraspOptions grasp = options.grasp;
  grasp.coupled = true;
  grasp.on_ground = true;
  contact::GraspModel model = parallel_grasp(grasp);
  if (options.shape) model.shape = *options.shape;
  model.slides[0].static_friction = options.stiction;
  model.slides[0].dynamic_friction = 0.75 * options.stiction;
  return model;
}

class Cycle {
 public:
  explicit Cycle(const WorkCycleOptions& options)
      : options_(options), stepper_(make_model(options), options.step, options.solve) {
    const contact::PadGrid& pad = options.grasp.pad;
    grasp_height_ = options.grasp.box_size.z() - options.coverage * pad.length + 0.5 * pad.length;
    height_ = grasp_height_ + kClearance;
    hold_still();
    const double friction = options.grasp.law.dynamic_friction;
    result_.grip_force = options.grip_force > 0
                             ? options.grip_force
                             : 2 * options.grasp.mass * 9.81 / (2 * std::max(friction, 1e-3));
  }

  WorkCycleResult run() {
    const double begin = thread_time();
    stepper_.system().set_command(0, {.stiffness = 1e4, .damping = 100}, 0);
    move_to(grasp_height_);
    end(CyclePhase::kApproach);
    close();
    end(CyclePhase::kClose);
    press();
    end(CyclePhase::kPress);
    move_to(grasp_height_ + options_.lift_height);
    end(CyclePhase::kLift);
    end(CyclePhase::kHold);
    move_to(grasp_height_);
    end(CyclePhase::kLower);
    end(CyclePhase::kRest);
    release();
    end(CyclePhase::kRelease);
    move_to(grasp_height_ + kClearance);
    end(CyclePhase::kRetreat);
    result_.cpu_time = thread_time() - begin;
    result_.duration = stepper_.state().time;
    result_.steps = stepper_.steps();
    result_.rejected = stepper_.rejected();
    return std::move(result_);
  }

 private:
  double now() const { return stepper_.state().time; }
  double phase_end() const { return kPhaseEnds[static_cast<int>(phase_)]; }

  CycleSample sample() const {
    const GraspState& state = stepper_.state();
    return {state.time,
            phase_,
            stepper_.system().pad_force(state, 0),
            stepper_.system().pad_force(state, 1),
            options_.grasp.opening - state.slide_position[0],
            -state.slide_velocity[0],
            state.p_WB};
  }

  // To `until`, or the phase's end; samples on the way.
  void advance(double until) {
    const double last = std::min(until, phase_end());
    while (now() < last) {
      double stop = last;
      if (options_.sample_period > 0) stop = std::min(last, next_sample_);
      stepper_.advance(stop);
      take_sample();
    }
  }

  void take_sample() {
    if (options_.sample_period == 0 || now() < next_sample_ - 1e-9) return;
    result_.samples.push_back(sample());
    // On a grid, so that samples of several runs are of one time.
    next_sample_ = options_.sample_period * std::floor(now() / options_.sample_period + 1.5);
  }

  void set_motion(double velocity, double acceleration) {
    contact::GripperMotion motion;
    motion.time = now();
    motion.X_WG.translation().z() = height_;
    motion.velocity.z() = velocity;
    motion.acceleration.z() = acceleration;
    stepper_.system().set_gripper_motion(motion);
    stepper_.restart();
  }
  void hold_still() { set_motion(0, 0); }

  // Trapezoidal speed: three pieces of constant acceleration.
  void move_to(double target) {
    const double distance = target - height_, sign = distance < 0 ? -1 : 1;
    const double a = options_.acceleration;
    const double v = std::min(options_.speed, std::sqrt(a * std::abs(distance)));
    const double cruise = (std::abs(distance) - v * v / a) / v;
    const double start = height_;
    const auto piece = [&](double duration, double velocity, double acceleration) {
      if (duration <= 0) return;
      set_motion(velocity, acceleration);
      const double t = now();
      advance(t + duration);
      height_ += velocity * (now() - t) + 0.5 * acceleration * (now() - t) * (now() - t);
    };
    piece(v / a, 0, sign * a);
    piece(cruise, sign * v, 0);
    piece(v / a, sign * v, -sign * a);
    height_ = start + distance;
    hold_still();
  }

  void close() {
    stepper_.system().set_command(
        0, {.damping = kVelocityGain, .speed = options_.close_speed, .limit = 20}, now());
    stepper_.restart();
    const auto touches = [&](const GraspState& state) {
      return stepper_.system().pad_force(state, 0) >= options_.touch_force &&
             stepper_.system().pad_force(state, 1) >= options_.touch_force;
    };
    bool touched = false;
    while (!touched && now() < phase_end()) {
      double stop = phase_end();
      if (options_.sample_period > 0) stop = std::min(stop, next_sample_);
      touched = stepper_.advance_until(stop, touches);
      take_sample();
    }
    result_.touch_time = now();
    // Velocity control goes over into force control at the force that is there.
    force_ = std::min(options_.touch_force, result_.grip_force);
    set_force(force_);
    advance(phase_end());
  }

  void set_force(double force) {
    // Static friction of the drive has to be overcome by its current, as in the real gripper.
    stepper_.system().set_command(0, {.force = force, .damping = 50}, now());
    stepper_.restart();
  }

  void press() {
    const double begin = now(), whole = result_.grip_force;
    for (int i = 1; i <= kRampSteps; ++i) {
      const double share = i / kRampSteps;
      set_force(force_ + (whole - force_) * share * share * (3 - 2 * share));
      advance(begin + 2 * share);
    }
  }

  void release() {
    stepper_.system().set_command(
        0, {.damping = kVelocityGain, .speed = -options_.close_speed, .limit = 20}, now());
    stepper_.restart();
    advance(now() + 1.0);
    stepper_.system().set_command(0, {.damping = kVelocityGain}, now());
    stepper_.restart();
  }

  // Waits for the phase's end and notes what is felt there.
  void end(CyclePhase phase) {
    advance(phase_end());
    const auto image = [&](int pad) {
      const auto& force = stepper_.state().pads[pad].normal_force;
      const auto size =
          static_cast<std::ptrdiff_t>(stepper_.system().model().pads[pad].layout.size());
      return std::vector<double>(force.begin(), force.begin() + size);
    };
    const int index = static_cast<int>(phase);
    result_.ends[index] = {sample(), image(0), image(1)};
    if (index + 1 < kCyclePhases) phase_ = static_cast<CyclePhase>(index + 1);
  }

  WorkCycleOptions options_;
  GraspStepper stepper_;
  WorkCycleResult result_;
  CyclePhase phase_ = CyclePhase::kApproach;
  double grasp_height_ = 0, height_ = 0;  // m, of G
  double next_sample_ = 0;                // s
  double force_ = 0;                      // N
};

}  // namespace

const char* to_string(CyclePhase phase) {
  constexpr const char* kNames[kCyclePhases] = {"approach", "close", "press",   "lift",   "hold",
                                                "lower",    "rest",  "release", "retreat"};
  return kNames[static_cast<int>(phase)];
}

WorkCycleResult run_work_cycle(const WorkCycleOptions& options) { return Cycle(options).run(); }

double largest_difference(const WorkCycleResult& a, const WorkCycleResult& b) {
  double largest = 0;
  for (int i = 0; i < kCyclePhases; ++i) {
    largest = std::max(largest, (a.ends[i].sample.box - b.ends[i].sample.box).norm());
  }
  auto other = b.samples.begin();
  for (const CycleSample& sample : a.samples) {
    while (other != b.samples.end() && other->time < sample.time - 1e-9) ++other;
    if (other == b.samples.end()) break;
    if (other->time > sample.time + 1e-9) continue;
    largest = std::max(largest, (sample.box - other->box).norm());
  }
  return largest;
}

}  // namespace prehend::simulation
