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
  static constexpr int kCandidates = 4;     // tested in one go
  static constexpr float kNowhere = 1e15f;  // m: its square is a number still

  struct Joint {
    std::array<float, 9> R{};  // to the frame before, by rows
    std::array<float, 3> t{};
    bool is_revolute = true;
  };
  struct Ball {
    float x = 0, y = 0, z = 0, radius = 0;
  };
  /// An obstacle (not a plane) that a group's bound may reach, in any position. `far`: the sum of
  /// radii and margin.
  struct Candidate {
    float x = kNowhere, y = 0, z = 0, far = 0;
    int obstacle = -1;  // none: fills up
  };
  /// Balls [first, last) of one joint and part, and one that holds them all.
  struct Group {
    int joint = -1;  // -1: stands with the base, never tested against the world
    int part = 0;
    int first = 0, last = 0;
    Ball bound;
    int first_candidate = 0, last_candidate = 0;  // a multiple of kCandidates
  };
  /// Pairs [first, last) of balls of two groups that must not touch each other.
  struct GroupPair {
    int a = 0, b = 0;
    int first = 0, last = 0;
  };
  struct BallPair {
    int a = 0, b = 0;
    float reach = 0;  // sum of radii
  };
  struct Obstacle {
    enum class Kind { kPlane, kBox, kSphere, kConvex };
    Kind kind = Kind::kSphere;
    Ball bound;                     // not of planes
    std::array<float, 3> margin{};  // for each Part
    std::array<float, 9> R{};       // box: from the base frame, by rows
    std::array<float, 3> t{}, half{};
    int first = 0, last = 0;  // faces of a plane (one) or convex piece
  };
  struct Face {
    float x = 0, y = 0, z = 0, offset = 0;
  };

  std::vector<Joint> joints;
  std::vector<Ball> balls;  // in the frame after their group's joint
  std::vector<Group> groups;
  std::vector<GroupPair> group_pairs;
  std::vector<BallPair> ball_pairs;
  std::vector<Candidate> candidates;
  std::vector<Obstacle> obstacles;
  std::vector<int> planes;  // of the obstacles
  std::vector<Face> faces;
};

/// @param own how many of the spheres are the robot's; the others are held.
BatchScene make_batch_scene(const robot::KinematicChain& chain, const RobotSpheres& spheres,
                            std::size_t own, const CollisionWorld& world, double margin);

}  // namespace prehend::motion
