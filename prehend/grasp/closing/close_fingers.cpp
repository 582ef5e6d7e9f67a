#include "prehend/grasp/closing/close_fingers.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include "prehend/grasp/closing/closing_registry.h"
#include "prehend/robot/drive_ratios.h"

namespace prehend::grasp {
namespace {

using Eigen::Vector3d;
using geometry::RigidTransform;
using robot::Joint;

std::size_t at(int index) { return static_cast<std::size_t>(index); }

constexpr double kLeastApproach = 0.02;  // share of the speed that must be towards what is touched

class FingersAdvancing {
 public:
  FingersAdvancing(const HandToClose& hand, const RigidTransform& X_WH,
                   const robot::Preshape& preshape, const Eigen::VectorXd& open,
                   const TouchScene& scene, const HandClosingOptions& options)
      : hand_(*hand.hand),
        balls_(hand.balls),
        preshape_(preshape),
        scene_(scene),
        options_(options),
        drives_(hand_) {
    result_.all = hand_.all_positions(open);
    result_.finger_touches.assign(hand_.fingers.size(), false);
    result_.broken_away.assign(hand_.breakaways.size(), 0);
    rate_.assign(hand_.model.joints.size(), 0);
    for (std::size_t j = 0; j < rate_.size(); ++j) {
      if (drives_.motor[j] >= 0) {
        rate_[j] = preshape.closing[at(drives_.motor[j])].rate * drives_.ratio[j];
      }
    }
    hand_.link_poses(result_.all, poses_);
    for (RigidTransform& pose : poses_) pose = X_WH * pose;
  }

  ClosedFingers run() {
    for (const std::vector<int>& group : groups()) close(group);
    collect_contacts();
    return std::move(result_);
  }

 private:
  /// Motors that move, in groups that no link or order to stop connects.
  std::vector<std::vector<int>> groups() const {
    const int count = hand_.size();
    std::vector<int> group(at(count));
    std::iota(group.begin(), group.end(), 0);
    const auto merge = [&](int a, int b) {
      const int from = group[at(b)], to = group[at(a)];
      std::replace(group.begin(), group.end(), from, to);
    };
    for (const auto& reach : balls_.reach) {
      int first = -1;
      for (std::size_t j = 0; j < reach.size(); ++j) {
        if (reach[j] == 0 || rate_[j] == 0) continue;
        if (first >= 0) merge(first, drives_.motor[j]);
        first = drives_.motor[j];
      }
    }
    for (int i = 0; i < count; ++i) {
      if (preshape_.closing[at(i)].with >= 0) merge(preshape_.closing[at(i)].with, i);
    }
    std::vector<std::vector<int>> result;
    for (int id = 0; id < count; ++id) {
      std::vector<int> members;
      for (int i = 0; i < count; ++i) {
        if (group[at(i)] == id && preshape_.closing[at(i)].rate != 0) members.push_back(i);
      }
      if (!members.empty()) result.push_back(std::move(members));
    }
    return result;
  }

