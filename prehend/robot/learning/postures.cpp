#include "prehend/robot/learning/postures.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

#include "prehend/geometry/triangle_mesh.h"
#include "prehend/robot/learning/at.h"
#include "prehend/robot/link_mesh.h"

namespace prehend::robot::learning {
namespace {

using Eigen::Vector3d;
using geometry::RigidTransform;

constexpr double kWidest = 0.13, kNarrow = 0.055, kWide = 0.075;  // m
constexpr double kStep = 0.005;                                   // m of opening

struct Opened {
  double opening = 0;  // m
  Eigen::VectorXd motors;
};

class Postures {
 public:
  Postures(const HandModel& hand, const Anatomy& anatomy, const Opposition& opposition)
      : hand_(hand), anatomy_(anatomy), opposition_(opposition) {
    fingers_ = opposition.first;
    fingers_.insert(fingers_.end(), opposition.second.begin(), opposition.second.end());
  }

  std::vector<FoundPreshape> find() {
    std::vector<FoundPreshape> result;
    const std::vector<Opened> ways = open();
    const std::optional<RigidTransform> X_PG = tool(1);
    if (ways.empty() || !X_PG) return result;
    const std::string name = fingers_.size() == 2   ? "pinch"
                             : fingers_.size() == 3 ? "tripod"
                                                    : "precision";
    if (auto wide = preshape(name, ways.back(), *X_PG)) result.push_back(*wide);
    if (ways.back().opening > kWide) {
      const auto narrow = std::find_if(ways.begin(), ways.end(),
                                       [](const Opened& one) { return one.opening >= kNarrow; });
      if (auto one = preshape(name + "_narrow", *narrow, *X_PG)) result.push_back(*one);
    }
    if (auto power = this->power(ways.back())) result.push_back(*power);
    return result;
  }

 private:
  const Joint& joint_of(int motor) const {
    return hand_.model.joints[at(hand_.actuated[at(motor)])];
  }

  double sign_of(int finger) const {
    return std::count(opposition_.first.begin(), opposition_.first.end(), finger) > 0 ? 1 : -1;
  }

  /// How far the pads are apart along the closing direction.
  double opening_of(const PlacedPads& pads) const {
    double first = 0, second = 0;
    for (const int finger : fingers_) {
      const double along = pads.p_H[at(finger)].dot(opposition_.closing_H);
      if (sign_of(finger) > 0) {
        first += along / static_cast<double>(opposition_.first.size());
      } else {
        second += along / static_cast<double>(opposition_.second.size());
      }
    }
    return second - first;
  }

  /// Ever wider, from where the pads meet.
  std::vector<Opened> open() const {
    const PlacedPads met = placed_pads(hand_, anatomy_, opposition_.motors);
    const std::vector<int> free = motors_of(anatomy_, fingers_, true);
    std::vector<Opened> ways;
    Eigen::VectorXd motors = opposition_.motors;
    for (double wanted = std::max(kStep, opposition_.gap + kStep); wanted <= kWidest + 1e-9;
         wanted += kStep) {
      const auto cost = [&](const Eigen::VectorXd& q) {
        const PlacedPads pads = placed_pads(hand_, anatomy_, q);
        double sum = 0;
        for (const int finger : fingers_) {
          const Vector3d wished = met.p_H[at(finger)] - sign_of(finger) *
                                                            (wanted - opposition_.gap) / 2 *
                                                            opposition_.closing_H;
          const Vector3d off = pads.p_H[at(finger)] - wished;
          const double along = off.dot(opposition_.closing_H);
          sum += std::pow(along / 0.005, 2) + (off.squaredNorm() - along * along) / (0.02 * 0.02) +
                 2 * (1 - pads.normal_H[at(finger)].dot(met.normal_H[at(finger)]));
        }
        return sum;
      };
      search(hand_, free, 0.05, cost, &motors);
      const PlacedPads pads = placed_pads(hand_, anatomy_, motors);
      const double opening = opening_of(pads);
      double turned = 0;
      for (const int finger : fingers_) {
        const double facing =
            sign_of(finger) * pads.normal_H[at(finger)].dot(opposition_.closing_H);
        turned = std::max(turned, std::acos(std::clamp(facing, -1.0, 1.0)));
      }
      // A finger of one motor turns as it opens: at most until its pad looks along the approach.
      constexpr double kTurned = 1.75;  // rad
      if (turned > kTurned) break;
      if (!ways.empty() && opening < ways.back().opening + kStep / 4) break;
      ways.push_back({opening, motors});
    }
    // An opening that nothing fits into is none.
    if (!ways.empty() && ways.back().opening < 0.015) ways.clear();
    return ways;
  }

