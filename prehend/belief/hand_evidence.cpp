#include "prehend/belief/hand_evidence.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include <Eigen/Geometry>

#include "prehend/text/require.h"
#include "prehend/touch/contact_fit.h"

namespace prehend::belief {
namespace {

using Eigen::Vector3d;
using geometry::RigidTransform;

constexpr double kTolerance = 5e-4;   // m, of the balls beneath flat faces
constexpr double kLeastMotion = 0.4;  // of the voxels' spacing
constexpr double kNearBox = 0.1;      // m, more than a ball moves in a step

/// The surface behind one texel.
struct FeltPoint {
  Vector3d p_P = Vector3d::Zero();     // m
  Vector3d face_P = Vector3d::Zero();  // unit, out of the pad
  double side = 0;                     // m, of the texel
  double force = 0;                    // N
  double depth = 0;                    // m, of the foam
  double unknown = 0;                  // m, standard, of that of a full texel
};

std::vector<FeltPoint> felt_points(const touch::FeltPad& pad, const touch::FeltTexels& felt) {
  const contact::PadLayout& layout = pad.layout;
  std::vector<FeltPoint> points;
  for (std::size_t i = 0; i < layout.size(); ++i) {
    if (!(felt.force[i] > 0)) continue;
    FeltPoint point;
    point.face_P = layout.normal(i);
    point.side = std::sqrt(layout.area(i));
    point.force = felt.force[i];
    point.depth = touch::rest_depth(pad.law, layout.scale[i], felt.force[i], layout.thickness());
    if (felt.state[i] == touch::Texel::kFull) {
      const double rest = layout.thickness() - point.depth;
      point.depth += rest / 2;
      point.unknown = rest / std::sqrt(12);
    }
    point.p_P = layout.position(i) - point.depth * point.face_P;
    points.push_back(point);
  }
  return points;
}

/// The strongest, then always the one farthest from those taken.
std::vector<FeltPoint> thinned(std::vector<FeltPoint> points, std::size_t most, double spacing) {
  if (points.empty()) return points;
  std::iter_swap(points.begin(),
                 std::max_element(points.begin(), points.end(),
                                  [](const auto& a, const auto& b) { return a.force < b.force; }));
  std::vector<double> apart(points.size(), std::numeric_limits<double>::infinity());
  std::size_t taken = 1;
  for (; taken < std::min(most, points.size()); ++taken) {
    std::size_t farthest = taken;
    for (std::size_t i = taken; i < points.size(); ++i) {
      apart[i] = std::min(apart[i], (points[i].p_P - points[taken - 1].p_P).norm());
      if (apart[i] > apart[farthest]) farthest = i;
    }
    if (apart[farthest] < spacing) break;
    std::swap(points[taken], points[farthest]);
    std::swap(apart[taken], apart[farthest]);
  }
  points.resize(taken);
  return points;
}

/// Outward normals of what a pad touches, where its texels tell.
class FeltSurface {
 public:
  FeltSurface(const touch::FeltPad& pad, const touch::FeltTexels& felt,
              const std::vector<FeltPoint>& points) {
    double force = 0;
    for (const FeltPoint& point : points) {
      center_P_ += point.force * point.p_P;
      force += point.force;
    }
    center_P_ /= force;
    fit_ = touch::fit_contact(pad, felt, center_P_);
  }
  bool is_known() const { return fit_.normal.has_value(); }
  Vector3d outward(const Vector3d& p_P) const {
    Vector3d out = -fit_.normal->direction;
    if (fit_.curvature) {
      const Vector3d& first = fit_.curvature->direction;
      const Vector3d second = first.cross(out);
      const Vector3d r = p_P - center_P_;
      out += fit_.curvature->largest * r.dot(first) * first +
             fit_.curvature->smallest * r.dot(second) * second;
    }
    return out.normalized();
  }

 private:
  Vector3d center_P_ = Vector3d::Zero();
  touch::ContactFit fit_;
};

HandSample between(const HandSample& from, const HandSample& to, double share) {
  HandSample sample;
  const Eigen::Quaterniond q(from.X_WH.linear());
  sample.X_WH.linear() = q.slerp(share, Eigen::Quaterniond(to.X_WH.linear())).matrix();
  sample.X_WH.translation() =
      from.X_WH.translation() + share * (to.X_WH.translation() - from.X_WH.translation());
  sample.joints = from.joints + share * (to.joints - from.joints);
  return sample;
}

/// By how much, and along which way of P, a ball is set back that reaches into the foam.
Vector3d set_back(const contact::PadLayout& layout, const Vector3d& center_P, double radius,
                  double depth) {
  std::size_t nearest = 0;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < layout.size(); ++i) {
    const double distance = (layout.position(i) - center_P).squaredNorm();
    if (!(layout.area(i) > 0) || distance >= least) continue;
    least = distance;
    nearest = i;
  }
  const Vector3d normal = layout.normal(nearest);
  const Vector3d r = layout.position(nearest) - center_P;
  const double below = r.dot(normal);
  const double aside = (r - below * normal).norm();
  const bool in_foam = below - radius < layout.thickness() && below > -layout.thickness() &&
                       aside < radius + std::sqrt(layout.area(nearest));
  return in_foam ? Vector3d(-depth * normal) : Vector3d::Zero();
}

}  // namespace

