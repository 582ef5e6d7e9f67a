#pragma once

#include <string>
#include <vector>

#include "prehend/robot/platform.h"
#include "prehend/simulation/arm_drive.h"
#include "prehend/simulation/world.h"

namespace prehend::simulation {

/// The carrier that a platform is: three slides along the world's axes and a joint that turns the
/// gripper about the vertical, which holds it straight down. Its limits, speeds and accelerations
/// are the platform's, it starts at `home`.
/// @throws geometry::InputError for any other platform, and for an unknown home.
CarrierModel carrier_of(const robot::Platform& platform, const std::string& home);

/// The joints of a stage: moves the carrier of a World along trajectories, as ArmDrive does with
/// the joints of an arm, with the platform's accelerations twice over for its loops and its brakes.
/// Its state is its value: copy to save.
class StageArm {
 public:
  /// @throws as carrier_of().
  StageArm(const robot::Platform& platform, const std::string& home);

  /// Checks and starts, from where the carrier stands.
  /// @throws std::invalid_argument (check_trajectory).
  void follow(const TrajectoryRequest& request, const std::vector<double>& tolerance,
              const World& world);
  /// To a set point, as ArmDrive::track(), from where the carrier stands or moves.
  void track(const robot::Positions& goal, const World& world);
  void stop() { drive_.stop(); }
  /// Forgets the last trajectory, and leaves the carrier to others.
  void let_go();
  /// Stops when the wrist's contact force exceeds `force` [N] in a step; 0: not.
  void stop_on_contact(double force);
  bool stopped_by_contact() const { return contact_; }

  /// Advances `world` by at most `steps` of its scene's and moves its carrier, which somebody else
  /// may move while no trajectory is followed. Returns how many: fewer where contact has stopped
  /// it. With fixed steps the carrier has one velocity in each; with adaptive ones a cubic through
  /// where the joints are at the beginning and the end, and contact is felt where a step ends.
  std::int64_t advance(World& world, std::int64_t steps);

  const ArmDrive& drive() const { return drive_; }
  bool moves() const { return moves_; }

 private:
  /// Whether the joints stand where they are to be: nothing is left to do.
  bool stands(const World& world) const;
  /// Steps the joints once and gives the carrier its velocity.
  void drive(World& world);
  /// Gives the carrier its path through the next `steps`.
  void guide(World& world, std::int64_t steps) const;
  bool feels(const World& world) const;

  ArmDriveOptions options_;
  ArmDrive drive_;
  bool moves_ = false;  // the carrier is driven
  double contact_limit_ = 0;
  bool contact_ = false;
};

/// Where the joints x, y, z [m] and yaw [rad] of a World's carrier are.
robot::Positions stage_position(const World& world);

}  // namespace prehend::simulation
