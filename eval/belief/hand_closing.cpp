#include "eval/belief/hand_closing.h"

#include "prehend/grasp/closing/distance_grid.h"
#include "prehend/grasp/closing/touch_scene.h"
#include "prehend/simulation/robot_world.h"

namespace prehend::eval {
namespace {

using geometry::RigidTransform;

constexpr double kApart = 5e-4;    // m, that an arm that is stopped leaves
constexpr double kEffort = 0.3;    // share of what the motors can
constexpr double kOverrun = 0.5;   // rad, as robot::GripOptions
constexpr double kSpeed = 0.3;     // share of the joints' greatest
constexpr double kTimeout = 10;    // s
constexpr double kSettling = 0.3;  // s
constexpr double kStep = 0.004;    // s
constexpr int kSampleEvery = 5;    // steps

belief::HandSample sample_of(const simulation::RobotWorld& world) {
  std::vector<std::string> names;
  std::vector<double> positions;
  for (const simulation::JointReading& joint : world.joints()) {
    names.push_back(joint.name);
    positions.push_back(joint.position);
  }
  return {world.X_WH(), touch::joint_positions(world.hand_model(), names, positions)};
}

}  // namespace

HandClosing close_hand(const grasp::HandToClose& to_close, const robot::ClosingWay& closing,
                       const RigidTransform& X_WH_start, const RigidTransform& X_WH_end,
                       const geometry::MeshQuery* object_W) {
  const robot::HandModel& hand = *to_close.hand;
  const Eigen::VectorXd open = hand.all_positions(closing.open);
  const Eigen::Vector3d way = X_WH_end.translation() - X_WH_start.translation();
  HandClosing result;
  RigidTransform X_WH = X_WH_end;
  if (object_W && way.norm() > 0) {
    const grasp::DistanceGrid grid(*object_W);
    grasp::TouchScene scene;
    scene.object_W = &grid;
    const grasp::Advance advance = grasp::advance_hand(to_close, X_WH_start, open, way.normalized(),
                                                       way.norm(), kApart, scene);
    result.arrived = advance.link < 0;
    if (!result.arrived) {
      X_WH.translation() = X_WH_start.translation() + advance.distance * way.normalized();
    }
  }
  result.way = {{X_WH_start, open}, {X_WH, open}};

  simulation::RobotWorldOptions options;
  options.step = kStep;
  simulation::RobotWorld world(hand, X_WH, "", options);
  if (object_W) world.add_object("object", object_W->mesh(), 1, true);
  world.set_hand(closing.open);
  simulation::HandCommand command;
  command.position = closing.at(kOverrun);
  command.speed = kSpeed;
  command.until_contact = true;
  command.effort = kEffort * world.hand().most_efforts();
  world.move_hand(command);
  double end = kTimeout;
  for (int step = 1; world.time() < end; ++step) {
    world.step();
    if (step % kSampleEvery == 0) result.way.push_back(sample_of(world));
    if (end == kTimeout && !world.hand().moving()) end = world.time() + kSettling;
  }
  result.way.push_back(sample_of(world));
  const std::vector<simulation::HandPadReading> pads = world.pads();
  for (std::size_t i = 0; i < pads.size(); ++i) {
    result.frames.push_back({pads[i].name,
                             touch::felt_pad_of(hand.pads[i]),
                             {pads[i].counts.begin(), pads[i].counts.end()}});
  }
  return result;
}

}  // namespace prehend::eval