  void close(const std::vector<int>& motors) {
    const auto in_group = [&](int motor) {
      return std::find(motors.begin(), motors.end(), motor) != motors.end();
    };
    // Joints whose frames the group moves, parents first, and the links to test.
    joints_.clear();
    links_.clear();
    for (std::size_t j = 0; j < rate_.size(); ++j) {
      const int child = hand_.model.joints[j].child;
      const auto& reach = balls_.reach[at(child)];
      bool moved = false;
      for (std::size_t k = 0; k < rate_.size() && !moved; ++k) {
        const bool above = reach[k] > 0 || k == j;
        moved = above && rate_[k] != 0 && in_group(drives_.motor[k]);
      }
      if (!moved) continue;
      joints_.push_back(static_cast<int>(j));
      if (!balls_.links[at(child)].nodes.empty()) links_.push_back(child);
    }
    // Until when each link cannot have touched anything, on the group's clock: links that are far
    // are not asked again while another one creeps up to its contact.
    std::vector<double> safe(links_.size(), 0);
    std::vector<int> nearest(links_.size(), -1);  // of each link's balls, when it was last asked
    double clock = 0;
    pushing_ = -1;
    for (int step = 0; step < options_.largest_steps; ++step) {
      double time = time_to_limits();
      push_ = Vector3d::Zero();
      if (!std::isfinite(time)) return;  // nothing moves any more
      if (pushing_ >= 0) {
        push_ = -towards_object(pushing_);
        const double left = options_.farthest_push - result_.push_W.norm();
        constexpr double kPush = 1e-3;  // m at a time, as fingers push along arcs
        if (push_.norm() > 0) time = std::min(time, std::clamp(left, 0.0, kPush) / push_.norm());
        if (!(left > 1e-9)) {
          stop_motor(pushing_motor_);
          pushing_ = -1;
          continue;
        }
      }
      int touching = -1;
      NearBall touch;
      for (std::size_t i = 0; i < links_.size(); ++i) {
        const int link = links_[i];
        const double speed = speed_bound(link) + (pushing_ >= 0 ? speed_bound(pushing_) : 0);
        if (speed == 0 || link == pushing_) continue;
        if (safe[i] > clock) {
          time = std::min(time, safe[i] - clock);
          continue;
        }
        const NearBall near =
            nearest_ball(balls_.links[at(link)], poses_[at(link)], scene_, kExact, nearest[i]);
        nearest[i] = near.ball;
        if (near.clearance > options_.tolerance) {
          const double free = (near.clearance - options_.tolerance / 2) / speed;
          safe[i] = clock + free;
          time = std::min(time, free);
        } else if (approaches(link, near)) {
          if (touching < 0 || near.clearance < touch.clearance) {
            touching = link;
            touch = near;
          }
        } else {
          time = std::min(time, options_.patch_depth / speed);
        }
      }
      if (touching >= 0) {
        correct(touching, touch);
        if (!begins_to_push(touching, touch.what)) stop_above(touching, touch.what);
        std::fill(safe.begin(), safe.end(), 0.0);  // joints move otherwise now
      } else {
        move(time);
        clock += time;
        stop_at_limits();
      }
    }
  }

  double speed_bound(int link) const {
    double speed = 0;
    for (const int j : joints_) speed += std::abs(rate_[at(j)]) * balls_.reach[at(link)][at(j)];
    return speed;
  }

  /// Velocity of a point that moves with the link.
  Vector3d velocity(int link, const Vector3d& p_W) const {
    Vector3d sum = Vector3d::Zero();
    for (const int j : joints_) {
      if (rate_[at(j)] == 0 || balls_.reach[at(link)][at(j)] == 0) continue;
      const Joint& joint = hand_.model.joints[at(j)];
      const RigidTransform& X_WJ = poses_[at(joint.child)];
      const Vector3d axis = X_WJ.linear() * joint.axis_J;
      sum += rate_[at(j)] * (joint.kind == Joint::Kind::kRevolute
                                 ? Vector3d(axis.cross(p_W - X_WJ.translation()))
                                 : axis);
    }
    return sum;
  }

  Vector3d center(int link, int ball) const {
    return poses_[at(link)] * balls_.links[at(link)].centers[at(ball)];
  }

  /// The part of a link's velocity at its nearest point that goes towards the object.
  Vector3d towards_object(int link) const {
    const NearBall near = nearest_ball(balls_.links[at(link)], poses_[at(link)], scene_);
    if (near.ball < 0) return Vector3d::Zero();
    const Vector3d p_W = center(link, near.ball);
    Vector3d away = Vector3d::Zero();
    scene_.exact_distance(p_W, near.what, &away);
    const double speed = velocity(link, p_W).dot(away);
    return speed < 0 ? Vector3d(speed * away) : Vector3d::Zero();
  }

  int finger_of(int link) const {
    for (std::size_t f = 0; f < hand_.fingers.size(); ++f) {
      const auto& links = hand_.fingers[f].links;
      if (std::find(links.begin(), links.end(), link) != links.end()) return static_cast<int>(f);
    }
    return -1;
  }

