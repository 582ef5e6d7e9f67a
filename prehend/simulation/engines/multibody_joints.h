#pragma once

#include <limits>
#include <vector>

#include <Eigen/Core>

namespace prehend::simulation::engines {

/// What a joint of a Multibody does by itself. Units of a revolute joint; of a prismatic one metres
/// for radians, N for N m, kg for kg m^2.
struct JointMechanics {
  /// Stops [rad] of the position (0: the scene's start). They take all the energy of what runs into
  /// them and hold it.
  double lower = -std::numeric_limits<double>::infinity();
  double upper = std::numeric_limits<double>::infinity();
  double damping = 0;        // N m s/rad, >= 0
  double dry_friction = 0;   // N m, >= 0, Coulomb: sticks up to it, then opposes the motion with it
  double rotor_inertia = 0;  // kg m^2, >= 0, of what turns with the joint beside its bodies
};

/// What drives a joint, until it is changed.
struct JointDrive {
  enum class Mode {
    kNone,      // nothing
    kVelocity,  // force = damping (target - velocity)
    kPosition   // force = stiffness (target - position) + damping (target_velocity - velocity)
  };
  Mode mode = Mode::kNone;
  double target = 0;           // rad or rad/s
  double target_velocity = 0;  // rad/s, of kPosition
  double stiffness = 0;        // N m/rad, >= 0, of kPosition
  double damping = 0;          // N m s/rad, >= 0
  /// The drive moves the sum position + share * (position of joint `along`), as a motor does that
  /// turns a chain of two links by one tendon or gear. -1: this joint alone.
  int along = -1;
  double share = 0;
  /// N m, >= 0, of the mode's force.
  double limit = std::numeric_limits<double>::infinity();
  double force = 0;  // N m, on top of that of the mode
};

/// Two joints by a gear with a clutch: `first` moves by `ratio` times what `second` moves, as long
/// as that takes no more than `breakaway` [N m, at `first`]; beyond, the clutch slips and bears
/// just that. So a BarrettHand's finger goes on with its outer link when the inner one is stopped
/// (Townsend, "The BarrettHand grasper", Industrial Robot 27(3), 2000: TorqueSwitch).
struct JointCoupling {
  int first = 0, second = 0;  // joints that follow none
  double ratio = 1;
  double breakaway = std::numeric_limits<double>::infinity();  // N m, > 0
};

/// One force along the velocity w = u_i - weight u_j of a step: clamp(offset - gain w, least,
/// most). Drives, stops, friction and clutches are all of this kind. The force falls with w, so the
/// step's equations stay those of a convex function and each has one solution.
struct JointRow {
  int i = 0, j = -1;  // coordinates
  double weight = 0;
  double offset = 0, gain = 0;
  double least = -std::numeric_limits<double>::infinity();
  double most = std::numeric_limits<double>::infinity();
  int cut = 0;  // -1: at `least`, 1: at `most`, 0: between

  double velocity(const Eigen::VectorXd& u) const { return u[i] - (j < 0 ? 0.0 : weight * u[j]); }
  double force(const Eigen::VectorXd& u) const {
    const double free = offset - gain * velocity(u);
    return free < least ? least : (free > most ? most : free);
  }
  /// Chooses `cut` for the velocities; a force that leaps from one end to the other comes to rest
  /// between them first, so that the choice does not alternate. True when it changed.
  bool choose(const Eigen::VectorXd& u);
};

/// @throws std::invalid_argument naming joint and field.
void validate(const JointMechanics& mechanics, int joint);
void validate(const JointDrive& drive, int joint);

}  // namespace prehend::simulation::engines
