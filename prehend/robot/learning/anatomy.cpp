#include "prehend/robot/learning/anatomy.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <random>
#include <set>

#include <fmt/format.h>

#include "prehend/geometry/errors.h"
#include "prehend/geometry/surface_samples.h"
#include "prehend/robot/drive_ratios.h"
#include "prehend/robot/learning/at.h"
#include "prehend/robot/link_mesh.h"

namespace prehend::robot::learning {
namespace {

using Eigen::Vector3d;
using geometry::InputError;
using geometry::RigidTransform;

constexpr double kParallel = 0.866;  // cos 30 deg
constexpr double kAhead = 0.707;     // cos 45 deg, of what moves ahead
constexpr double kJointed = 0.004;   // m
constexpr int kSamples = 400;        // of a link's surface

struct SurfacePoint {
  Vector3d p, normal;  // in the link's frame
  double area;
};

class Finder {
 public:
  explicit Finder(const HandModel& hand)
      : hand_(hand), model_(hand.model), palm_(hand.palm), drives_(hand) {
    above_.assign(model_.links.size(), -1);
    for (std::size_t j = 0; j < model_.joints.size(); ++j) {
      above_[at(model_.joints[j].child)] = static_cast<int>(j);
    }
  }

  Anatomy find() {
    sample_surfaces();
    find_fingers();
    for (FoundFinger& finger : anatomy_.fingers) find_roles(finger);
    for (const SurfacePoint& point : surface_[at(palm_)]) {
      anatomy_.palm_H.push_back(hand_.X_HP * point.p);
      anatomy_.palm_normals_H.push_back(hand_.X_HP.linear() * point.normal);
    }
    find_center();
    for (FoundFinger& finger : anatomy_.fingers) {
      find_sense(finger);
      find_pad(finger);
    }
    return std::move(anatomy_);
  }

 private:
  std::vector<RigidTransform> poses_at(const Eigen::VectorXd& motors) const {
    std::vector<RigidTransform> poses;
    hand_.link_poses(hand_.all_positions(motors), poses);
    return poses;
  }

  bool moves(int joint) const { return joint >= 0 && drives_.motor[at(joint)] >= 0; }

  void sample_surfaces() {
    surface_.resize(model_.links.size());
    for (std::size_t l = 0; l < model_.links.size(); ++l) {
      const geometry::TriangleMesh mesh = link_mesh(model_.links[l]);
      if (mesh.triangles.empty()) continue;
      const double area = geometry::surface_area(mesh) / kSamples;
      for (const auto& sample : geometry::surface_samples(mesh, kSamples, 7)) {
        const Eigen::Vector3i& t = mesh.triangles[at(sample.triangle)];
        const Vector3d &a = mesh.vertices[at(t[0])], &b = mesh.vertices[at(t[1])],
                       &c = mesh.vertices[at(t[2])];
        const Vector3d normal = (b - a).cross(c - a);
        if (normal.norm() > 0) surface_[l].push_back({sample.point, normal.normalized(), area});
      }
    }
  }

  /// Links from the palm (without it) to this one.
  std::vector<int> chain_to(int link) const {
    std::vector<int> links;
    for (; link != palm_ && above_[at(link)] >= 0;
         link = model_.joints[at(above_[at(link)])].parent) {
      links.push_back(link);
    }
    std::reverse(links.begin(), links.end());
    return links;
  }

  std::set<int> motors_of(const std::vector<int>& links) const {
    std::set<int> motors;
    for (const int link : links) {
      if (moves(above_[at(link)])) motors.insert(drives_.motor[at(above_[at(link)])]);
    }
    return motors;
  }

  bool is_beneath_palm(int link) const {
    for (; link >= 0;) {
      if (link == palm_) return true;
      const int joint = above_[at(link)];
      if (joint < 0) return false;
      link = model_.joints[at(joint)].parent;
    }
    return false;
  }