  /// Whether the motor that moves a link, which touches, moves another finger, too, and pushes the
  /// object on until that one touches: jaws bring what they grasp to their middle.
  bool begins_to_push(int link, Touched what) {
    const int finger = finger_of(link);
    if (what != Touched::kObject || pushing_ >= 0 || finger < 0) return false;
    int motor = -1;
    for (const int j : joints_) {
      if (rate_[at(j)] == 0 || balls_.reach[at(link)][at(j)] == 0) continue;
      if (motor >= 0 && motor != drives_.motor[at(j)]) return false;
      motor = drives_.motor[at(j)];
    }
    const bool moves_other = std::any_of(links_.begin(), links_.end(), [&](int other) {
      if (finger_of(other) < 0 || finger_of(other) == finger) return false;
      return std::any_of(joints_.begin(), joints_.end(), [&](int j) {
        return drives_.motor[at(j)] == motor && balls_.reach[at(other)][at(j)] > 0;
      });
    });
    if (motor < 0 || !moves_other) return false;
    pushing_ = link;
    pushing_motor_ = motor;
    return true;
  }

  bool approaches(int link, const NearBall& near) const {
    const Vector3d p_W = center(link, near.ball);
    Vector3d away = Vector3d::Zero();
    scene_.exact_distance(p_W, near.what, &away);
    const Vector3d v = velocity(link, p_W) + push_;
    return v.dot(away) < -kLeastApproach * v.norm() || away.isZero();
  }

  /// Moves on (or back) to where the ball touches by its exact distance.
  void correct(int link, const NearBall& near) {
    for (int pass = 0; pass < 2; ++pass) {
      const Vector3d p_W = center(link, near.ball);
      Vector3d away = Vector3d::Zero();
      const double clearance = scene_.exact_distance(p_W, near.what, &away) -
                               balls_.links[at(link)].radii[at(near.ball)];
      const double speed = -(velocity(link, p_W) + push_).dot(away);
      // Not by more than interpolation can be wrong; a link that starts in contact stays.
      if (!(std::abs(clearance) < options_.patch_depth) || speed < 1e-3) return;
      const double time = clearance / speed;
      if (time > 0 && time > time_to_limits()) return;
      move(time);
    }
  }

  double time_to_limits() const {
    double time = std::numeric_limits<double>::infinity();
    for (const int j : joints_) {
      const double rate = rate_[at(j)];
      if (rate == 0) continue;
      const Joint& joint = hand_.model.joints[at(j)];
      const double way = (rate > 0 ? joint.upper : joint.lower) - result_.all[j];
      time = std::min(time, std::max(0.0, way / rate));
    }
    return time;
  }

  void move(double time) {
    if (!push_.isZero()) {
      result_.push_W += time * push_;
      for (RigidTransform& pose : poses_) pose.translation() += time * push_;
    }
    for (const int j : joints_) {
      const Joint& joint = hand_.model.joints[at(j)];
      result_.all[j] = std::clamp(result_.all[j] + time * rate_[at(j)], joint.lower, joint.upper);
      for (std::size_t b = 0; b < hand_.breakaways.size(); ++b) {
        if (hand_.breakaways[b].joint == j && rate_[at(hand_.breakaways[b].leader)] == 0) {
          result_.broken_away[b] += time * rate_[at(j)];
        }
      }
      poses_[at(joint.child)] = poses_[at(joint.parent)] * joint.pose_at(result_.all[j]);
    }
  }

  void stop_motor(int motor) {
    for (std::size_t j = 0; j < rate_.size(); ++j) {
      if (drives_.motor[j] == motor) rate_[j] = 0;
    }
    for (int other = 0; other < hand_.size(); ++other) {
      if (preshape_.closing[at(other)].with != motor) continue;
      for (std::size_t j = 0; j < rate_.size(); ++j) {
        if (drives_.motor[j] == other) rate_[j] = 0;
      }
    }
  }

