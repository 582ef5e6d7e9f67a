#include "prehend/motion/kept_apart.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <mutex>
#include <numbers>
#include <set>

#include "prehend/motion/robot_spheres.h"

namespace prehend::motion {
namespace {

using Eigen::Vector3d;
using robot::ChainJoint;

constexpr double kTurn = 2 * std::numbers::pi;  // rad
constexpr double kRounding = 1e-9;              // m
constexpr std::size_t kMostKept = 4096;         // pairs of links

int most_boxes(std::size_t joints) { return joints <= 3 ? 1000 : 10; }

/// Positions of the joints between two balls.
struct Box {
  std::array<double, robot::kMostChainJoints> lower{}, upper{};
};

/// Distance of `from` from where `p` comes to as it turns or slides by `lower` to `upper`.
double distance_from_way(const ChainJoint& joint, const Vector3d& p, double lower, double upper,
                         const Vector3d& from) {
  const Vector3d& axis = joint.axis_J;
  if (!joint.is_revolute) {
    return (p + std::clamp(axis.dot(from - p), lower, upper) * axis - from).norm();
  }
  const Vector3d out = p - axis.dot(p) * axis, to = from - axis.dot(from) * axis;
  // The turn that brings it nearest, the first one from `lower` on and the one before.
  const double nearest = std::atan2(axis.dot(out.cross(to)), out.dot(to));
  const double ahead = nearest + kTurn * std::ceil((lower - nearest) / kTurn);
  const double off =
      ahead <= upper ? 0 : std::max(0.0, std::min(ahead - upper, lower - (ahead - kTurn)));
  const double across2 =
      out.squaredNorm() + to.squaredNorm() - 2 * out.norm() * to.norm() * std::cos(off);
  const double height = axis.dot(from - p);
  return std::sqrt(std::max(0.0, across2) + height * height);
}

struct Look {
  double at_least = 0;     // m, how near the centres come to each other within the box
  double in_middle = 0;    // m, how near at the middles of all joints but the first
  std::size_t widest = 0;  // the joint that moves the ball most; 0: none but the first
};

/// Of a ball at `a` before `count` joints and one at `p` after them.
Look look_at(const ChainJoint* joints, std::size_t count, const Box& box, const Vector3d& a,
             Vector3d p) {
  Look look;
  double moved = 0, most = 0;
  for (std::size_t k = count - 1; k > 0; --k) {
    const ChainJoint& joint = joints[k];
    const double middle = (box.lower[k] + box.upper[k]) / 2;
    const double half = (box.upper[k] - box.lower[k]) / 2;
    double way = half;
    if (joint.is_revolute) {
      const double lever = joint.axis_J.cross(p).norm() + moved;
      way = 2 * std::sin(std::min(half, std::numbers::pi) / 2) * lever;
      p = Eigen::AngleAxisd(middle, joint.axis_J) * p;
    } else {
      p += middle * joint.axis_J;
    }
    p = joint.X_PJ * p;
    moved += way;
    if (way > most) {
      most = way;
      look.widest = k;
    }
  }
  look.in_middle =
      distance_from_way(joints[0], p, box.lower[0], box.upper[0], joints[0].X_PJ.inverse() * a);
  look.at_least = look.in_middle - moved;
  return look;
}

using Balls = std::vector<int>;  // of all
using Pairs = std::vector<std::pair<int, int>>;

/// Looks for balls of two links that are kept apart.
class LinkPairSearch {
 public:
  LinkPairSearch(const robot::KinematicChain& chain, const std::vector<RobotSphere>& spheres)
      : chain_(chain), spheres_(spheres) {}

  /// As places in `a` and in `b`.
  Pairs find(const Balls& a, const Balls& b) {
    apart_.clear();
    a_ = &a;
    b_ = &b;
    look(places(a), places(b));
    return std::move(apart_);
  }