  void find_fingers() {
    // Tips: the last links with a shape, of groups that no joint moves anything beyond.
    std::vector<int> last(model_.links.size(), -1);  // the joint that moves a link
    std::vector<bool> has_beyond(model_.joints.size(), false);
    std::map<int, int> tips;  // of a joint: the farthest link with a shape that moves with it
    for (std::size_t j = 0; j < model_.joints.size(); ++j) {
      const Joint& joint = model_.joints[j];
      const int mover = moves(static_cast<int>(j)) ? static_cast<int>(j) : last[at(joint.parent)];
      last[at(joint.child)] = mover;
    }
    for (std::size_t l = 0; l < model_.links.size(); ++l) {
      if (last[l] < 0 || surface_[l].empty() || !is_beneath_palm(static_cast<int>(l))) continue;
      // Joints above the one that moves it have something beyond.
      for (int joint = last[l];;) {
        const int parent = model_.joints[at(joint)].parent;
        joint = last[at(parent)];
        if (joint < 0) break;
        has_beyond[at(joint)] = true;
      }
      const auto known = tips.find(last[l]);
      if (known == tips.end() ||
          chain_to(static_cast<int>(l)).size() > chain_to(known->second).size()) {
        tips[last[l]] = static_cast<int>(l);
      }
    }
    std::vector<std::vector<int>> chains;
    for (const auto& [joint, link] : tips) {
      if (!has_beyond[at(joint)]) chains.push_back(chain_to(link));
    }
    chains = without_linkages(chains);
    // A link is of one finger; stems that fingers share are none's.
    std::map<int, int> uses;
    for (const auto& chain : chains) {
      for (const int link : chain) ++uses[link];
    }
    std::set<std::string> names;
    for (const auto& chain : chains) {
      FoundFinger finger;
      for (const int link : chain) {
        if (uses[link] == 1) finger.links.push_back(link);
      }
      finger.name = "finger_" + std::to_string(anatomy_.fingers.size() + 1);
      for (auto link = finger.links.rbegin(); link != finger.links.rend(); ++link) {
        if (moves(above_[at(*link)])) finger.base = above_[at(*link)];
      }
      finger.length = length_of(finger);
      anatomy_.fingers.push_back(std::move(finger));
    }
    if (anatomy_.fingers.size() < 2) {
      throw InputError("'" + model_.name + "' has " + std::to_string(anatomy_.fingers.size()) +
                           " finger with a shape that moves",
                       "A hand has two at least: see whether its meshes are there");
    }
    anatomy_.said.push_back(
        {"fingers", fmt::format("{}, each to where no joint moves anything beyond", chains.size()),
         0.95});
  }

  /// Of chains that one motor moves and that stay together, the one that reaches farther.
  std::vector<std::vector<int>> without_linkages(const std::vector<std::vector<int>>& chains) {
    std::vector<int> group(chains.size());
    std::iota(group.begin(), group.end(), 0);
    for (std::size_t a = 0; a < chains.size(); ++a) {
      for (std::size_t b = a + 1; b < chains.size(); ++b) {
        const auto motors = motors_of(chains[a]);
        if (motors.size() != 1 || motors != motors_of(chains[b])) continue;
        if (!stay_together(chains[a], chains[b], *motors.begin())) continue;
        const int from = group[b], to = group[a];
        std::replace(group.begin(), group.end(), from, to);
      }
    }
    std::vector<std::vector<int>> result;
    for (int id = 0; id < static_cast<int>(chains.size()); ++id) {
      const std::vector<int>* farthest = nullptr;
      double reach = -1;
      for (std::size_t c = 0; c < chains.size(); ++c) {
        if (group[c] != id) continue;
        const double its = reach_of(chains[c].back());
        if (its > reach) {
          reach = its;
          farthest = &chains[c];
        }
      }
      if (farthest == nullptr) continue;
      for (std::size_t c = 0; c < chains.size(); ++c) {
        if (group[c] != id || &chains[c] == farthest) continue;
        for (const int link : chains[c]) {
          if (std::count(farthest->begin(), farthest->end(), link) == 0) {
            anatomy_.linkage.push_back(link);
          }
        }
      }
      result.push_back(*farthest);
    }
    if (!anatomy_.linkage.empty()) {
      std::string names;
      for (const int link : anatomy_.linkage) {
        names += (names.empty() ? "'" : ", '") + model_.links[at(link)].name + "'";
      }
      anatomy_.said.push_back({"linkage", names + " move with a finger and are none", 0.8});
    }
    return result;
  }

  bool stay_together(const std::vector<int>& a, const std::vector<int>& b, int motor) const {
    const Joint& joint = model_.joints[at(hand_.actuated[at(motor)])];
    for (const double share : {0.1, 0.5, 0.9}) {
      Eigen::VectorXd q = rest();
      q[motor] = joint.lower + share * (joint.upper - joint.lower);
      const auto poses = poses_at(q);
      double least = std::numeric_limits<double>::infinity();
      for (const int la : a) {
        for (const int lb : b) {
          if (la == lb) continue;
          for (const SurfacePoint& pa : surface_[at(la)]) {
            const Vector3d p = poses[at(la)] * pa.p;
            for (const SurfacePoint& pb : surface_[at(lb)]) {
              least = std::min(least, (p - poses[at(lb)] * pb.p).squaredNorm());
            }
          }
        }
      }
      if (!(least < kJointed * kJointed)) return false;
    }
    return true;
  }

  double reach_of(int link) const {
    const auto poses = poses_at(rest());
    double reach = 0;
    for (const SurfacePoint& point : surface_[at(link)]) {
      reach = std::max(reach, (poses[at(link)] * point.p - poses[at(palm_)].translation()).norm());
    }
    return reach;
  }