  void stop_above(int link, Touched what) {
    if (what != Touched::kObject) result_.other = what;
    for (const int j : joints_) {
      if (rate_[at(j)] == 0 || balls_.reach[at(link)][at(j)] == 0) continue;
      // A joint below this one that breaks away and does not carry the link goes on alone.
      const auto broken = std::find_if(
          hand_.breakaways.begin(), hand_.breakaways.end(),
          [&](const auto& b) { return b.leader == j && balls_.reach[at(link)][at(b.joint)] == 0; });
      double on = 0;
      if (broken != hand_.breakaways.end() && what == Touched::kObject) {
        on = std::copysign(rate_[at(j)] * broken->rate, rate_[at(broken->joint)]);
      }
      stop_motor(drives_.motor[at(j)]);
      if (on != 0) rate_[at(broken->joint)] = on;
    }
  }

  void stop_at_limits() {
    for (const int j : joints_) {
      const double rate = rate_[at(j)];
      if (rate == 0) continue;
      const Joint& joint = hand_.model.joints[at(j)];
      const double way = (rate > 0 ? joint.upper : joint.lower) - result_.all[j];
      if (way / rate > 1e-12) continue;
      // One that has broken away stops alone, as its leader stands.
      if (joint.mimic && rate_[at(joint.mimic->joint)] == 0) {
        rate_[at(j)] = 0;
      } else {
        stop_motor(drives_.motor[at(j)]);
      }
    }
  }

  void collect_contacts() {
    for (std::size_t l = 0; l < poses_.size(); ++l) {
      Vector3d point = Vector3d::Zero(), inward = Vector3d::Zero();
      double weights = 0;
      patch_.clear();
      each_near_ball(balls_.links[l], poses_[l], *scene_.object_W, options_.patch_depth,
                     [&](int ball, const Vector3d& p_W, double clearance) {
                       const Vector3d away = scene_.object_W->away(p_W);
                       const double weight = options_.patch_depth - clearance;
                       const double distance = clearance + balls_.links[l].radii[at(ball)];
                       patch_.push_back({p_W - distance * away, weight});
                       point += weight * patch_.back().first;
                       inward -= weight * away;
                       weights += weight;
                     });
      if (!(weights > 0) || !(inward.norm() > 1e-6 * weights)) continue;
      point /= weights;
      double radius = 0;
      for (const auto& [p, weight] : patch_) radius += weight / weights * (p - point).norm();
      GraspContact contact;
      contact.contact_W = {point, inward.normalized(), hand_.friction, radius};
      contact.link = static_cast<int>(l);
      name_place(contact, poses_[l]);
      result_.contacts.push_back(contact);
    }
  }

  void name_place(GraspContact& contact, const RigidTransform& X_WL) {
    for (std::size_t f = 0; f < hand_.fingers.size(); ++f) {
      const auto& links = hand_.fingers[f].links;
      if (std::find(links.begin(), links.end(), contact.link) == links.end()) continue;
      contact.finger = static_cast<int>(f);
      result_.finger_touches[f] = true;
    }
    for (std::size_t i = 0; i < hand_.pads.size(); ++i) {
      const robot::HandPad& pad = hand_.pads[i];
      if (pad.link != contact.link) continue;
      const RigidTransform X_PW = (X_WL * pad.X_LP).inverse();
      const Vector3d p = X_PW * contact.contact_W.point;
      const Vector3d n = X_PW.linear() * contact.contact_W.normal;
      if (pad.covers(p, n)) contact.pad = static_cast<int>(i);
    }
  }

