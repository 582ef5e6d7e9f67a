#include "prehend/motion/batch_scene.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <span>
#include <utility>

#include "prehend/geometry/rotation_between.h"
#include "prehend/motion/collision_world.h"

namespace prehend::motion {
namespace {

using Eigen::Vector3d;
using geometry::RigidTransform;

constexpr double kRounding = 1e-6;  // m
constexpr int kLargestGroup = 8;
constexpr int kDraws = 50;

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

/// Balls' centres and radii coordinate by coordinate, so that many are looked at at once.
struct BallArrays {
  Eigen::ArrayXd x, y, z, radius, distance;

  explicit BallArrays(const std::vector<Placed>& balls) {
    const auto count = static_cast<Eigen::Index>(balls.size());
    for (Eigen::ArrayXd* array : {&x, &y, &z, &radius, &distance}) array->resize(count);
    for (Eigen::Index i = 0; i < count; ++i) {
      const Placed& ball = balls[static_cast<std::size_t>(i)];
      x[i] = ball.p.x();
      y[i] = ball.p.y();
      z[i] = ball.p.z();
      radius[i] = ball.radius;
    }
  }
  void measure_from(const Vector3d& center) {
    distance =
        ((x - center.x()).square() + (y - center.y()).square() + (z - center.z()).square()).sqrt();
  }
  /// The ball that reaches farthest from the centre that was measured from.
  Eigen::Index farthest() const {
    Eigen::Index index = 0;
    (distance + radius).maxCoeff(&index);
    return index;
  }
};

/// A ball round balls: their middle, drawn towards the farthest of them again and again (M. Badoiu
/// and K. L. Clarkson, "Smaller core-sets for balls", SODA 2003).
BatchScene::Node bound_of(const std::vector<Placed>& balls) {
  Eigen::AlignedBox3d box;
  for (const Placed& ball : balls) box.extend(ball.p);
  Vector3d center = box.center();
  BallArrays arrays(balls);
  for (int k = 1; k <= kDraws && balls.size() > 1; ++k) {
    arrays.measure_from(center);
    center += (balls[static_cast<std::size_t>(arrays.farthest())].p - center) / (k + 1);
  }
  arrays.measure_from(center);
  BatchScene::Node node;
  node.ball = make_ball(center, (arrays.distance + arrays.radius).maxCoeff() + kRounding);
  node.spread = static_cast<float>(arrays.distance.maxCoeff() + kRounding);
  return node;
}

/// Adds a node for balls and those under it: they are split at the middle of their longest extent
/// until they are few.
void add_nodes(std::vector<Placed> balls, BatchScene::Tree& tree, BatchScene& scene) {
  const auto at = scene.nodes.size();
  if (balls.size() > 1) scene.nodes.push_back(bound_of(balls));
  if (balls.size() > kLargestGroup) {
    Eigen::AlignedBox3d box;
    for (const Placed& ball : balls) box.extend(ball.p);
    Eigen::Index axis = 0;
    box.sizes().maxCoeff(&axis);
    std::sort(balls.begin(), balls.end(), [axis](const Placed& a, const Placed& b) {
      return a.p[axis] != b.p[axis] ? a.p[axis] < b.p[axis] : a.index < b.index;
    });
    const auto middle = balls.begin() + static_cast<std::ptrdiff_t>(balls.size() / 2);
    add_nodes({balls.begin(), middle}, tree, scene);
    add_nodes({middle, balls.end()}, tree, scene);
  } else {
    for (const Placed& ball : balls) {
      const auto index = static_cast<std::size_t>(ball.index);
      scene.ball_tree[index] = static_cast<int>(scene.trees.size());
      scene.ball_leaf[index] = tree.leaves;
      BatchScene::Node leaf;
      leaf.ball = make_ball(ball.p, ball.radius);
      leaf.next = static_cast<int>(scene.nodes.size()) + 1;
      leaf.leaf = tree.leaves++;
      scene.nodes.push_back(leaf);
    }
  }
  scene.nodes[at].next = static_cast<int>(scene.nodes.size());
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

/// Lists what each tree can come near to.
void find_candidates(const Reach& reach, const CollisionWorld& world, BatchScene& scene) {
  for (BatchScene::Tree& tree : scene.trees) {
    const BatchScene::Ball& root = scene.nodes[static_cast<std::size_t>(tree.first)].ball;
    for (std::size_t i = 0; tree.joint >= 0 && i < scene.obstacles.size(); ++i) {
      const float margin = scene.obstacles[i].margin[static_cast<std::size_t>(tree.part)];
      if (margin == -std::numeric_limits<float>::infinity()) continue;
      const double arm = reach.length[static_cast<std::size_t>(tree.joint)] +
                         Vector3d(root.x, root.y, root.z).norm() + root.radius +
                         std::max(0.0F, margin);
      // A millimetre for what single precision loses.
      const bool is_plane = scene.obstacles[i].kind == BatchScene::Obstacle::Kind::kPlane;
      if (is_plane || world.obstacles()[i].bounds.exteriorDistance(reach.anchor) < arm + 1e-3) {
        tree.obstacles.push_back(static_cast<int>(i));
      }
    }
  }
}

/// Lists which trees, and which of their balls, must not touch each other, of the pairs of spheres
/// from the `first` on.
void add_pairs(const RobotSpheres& spheres, std::size_t first, BatchScene& scene) {
  const std::span pairs = std::span(spheres.self_pairs).subspan(first);
  // The tree of the joint that comes first is `a`.
  const auto ordered = [&](const std::pair<int, int>& pair) {
    auto a = static_cast<std::size_t>(pair.first), b = static_cast<std::size_t>(pair.second);
    if (spheres.spheres[a].joint > spheres.spheres[b].joint) std::swap(a, b);
    return std::pair(a, b);
  };
  const std::size_t trees = scene.trees.size();
  const auto key_of = [&](std::size_t a, std::size_t b) {
    return static_cast<std::size_t>(scene.ball_tree[a]) * trees +
           static_cast<std::size_t>(scene.ball_tree[b]);
  };
  std::vector<std::size_t> counts(trees * trees, 0);
  for (const auto& pair : pairs) {
    const auto [a, b] = ordered(pair);
    ++counts[key_of(a, b)];
  }
  std::vector<int> pair_of(trees * trees, -1);  // where some may touch
  for (std::size_t key = 0; key < counts.size(); ++key) {
    if (counts[key] == 0) continue;
    BatchScene::TreePair pair{static_cast<int>(key / trees), static_cast<int>(key % trees), {}};
    const auto all = static_cast<std::size_t>(scene.trees[key / trees].leaves) *
                     static_cast<std::size_t>(scene.trees[key % trees].leaves);
    if (counts[key] < all) {
      pair.must_not.resize(all, false);
      pair_of[key] = static_cast<int>(scene.tree_pairs.size());
    }
    scene.tree_pairs.push_back(std::move(pair));
  }
  for (const auto& one : pairs) {
    const auto [a, b] = ordered(one);
    const int at = pair_of[key_of(a, b)];
    if (at < 0) continue;
    BatchScene::TreePair& pair = scene.tree_pairs[static_cast<std::size_t>(at)];
    pair.must_not[static_cast<std::size_t>(
        scene.ball_leaf[a] * scene.trees[static_cast<std::size_t>(pair.b)].leaves +
        scene.ball_leaf[b])] = true;
  }
}

BatchScene::Obstacle make_obstacle(const CollisionWorld::Obstacle& from, double margin,
                                   BatchScene& scene) {
  using From = CollisionWorld::Obstacle::Kind;
  using To = BatchScene::Obstacle::Kind;
  BatchScene::Obstacle obstacle;
  obstacle.kind = from.kind == From::kPlane    ? To::kPlane
                  : from.kind == From::kBox    ? To::kBox
                  : from.kind == From::kSphere ? To::kSphere
                                               : To::kConvex;
  if (from.kind != From::kPlane) {
    obstacle.center = floats(from.bounds.center());
    obstacle.half = floats(from.bounds.sizes() / 2 + Vector3d::Constant(kRounding));
  }
  obstacle.ball = make_ball(from.center, from.radius);
  for (const Part part : {Part::kArm, Part::kHand, Part::kHeld}) {
    obstacle.margin[static_cast<std::size_t>(part)] =
        static_cast<float>(from.margin_for(part, margin));
  }
  obstacle.R = rows(from.X_OB.linear());
  obstacle.t = floats(from.X_OB.translation());
  obstacle.sides = floats(from.half);
  obstacle.first = static_cast<int>(scene.faces.size());
  for (const geometry::Plane& face : from.faces) {
    const auto n = floats(face.normal);
    scene.faces.push_back({n[0], n[1], n[2], static_cast<float>(face.offset)});
  }
  obstacle.last = static_cast<int>(scene.faces.size());
  return obstacle;
}

/// Axis z to each joint's own.
std::vector<Eigen::Quaterniond> turned_frames(const robot::KinematicChain& chain) {
  std::vector<Eigen::Quaterniond> turned;
  for (const robot::ChainJoint& joint : chain.joints()) {
    turned.push_back(geometry::rotation_between(Vector3d::UnitZ(), joint.axis_J));
  }
  return turned;
}

/// Adds trees of the spheres from the `first` on, one for each part of each link.
void add_trees(const robot::KinematicChain& chain, const RobotSpheres& spheres, std::size_t first,
               bool held, BatchScene& scene) {
  const std::vector<Eigen::Quaterniond> turned = turned_frames(chain);
  scene.ball_tree.resize(spheres.spheres.size());
  scene.ball_leaf.resize(spheres.spheres.size());
  std::map<std::array<int, 3>, std::vector<Placed>> links;
  for (std::size_t i = first; i < spheres.spheres.size(); ++i) {
    const RobotSphere& sphere = spheres.spheres[i];
    const Part part = part_of_ball(sphere, held, chain.size());
    const Vector3d p =
        sphere.joint < 0
            ? sphere.p_J
            : Vector3d(turned[static_cast<std::size_t>(sphere.joint)].conjugate() * sphere.p_J);
    links[{sphere.joint, static_cast<int>(part), sphere.link}].push_back(
        {p, sphere.radius + kRounding, static_cast<int>(i)});
  }
  // The last joint's first: it is in the way most often.
  for (auto at = links.rbegin(); at != links.rend(); ++at) {
    BatchScene::Tree tree;
    tree.joint = at->first[0];
    tree.part = at->first[1];
    tree.first = static_cast<int>(scene.nodes.size());
    add_nodes(std::move(at->second), tree, scene);
    tree.last = static_cast<int>(scene.nodes.size());
    scene.trees.push_back(std::move(tree));
  }
}

}  // namespace

BatchScene make_batch_robot(const robot::KinematicChain& chain, const RobotSpheres& spheres) {
  BatchScene scene;
  // A joint's own frame, turned so that its axis is z.
  const std::vector<Eigen::Quaterniond> turned = turned_frames(chain);
  for (std::size_t i = 0; i < turned.size(); ++i) {
    const robot::ChainJoint& joint = chain.joints()[i];
    Eigen::Matrix3d R = joint.X_PJ.linear() * turned[i].toRotationMatrix();
    Vector3d t = joint.X_PJ.translation();
    if (i > 0) {
      const Eigen::Matrix3d back = turned[i - 1].conjugate().toRotationMatrix();
      R = back * R;
      t = back * t;
    }
    scene.joints.push_back({rows(R), floats(t), joint.is_revolute});
  }
  add_trees(chain, spheres, 0, false, scene);
  add_pairs(spheres, 0, scene);
  return scene;
}

void hold_in_batch(const robot::KinematicChain& chain, const RobotSpheres& spheres,
                   std::size_t own_pairs, BatchScene& scene) {
  add_trees(chain, spheres, scene.ball_tree.size(), true, scene);
  add_pairs(spheres, own_pairs, scene);
}

void place_in_batch(const robot::KinematicChain& chain, const CollisionWorld& world, double margin,
                    BatchScene& scene) {
  scene.obstacles.clear();
  scene.faces.clear();
  for (BatchScene::Tree& tree : scene.trees) tree.obstacles.clear();
  for (const CollisionWorld::Obstacle& from : world.obstacles()) {
    scene.obstacles.push_back(make_obstacle(from, margin, scene));
  }
  find_candidates(reach_of(chain), world, scene);
}

}  // namespace prehend::motion
