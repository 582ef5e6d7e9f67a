#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "prehend/contact/grasp_system.h"

namespace prehend::contact {

enum class Integration {
  kExplicit,     // the paper's; unstable for light bodies and steps above a tenth of a millisecond
  kFirstOrder,   // backward Euler; stable for any step, over-damps what it does not resolve
  kSecondOrder,  // SDIRK2: two backward Euler stages; stable for any step, for resolved modes
  kAdaptive      // kSecondOrder with the step chosen for a tolerance
};

/// @throws std::invalid_argument naming the known ones: explicit, first_order, second_order,
/// adaptive.
Integration integration_from_name(const std::string& name);

struct StepOptions {
  Integration integration = Integration::kFirstOrder;
  double step = 1e-3;  // s; of kAdaptive: the first one and the one after a command
  /// Of kAdaptive: estimated error that one step may add to any position [m]. The error at the end
  /// of a work cycle is measured by eval_stability; about 100 times this.
  double tolerance = 1e-7;
  double least_step = 1e-6;  // s, of kAdaptive: taken whatever its error
  double most_step = 0.1;    // s, of kAdaptive
};

/// Advances a GraspSystem in time.
///
/// Second order: SDIRK2, see sdirk.h.
///
/// Adaptive: the local error 0.0404 h^3 |y'''| of that method, y''' by the second divided
/// difference of the slopes at t, t + gamma h and t + h, for positions and for velocities; an error
/// in velocity counts as what it moves within 10 ms, the time in which a grasp's modes decay. A
/// foam that remembers adds foam_step_error(). Events end a step: commands (the caller calls
/// restart()), touch-down (the step is cut to the time to touch), impact and stick-slip (the
/// estimate rejects the step until they are resolved).
class GraspStepper {
 public:
  /// @throws std::invalid_argument naming the option that is not finite and positive.
  GraspStepper(GraspModel model, const StepOptions& options, const SolveOptions& solve = {});

  GraspSystem& system() { return system_; }
  const GraspSystem& system() const { return system_; }
  const GraspState& state() const { return state_; }
  /// @throws std::invalid_argument when the state is of another model.
  void set_state(const GraspState& state);

  /// One step, at most to time `until` [s]; returns its length [s].
  double step(double until);
  /// Steps until state().time is `until` [s] (to rounding).
  void advance(double until);
  /// Steps until `until` [s] or until `event` holds after a step; then returns true. Adaptive steps
  /// across the event are repeated shorter until it is known to `resolution` [s].
  bool advance_until(double until, const std::function<bool(const GraspState&)>& event,
                     double resolution = 1e-4);
  /// A force or a motion has changed abruptly: the next adaptive step is a short one.
  void restart();

  std::int64_t steps() const { return steps_; }        // taken
  std::int64_t rejected() const { return rejected_; }  // adaptive steps that were repeated
  std::int64_t solves() const { return solves_; }      // linear systems

 private:
  void second_order(const GraspState& base, double h);
  double adaptive(double until);
  double error_of(double h);  // m, of the step from state_ over first_ to next_
  void extrapolate(const GraspState& base, GraspState& out) const;

  StepOptions options_;
  GraspSystem system_;
  GraspState state_, first_, extrapolated_, next_;
  double proposed_;                     // s
  bool has_slope_ = false;              // slope_ is known
  Eigen::VectorXd slope_, next_slope_;  // accelerations at state_ and next_
  Eigen::VectorXd velocities_[3], middle_slope_;
  std::int64_t steps_ = 0, rejected_ = 0, solves_ = 0;
};

}  // namespace prehend::contact
