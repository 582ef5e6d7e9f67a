#include "prehend/motion/batch_scene.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "prehend/geometry/rotation_between.h"
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

/// A point that never moves, and how far from it a ball of each joint's frame can be, beside its
/// own distance from that frame's origin: on the first axis, beside the second joint.
struct Reach {
  Vector3d anchor = Vector3d::Zero();
  std::vector<double> length;  // m, of each joint's origin
};

Reach reach_of(const robot::KinematicChain& chain) {
  const auto& joints = chain.joints();
  Reach reach;
  reach.anchor = joints[0].X_PJ.translation();
  double length = 0;
  const auto travel = [](const robot::ChainJoint& joint) {
    return joint.is_revolute ? 0 : std::max(std::abs(joint.lower), std::abs(joint.upper));
  };
  for (std::size_t j = 0; j < joints.size(); ++j) {
    if (j == 1 && joints[0].is_revolute) {
      const Vector3d way = joints[1].X_PJ.translation();
      const double along = way.dot(joints[0].axis_J);
      reach.anchor += joints[0].X_PJ.linear() * (along * joints[0].axis_J);
      reach.length[0] = std::abs(along);
      length = (way - along * joints[0].axis_J).norm();
    } else if (j > 0) {
      length += joints[j].X_PJ.translation().norm();
    }
    length += travel(joints[j]);
    reach.length.push_back(length);
  }
  return reach;
}

/// Lists what each group can come near to.
void find_candidates(const Reach& reach, BatchScene& scene) {
  for (BatchScene::Group& group : scene.groups) {
    group.first_candidate = static_cast<int>(scene.candidates.size());
    for (std::size_t i = 0; group.joint >= 0 && i < scene.obstacles.size(); ++i) {
      const BatchScene::Obstacle& obstacle = scene.obstacles[i];
      if (obstacle.kind == BatchScene::Obstacle::Kind::kPlane) continue;
      const BatchScene::Ball& ball = obstacle.bound;
      const float far =
          ball.radius + group.bound.radius + obstacle.margin[static_cast<std::size_t>(group.part)];
      const double arm = reach.length[static_cast<std::size_t>(group.joint)] +
                         Vector3d(group.bound.x, group.bound.y, group.bound.z).norm();
      // A millimetre for what single precision loses.
      if (!((Vector3d(ball.x, ball.y, ball.z) - reach.anchor).norm() < arm + far + 1e-3)) continue;
      scene.candidates.push_back({ball.x, ball.y, ball.z, far, static_cast<int>(i)});
    }
    while (scene.candidates.size() % BatchScene::kCandidates != 0) scene.candidates.push_back({});
    group.last_candidate = static_cast<int>(scene.candidates.size());
  }
}

}  // namespace

BatchScene make_batch_scene(const robot::KinematicChain& chain, const RobotSpheres& spheres,
                            std::size_t own, const CollisionWorld& world, double margin) {
  BatchScene scene;
  // A joint's own frame, turned so that its axis is z.
  std::vector<Eigen::Quaterniond> turned;
  for (const robot::ChainJoint& joint : chain.joints()) {
    turned.push_back(geometry::rotation_between(Vector3d::UnitZ(), joint.axis_J));
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
  // Pairs of balls by their groups; within one in their order.
  const auto groups = scene.groups.size();
  const auto key_of = [&](const std::pair<int, int>& pair) {
    return static_cast<std::size_t>(group_of[static_cast<std::size_t>(pair.first)]) * groups +
           static_cast<std::size_t>(group_of[static_cast<std::size_t>(pair.second)]);
  };
  std::vector<int> starts(groups * groups + 1, 0);
  for (const auto& pair : spheres.self_pairs) ++starts[key_of(pair) + 1];
  for (std::size_t key = 0; key < groups * groups; ++key) {
    starts[key + 1] += starts[key];
    if (starts[key + 1] == starts[key]) continue;
    scene.group_pairs.push_back({static_cast<int>(key / groups), static_cast<int>(key % groups),
                                 starts[key], starts[key + 1]});
  }
  scene.ball_pairs.resize(spheres.self_pairs.size());
  for (const auto& pair : spheres.self_pairs) {
    const auto a = static_cast<std::size_t>(pair.first), b = static_cast<std::size_t>(pair.second);
    const double reach = spheres.spheres[a].radius + spheres.spheres[b].radius + kRounding;
    scene.ball_pairs[static_cast<std::size_t>(starts[key_of(pair)]++)] = {
        place[a], place[b], static_cast<float>(reach)};
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
    if (obstacle.kind == To::kPlane)
      scene.planes.push_back(static_cast<int>(scene.obstacles.size()));
    scene.obstacles.push_back(obstacle);
  }
  find_candidates(reach_of(chain), scene);
  return scene;
}

}  // namespace prehend::motion