  double length_of(const FoundFinger& finger) const {
    const auto poses = poses_at(rest());
    double length = 0;
    for (const int link : finger.links) {
      for (const SurfacePoint& point : surface_[at(link)]) {
        length = std::max(
            length,
            (poses[at(link)] * point.p - poses[at(finger.links.front())].translation()).norm());
      }
    }
    return length;
  }

  /// All motors at 0, or at the limit that is nearest to it.
  Eigen::VectorXd rest() const {
    Eigen::VectorXd q(hand_.size());
    for (int i = 0; i < q.size(); ++i) {
      const Joint& joint = model_.joints[at(hand_.actuated[at(i)])];
      q[i] = std::clamp(0.0, joint.lower, joint.upper);
    }
    return q;
  }

  Vector3d axis_at(int joint, const std::vector<RigidTransform>& poses) const {
    const Joint& one = model_.joints[at(joint)];
    return (poses[at(one.child)].linear() * one.axis_J).normalized();
  }

  void find_roles(FoundFinger& finger) {
    const auto poses = poses_at(rest());
    const std::vector<int> chain = chain_to(finger.links.back());
    Vector3d curl = Vector3d::Zero();  // axis of the last hinge
    for (auto link = chain.rbegin(); link != chain.rend(); ++link) {
      const int joint = above_[at(*link)];
      if (!moves(joint) || model_.joints[at(joint)].kind != Joint::Kind::kRevolute) continue;
      curl = axis_at(joint, poses);
      break;
    }
    std::map<int, double> closing;  // motor, its sense along `curl`
    std::set<int> turning;
    for (const int link : chain) {
      const int joint = above_[at(link)];
      if (!moves(joint)) continue;
      const int motor = drives_.motor[at(joint)];
      const double along = model_.joints[at(joint)].kind == Joint::Kind::kPrismatic
                               ? 1
                               : axis_at(joint, poses).dot(curl);
      if (std::abs(along) >= kParallel) {
        closing.emplace(motor, std::copysign(1.0, along * drives_.ratio[at(joint)]));
      } else {
        turning.insert(motor);
      }
    }
    for (const auto& [motor, sense] : closing) {
      finger.closing.push_back(motor);
      finger.sense.push_back(sense);
      turning.erase(motor);
    }
    finger.turning.assign(turning.begin(), turning.end());
  }

  Vector3d tip_of(const FoundFinger& finger, const std::vector<RigidTransform>& poses) const {
    const int link = finger.links.back();
    Vector3d sum = Vector3d::Zero();
    for (const SurfacePoint& point : surface_[at(link)]) sum += point.p;
    return poses[at(link)] * (sum / static_cast<double>(surface_[at(link)].size()));
  }

  Eigen::VectorXd random_posture(std::mt19937& random) const {
    std::uniform_real_distribution<double> unit(0, 1);
    Eigen::VectorXd q(hand_.size());
    for (int i = 0; i < q.size(); ++i) {
      const Joint& joint = model_.joints[at(hand_.actuated[at(i)])];
      q[i] = joint.lower + unit(random) * (joint.upper - joint.lower);
    }
    return q;
  }

  void find_center() {
    constexpr int kPostures = 500;
    std::mt19937 random(11);
    Vector3d sum = Vector3d::Zero();
    for (int i = 0; i < kPostures; ++i) {
      const auto poses = poses_at(random_posture(random));
      for (const FoundFinger& finger : anatomy_.fingers) sum += tip_of(finger, poses);
    }
    anatomy_.center_H = sum / (kPostures * static_cast<double>(anatomy_.fingers.size()));
  }

  void find_sense(FoundFinger& finger) {
    constexpr double kFarthest = 1.6;  // rad from rest: beyond, a finger winds up
    constexpr int kPostures = 64;
    std::mt19937 random(13);
    double difference = 0, size = 0;
    for (int i = 0; i < kPostures; ++i) {
      Eigen::VectorXd q = random_posture(random);
      double distance[2];
      for (const int end : {0, 1}) {
        for (std::size_t m = 0; m < finger.closing.size(); ++m) {
          const Joint& joint = model_.joints[at(hand_.actuated[at(finger.closing[m])])];
          const bool upper = (finger.sense[m] > 0) == (end == 1);
          const double zero = std::clamp(0.0, joint.lower, joint.upper);
          q[finger.closing[m]] = upper ? std::min(joint.upper, zero + kFarthest)
                                       : std::max(joint.lower, zero - kFarthest);
        }
        distance[end] = (tip_of(finger, poses_at(q)) - anatomy_.center_H).norm();
      }
      difference += distance[0] - distance[1];
      size += std::max(distance[0], distance[1]);
    }
    if (difference < 0) {
      for (double& sense : finger.sense) sense = -sense;
    }
    const double share = std::abs(difference) / std::max(size, 1e-9);
    anatomy_.said.push_back(
        {finger.name,
         fmt::format("closes towards the others: its tip comes {:.0f} % nearer", 100 * share),
         std::clamp(0.5 + 2 * share, 0.5, 0.98)});
  }

