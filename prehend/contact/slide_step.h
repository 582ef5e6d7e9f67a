#pragma once

#include "prehend/contact/grasp_model.h"

namespace prehend::contact {

/// One slide over one implicit step: its drive's force and its friction, linearised. What a solver
/// folds into the slide's row is mass + h slope on the diagonal and mass v + h offset on the right.
class SlideStep {
 public:
  explicit SlideStep(const SlideModel& model);

  /// Holds from now on; the reference counts from `time` [s]. @throws std::invalid_argument, see
  /// validate(SlideCommand).
  void set_command(const SlideCommand& command, double time);
  const SlideCommand& command() const { return command_; }

  /// The servo's part at time t, position q and velocity v [N], not cut.
  double servo_force(double t, double q, double v) const;
  /// Force of the whole drive [N], the servo's part cut.
  double drive_force(double t, double q, double v) const;
  /// Most that the drive can do at that state [N], a bound of its size.
  double most_force(double t, double q, double v) const;

  /// Whether the servo's force is cut, judged at the velocity guess `v` of the end of a step of `h`
  /// [s] from position `q` at time t_end; true when that has changed. The force of a servo falls
  /// with the velocity and the solution without cut tells on which side the cut is; so from one
  /// limit to the other it goes by way of no cut, and settles within kMostCutChanges. `first`: of a
  /// step, forgets the last one's.
  bool update_saturation(double q, double h, double t_end, double v, bool first);
  static constexpr int kMostCutChanges = 4;

  /// Linearises drive and friction at the guess `v`; `bristle` [m] is that at the step's start.
  void linearise(double q, double bristle, double h, double t_end, double v);
  double offset() const { return offset_; }  // N
  double slope() const { return slope_; }    // N s/m: force = offset - slope v
  /// The bristle at the step's end, for the solved velocity.
  double advanced_bristle(double bristle, double h, double v) const {
    return inverse_decay_ * (bristle + h * v);
  }
  const TexelLaw& friction() const { return friction_; }

 private:
  TexelLaw friction_;                          // a bristle under a normal force of 1 N
  double static_friction_, dynamic_friction_;  // N, the slide's own
  SlideCommand command_;
  double command_time_ = 0;  // s
  double offset_ = 0, slope_ = 0, inverse_decay_ = 0;
  int saturation_ = 0;  // of the servo's part: 0 not cut, +1 or -1 at the limit
};

}  // namespace prehend::contact
