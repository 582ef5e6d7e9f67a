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
#include "prehend/motion/nearest_kernel.h"

namespace prehend::motion {
namespace {

using robot::Positions;

constexpr double kLargestJump = 0.3;   // rad or m, of a joint on a straight step
constexpr double kLargestMiss = 1e-4;  // m and rad
constexpr double kTurnStep = 0.05;     // rad
constexpr int kProjectionSteps = 10;
constexpr int kRefinements = 4;  // of the resolution, by halves
constexpr int kCornerHalvings = 5;
constexpr double kLeastGain = 0.01;  // of the length, by a round of corners

void check(const RrtOptions& options) {
  const auto require = [](bool condition, const char* what) {
    if (!condition) throw std::invalid_argument(std::string("RrtOptions.") + what);
  };
  require(options.step > 0 && std::isfinite(options.step), "step must be > 0");
  require(options.resolution > 0 && std::isfinite(options.resolution), "resolution must be > 0");
  require(options.iterations >= 1, "iterations must be >= 1");
  require(options.budget >= 0, "budget must be >= 0");
  require(options.shortcuts >= 0, "shortcuts must be >= 0");
}

void check(const RobotInWorld& robot, const Eigen::Ref<const Eigen::VectorXd>& q,
           const char* what) {
  if (q.size() != robot.chain().size() || !q.allFinite()) {
    throw std::invalid_argument(std::string(what) + " needs " +
                                std::to_string(robot.chain().size()) + " finite positions");
  }
}

/// A tree of positions that are joined by free lines.
struct Tree {
  std::vector<Positions> nodes;
  std::vector<int> parents;
  std::vector<float> blocks;  // as nearest_point() takes them

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
  Search(const RobotInWorld& robot, const RrtOptions& options)
      : robot_(robot), options_(options), random_(options.seed) {}

  /// Grows from the node nearest to `target` to it, step by step ("connect"); the last node, -1
  /// when there was no step at all. `reached`: it is the target.
  int grow(Tree& tree, const Positions& target, int steps, bool& reached) {
    int at = tree.nearest(target);
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
      if (!robot_.is_free_between(from, next, options_.resolution)) {
        reached = false;
        return last;
      }
      at = last = tree.add(next, at);
      if (reached) return last;
    }
    return last;
  }

  Positions sample() {
    Positions q(robot_.chain().size());
    for (int i = 0; i < robot_.chain().size(); ++i) {
      const robot::ChainJoint& joint = robot_.chain().joints()[static_cast<std::size_t>(i)];
      const double low = std::isfinite(joint.lower) ? joint.lower : -std::numbers::pi;
      const double high = std::isfinite(joint.upper) ? joint.upper : std::numbers::pi;
      q[i] = low + (high - low) * uniform();
    }
    return q;
  }

  /// Goes straight from each waypoint to the farthest of those half, a quarter, ... of the rest
  /// ahead that it may; whether the whole way is swept free then. What is not replaced by a
  /// shortcut is tested here.
  bool drop_waypoints(std::vector<Positions>& way) {
    std::vector<Positions> kept{way.front()};
    bool swept_free = true;
    for (std::size_t i = 0; i + 1 < way.size();) {
      std::size_t ahead = way.size() - 1 - i;
      while (ahead > 1 && !is_shortcut(way[i], way[i + ahead])) ahead /= 2;
      if (ahead == 1) swept_free = swept_free && robot_.is_swept_free(way[i], way[i + 1]);
      i += ahead;
      kept.push_back(way[i]);
    }
    way = std::move(kept);
    return swept_free;
  }

  /// Cuts corners until a round gains little: each as widely as is free of whole, half, a quarter,
  /// ... of the pieces beside it.
  void cut_corners(std::vector<Positions>& way) {
    for (double before = length_of(way); tries_ < options_.shortcuts;) {
      for (std::size_t corner = 1; corner + 1 < way.size(); ++corner) {
        const Positions in = way[corner - 1] - way[corner], out = way[corner + 1] - way[corner];
        double share = 1;
        for (int k = 0; k < kCornerHalvings; ++k, share /= 2) {
          const Positions a = way[corner] + share * in, b = way[corner] + share * out;
          if (!is_shortcut(a, b)) continue;
          const auto at = way.begin() + static_cast<std::ptrdiff_t>(corner);
          if (share == 1) {
            way.erase(at);
            --corner;
          } else {
            *at = a;
            way.insert(at + 1, b);
            ++corner;
          }
          break;
        }
      }
      const double after = length_of(way);
      if (!(after < (1 - kLeastGain) * before)) return;
      before = after;
    }
  }

  static double length_of(const std::vector<Positions>& way) {
    double length = 0;
    for (std::size_t i = 1; i < way.size(); ++i) length += (way[i] - way[i - 1]).norm();
    return length;
  }

