#pragma once

namespace prehend::simulation {

/// A screw under an axial load F [N], with friction in its thread and no collar. Sliding friction
/// grows with the load, and with it the torque. Source: Shigley, "Mechanical Engineering Design",
/// section 8-2, "The Mechanics of Power Screws", equations 8-1 to 8-5; there d_m is the mean
/// diameter, l the lead, f the friction, 2 alpha the thread's angle.
struct PowerScrew {
  double lead = 0.008;           // m of the nut for each turn
  double mean_diameter = 0.030;  // m
  double friction = 0.08;        // Coulomb, of the thread's flanks
  double flank_angle = 0;  // rad, half of the thread's angle: 0 square, 15 degrees trapezoidal

  /// Torque [N m] that moves the nut against a load of 1 N:
  /// d_m/2 (l + pi f d_m sec a) / (pi d_m - f l sec a); infinity where it cannot be moved.
  double raising_torque() const;
  /// Torque [N m] that moves the nut along with a load of 1 N:
  /// d_m/2 (pi f d_m sec a - l) / (pi d_m + f l sec a); negative: the load turns the screw.
  double lowering_torque() const;
  /// l / (2 pi raising_torque()): of the work done on the screw the share that raises the load.
  double efficiency() const;
  /// pi f d_m sec a > l, that is f sec a > tan(lead angle): no load turns the screw.
  bool is_self_locking() const;

  /// What thread friction takes of a load of 1 N as a force at the nut [N]: moving against the load
  /// 1 / efficiency - 1, along with it 1 + 2 pi lowering_torque() / l (above 1: self-locking).
  double friction_against_load() const;
  double friction_along_load() const;
};

/// @throws std::invalid_argument naming the field, as `owner`.lead and so on; also when friction is
/// so large that no torque raises a load.
void validate(const PowerScrew& screw, const char* owner);

}  // namespace prehend::simulation
