#include <cmath>

#include "eval/touch/hold.h"
#include "prehend/geometry/gravity.h"
#include "prehend/simulation/robot_world.h"
#include "prehend/simulation/shapes.h"
#include "prehend/text/tree_file.h"

namespace prehend::eval::touch {

using geometry::RigidTransform;
using simulation::RobotWorld;

namespace {

constexpr double kGraspHeight = 0.07, kLift = 0.05;  // m
constexpr double kWay = 1.6;                         // rad, that fingers are told to close by
const Eigen::Vector3d kBox(0.06, 0.06, 0.12);        // m
constexpr double kFriction = 0.7;

/// H where the tool of `preshape` is at `p_W`, straight down.
RigidTransform above(const robot::HandModel& hand, const robot::Preshape& preshape,
                     const Eigen::Vector3d& p_W) {
  RigidTransform X_WG = RigidTransform::Identity();
  X_WG.linear() = Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX()).toRotationMatrix();
  X_WG.translation() = p_W;
  return X_WG * (hand.X_HP * preshape.X_PG).inverse();
}

double pressing(const RobotWorld& world) {  // N, sum over the links and their pads
  double sum = 0;
  for (const simulation::LinkContact& contact : world.link_contacts()) sum += contact.normal_force;
  return sum;
}

}  // namespace

RobotWorld hand_over_box(const robot::HandModel& hand, double mass, double step) {
  const robot::Preshape& preshape = hand.preshapes.front();
  simulation::RobotWorldOptions options;
  options.step = step;
  RobotWorld world(hand, above(hand, preshape, {0, 0, kGraspHeight}), preshape.name, options);
  world.add_object("box", simulation::make_standing_box(kBox), mass, false, kFriction);
  return world;
}

simulation::HandCommand closing_on_box(const robot::HandModel& hand) {
  const robot::Preshape& preshape = hand.preshapes.front();
  simulation::HandCommand command;
  command.position = preshape.open;
  for (int i = 0; i < hand.size(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    const robot::Joint& joint = hand.model.joints[static_cast<std::size_t>(hand.actuated[k])];
    command.position[i] =
        std::clamp(preshape.open[i] + kWay * preshape.closing[k].rate, joint.lower, joint.upper);
  }
  command.speed = 0.3;
  command.until_contact = true;
  return command;
}

HandHold run_hand_hold(const std::string& hand_name, const HoldTest& test) {
  const robot::HandModel hand =
      robot::read_hand_model(text::tree_file("config/robots/" + hand_name + ".yaml"));
  RobotWorld world = hand_over_box(hand, test.mass, test.step);
  const auto advance = [&world](double seconds) {
    for (long i = std::lround(seconds / world.options().step); i > 0; --i) world.step();
  };
  const auto height = [&world] { return world.body("box").height; };
  world.move_hand(closing_on_box(hand));
  advance(3);
  HandHold result;
  result.bears = std::min(hand.friction, kFriction) * pressing(world) / geometry::kGravity;
  RigidTransform up = world.X_WH();
  up.translation().z() += kLift;
  world.carry(up, 1);
  advance(2);
  const double at_start = height();
  advance(0.5 * test.duration);
  const double at_middle = height();
  advance(0.5 * test.duration);
  HoldResult& hold = result.hold;
  hold.slip = at_middle - height();
  hold.held = at_start > 0.9 * kLift && at_start - height() < 0.005;
  hold.creep = hold.slip / (0.5 * test.duration);
  return result;
}

}  // namespace prehend::eval::touch