 private:
  double uniform() { return static_cast<double>(random_() >> 11) * 0x1.0p-53; }

  /// Whether a straight line is free, as long as there are tries left.
  bool is_shortcut(const Positions& from, const Positions& to) {
    if (tries_ >= options_.shortcuts) return false;
    ++tries_;
    // Coarsely first: many are not free.
    return robot_.is_free_between(from, to, options_.resolution) && robot_.is_swept_free(from, to);
  }

  const RobotInWorld& robot_;
  const RrtOptions& options_;
  std::mt19937_64 random_;
  int tries_ = 0;  // of shortcuts
};

}  // namespace

double JointPath::length() const { return Search::length_of(waypoints); }

namespace {

/// plan_path() at one resolution. `swept_free`: so is the path, which is shortened only then.
JointPath search(const RobotInWorld& robot, const Eigen::Ref<const Eigen::VectorXd>& start,
                 const std::vector<Positions>& goals, const RrtOptions& options, bool& swept_free) {
  JointPath path;
  if (goals.empty()) {
    path.reason = "there are no goals";
    return path;
  }
  if (std::string problem = robot.problem(start); !problem.empty()) {
    path.reason = "at the start, " + problem;
    return path;
  }
  Tree from_start, from_goals;
  std::vector<int> goal_of;  // root of from_goals -> goal
  std::string goal_problem;
  for (std::size_t first = 0; first < goals.size(); first += kBatch) {
    const auto count = static_cast<int>(std::min<std::size_t>(kBatch, goals.size() - first));
    const std::uint32_t not_free = robot.not_free(&goals[first], count);
    for (int i = 0; i < count; ++i) {
      const std::size_t g = first + static_cast<std::size_t>(i);
      if ((not_free >> i) & 1u) {
        // Within single precision of touching it may be free after all: as touching as need be.
        goal_problem = robot.problem(goals[g]);
        if (!goal_problem.empty()) continue;
      }
      from_goals.add(goals[g], -1);
      goal_of.push_back(static_cast<int>(g));
    }
  }
  if (from_goals.nodes.empty()) {
    path.reason =
        (goals.size() == 1 ? "at the goal, " : "at every goal; at the last, ") + goal_problem;
    return path;
  }
  const Positions first = start;
  from_start.add(first, -1);
  Search tree_search(robot, options);
  const auto finish = [&](std::vector<Positions> way, const Positions& reached) {
    for (std::size_t r = 0; r < goal_of.size(); ++r) {
      if (from_goals.nodes[r] == reached) path.goal = goal_of[r];
    }
    swept_free = tree_search.drop_waypoints(way);
    if (swept_free) tree_search.cut_corners(way);
    path.waypoints = std::move(way);
    return std::move(path);
  };
  const Positions& nearest_goal =
      from_goals.nodes[static_cast<std::size_t>(from_goals.nearest(first))];
  if (robot.is_free_between(first, nearest_goal, options.resolution)) {
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
    const int node = tree_search.grow(*grown, tree_search.sample(), 1, reached);
    if (node >= 0) {
      const Positions target = grown->nodes[static_cast<std::size_t>(node)];
      const int met = tree_search.grow(*other, target, std::numeric_limits<int>::max(), reached);
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
    std::swap(grown, other);
  }
  char text[160];
  std::snprintf(text, sizeof text, "no path was found with %d samples (%zu and %zu positions)",
                path.iterations, from_start.nodes.size(), from_goals.nodes.size());
  path.reason = text;
  return path;
}

}  // namespace

JointPath plan_path(const RobotInWorld& robot, const Eigen::Ref<const Eigen::VectorXd>& start,
                    const std::vector<Positions>& goals, const RrtOptions& options) {
  check(options);
  check(robot, start, "plan_path: the start");
  for (const Positions& goal : goals) check(robot, goal, "plan_path: a goal");
  const auto begin = std::chrono::steady_clock::now();
  RrtOptions finer = options;
  JointPath path;
  for (int k = 0; k <= kRefinements; ++k, finer.resolution /= 2) {
    if (options.budget > 0) {
      const std::chrono::duration<double> used = std::chrono::steady_clock::now() - begin;
      finer.budget = std::max(1e-9, options.budget - used.count());
    }
    bool swept_free = true;
    path = search(robot, start, goals, finer, swept_free);
    if (!path.found() || swept_free) return path;
  }
  path.waypoints.clear();
  path.goal = -1;
  path.reason = "every path that was found touches something between tested positions";
  return path;
}

JointPath straight_path(const RobotInWorld& robot, const Eigen::Ref<const Eigen::VectorXd>& start,
                        const geometry::RigidTransform& X_BT, double step) {
  check(robot, start, "straight_path: the start");
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
