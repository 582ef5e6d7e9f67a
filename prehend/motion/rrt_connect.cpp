#include "prehend/motion/rrt_connect.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>
#include <random>
#include <stdexcept>
#include <utility>

#include <Eigen/Cholesky>

#include "prehend/geometry/symmetric_solve.h"
#include "prehend/motion/batch_scene.h"
#include "prehend/motion/nearest_kernel.h"
#include "prehend/motion/plan_path.h"

namespace prehend::motion {
namespace {

using robot::Positions;

constexpr double kLargestJump = 0.3;   // rad or m, of a joint on a straight step
constexpr double kLargestMiss = 1e-4;  // m and rad
constexpr double kTurnStep = 0.05;     // rad
constexpr int kProjectionSteps = 10;
constexpr double kDomain = 5;  // steps

/// A tree of positions that are joined by free lines.
struct Tree {
  std::vector<Positions> nodes;
  std::vector<int> parents;
  std::vector<bool> is_stopped;  // whether something was in the way from there
  std::vector<float> blocks;     // as nearest_point() takes them
  std::size_t roots = 0;

  int add(const Positions& q, int parent) {
    const auto joints = static_cast<std::size_t>(q.size());
    const std::size_t lane = nodes.size() % std::size_t{kBatch};
    // What is not there is far.
    if (lane == 0) blocks.resize(blocks.size() + joints * kBatch, kFar);
    float* block = blocks.data() + blocks.size() - joints * kBatch;
    for (std::size_t j = 0; j < joints; ++j) {
      block[j * kBatch + lane] = static_cast<float>(q[static_cast<Eigen::Index>(j)]);
    }
    nodes.push_back(q);
    parents.push_back(parent);
    is_stopped.push_back(false);
    roots += parent < 0 ? 1 : 0;
    return static_cast<int>(nodes.size()) - 1;
  }
  int nearest(const Positions& q) const {
    std::array<float, robot::kMostChainJoints> at;
    for (Eigen::Index j = 0; j < q.size(); ++j) {
      at[static_cast<std::size_t>(j)] = static_cast<float>(q[j]);
    }
    return static_cast<int>(
        nearest_point(blocks.data(), nodes.size(), at.data(), static_cast<std::size_t>(q.size())));
  }
  std::vector<Positions> way_from_root(int node) const {
    std::vector<Positions> way;
    for (; node >= 0; node = parents[static_cast<std::size_t>(node)]) {
      way.push_back(nodes[static_cast<std::size_t>(node)]);
    }
    std::reverse(way.begin(), way.end());
    return way;
  }

 private:
  static constexpr float kFar = 1e15f;
};

class Search {
 public:
  Search(const FreeSpace& space, const PathOptions& options)
      : space_(space), options_(options), random_(options.seed) {}

  /// One step from the nearest node towards a random position; the new node, -1 when there is none.
  /// A node from which something was in the way does not go towards what is far: the way there is
  /// seldom free.
  int grow(Tree& tree) {
    const Positions target = sample();
    const auto at = static_cast<std::size_t>(tree.nearest(target));
    if (tree.is_stopped[at] && (target - tree.nodes[at]).norm() > kDomain * options_.step) {
      return -1;
    }
    bool reached = false;
    const int node = grow(tree, static_cast<int>(at), target, 1, reached);
    if (node < 0) tree.is_stopped[at] = true;
    return node;
  }

  /// Grows from the node nearest to `target` to it, step by step; the last node, -1 when there was
  /// no step at all. `reached`: it is the target.
  int connect(Tree& tree, const Positions& target, bool& reached) {
    return grow(tree, tree.nearest(target), target, std::numeric_limits<int>::max(), reached);
  }

 private:
  int grow(Tree& tree, int at, const Positions& target, int steps, bool& reached) {
    int last = -1;
    reached = false;
    for (int step = 0; step < steps; ++step) {
      const Positions from = tree.nodes[static_cast<std::size_t>(at)];
      const double distance = (target - from).norm();
      if (distance < 1e-12) {
        reached = true;
        return at;
      }
      reached = distance <= options_.step;
      const Positions next =
          reached ? target : Positions(from + (options_.step / distance) * (target - from));
      if (!space_.is_swept_free(from, next)) {
        reached = false;
        return last;
      }
      at = last = tree.add(next, at);
      if (reached) return last;
    }
    return last;
  }

  Positions sample() {
    Positions q(space_.size());
    for (int i = 0; i < space_.size(); ++i) {
      const double lower = space_.lower(i), upper = space_.upper(i);
      const double low = std::isfinite(lower) ? lower : -std::numbers::pi;
      const double high = std::isfinite(upper) ? upper : std::numbers::pi;
      q[i] = low + (high - low) * uniform();
    }
    return q;
  }
  double uniform() { return static_cast<double>(random_() >> 11) * 0x1.0p-53; }

