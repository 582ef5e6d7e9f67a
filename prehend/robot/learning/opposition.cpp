#include "prehend/robot/learning/opposition.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <set>

#include "prehend/robot/learning/at.h"

namespace prehend::robot::learning {
namespace {

using Eigen::Vector3d;

constexpr double kBeside = 0.015, kGap = 0.12;  // m, at most
constexpr double kFacing = 1.1;                 // rad, at most: 63 deg

struct Meeting {
  Vector3d p_first, p_second, axis;  // mean pads; axis from first to second, unit
  double cost = 0, beside = 0, gap = 0, angle = 0;
};

Meeting meeting(const PlacedPads& pads, const std::vector<int>& first,
                const std::vector<int>& second, const Vector3d& palm_H) {
  const auto mean = [](const std::vector<Vector3d>& all, const std::vector<int>& of) {
    Vector3d sum = Vector3d::Zero();
    for (const int finger : of) sum += all[at(finger)];
    return Vector3d(sum / static_cast<double>(of.size()));
  };
  Meeting result;
  result.p_first = mean(pads.p_H, first);
  result.p_second = mean(pads.p_H, second);
  const Vector3d n_first = mean(pads.normal_H, first), n_second = mean(pads.normal_H, second);
  const Vector3d both = n_first - n_second;
  result.axis = both.norm() > 1e-6 ? Vector3d(both.normalized()) : Vector3d::UnitY();
  const Vector3d between = result.p_second - result.p_first;
  result.gap = between.dot(result.axis);
  result.beside = (between - result.gap * result.axis).norm();
  const auto square = [](double x) { return x * x; };
  double facing = 0, apart = 0, spread = 0, hooked = 0;
  const auto add = [&](const std::vector<int>& group, const Vector3d& p, double sign) {
    for (std::size_t i = 0; i < group.size(); ++i) {
      const double cosine = sign * pads.normal_H[at(group[i])].dot(result.axis);
      result.angle = std::max(result.angle, std::acos(std::clamp(cosine, -1.0, 1.0)));
      facing += 1 - cosine;
      // A finger whose base is ahead of its pad hooks round the other one.
      const double ahead =
          sign * (pads.base_H[at(group[i])] - pads.p_H[at(group[i])]).dot(result.axis);
      hooked += square(std::max(0.0, ahead - 0.02) / 0.02);
      apart += square((pads.p_H[at(group[i])] - p).dot(result.axis) / 0.01);
      // Nor does it look away from the palm, but where the finger is wound up.
      const double outward =
          (pads.p_H[at(group[i])] - palm_H).normalized().dot(pads.normal_H[at(group[i])]);
      hooked += square(std::max(0.0, outward - 0.3) / 0.2);
      const Vector3d off = pads.p_H[at(group[i])] - p;
      const double away = (off - off.dot(result.axis) * result.axis).norm();
      spread += square(std::max(0.0, away - 0.04) / 0.02);  // and no farther than a hand is wide
      for (std::size_t k = i + 1; k < group.size(); ++k) {
        const double near = (pads.p_H[at(group[i])] - pads.p_H[at(group[k])]).norm();
        spread += square(std::max(0.0, 0.02 - near) / 0.01);  // fingers are side by side
      }
    }
  };
  add(first, result.p_first, 1);
  add(second, result.p_second, -1);
  // Pads that have passed each other look back at where their own fingers begin.
  const double passed = (mean(pads.base_H, first) - mean(pads.base_H, second)).dot(result.axis);
  const double crossed = square(std::max(0.0, passed - 0.01) / 0.005);
  result.cost = square(result.beside / 0.01) + square(result.gap / (result.gap > 0 ? 0.1 : 0.01)) +
                3 * facing + apart + spread + hooked + crossed;
  return result;
}

/// How far a point is out of the palm [m]; negative: within it.
double out_of_palm(const Anatomy& anatomy, const Vector3d& p_H) {
  double least = std::numeric_limits<double>::infinity(), sign = 1;
  for (std::size_t i = 0; i < anatomy.palm_H.size(); ++i) {
    const Vector3d d = p_H - anatomy.palm_H[i];
    if (d.squaredNorm() >= least) continue;
    least = d.squaredNorm();
    sign = d.dot(anatomy.palm_normals_H[i]) < 0 ? -1 : 1;
  }
  return sign * std::sqrt(least);
}

}  // namespace

double Opposition::sure() const {
  return std::exp(-std::pow(beside / 0.015, 2) - std::pow(angle / 0.87, 2) -
                  std::pow(std::max(0.0, gap) / 0.12, 2));
}

PlacedPads placed_pads(const HandModel& hand, const Anatomy& anatomy,
                       const Eigen::VectorXd& motors) {
  thread_local std::vector<geometry::RigidTransform> poses;
  hand.link_poses(hand.all_positions(motors), poses);
  PlacedPads result;
  for (const FoundFinger& finger : anatomy.fingers) {
    const auto& X_HL = poses[at(finger.pad.link)];
    result.p_H.emplace_back(X_HL * finger.pad.p_L);
    result.normal_H.emplace_back(X_HL.linear() * finger.pad.normal_L);
    const int child = hand.model.joints[at(finger.base)].child;
    result.base_H.emplace_back(poses[at(child)].translation());
  }
  // Those that press where they move.
  constexpr double kStep = 1e-4;  // rad
  thread_local Eigen::VectorXd moved;
  moved = motors;
  bool any = false;
  for (const FoundFinger& finger : anatomy.fingers) {
    if (!finger.presses_ahead) continue;
    for (std::size_t m = 0; m < finger.closing.size(); ++m) {
      moved[finger.closing[m]] += kStep * finger.sense[m];
    }
    any = true;
  }
  if (!any) return result;
  hand.link_poses(hand.all_positions(moved), poses);
  for (std::size_t f = 0; f < anatomy.fingers.size(); ++f) {
    const FoundFinger& finger = anatomy.fingers[f];
    if (!finger.presses_ahead) continue;
    result.normal_H[f] = (poses[at(finger.pad.link)] * finger.pad.p_L - result.p_H[f]).normalized();
  }
  return result;
}

std::vector<int> motors_of(const Anatomy& anatomy, const std::vector<int>& fingers,
                           bool only_closing) {
  std::set<int> motors;
  for (const int finger : fingers) {
    const FoundFinger& one = anatomy.fingers[at(finger)];
    motors.insert(one.closing.begin(), one.closing.end());
    if (!only_closing) motors.insert(one.turning.begin(), one.turning.end());
  }
  return {motors.begin(), motors.end()};
}

Opposition oppose(const HandModel& hand, const Anatomy& anatomy, std::vector<int> first,
                  std::vector<int> second, int starts) {
  std::vector<int> fingers = first;
  fingers.insert(fingers.end(), second.begin(), second.end());
  const std::vector<int> free = motors_of(anatomy, fingers, false);
  double length = 0;
  for (const int finger : fingers) length = std::max(length, anatomy.fingers[at(finger)].length);
  const Vector3d palm_H = hand.X_HP.translation();
  const auto cost = [&](const Eigen::VectorXd& motors) {
    const Meeting there = meeting(placed_pads(hand, anatomy, motors), first, second, palm_H);
    // Things are held away from the palm, by fingers that are rather straight and can open.
    const Vector3d p_H = (there.p_first + there.p_second) / 2;
    const double too_near = std::max(0.0, 0.03 - out_of_palm(anatomy, p_H)) / 0.015;
    double bent = 0;
    for (const int finger : fingers) {
      const FoundFinger& one = anatomy.fingers[at(finger)];
      double room = 0;   // m, to open
      double wound = 0;  // rad, all in all
      for (std::size_t m = 0; m < one.closing.size(); ++m) {
        constexpr double kSlightly = 0.3;  // rad
        const double position = motors[one.closing[m]];
        const Joint& joint = hand.model.joints[at(hand.actuated[at(one.closing[m])])];
        const bool turns = joint.kind == Joint::Kind::kRevolute;
        if (turns) bent += 0.2 * std::pow(position - kSlightly * one.sense[m], 2);
        if (turns) wound += position * one.sense[m];
        room += (turns ? one.length : 1) *
                std::abs(position - (one.sense[m] > 0 ? joint.lower : joint.upper));
      }
      bent += std::pow(std::max(0.0, 0.04 - room) / 0.02, 2);
      bent += std::pow(std::max(0.0, wound - 2.4) / 0.3, 2);  // no finger folds onto itself
    }
    return there.cost + too_near * too_near + bent - std::min(1.0, (p_H - palm_H).norm() / length);
  };
  // Fingers that have no part in it stand open.
  Eigen::VectorXd rest(hand.size());
  for (int i = 0; i < hand.size(); ++i) {
    const Joint& joint = hand.model.joints[at(hand.actuated[at(i)])];
    rest[i] = std::clamp(0.0, joint.lower, joint.upper);
  }
  for (const FoundFinger& finger : anatomy.fingers) {
    for (std::size_t m = 0; m < finger.closing.size(); ++m) {
      const Joint& joint = hand.model.joints[at(hand.actuated[at(finger.closing[m])])];
      constexpr double kBack = 1.4;  // rad at most
      rest[finger.closing[m]] =
          finger.sense[m] > 0 ? std::max(joint.lower, -kBack) : std::min(joint.upper, kBack);
      rest[finger.closing[m]] = std::clamp(rest[finger.closing[m]], joint.lower, joint.upper);
    }
  }
  std::mt19937 random(17);
  std::uniform_real_distribution<double> unit(0, 1);
  double best = 0;
  Opposition result;
  for (int start = 0; start < starts; ++start) {
    Eigen::VectorXd motors = rest;
    for (const int motor : free) {
      const Joint& joint = hand.model.joints[at(hand.actuated[at(motor)])];
      motors[motor] = joint.lower + unit(random) * (joint.upper - joint.lower);
    }
    const double there = search(hand, free, 0.25, cost, &motors);
    if (start > 0 && !(there < best)) continue;
    best = there;
    result.motors = motors;
  }
  const Meeting found = meeting(placed_pads(hand, anatomy, result.motors), first, second, palm_H);
  result.first = std::move(first);
  result.second = std::move(second);
  result.p_H = (found.p_first + found.p_second) / 2;
  result.closing_H = found.axis;
  result.beside = found.beside;
  result.gap = found.gap;
  result.angle = found.angle;
  return result;
}

std::vector<Opposition> find_oppositions(const HandModel& hand, const Anatomy& anatomy) {
  constexpr int kStarts = 120;
  constexpr std::size_t kPairs = 2;  // of a hand with more than three fingers
  const int count = static_cast<int>(anatomy.fingers.size());
  std::vector<Opposition> all;
  std::vector<double> sums(at(count), 0);
  std::vector<std::vector<double>> sure(at(count), std::vector<double>(at(count), 0));
  for (int a = 0; a < count; ++a) {
    for (int b = a + 1; b < count; ++b) {
      Opposition pair = oppose(hand, anatomy, {a}, {b}, kStarts);
      sure[at(a)][at(b)] = sure[at(b)][at(a)] = pair.sure();
      sums[at(a)] += pair.sure();
      sums[at(b)] += pair.sure();
      all.push_back(std::move(pair));
    }
  }
  const auto by_sureness = [](const Opposition& a, const Opposition& b) {
    return a.sure() > b.sure();
  };
  // Each finger of three may be the thumb; of more, the one that opposes the others best.
  std::vector<int> thumbs;
  if (count == 3) {
    thumbs = {0, 1, 2};
  } else if (count > 3) {
    thumbs = {static_cast<int>(std::max_element(sums.begin(), sums.end()) - sums.begin())};
    std::erase_if(all, [&](const Opposition& pair) {
      return pair.first.front() != thumbs.front() && pair.second.front() != thumbs.front();
    });
    std::stable_sort(all.begin(), all.end(), by_sureness);
    all.resize(std::min(all.size(), kPairs));
  }
  for (const int thumb : thumbs) {
    std::vector<int> others;
    for (int other = 0; other < count; ++other) {
      if (other != thumb) others.push_back(other);
    }
    std::stable_sort(others.begin(), others.end(),
                     [&](int a, int b) { return sure[at(thumb)][at(a)] > sure[at(thumb)][at(b)]; });
    for (std::size_t size = 2; size <= others.size(); ++size) {
      all.push_back(oppose(hand, anatomy, {thumb},
                           {others.begin(), others.begin() + static_cast<std::ptrdiff_t>(size)},
                           kStarts));
    }
  }
  std::erase_if(all, [](const Opposition& one) {
    return one.beside > kBeside || one.angle > kFacing || one.gap > kGap;
  });
  std::stable_sort(all.begin(), all.end(), by_sureness);
  return all;
}

}  // namespace prehend::robot::learning
