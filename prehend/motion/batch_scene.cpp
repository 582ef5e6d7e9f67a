#include "prehend/motion/batch_scene.h"

#include <algorithm>
#include <map>
#include <utility>

#include "prehend/motion/collision_world.h"

namespace prehend::motion {
namespace {

using Eigen::Vector3d;
using geometry::RigidTransform;

constexpr double kRounding = 1e-6;  // m
constexpr int kLargestGroup = 16;

std::array<float, 9> rows(const Eigen::Matrix3d& R) {
  std::array<float, 9> result{};
  for (int i = 0; i < 9; ++i)
    result[static_cast<std::size_t>(i)] = static_cast<float>(R(i / 3, i % 3));
  return result;
}

std::array<float, 3> floats(const Vector3d& p) {
  return {static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())};
}

BatchScene::Ball make_ball(const Vector3d& p, double radius) {
  return {static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z()),
          static_cast<float>(radius)};
}

/// A ball of the robot in its joint's turned frame, and where it stands in RobotSpheres.
struct Placed {
  Vector3d p;
  double radius;
  int index;
};

/// Splits balls at the middle of their longest extent until groups are small.
void group(std::vector<Placed> balls, int joint, Part part, BatchScene& scene,
           std::vector<int>& place, std::vector<int>& group_of) {
  Eigen::AlignedBox3d box;
  for (const Placed& ball : balls) box.extend(ball.p);
  if (balls.size() > kLargestGroup) {
    Eigen::Index axis = 0;
    box.sizes().maxCoeff(&axis);
    std::sort(balls.begin(), balls.end(), [axis](const Placed& a, const Placed& b) {
      return a.p[axis] != b.p[axis] ? a.p[axis] < b.p[axis] : a.index < b.index;
    });
    const auto middle = balls.begin() + static_cast<std::ptrdiff_t>(balls.size() / 2);
    group({balls.begin(), middle}, joint, part, scene, place, group_of);
    group({middle, balls.end()}, joint, part, scene, place, group_of);
    return;
  }
  BatchScene::Group result;
  result.joint = joint;
  result.part = static_cast<int>(part);
  result.first = static_cast<int>(scene.balls.size());
  double radius = 0;
  for (const Placed& ball : balls) {
    radius = std::max(radius, (ball.p - box.center()).norm() + ball.radius);
    place[static_cast<std::size_t>(ball.index)] = static_cast<int>(scene.balls.size());
    group_of[static_cast<std::size_t>(ball.index)] = static_cast<int>(scene.groups.size());
    scene.balls.push_back(make_ball(ball.p, ball.radius));
  }
  result.last = static_cast<int>(scene.balls.size());
  result.bound = make_ball(box.center(), radius + kRounding);
  scene.groups.push_back(result);
}

}  // namespace

BatchScene make_batch_scene(const robot::KinematicChain& chain, const RobotSpheres& spheres,
                            std::size_t own, const CollisionWorld& world, double margin) {
  BatchScene scene;
  // A joint's own frame, turned so that its axis is z.
  std::vector<Eigen::Quaterniond> turned;
  for (const robot::ChainJoint& joint : chain.joints()) {
    turned.push_back(Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), joint.axis_J));
    Eigen::Matrix3d R = joint.X_PJ.linear() * turned.back().toRotationMatrix();
    Vector3d t = joint.X_PJ.translation();
    if (turned.size() > 1) {
      const Eigen::Matrix3d back = turned[turned.size() - 2].conjugate().toRotationMatrix();
      R = back * R;
      t = back * t;
    }
    scene.joints.push_back({rows(R), floats(t), joint.is_revolute});
  }
  std::map<std::pair<int, int>, std::vector<Placed>> by_joint;
  for (std::size_t i = 0; i < spheres.spheres.size(); ++i) {
    const RobotSphere& sphere = spheres.spheres[i];
    const Part part = part_of_ball(sphere, i >= own, chain.size());
    const Vector3d p =
        sphere.joint < 0
            ? sphere.p_J
            : Vector3d(turned[static_cast<std::size_t>(sphere.joint)].conjugate() * sphere.p_J);
    by_joint[{sphere.joint, static_cast<int>(part)}].push_back(
        {p, sphere.radius, static_cast<int>(i)});
  }
  std::vector<int> place(spheres.spheres.size()), group_of(spheres.spheres.size());
  for (auto& [key, balls] : by_joint) {
    group(std::move(balls), key.first, static_cast<Part>(key.second), scene, place, group_of);
  }
  std::map<std::pair<int, int>, std::vector<BatchScene::BallPair>> by_groups;
  for (const auto& [first, second] : spheres.self_pairs) {
    const auto a = static_cast<std::size_t>(first), b = static_cast<std::size_t>(second);
    const double reach = spheres.spheres[a].radius + spheres.spheres[b].radius + kRounding;
    by_groups[{group_of[a], group_of[b]}].push_back(
        {place[a], place[b], static_cast<float>(reach)});
  }
  for (const auto& [key, pairs] : by_groups) {
    const int first = static_cast<int>(scene.ball_pairs.size());
    scene.ball_pairs.insert(scene.ball_pairs.end(), pairs.begin(), pairs.end());
    scene.group_pairs.push_back(
        {key.first, key.second, first, static_cast<int>(scene.ball_pairs.size())});
  }
  for (const CollisionWorld::Obstacle& from : world.obstacles()) {
    using From = CollisionWorld::Obstacle::Kind;
    using To = BatchScene::Obstacle::Kind;
    BatchScene::Obstacle obstacle;
    obstacle.kind = from.kind == From::kPlane    ? To::kPlane
                    : from.kind == From::kBox    ? To::kBox
                    : from.kind == From::kSphere ? To::kSphere
                                                 : To::kConvex;
    obstacle.bound = make_ball(from.center, from.radius);
    for (const Part part : {Part::kArm, Part::kHand, Part::kHeld}) {
      obstacle.margin[static_cast<std::size_t>(part)] =
          static_cast<float>(from.margin_for(part, margin) + kRounding);
    }
    obstacle.R = rows(from.X_OB.linear());
    obstacle.t = floats(from.X_OB.translation());
    obstacle.half = floats(from.half);
    obstacle.first = static_cast<int>(scene.faces.size());
    for (const geometry::Plane& face : from.faces) {
      const auto n = floats(face.normal);
      scene.faces.push_back({n[0], n[1], n[2], static_cast<float>(face.offset)});
    }
    obstacle.last = static_cast<int>(scene.faces.size());
    scene.obstacles.push_back(obstacle);
  }
  return scene;
}

}  // namespace prehend::motion