void HandEvidenceOptions::validate() const {
  const text::Require require{"HandEvidenceOptions."};
  require(most_contacts > 0, "most_contacts must be above 0");
  require(contact_spacing >= 0 && contact_spacing < 1, "contact_spacing must be from 0 to 1 m");
  require(placement > 0 && placement < 0.1, "placement must be above 0, below 0.1 m");
  require(foam >= 0 && foam < 10, "foam must be from 0 to 10");
  require(slope >= 0 && slope < 10, "slope must be from 0 to 10");
  require(margin >= 0 && margin < 0.1, "margin must be from 0 to 0.1 m");
}

HandEvidence::HandEvidence(robot::HandModel hand, const HandEvidenceOptions& options)
    : hand_(std::move(hand)), options_(options) {
  options_.validate();
  balls_ = grasp::make_hand_balls(hand_, kTolerance);
}

void HandEvidence::check(const HandSample& sample) const {
  const std::size_t joints = hand_.model.joints.size();
  if (static_cast<std::size_t>(sample.joints.size()) != joints) {
    throw std::invalid_argument("HandEvidence: " + std::to_string(sample.joints.size()) +
                                " positions for the " + std::to_string(joints) +
                                " joints of the hand " + hand_.name);
  }
  for (std::size_t j = 0; j < joints; ++j) {
    if (std::isfinite(sample.joints[static_cast<Eigen::Index>(j)])) continue;
    throw std::invalid_argument("HandEvidence: the position of the joint '" +
                                hand_.model.joints[j].name + "' of the hand " + hand_.name +
                                " is not finite");
  }
  if (!sample.X_WH.matrix().allFinite()) {
    throw std::invalid_argument("HandEvidence: X_WH of the hand " + hand_.name + " is not finite");
  }
}

const robot::HandPad& HandEvidence::pad_named(const std::string& name) const {
  const auto pad = std::find_if(hand_.pads.begin(), hand_.pads.end(),
                                [&](const auto& one) { return one.name == name; });
  if (pad == hand_.pads.end()) {
    throw std::invalid_argument("HandEvidence: the hand " + hand_.name + " has no pad '" + name +
                                "'");
  }
  return *pad;
}

const robot::HandPad& HandEvidence::pad_of(const touch::PadFrame& frame) const {
  const robot::HandPad& pad = pad_named(frame.pad);
  if (frame.counts.size() != frame.felt->layout.size()) {
    throw std::invalid_argument("HandEvidence: " + std::to_string(frame.counts.size()) +
                                " counts for the " + std::to_string(frame.felt->layout.size()) +
                                " texels of the pad '" + frame.pad + "'");
  }
  return pad;
}

std::vector<RigidTransform> HandEvidence::link_poses(const HandSample& sample) const {
  std::vector<RigidTransform> poses;
  hand_.link_poses(sample.joints, poses);
  for (RigidTransform& pose : poses) pose = sample.X_WH * pose;
  return poses;
}

std::vector<Contact> HandEvidence::contacts(const HandSample& at,
                                            const std::vector<touch::PadFrame>& frames) const {
  check(at);
  const std::vector<RigidTransform> X_WL = link_poses(at);
  std::vector<Contact> contacts;
  for (const touch::PadFrame& frame : frames) {
    const robot::HandPad& pad = pad_of(frame);
    const touch::FeltTexels felt = touch::felt_texels(*frame.felt, frame.counts);
    const std::vector<FeltPoint> points = felt_points(*frame.felt, felt);
    if (points.empty()) continue;
    const RigidTransform X_WP = X_WL[static_cast<std::size_t>(pad.link)] * pad.X_LP;
    const FeltSurface surface(*frame.felt, felt, points);
    const std::vector<FeltPoint> few =
        thinned(points, static_cast<std::size_t>(options_.most_contacts), options_.contact_spacing);
    const double common = options_.placement * std::sqrt(static_cast<double>(few.size()));
    for (const FeltPoint& point : few) {
      const Vector3d out = surface.is_known() ? surface.outward(point.p_P) : -point.face_P;
      const double slope = surface.is_known() ? out.cross(point.face_P).norm() : options_.slope;
      Contact contact;
      contact.p_W = X_WP * point.p_P;
      contact.normal_W = X_WP.linear() * out;
      contact.deviation = Eigen::Vector4d(common, options_.foam * point.depth, point.unknown,
                                          slope * point.side / std::sqrt(12))
                              .norm();
      contacts.push_back(contact);
    }
  }
  return contacts;
}

