#pragma once

#include <array>
#include <vector>

namespace prehend::motion {

class CollisionWorld;
struct RobotSpheres;

}  // namespace prehend::motion

namespace prehend::robot {

class KinematicChain;

}  // namespace prehend::robot

namespace prehend::motion {

/// Positions that are tested at once.
constexpr int kBatch = 8;

/// A robot and its world laid out for touching_lanes(): single precision, metres, base frame.
/// Frames of joints are turned so that each joint's axis is z. Distances that count as touching are
/// 1 um larger than the world's, more than single precision loses.
struct BatchScene {
  struct Joint {
    std::array<float, 9> R{};  // to the frame before, by rows
    std::array<float, 3> t{};
    bool is_revolute = true;
  };
  struct Ball {
    float x = 0, y = 0, z = 0, radius = 0;
  };
  /// A ball of the robot, or one that holds all balls of the nodes after it and before `next`: what
  /// is far from that is far from them.
  struct Node {
    Ball ball;
    float spread = 0;  // m, of the centres of its balls from its own, at most
    int next = 0;
    int leaf = -1;  // a ball: how many there are before it in the tree; -1: others follow
  };
  /// Nodes [first, last) of one link; the first holds all.
  struct Tree {
    int joint = -1;  // -1: stands with the base, never tested against the world
    int part = 0;
    int first = 0, last = 0;
    int leaves = 0;
    std::vector<int> obstacles;  // that it may reach in any position
  };
  /// Two trees whose balls must not touch each other.
  struct TreePair {
    int a = 0, b = 0;  // the joint of b is that of a or after it
    /// Whether a ball of `a` (row) must not touch one of `b`; empty: none may.
    std::vector<bool> must_not;
  };
  struct Obstacle {
    enum class Kind { kPlane, kBox, kSphere, kConvex };
    Kind kind = Kind::kSphere;
    Ball ball;                              // kSphere
    std::array<float, 3> center{}, half{};  // of a box round all of it, along the base's axes
    std::array<float, 3> margin{};          // for each Part
    std::array<float, 9> R{};               // box: from the base frame, by rows
    std::array<float, 3> t{}, sides{};      // box: and its half sides
    int first = 0, last = 0;                // faces of a plane (one) or convex piece
  };
  struct Face {
    float x = 0, y = 0, z = 0, offset = 0;
  };

  std::vector<Joint> joints;
  std::vector<Node> nodes;  // in the frame after their tree's joint
  std::vector<Tree> trees;
  std::vector<TreePair> tree_pairs;
  std::vector<Obstacle> obstacles;
  std::vector<Face> faces;
  std::vector<int> ball_tree, ball_leaf;  // of each sphere: its tree, its place in that
};

/// The robot alone, which is what takes time: balls round its balls are drawn.
BatchScene make_batch_robot(const robot::KinematicChain& chain, const RobotSpheres& spheres);

/// Adds what the robot holds to what make_batch_robot() made of it: the spheres that came after
/// its own, and the pairs after `own_pairs`.
void hold_in_batch(const robot::KinematicChain& chain, const RobotSpheres& spheres,
                   std::size_t own_pairs, BatchScene& scene);

/// Puts the world's obstacles in the place of those that are there.
void place_in_batch(const robot::KinematicChain& chain, const CollisionWorld& world, double margin,
                    BatchScene& scene);

}  // namespace prehend::motion
