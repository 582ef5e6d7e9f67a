#include "prehend/motion/pick_scenes.h"

#include <algorithm>
#include <limits>

namespace prehend::motion {
namespace {

constexpr double kSlack = 1e-3;  // m that what is held may come nearer on its way up, at least
constexpr double kNever = std::numeric_limits<double>::infinity();

}  // namespace

PickScenes::PickScenes(const RobotInWorld& robot, const PickTask& task)
    : task_(task), reach_(robot), approach_(robot), without_(robot) {
  approach_.change_world([this](CollisionWorld& world) { let_hand(world); });
  without_.change_world([&task](CollisionWorld& world) { world.remove(task.object.name); });
}

void PickScenes::let_hand(CollisionWorld& world) const {
  world.set_margin(task_.object.name, Part::kHand, -kNever);
  for (const std::string& name : task_.kept_clear) world.set_margin(name, Part::kHand, -kNever);
}

std::vector<RobotSphere> PickScenes::held(const PickGrasp& grasp) const {
  const geometry::RigidTransform X_TO = grasp.X_BT.inverse() * task_.object.X_BO;
  std::vector<RobotSphere> balls;
  for (const Ball& ball : task_.object.cover_O.balls) {
    balls.push_back({-1, X_TO * ball.center, ball.radius});
  }
  return balls;
}

RobotInWorld PickScenes::carry(const PickGrasp& grasp) const {
  RobotInWorld scene = without_;
  scene.attach(held(grasp));
  return scene;
}

RobotInWorld PickScenes::lift(const PickGrasp& grasp, const robot::Positions& q) const {
  RobotInWorld scene = without_;
  scene.attach(held(grasp), [&](CollisionWorld& world) {
    for (const std::string& name : world.names()) {
      // Things that lie there overlap by as much as their shapes are thought too large, at least.
      const double clearance = scene.held_clearance(name, q);
      const double near = clearance - std::max(kSlack, -clearance);
      if (near < scene.margin()) world.set_margin(name, Part::kHeld, near);
    }
    let_hand(world);
  });
  return scene;
}

RobotInWorld PickScenes::retreat(const geometry::RigidTransform& X_BO) const {
  RobotInWorld scene = without_;
  scene.change_world([&](CollisionWorld& world) {
    for (const Ball& ball : task_.object.cover_O.balls) {
      world.add_sphere(task_.object.name, X_BO * ball.center, ball.radius);
    }
    let_hand(world);
  });
  return scene;
}

geometry::RigidTransform PickScenes::X_BT_at(const PickGrasp& grasp,
                                             const geometry::RigidTransform& X_BO) const {
  return X_BO * task_.object.X_BO.inverse() * grasp.X_BT;
}

Eigen::Vector3d PickScenes::approach_at(const PickGrasp& grasp,
                                        const geometry::RigidTransform& X_BO) const {
  return X_BO.linear() * task_.object.X_BO.linear().transpose() * grasp.approach_direction_B;
}

}  // namespace prehend::motion