 private:
  static Balls places(const Balls& balls) {
    Balls result;
    for (std::size_t i = 0; i < balls.size(); ++i) result.push_back(static_cast<int>(i));
    return result;
  }
  const RobotSphere& at(const Balls& link, int place) const {
    return spheres_[static_cast<std::size_t>(link[static_cast<std::size_t>(place)])];
  }
  RobotSphere round(const Balls& link, const Balls& balls) const {
    RobotSphere all = at(link, balls.front());
    if (balls.size() == 1) return all;
    Eigen::AlignedBox3d box;
    for (const int i : balls) box.extend(at(link, i).p_J);
    all.p_J = box.center();
    all.radius = 0;
    for (const int i : balls) {
      const RobotSphere& ball = at(link, i);
      all.radius = std::max(all.radius, (ball.p_J - all.p_J).norm() + ball.radius);
    }
    return all;
  }
  std::pair<Balls, Balls> halves(const Balls& link, Balls balls) const {
    Eigen::AlignedBox3d box;
    for (const int i : balls) box.extend(at(link, i).p_J);
    Eigen::Index axis = 0;
    box.sizes().maxCoeff(&axis);
    std::ranges::sort(balls, [&](int one, int other) {
      return std::pair(at(link, one).p_J[axis], one) < std::pair(at(link, other).p_J[axis], other);
    });
    const auto middle = balls.begin() + static_cast<std::ptrdiff_t>(balls.size() / 2);
    return {{balls.begin(), middle}, {middle, balls.end()}};
  }
  void look(const Balls& a, const Balls& b) {
    const RobotSphere round_a = round(*a_, a), round_b = round(*b_, b);
    if (are_kept_apart(chain_, round_a, round_b)) {
      for (const int i : a) {
        for (const int j : b) apart_.emplace_back(i, j);
      }
      return;
    }
    if (a.size() == 1 && b.size() == 1) return;
    const bool splits_a = b.size() == 1 || (a.size() > 1 && round_a.radius > round_b.radius);
    const auto [first, second] = splits_a ? halves(*a_, a) : halves(*b_, b);
    look(splits_a ? first : a, splits_a ? b : first);
    look(splits_a ? second : a, splits_a ? b : second);
  }