  Vector3d palm_middle() const {
    const geometry::TriangleMesh mesh = link_mesh(hand_.model.links[at(hand_.palm)]);
    if (!mesh.vertices.empty()) return hand_.X_HP * geometry::bounds(mesh).center();
    // The middle of where its fingers begin.
    std::vector<RigidTransform> poses;
    hand_.link_poses(hand_.all_positions(opposition_.motors), poses);
    Vector3d sum = Vector3d::Zero();
    for (const int finger : fingers_) {
      sum += poses[at(anatomy_.fingers[at(finger)].links.front())].translation();
    }
    return sum / static_cast<double>(fingers_.size());
  }

  /// Frame G in the palm's, its origin on the way from the palm's face (0) to the pads (1).
  std::optional<RigidTransform> tool(double share) const {
    const Vector3d y = opposition_.closing_H;
    const Vector3d middle = palm_middle();
    Vector3d z = opposition_.p_H - middle;
    z -= z.dot(y) * y;
    if (!(z.norm() > 0.01)) return std::nullopt;
    z.normalize();
    RigidTransform X_HG = RigidTransform::Identity();
    X_HG.linear().col(0) = y.cross(z);
    X_HG.linear().col(1) = y;
    X_HG.linear().col(2) = z;
    double face = middle.dot(z);
    for (const Vector3d& p : link_mesh(hand_.model.links[at(hand_.palm)]).vertices) {
      face = std::max(face, (hand_.X_HP * p).dot(z));
    }
    const double tip = opposition_.p_H.dot(z);
    if (share < 1 && !(tip - face > 0.03)) return std::nullopt;
    const double height = share < 1 ? face + share * (tip - face) : tip;
    X_HG.translation() = opposition_.p_H + (height - tip) * z;
    return RigidTransform(hand_.X_HP.inverse() * X_HG);
  }

  double smoothness(const PlacedPads& pads) const {
    double least = 1;
    for (const int finger : fingers_) {
      least =
          std::min(least, sign_of(finger) * pads.normal_H[at(finger)].dot(opposition_.closing_H));
    }
    return least;
  }

  std::optional<FoundPreshape> preshape(const std::string& name, const Opened& open,
                                        const RigidTransform& X_PG) const {
    FoundPreshape result;
    result.preshape.name = name;
    result.preshape.open = open.motors;
    result.preshape.X_PG = X_PG;
    result.preshape.closing.resize(hand_.actuated.size());
    result.opening = open.opening;
    const Eigen::VectorXd way = opposition_.motors - open.motors;
    double fastest = 0;
    for (int i = 0; i < hand_.size(); ++i) fastest = std::max(fastest, std::abs(way[i]));
    if (!(fastest > 0)) return std::nullopt;
    for (int i = 0; i < hand_.size(); ++i) {
      constexpr double kStill = 0.04;  // of the fastest
      const double rate = way[i] / fastest;
      if (std::abs(rate) > kStill) result.preshape.closing[at(i)].rate = rate;
    }
    // A finger stops as one: its slower motors with its fastest.
    for (const int finger : fingers_) {
      int leader = -1;
      for (const int motor : anatomy_.fingers[at(finger)].closing) {
        const double rate = std::abs(result.preshape.closing[at(motor)].rate);
        if (leader < 0 || rate > std::abs(result.preshape.closing[at(leader)].rate)) leader = motor;
      }
      for (const int motor : anatomy_.fingers[at(finger)].closing) {
        if (motor != leader && result.preshape.closing[at(motor)].rate != 0 &&
            result.preshape.closing[at(motor)].with < 0) {
          result.preshape.closing[at(motor)].with = leader;
        }
      }
    }
    result.sure = opposition_.sure() *
                  std::clamp(0.3 + smoothness(placed_pads(hand_, anatomy_, open.motors)), 0.0, 1.0);
    return result;
  }