HandEvidence::PadDepths HandEvidence::depths(const std::vector<touch::PadFrame>& frames) const {
  PadDepths depths;
  for (const touch::PadFrame& frame : frames) {
    const robot::HandPad& pad = pad_of(frame);
    for (const FeltPoint& point :
         felt_points(*frame.felt, touch::felt_texels(*frame.felt, frame.counts))) {
      double& depth = depths[pad.name];
      depth = std::max(depth, point.depth);
    }
  }
  return depths;
}

// In the links' frames.
std::vector<std::vector<Vector3d>> HandEvidence::centers_behind_foam(
    const PadDepths& depths) const {
  std::vector<std::vector<Vector3d>> centers;
  for (const grasp::LinkBalls& link : balls_.links) centers.push_back(link.centers);
  for (const auto& [name, depth] : depths) {
    const robot::HandPad& pad = pad_named(name);
    if (!(depth >= 0) || !std::isfinite(depth)) {
      throw std::invalid_argument("HandEvidence: the foam of the pad '" + name +
                                  "' gives way by no depth");
    }
    const auto link = static_cast<std::size_t>(pad.link);
    const RigidTransform X_PL = pad.X_LP.inverse(Eigen::Isometry);
    for (std::size_t i = 0; i < centers[link].size(); ++i) {
      const Vector3d way_P = set_back(*pad.layout, X_PL * balls_.links[link].centers[i],
                                      balls_.links[link].radii[i], depth);
      centers[link][i] += pad.X_LP.linear() * way_P;
    }
  }
  return centers;
}

int HandEvidence::steps_between(const HandSample& from, const HandSample& to,
                                double least_step) const {
  const double shift = (to.X_WH.translation() - from.X_WH.translation()).norm();
  const double turn = Eigen::AngleAxisd(from.X_WH.linear().transpose() * to.X_WH.linear()).angle();
  const Eigen::VectorXd motion = (to.joints - from.joints).cwiseAbs();
  std::vector<RigidTransform> X_HL;
  hand_.link_poses(from.joints, X_HL);
  constexpr double kMostSteps = 1e5;
  double steps = 1;
  for (std::size_t l = 0; l < balls_.links.size(); ++l) {
    const grasp::LinkBalls& link = balls_.links[l];
    if (link.radii.empty()) continue;
    double way = shift + turn * (X_HL[l].translation().norm() + link.reach);
    for (std::size_t j = 0; j < balls_.reach[l].size(); ++j) {
      way += balls_.reach[l][j] * motion[static_cast<Eigen::Index>(j)];
    }
    const double smallest = *std::min_element(link.radii.begin(), link.radii.end());
    steps = std::max(steps, std::ceil(way / std::max(smallest - options_.margin, least_step)));
  }
  return static_cast<int>(std::min(steps, kMostSteps));
}

void HandEvidence::sweep(const std::vector<HandSample>& way, const PadDepths& depths,
                         geometry::SweptSpace* space) const {
  if (way.empty()) throw std::invalid_argument("HandEvidence: a way without samples");
  for (const HandSample& sample : way) check(sample);
  const std::vector<std::vector<Vector3d>> centers = centers_behind_foam(depths);
  std::vector<std::vector<Vector3d>> at_W = centers;  // up to where each ball was added
  // What moved less than `least` is added with the next motion.
  const auto move_to = [&](const std::vector<RigidTransform>& X_WL, double least) {
    for (std::size_t l = 0; l < centers.size(); ++l) {
      for (std::size_t i = 0; i < centers[l].size(); ++i) {
        const Vector3d end = X_WL[l] * centers[l][i];
        const double radius = balls_.links[l].radii[i] - options_.margin;
        if ((end - at_W[l][i]).squaredNorm() <= least * least) continue;
        if (space->box().squaredExteriorDistance(end) < kNearBox * kNearBox) {
          space->add_path(at_W[l][i], end, radius);
        }
        at_W[l][i] = end;
      }
    }
  };
  const std::vector<RigidTransform> first = link_poses(way.front());
  for (std::size_t l = 0; l < centers.size(); ++l) {
    for (std::size_t i = 0; i < centers[l].size(); ++i) {
      at_W[l][i] = first[l] * centers[l][i];
      space->add_ball(at_W[l][i], balls_.links[l].radii[i] - options_.margin);
    }
  }
  for (std::size_t s = 1; s < way.size(); ++s) {
    const int steps = steps_between(way[s - 1], way[s], 0.5 * space->spacing());
    for (int i = 1; i < steps; ++i) {
      move_to(link_poses(between(way[s - 1], way[s], static_cast<double>(i) / steps)),
              kLeastMotion * space->spacing());
    }
    move_to(link_poses(way[s]), s + 1 < way.size() ? kLeastMotion * space->spacing() : 0);
  }
}

}  // namespace prehend::belief