  void find_pad(FoundFinger& finger) {
    // How the last link moves while all of its finger's motors close.
    const int tip = finger.links.back();
    const auto poses = poses_at(rest());
    Eigen::VectorXd closer = rest();
    constexpr double kStep = 1e-4;  // rad or m
    for (std::size_t m = 0; m < finger.closing.size(); ++m) {
      closer[finger.closing[m]] += kStep * finger.sense[m];
    }
    const RigidTransform X_LH = poses[at(tip)].inverse();
    const RigidTransform X_LM = X_LH * poses_at(closer)[at(tip)];
    const auto velocity = [&](const Vector3d& p) -> Vector3d { return (X_LM * p - p) / kStep; };
    // Its nearest joint, and the axis that it turns or slides by.
    const std::vector<int> chain = chain_to(tip);
    int joint = -1;
    for (auto link = chain.rbegin(); link != chain.rend() && joint < 0; ++link) {
      if (moves(above_[at(*link)])) joint = above_[at(*link)];
    }
    const Joint& one = model_.joints[at(joint)];
    const Vector3d axis_L = X_LH.linear() * axis_at(joint, poses);
    const Vector3d origin_L = X_LH * poses[at(one.child)].translation();
    const bool turns = one.kind == Joint::Kind::kRevolute;
    // Along the link, from its joint to its end; a slide's fingers reach away from the palm.
    const auto& surface = surface_[at(tip)];
    Vector3d along = Vector3d::Zero();
    if (turns) {
      for (const SurfacePoint& point : surface) along += point.p - origin_L;
      along -= along.dot(axis_L) * axis_L;
    } else {
      const Vector3d palm_L = X_LH * poses[at(palm_)].translation();
      for (const SurfacePoint& point : surface) along += point.p - palm_L;
      along -= along.dot(axis_L) * axis_L;
    }
    along.normalize();
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const SurfacePoint& point : surface) {
      low = std::min(low, point.p.dot(along));
      high = std::max(high, point.p.dot(along));
    }
    Vector3d sum = Vector3d::Zero(), normals = Vector3d::Zero();
    double area = 0, all = 0;
    for (const double from : {0.35, 0.0}) {  // all of it, where nothing of its end moves ahead
      for (const SurfacePoint& point : surface) {
        const double share = (point.p.dot(along) - low) / std::max(high - low, 1e-9);
        all += point.area;
        const Vector3d v = velocity(point.p);
        if (share < from || share > 0.95 || v.dot(point.normal) < kAhead * v.norm()) continue;
        sum += point.area * point.p;
        normals += point.area * point.normal;
        area += point.area;
      }
      if (area > 0) break;
    }
    finger.pad.link = tip;
    if (!(area > 0)) {
      throw InputError("Finger '" + finger.name + "' of '" + model_.name + "', at link '" +
                           model_.links[at(tip)].name + "', has no inner surface",
                       "See whether its mesh is turned inside out");
    }
    finger.pad.p_L = sum / area;
    finger.pad.normal_L = normals.normalized();
    // The middle of a bent surface lies beneath it: out to the foremost of what is near.
    double out = 0;
    for (const SurfacePoint& point : surface) {
      const Vector3d d = point.p - finger.pad.p_L;
      const double ahead = d.dot(finger.pad.normal_L);
      if ((d - ahead * finger.pad.normal_L).norm() < 0.006) out = std::max(out, ahead);
    }
    finger.pad.p_L += std::min(out, 0.02) * finger.pad.normal_L;
    if (finger.closing.size() != 1) return;
    const Joint& motor = model_.joints[at(hand_.actuated[at(finger.closing.front())])];
    Eigen::VectorXd ends = rest();
    ends[finger.closing.front()] = motor.lower;
    const Vector3d low_H = poses_at(ends)[at(tip)].linear() * finger.pad.normal_L;
    ends[finger.closing.front()] = motor.upper;
    const Vector3d high_H = poses_at(ends)[at(tip)].linear() * finger.pad.normal_L;
    constexpr double kTurns = 0.54;  // cos 1 rad
    finger.presses_ahead = low_H.dot(high_H) < kTurns;
  }

  const HandModel& hand_;
  const RobotModel& model_;
  int palm_;
  DriveRatios drives_;
  Anatomy anatomy_;
  std::vector<int> above_;  // the joint above a link
  std::vector<std::vector<SurfacePoint>> surface_;
};

}  // namespace

Anatomy find_anatomy(const HandModel& hand) { return Finder(hand).find(); }

}  // namespace prehend::robot::learning
