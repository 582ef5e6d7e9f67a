// What a robot's world saves and restores.

#include "prehend/contact/require.h"
#include "prehend/simulation/robot_world_implementation.h"

namespace prehend::simulation {

struct RobotWorld::State {
  std::uint64_t generation = 0;
  engines::MultibodyState state;
  HandDrive hand;
  std::optional<ArmDrive> arm;
  RobotSensors sensors;
  ContactWrench wrist;
  std::optional<Implementation::Path> path;
  geometry::RigidTransform X_WR;
  Eigen::VectorXd all;
  std::vector<double> still_time, drive_force;
  std::vector<char> asleep;
  double contact_limit = 0, contact_time = 0;
  bool contact = false;
};

std::shared_ptr<const RobotWorld::State> RobotWorld::save() const {
  const Implementation& world = *implementation_;
  auto saved = std::make_shared<State>(State{world.generation,
                                             world.state,
                                             *world.hand,
                                             world.arm,
                                             world.sensors,
                                             world.wrist,
                                             world.path,
                                             world.X_WR,
                                             world.all,
                                             {},
                                             world.system->drive_forces(),
                                             {},
                                             world.contact_limit,
                                             world.contact_time,
                                             world.contact});
  for (const Implementation::Thing& thing : world.things) {
    saved->still_time.push_back(thing.still_time);
    saved->asleep.push_back(thing.asleep ? 1 : 0);
  }
  return saved;
}

void RobotWorld::restore(const State& saved) {
  Implementation& world = *implementation_;
  contact::require(saved.generation == world.generation, "the saved state",
                   "of this world with these objects");
  world.state = saved.state;
  *world.hand = saved.hand;
  world.arm = saved.arm;
  world.sensors = saved.sensors;
  world.wrist = saved.wrist;
  world.path = saved.path;
  world.X_WR = saved.X_WR;
  world.all = saved.all;
  world.contact_limit = saved.contact_limit;
  world.contact_time = saved.contact_time;
  world.contact = saved.contact;
  world.system->set_drive_forces(saved.drive_force);
  for (std::size_t i = 0; i < world.things.size(); ++i) {
    Implementation::Thing& thing = world.things[i];
    thing.still_time = saved.still_time[i];
    thing.asleep = saved.asleep[i] != 0;
    if (!thing.model.is_static) world.system->set_asleep(thing.body, thing.asleep);
  }
}

}  // namespace prehend::simulation
