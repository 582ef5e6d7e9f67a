#include "prehend/simulation/stage_arm.h"

#include <algorithm>
#include <cmath>

#include "prehend/contact/require.h"
#include "prehend/geometry/errors.h"

namespace prehend::simulation {
namespace {

using geometry::RigidTransform;

constexpr double kSamePose = 1e-9;  // m and 1
constexpr double kReserve = 2;      // of the platform's accelerations, for loops and brakes

[[noreturn]] void refuse_stage(const robot::Platform& platform, const std::string& why) {
  throw geometry::InputError(
      "Platform '" + platform.name + "', whose hand is moved through /gripper, " + why,
      "Simulate it as config/robots/stage_pg70.yaml is: slides along the world's x, y and z, a "
      "joint "
      "that turns about z, and the gripper straight down; or write hand_port: joints");
}

ArmDriveOptions drive_options(const robot::Platform& platform) {
  ArmDriveOptions options;
  for (const double most : platform.acceleration) options.accelerations.push_back(kReserve * most);
  return options;
}

}  // namespace

CarrierModel carrier_of(const robot::Platform& platform, const std::string& home) {
  const robot::KinematicChain chain = platform.arm_chain();
  if (chain.size() != 4) refuse_stage(platform, "has no four joints");
  if (!platform.hand.motors.empty()) {
    throw geometry::InputError(
        platform.hand.motors.begin()->second.place +
            " has no effect on a hand that is moved through /gripper",
        "Remove it, and describe its motor in the gripper's file under `drive`");
  }
  CarrierModel carrier;
  // The pose is what a carrier makes of the joints, wherever they are.
  const robot::Preshape& preshape = platform.hand.preshapes.front();
  for (int i = -1; i < 4; ++i) {
    robot::Positions q = chain.middle();
    if (i >= 0) q[i] += 0.1;
    const RigidTransform X_WG = platform.X_WB * chain.forward(q) * platform.X_FG(preshape);
    const RigidTransform expected = carrier.gripper_pose(q.head<3>(), q[3]);
    if ((X_WG.matrix() - expected.matrix()).cwiseAbs().maxCoeff() > kSamePose) {
      refuse_stage(platform, "is no stage whose joints are x, y, z of the gripper and its yaw");
    }
  }
  const auto& joints = chain.joints();
  carrier.max_speed = carrier.max_acceleration = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto axis = static_cast<Eigen::Index>(i);
    carrier.minimum[axis] = joints[i].lower;
    carrier.maximum[axis] = joints[i].upper;
    carrier.max_speed = std::max(carrier.max_speed, joints[i].max_velocity);
    carrier.max_acceleration = std::max(carrier.max_acceleration, platform.acceleration[axis]);
  }
  carrier.max_yaw_rate = joints[3].max_velocity;
  carrier.max_yaw_acceleration = platform.acceleration[3];
  const robot::Positions start = platform.home(home).arm;
  carrier.start = start.head<3>();
  carrier.start_yaw = start[3];
  return carrier;
}

robot::Positions stage_position(const World& world) {
  const CarrierReading carrier = world.carrier();
  robot::Positions q(4);
  q << carrier.X_WG.translation(), carrier.yaw;
  return q;
}

StageArm::StageArm(const robot::Platform& platform, const std::string& home)
    : options_(drive_options(platform)),
      drive_(platform.arm_chain(), platform.home(home).arm, options_) {
  carrier_of(platform, home);
}

void StageArm::follow(const TrajectoryRequest& request, const std::vector<double>& tolerance,
                      const World& world) {
  const robot::Positions q = moves_ ? drive_.position() : stage_position(world);
  const ArmTrajectory trajectory = check_trajectory(drive_.chain(), request, q, options_);
  if (!moves_) drive_ = ArmDrive(drive_.chain(), q, options_);
  drive_.follow(trajectory, tolerance);
  moves_ = true;
  stop_on_contact(0);
}

void StageArm::track(const robot::Positions& goal, const World& world) {
  if (!moves_) drive_ = ArmDrive(drive_.chain(), stage_position(world), options_);
  drive_.track(goal);
  moves_ = true;
  stop_on_contact(0);
}

void StageArm::let_go() {
  drive_.forget();
  moves_ = false;
  stop_on_contact(0);
}

void StageArm::stop_on_contact(double force) {
  contact::require_not_negative(force, "contact_force");
  contact_limit_ = force;
  contact_ = false;
}

bool StageArm::stands(const World& world) const {
  const robot::Positions way = drive_.position() - stage_position(world);
  return drive_.is_idle() && way.cwiseAbs().maxCoeff() < kSamePose;
}

void StageArm::drive(World& world) {
  const double h = world.scene().step;
  drive_.step(h);
  if (stands(world)) {
    world.drive_carrier(Eigen::Vector3d::Zero(), 0);
    moves_ = false;
    return;
  }
  const robot::Positions way = drive_.position() - stage_position(world);
  world.drive_carrier(way.head<3>() / h, way[3] / h);
}

// A joint's velocity is the mean over its last step: at an instant it is that of the steps before
// and after.
void StageArm::guide(World& world, std::int64_t steps) const {
  const double h = world.scene().step;
  ArmDrive ahead = drive_;
  const auto velocity_here = [&](ArmDrive drive) -> Eigen::Vector4d {
    const robot::Positions before = drive.velocity();
    drive.step(h);
    return 0.5 * (before + drive.velocity());
  };
  const Eigen::Vector4d start = velocity_here(ahead);
  for (std::int64_t i = 0; i < steps; ++i) ahead.step(h);
  const Eigen::Vector4d way = ahead.position() - stage_position(world);
  world.guide_carrier(
      CarrierPath::between(way, start, velocity_here(ahead), static_cast<double>(steps) * h));
}

bool StageArm::feels(const World& world) const {
  return contact_limit_ > 0 && world.wrist_wrench().force.norm() > contact_limit_;
}

std::int64_t StageArm::advance(World& world, std::int64_t steps) {
  const auto contact = [&] { return feels(world); };
  std::int64_t done = 0;
  if (!world.scene().physics.adaptive) {
    for (bool met = false; done < steps && !met; ++done) {
      if (moves_) drive(world);
      world.step();
      met = contact();
    }
  } else {
    if (moves_ && stands(world)) {
      world.drive_carrier(Eigen::Vector3d::Zero(), 0);
      moves_ = false;
    }
    if (moves_) guide(world, steps);
    done = world.advance(steps, contact);
    for (std::int64_t i = 0; moves_ && i < done; ++i) drive_.step(world.scene().step);
  }
  if (contact()) {
    stop();
    contact_ = true;
    contact_limit_ = 0;
  }
  return done;
}

}  // namespace prehend::simulation
