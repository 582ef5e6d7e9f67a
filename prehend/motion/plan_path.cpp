#include "prehend/motion/plan_path.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "prehend/motion/batch_scene.h"

namespace prehend::motion {
namespace {

using robot::Positions;

constexpr int kRefinements = 4;  // of the resolution, by halves
constexpr int kCornerHalvings = 5;
constexpr double kLeastGain = 0.03;  // of the length, by a round of corners
constexpr double kSame = 1e-9;       // rad or m

void check(const PathOptions& options) {
  const auto require = [](bool condition, const char* what) {
    if (!condition) throw std::invalid_argument(std::string("PathOptions.") + what);
  };
  require(options.step > 0 && std::isfinite(options.step), "step must be > 0");
  require(options.resolution > 0 && std::isfinite(options.resolution), "resolution must be > 0");
  require(options.iterations >= 1, "iterations must be >= 1");
  require(options.budget >= 0, "budget must be >= 0");
  require(options.shortcuts >= 0, "shortcuts must be >= 0");
}

double length_of(const std::vector<Positions>& way) {
  double length = 0;
  for (std::size_t i = 1; i < way.size(); ++i) length += (way[i] - way[i - 1]).norm();
  return length;
}

/// Shortens a way by pieces that are swept free.
class Shortener {
 public:
  Shortener(const FreeSpace& space, const PathOptions& options)
      : space_(space), options_(options) {}

  /// Goes straight from each waypoint to the farthest of those half, a quarter, ... of the rest
  /// ahead that it may; whether the whole way is swept free then. What is not replaced by a
  /// shortcut is tested here.
  bool drop_waypoints(std::vector<Positions>& way) {
    std::vector<Positions> kept{way.front()};
    bool swept_free = true;
    for (std::size_t i = 0; i + 1 < way.size();) {
      std::size_t ahead = way.size() - 1 - i;
      while (ahead > 1 && !is_shortcut(way[i], way[i + ahead])) ahead /= 2;
      if (ahead == 1) swept_free = swept_free && space_.is_swept_free(way[i], way[i + 1]);
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

 private:
  /// Whether a straight line is free, as long as there are tries left.
  bool is_shortcut(const Positions& from, const Positions& to) {
    if (tries_ >= options_.shortcuts) return false;
    ++tries_;
    return space_.is_swept_free(from, to);
  }

  const FreeSpace& space_;
  const PathOptions& options_;
  int tries_ = 0;  // of shortcuts
};

/// The goals that are free.
struct FreeGoals {
  std::vector<Positions> goals;
  std::vector<int> index;  // of each, among all
  std::string problem;     // of the last that is not
};

FreeGoals free_goals(const FreeSpace& space, const std::vector<Positions>& goals) {
  FreeGoals result;
  for (std::size_t first = 0; first < goals.size(); first += kBatch) {
    const auto count = static_cast<int>(std::min<std::size_t>(kBatch, goals.size() - first));
    const std::uint32_t not_free = space.not_free(&goals[first], count);
    for (int i = 0; i < count; ++i) {
      const std::size_t g = first + static_cast<std::size_t>(i);
      if ((not_free >> i) & 1u) {
        // Within single precision of touching it may be free after all: as touching as need be.
        result.problem = space.problem(goals[g]);
        if (!result.problem.empty()) continue;
      }
      result.goals.push_back(goals[g]);
      result.index.push_back(static_cast<int>(g));
    }
  }
  return result;
}

/// Whether a path goes from the start to the goal that it names.
bool joins(const JointPath& path, const Eigen::Ref<const Eigen::VectorXd>& start,
           const std::vector<Positions>& goals) {
  if (path.goal < 0 || path.goal >= static_cast<int>(goals.size())) return false;
  for (const Positions& waypoint : path.waypoints) {
    if (waypoint.size() != start.size() || !waypoint.allFinite()) return false;
  }
  return (path.waypoints.front() - start).norm() < kSame &&
         (path.waypoints.back() - goals[static_cast<std::size_t>(path.goal)]).norm() < kSame;
}

}  // namespace

void check_positions(const FreeSpace& space, const Eigen::Ref<const Eigen::VectorXd>& q,
                     const char* what) {
  if (q.size() != space.size() || !q.allFinite()) {
    throw std::invalid_argument(std::string(what) + " needs " + std::to_string(space.size()) +
                                " finite positions");
  }
}

JointPath plan_path(const PathPlanner& planner, const FreeSpace& space,
                    const Eigen::Ref<const Eigen::VectorXd>& start,
                    const std::vector<Positions>& goals, const PathOptions& options) {
  check(options);
  check_positions(space, start, "plan_path: the start");
  for (const Positions& goal : goals) check_positions(space, goal, "plan_path: a goal");
  const auto begin = std::chrono::steady_clock::now();
  JointPath path;
  const auto failed = [&path](std::string reason) {
    path.waypoints.clear();
    path.goal = -1;
    path.reason = std::move(reason);
    return std::move(path);
  };
  if (goals.empty()) return failed("there are no goals");
  if (const FreeGoals at_start = free_goals(space, {start}); at_start.goals.empty()) {
    return failed("at the start, " + at_start.problem);
  }
  const FreeGoals free = free_goals(space, goals);
  if (free.goals.empty()) {
    return failed((goals.size() == 1 ? "at the goal, " : "at every goal; at the last, ") +
                  free.problem);
  }
  PathOptions finer = options;
  for (int k = 0; k <= kRefinements; ++k, finer.resolution /= 2) {
    if (options.budget > 0) {
      const std::chrono::duration<double> used = std::chrono::steady_clock::now() - begin;
      finer.budget = std::max(1e-9, options.budget - used.count());
    }
    path = planner.plan(space, start, free.goals, finer);
    if (!path.found()) return path;
    if (!joins(path, start, free.goals)) {
      return failed("the planner '" + planner.name() +
                    "' gave a path that does not join the start to a goal");
    }
    path.goal = free.index[static_cast<std::size_t>(path.goal)];
    Shortener shortener(space, finer);
    if (shortener.drop_waypoints(path.waypoints)) {
      shortener.cut_corners(path.waypoints);
      return path;
    }
  }
  return failed("every path that was found touches something between tested positions");
}

}  // namespace prehend::motion
