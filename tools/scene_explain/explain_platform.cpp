#include "tools/scene_explain/explain_platform.h"

#include <cmath>
#include <numbers>
#include <set>

#include <fmt/format.h>

#include "prehend/planning/platform_pick.h"
#include "prehend/planning/platform_world.h"
#include "prehend/robot/platform.h"

namespace prehend::tools {
namespace {

using simulation::Explanation;
using simulation::kNoBound;

constexpr double kBeyond = 1.8;  // resolutions, see make_robot_spheres()

std::string motion_of(const robot::Platform& platform) {
  const robot::KinematicChain chain = platform.arm_chain();
  std::string joints;
  for (int k = 0; k < chain.size(); ++k) {
    const robot::ChainJoint& joint = chain.joints()[static_cast<std::size_t>(k)];
    const bool slides = !joint.is_revolute;
    const double unit = slides ? 1e3 : 180 / std::numbers::pi;
    joints +=
        fmt::format("{}{} {:.0f} to {:.0f} {}, {:.0f} {}/s, {:.0f} {}/s^2",
                    joints.empty() ? "" : "; ", joint.name, unit * joint.lower, unit * joint.upper,
                    slides ? "mm" : "deg", unit * joint.max_velocity, slides ? "mm" : "deg",
                    unit * platform.acceleration[k], slides ? "mm" : "deg");
  }
  return joints;
}

std::string text_of(const robot::HandModel& hand) {
  std::size_t cells = 0;
  for (const robot::HandPad& pad : hand.pads) cells += pad.layout->cells();
  std::string preshapes;
  for (const robot::Preshape& one : hand.preshapes) {
    preshapes += (preshapes.empty() ? "" : ", ") + one.name;
  }
  return fmt::format("{}: {} motors, {} pads of {} cells, closes by {}; preshapes {}", hand.name,
                     hand.size(), hand.pads.size(), cells, hand.closing_method(), preshapes);
}

void tell_collisions(const robot::Platform& platform, Explanation* out) {
  const planning::PlatformPickOptions options;
  const motion::RobotInWorld robot =
      planning::robot_in(motion::CollisionWorld(), platform, platform.hand.preshapes.front().open,
                         options.margin, options.sphere_resolution, nullptr);
  const motion::RobotSpheres& balls = robot.spheres();
  std::set<int> links;
  for (const motion::RobotSphere& ball : balls.spheres) links.insert(ball.link);
  const std::size_t count = balls.spheres.size(), tested = balls.self_pairs.size(),
                    apart = balls.apart_pairs.size();
  const std::size_t pairs = count * (count - 1) / 2;
  out->modelled.push_back(
      {"links, for collisions",
       fmt::format("{} balls that hold {} links; {:.0f} mm are kept from obstacles", count,
                   links.size(), 1e3 * options.margin)});
  out->modelled.push_back({"the robot against itself", fmt::format("{} pairs of balls", tested)});
  const double beyond = kBeyond * options.sphere_resolution;
  out->left_out.push_back(
      {"the links' shapes", "collision_checker: fcl, bullet test them", beyond, "m",
       fmt::format("balls reach at most {:.0f} mm beyond them; of meshes {:.0f} mm", 1e3 * beyond,
                   1e3 * options.sphere_resolution / 5),
       "balls are tested many at once"});
  out->left_out.push_back(
      {fmt::format("{} of {} pairs of balls", apart, pairs), "links that cannot collide", 0, "m",
       "proven of all positions of the joints between them, within their limits",
       "they touch nowhere"});
  out->left_out.push_back(
      {fmt::format("{} of {} pairs of balls", pairs - tested - apart, pairs),
       "links that are built to touch", kNoBound, "",
       "what touches in the middle of the limits is taken to be built so",
       "of one link, of neighbours, or overlapping in the middle of the limits"});
}

}  // namespace

Explanation explain_platform(const std::filesystem::path& file) {
  const robot::Platform platform = robot::read_platform(file);
  Explanation out;
  out.modelled.push_back({"arm", motion_of(platform)});
  out.modelled.push_back({"hand", text_of(platform.hand)});
  tell_collisions(platform, &out);
  out.left_out.push_back({"bending of links, play of joints", "", kNoBound, "", "no bound is known",
                          "there is no model of it"});
  out.remarks.push_back("How it is simulated: prehend explain config/scenes/demo.yaml --platform " +
                        platform.name);
  return out;
}

}  // namespace prehend::tools