  const robot::KinematicChain& chain_;
  const std::vector<RobotSphere>& spheres_;
  const Balls *a_ = nullptr, *b_ = nullptr;
  Pairs apart_;
};

/// All that the proofs of two links rest on.
std::vector<double> inputs_of(const robot::KinematicChain& chain,
                              const std::vector<RobotSphere>& spheres, const Balls& a,
                              const Balls& b) {
  std::vector<double> inputs;
  for (const Balls* balls : {&a, &b}) {
    inputs.push_back(static_cast<double>(balls->size()));
    for (const int i : *balls) {
      const RobotSphere& ball = spheres[static_cast<std::size_t>(i)];
      inputs.insert(inputs.end(), {static_cast<double>(ball.joint), ball.p_J.x(), ball.p_J.y(),
                                   ball.p_J.z(), ball.radius});
    }
  }
  for (const ChainJoint& joint : chain.joints()) {
    const Eigen::Matrix4d& X_PJ = joint.X_PJ.matrix();
    inputs.insert(inputs.end(), X_PJ.data(), X_PJ.data() + X_PJ.size());
    inputs.insert(inputs.end(), {joint.axis_J.x(), joint.axis_J.y(), joint.axis_J.z(), joint.lower,
                                 joint.upper, joint.is_revolute ? 1.0 : 0.0});
  }
  return inputs;
}

/// LinkPairSearch::find(), or what it gave before.
Pairs found_of(const robot::KinematicChain& chain, const std::vector<RobotSphere>& spheres,
               const Balls& a, const Balls& b) {
  static std::mutex mutex;
  static std::map<std::vector<double>, Pairs> kept;
  std::vector<double> inputs = inputs_of(chain, spheres, a, b);
  {
    const std::lock_guard lock(mutex);
    const auto known = kept.find(inputs);
    if (known != kept.end()) return known->second;
  }
  Pairs found = LinkPairSearch(chain, spheres).find(a, b);
  const std::lock_guard lock(mutex);
  if (kept.size() >= kMostKept) kept.clear();
  kept.emplace(std::move(inputs), found);
  return found;
}

}  // namespace

bool are_kept_apart(const robot::KinematicChain& chain, const RobotSphere& a,
                    const RobotSphere& b) {
  if (a.joint > b.joint) return are_kept_apart(chain, b, a);
  const auto count = static_cast<std::size_t>(b.joint - a.joint);
  if (count == 0) return false;
  const ChainJoint* joints = chain.joints().data() + (a.joint + 1);
  Box all;
  for (std::size_t k = 0; k < count; ++k) {
    all.lower[k] = joints[k].lower - kPastLimits;
    all.upper[k] = joints[k].upper + kPastLimits;
    if (joints[k].is_revolute && !(all.upper[k] - all.lower[k] < kTurn)) {
      all.lower[k] = -kTurn / 2;
      all.upper[k] = kTurn / 2;
    }
    if (!std::isfinite(all.lower[k]) || !std::isfinite(all.upper[k])) return false;
  }
  struct Open {
    Box box;
    Look look;
  };
  const double needed = a.radius + b.radius + kRounding;
  std::vector<Open> open;
  const auto may_touch = [&](const Box& box) {
    const Look look = look_at(joints, count, box, a.p_J, b.p_J);
    if (look.at_least > needed) return false;
    // Where they come nearest is looked at first: they may touch there.
    const bool nearer = open.empty() || look.at_least < open.back().look.at_least;
    open.insert(nearer ? open.end() : open.end() - 1, {box, look});
    // Also where a distance is no number.
    return !(look.in_middle > needed) || look.widest == 0;
  };
  if (may_touch(all)) return false;
  for (int boxes = most_boxes(count); !open.empty(); --boxes) {
    if (boxes == 0) return false;
    const Open one = open.back();
    open.pop_back();
    const std::size_t k = one.look.widest;
    Box low = one.box, high = one.box;
    low.upper[k] = high.lower[k] = (one.box.lower[k] + one.box.upper[k]) / 2;
    if (may_touch(low) || may_touch(high)) return false;
  }
  return true;
}

std::vector<std::pair<int, int>> kept_apart(const robot::KinematicChain& chain,
                                            const std::vector<RobotSphere>& spheres,
                                            const std::vector<std::pair<int, int>>& pairs) {
  const auto link_of = [&](int i) {
    const RobotSphere& ball = spheres[static_cast<std::size_t>(i)];
    return std::pair(ball.link, ball.joint);
  };
  using Link = std::pair<int, int>;
  std::map<std::pair<Link, Link>, std::pair<std::set<int>, std::set<int>>> links;
  for (auto [a, b] : pairs) {
    if (link_of(b) < link_of(a)) std::swap(a, b);
    auto& [first, second] = links[{link_of(a), link_of(b)}];
    first.insert(a);
    second.insert(b);
  }
  std::set<std::pair<int, int>> apart;
  for (const auto& [pair, balls] : links) {
    const Balls a(balls.first.begin(), balls.first.end()),
        b(balls.second.begin(), balls.second.end());
    for (const auto& [i, j] : found_of(chain, spheres, a, b)) {
      apart.insert(std::minmax(a[static_cast<std::size_t>(i)], b[static_cast<std::size_t>(j)]));
    }
  }
  std::vector<std::pair<int, int>> result;
  std::ranges::copy_if(pairs, std::back_inserter(result), [&](const auto& pair) {
    return apart.contains(std::minmax(pair.first, pair.second));
  });
  return result;
}

}  // namespace prehend::motion