  std::optional<FoundPreshape> power(const Opened& widest) const {
    const std::optional<RigidTransform> X_PG = tool(0.6);
    if (!X_PG) return std::nullopt;
    FoundPreshape result;
    result.preshape.name = fingers_.size() == 2   ? "power_two"
                           : fingers_.size() == 3 ? "power_three"
                                                  : "power";
    result.preshape.X_PG = *X_PG;
    result.preshape.closing.resize(hand_.actuated.size());
    Eigen::VectorXd open = opposition_.motors;
    bool has_bend = false;
    for (const int finger : fingers_) {
      const FoundFinger& one = anatomy_.fingers[at(finger)];
      for (std::size_t m = 0; m < one.closing.size(); ++m) {
        const int motor = one.closing[m];
        const Joint& joint = joint_of(motor);
        if (joint.kind != Joint::Kind::kRevolute) return std::nullopt;
        const bool is_first = motor == first_motor(one);
        constexpr double kBent = 0.3;  // rad: slightly
        if (!is_first) {
          open[motor] = std::clamp(one.sense[m] * kBent, joint.lower, joint.upper);
          has_bend = true;
        } else {
          open[motor] = widest.motors[motor];
        }
        result.preshape.closing[at(motor)].rate = one.sense[m] * (is_first ? 1 : 0.5);
      }
    }
    if (!has_bend) return std::nullopt;
    // Each finger opens by its first motor to where the pads are as far apart as they may be.
    for (const int finger : fingers_) {
      const FoundFinger& one = anatomy_.fingers[at(finger)];
      const int motor = first_motor(one);
      const Joint& joint = joint_of(motor);
      double best = std::numeric_limits<double>::infinity(), there = open[motor];
      for (int i = 0; i <= 40; ++i) {
        open[motor] = joint.lower + i / 40.0 * (joint.upper - joint.lower);
        const PlacedPads pads = placed_pads(hand_, anatomy_, open);
        const double out =
            -sign_of(finger) * (pads.p_H[at(finger)] - opposition_.p_H).dot(opposition_.closing_H);
        const double off = std::abs(out - 0.06);
        if (off < best) {
          best = off;
          there = open[motor];
        }
      }
      open[motor] = there;
    }
    result.preshape.open = open;
    const PlacedPads pads = placed_pads(hand_, anatomy_, open);
    result.opening = opening_of(pads);
    if (!(result.opening > 0.03)) return std::nullopt;
    result.sure = 0.8 * opposition_.sure();
    return result;
  }

  /// The closing motor that moves the most of a finger: that nearest to the palm.
  int first_motor(const FoundFinger& finger) const {
    int first = -1;
    std::size_t depth = std::numeric_limits<std::size_t>::max();
    for (const int motor : finger.closing) {
      const int child = hand_.model.joints[at(hand_.actuated[at(motor)])].child;
      std::size_t its = 0;
      for (auto above = hand_.model.joint_above(child); above;
           above = hand_.model.joint_above(hand_.model.joints[at(*above)].parent)) {
        ++its;
      }
      if (its >= depth) continue;
      depth = its;
      first = motor;
    }
    return first;
  }

  const HandModel& hand_;
  const Anatomy& anatomy_;
  const Opposition& opposition_;
  std::vector<int> fingers_;
};

}  // namespace

std::vector<FoundPreshape> find_preshapes(const HandModel& hand, const Anatomy& anatomy,
                                          const std::vector<Opposition>& oppositions,
                                          double least) {
  std::vector<FoundPreshape> result;
  std::map<std::string, int> used;
  for (const Opposition& opposition : oppositions) {
    if (!result.empty() && opposition.sure() < least) continue;
    for (FoundPreshape& one : Postures(hand, anatomy, opposition).find()) {
      const int count = ++used[one.preshape.name];
      if (count > 1) one.preshape.name += "_" + std::to_string(count);
      result.push_back(std::move(one));
    }
  }
  return result;
}

}  // namespace prehend::robot::learning