  const robot::HandModel& hand_;
  const HandBalls& balls_;
  const robot::Preshape& preshape_;
  const TouchScene& scene_;
  const HandClosingOptions& options_;
  robot::DriveRatios drives_;
  std::vector<double> rate_;               // of the joints, now
  std::vector<RigidTransform> poses_;      // X_WL
  std::vector<int> joints_, links_;        // of the group that closes
  int pushing_ = -1, pushing_motor_ = -1;  // a link that pushes the object, none: -1
  Vector3d push_ = Vector3d::Zero();       // of the hand against it, for each unit of time
  std::vector<std::pair<Vector3d, double>> patch_;
  ClosedFingers result_;
};

}  // namespace

HandToClose::HandToClose(const robot::HandModel& model)
    : hand(&model), method(grasp::closing_method(model)), balls(make_hand_balls(model)) {}

void HandClosingOptions::validate() const {
  const auto positive = [](double value, const char* field) {
    if (value > 0 && std::isfinite(value)) return;
    throw std::invalid_argument(std::string("HandClosingOptions.") + field + " must be positive");
  };
  positive(tolerance, "tolerance");
  positive(patch_depth, "patch_depth");
  positive(largest_steps, "largest_steps");
  if (!(farthest_push >= 0) || !std::isfinite(farthest_push)) {
    throw std::invalid_argument("HandClosingOptions.farthest_push must not be negative");
  }
}

ClosedFingers close_fingers(const HandToClose& hand, const RigidTransform& X_WH,
                            const robot::Preshape& preshape, const Eigen::VectorXd& open,
                            const TouchScene& scene, const HandClosingOptions& options) {
  options.validate();
  return FingersAdvancing(hand, X_WH, preshape, open, scene, options).run();
}

NearBall hand_clearance(const HandToClose& hand, const RigidTransform& X_WH,
                        const Eigen::VectorXd& all, const TouchScene& scene, int* link) {
  thread_local std::vector<RigidTransform> poses;
  hand.hand->link_poses(all, poses);
  NearBall least;
  for (std::size_t l = 0; l < poses.size(); ++l) {
    const NearBall near = nearest_ball(hand.balls.links[l], X_WH * poses[l], scene);
    if (near.clearance >= least.clearance) continue;
    least = near;
    if (link != nullptr) *link = static_cast<int>(l);
  }
  return least;
}

Advance advance_hand(const HandToClose& hand, const RigidTransform& X_WH,
                     const Eigen::VectorXd& all, const Vector3d& direction_W, double distance,
                     double margin, const TouchScene& scene) {
  constexpr double kTolerance = 1e-4;  // m
  std::vector<RigidTransform> poses;
  hand.hand->link_poses(all, poses);
  for (RigidTransform& pose : poses) pose = X_WH * pose;
  Advance result;
  result.distance = distance;
  // The table is flat: one look at each link tells how far.
  const double speed = scene.table_W ? -direction_W.dot(scene.table_W->normal) : 0;
  for (std::size_t l = 0; scene.table_W && l < poses.size(); ++l) {
    // Of interest is what stops the hand before anything else did, or where it starts.
    const double most = margin + kTolerance + std::max(0.0, speed * result.distance);
    const NearBall lowest = lowest_ball(hand.balls.links[l], poses[l], *scene.table_W, most);
    if (lowest.ball < 0) continue;
    const double room = lowest.clearance - margin;
    double way = 0;
    if (room > kTolerance) {
      if (!(speed > 0)) continue;
      way = (room - kTolerance / 2) / speed;
    }
    if (way < result.distance) result = {way, Touched::kTable, static_cast<int>(l)};
  }
  if (scene.object_W == nullptr && scene.obstacles_W == nullptr) return result;
  TouchScene solid = scene;
  solid.table_W.reset();
  for (std::size_t l = 0; l < poses.size(); ++l) {
    const LinkBalls& balls = hand.balls.links[l];
    if (balls.nodes.empty()) continue;
    double way = 0;
    int likely = -1;
    while (way < result.distance) {
      RigidTransform moved = poses[l];
      moved.translation() += way * direction_W;
      const NearBall near = nearest_ball(balls, moved, solid, margin + kTolerance, likely);
      likely = near.ball;
      const double room = near.clearance - margin;
      if (room > kTolerance) {
        way += room - kTolerance / 2;
        continue;
      }
      result = {way, near.what, static_cast<int>(l)};
      break;
    }
  }
  return result;
}

}  // namespace prehend::grasp