  const FreeSpace& space_;
  const PathOptions& options_;
  std::mt19937_64 random_;
};

}  // namespace

std::string RrtConnect::about() const {
  return "RRT-Connect (Kuffner and LaValle, ICRA 2000) from the start and from all goals";
}

JointPath RrtConnect::plan(const FreeSpace& space, const Eigen::Ref<const Eigen::VectorXd>& start,
                           const std::vector<Positions>& goals, const PathOptions& options) const {
  JointPath path;
  Tree from_start, from_goals;
  for (const Positions& goal : goals) from_goals.add(goal, -1);
  const Positions first = start;
  from_start.add(first, -1);
  Search tree_search(space, options);
  const auto finish = [&](std::vector<Positions> way, const Positions& reached) {
    for (std::size_t g = 0; g < goals.size(); ++g) {
      if (goals[g] == reached) path.goal = static_cast<int>(g);
    }
    path.waypoints = std::move(way);
    return std::move(path);
  };
  const Positions& nearest_goal =
      from_goals.nodes[static_cast<std::size_t>(from_goals.nearest(first))];
  if (space.is_swept_free(first, nearest_goal)) {
    return finish({first, nearest_goal}, nearest_goal);
  }
  const auto begin = std::chrono::steady_clock::now();
  Tree* grown = &from_start;
  Tree* other = &from_goals;
  for (; path.iterations < options.iterations; ++path.iterations) {
    if (options.budget > 0 &&
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count() >
            options.budget) {
      break;
    }
    bool reached = false;
    const int node = tree_search.grow(*grown);
    if (node >= 0) {
      const Positions target = grown->nodes[static_cast<std::size_t>(node)];
      const int met = tree_search.connect(*other, target, reached);
      if (reached) {
        std::vector<Positions> way = grown->way_from_root(node);
        std::vector<Positions> rest = other->way_from_root(met);
        const bool swapped = grown == &from_goals;
        if (swapped) std::swap(way, rest);
        const Positions goal = rest.front();
        std::reverse(rest.begin(), rest.end());
        way.insert(way.end(), rest.begin() + 1, rest.end());
        return finish(std::move(way), goal);
      }
    }
    // The one that has grown less is next.
    if (grown->nodes.size() - grown->roots > other->nodes.size() - other->roots) {
      std::swap(grown, other);
    }
  }
  char text[160];
  std::snprintf(text, sizeof text, "no path was found with %d samples (%zu and %zu positions)",
                path.iterations, from_start.nodes.size(), from_goals.nodes.size());
  path.reason = text;
  return path;
}

JointPath plan_path(const FreeSpace& space, const Eigen::Ref<const Eigen::VectorXd>& start,
                    const std::vector<Positions>& goals, const PathOptions& options) {
  return plan_path(RrtConnect(), space, start, goals, options);
}

JointPath straight_path(const RobotInWorld& robot, const Eigen::Ref<const Eigen::VectorXd>& start,
                        const geometry::RigidTransform& X_BT, double step) {
  check_positions(robot, start, "straight_path: the start");
  if (!(step > 0) || !X_BT.matrix().allFinite()) {
    throw std::invalid_argument("straight_path: step must be positive and the pose finite");
  }
  const robot::KinematicChain& chain = robot.chain();
  JointPath path;
  if (std::string problem = robot.problem(start); !problem.empty()) {
    path.reason = "at the start, " + problem;
    return path;
  }
  const geometry::RigidTransform X_from = chain.forward(start);
  const Eigen::Quaterniond q_from(X_from.linear()), q_to(X_BT.linear());
  const Eigen::Vector3d way = X_BT.translation() - X_from.translation();
  const int steps = std::max(1, static_cast<int>(std::ceil(std::max(
                                    way.norm() / step, q_from.angularDistance(q_to) / kTurnStep))));
  Positions q = start;
  std::vector<Positions> waypoints{q};
  for (int i = 1; i <= steps; ++i) {
    const double part = static_cast<double>(i) / steps;
    const geometry::RigidTransform target =
        geometry::make_transform(q_from.slerp(part, q_to), X_from.translation() + part * way);
    const Positions before = q;
    Eigen::Matrix<double, 6, 1> error;
    const auto miss = [&] {
      const geometry::RigidTransform X = chain.forward(q);
      const Eigen::AngleAxisd turn(Eigen::Matrix3d(target.linear() * X.linear().transpose()));
      error << target.translation() - X.translation(), turn.angle() * turn.axis();
      return std::max(error.head<3>().norm(), error.tail<3>().norm());
    };
    for (int k = 0; k < kProjectionSteps && miss() > 1e-9; ++k) {
      const auto J = chain.jacobian(q);
      const Eigen::Matrix<double, 6, 6> normal =
          J * J.transpose() + 1e-10 * Eigen::Matrix<double, 6, 6>::Identity();
      q += J.transpose() * geometry::symmetric_solve<6>(normal, error);
    }
    std::string problem;
    if (miss() > kLargestMiss) {
      problem = "the arm cannot follow";
    } else if ((q - before).cwiseAbs().maxCoeff() > kLargestJump) {
      problem = "a joint would jump";
    } else if (problem = robot.problem(q); problem.empty() && !robot.is_swept_free(before, q)) {
      problem = "something is touched";
    }
    if (!problem.empty()) {
      char text[80];
      std::snprintf(text, sizeof text, "after %.0f of %.0f mm, ", 1e3 * (part * way.norm()),
                    1e3 * way.norm());
      path.reason = text + problem;
      return path;
    }
    path.completed = part;
    waypoints.push_back(q);
  }
  path.waypoints = std::move(waypoints);
  path.goal = 0;
  return path;
}

}  // namespace prehend::motion
