#include <algorithm>
#include <optional>

#include "eval/belief/toucher.h"

namespace prehend::eval {
namespace {

/// Where the fingertip's centre is stopped, and what it touches there; nothing at the probe's end.
struct Stopped {
  Eigen::Vector3d center_W;
  std::optional<Eigen::Vector3d> touched_W, normal_W;
};
Stopped moved_until_touch(const belief::Probe& probe, double radius,
                          const geometry::MeshQuery& truth) {
  constexpr double kTouches = 2e-5;  // m
  const Eigen::Vector3d way = probe.end_W - probe.start_W;
  const double length = way.norm();
  double gone = 0;
  while (true) {
    const Eigen::Vector3d center = probe.start_W + gone / length * way;
    const auto nearest = truth.nearest(center);
    const double clearance = nearest->distance - radius;
    if (clearance < kTouches) {
      return {center, nearest->point, (center - nearest->point).normalized()};
    }
    if (gone >= length) return {probe.end_W, std::nullopt, std::nullopt};
    gone = std::min(length, gone + clearance);
  }
}

belief::Contact felt(const Stopped& stopped, const TouchNoise& noise, std::mt19937_64& random) {
  std::normal_distribution<double> normal(0, 1);
  belief::Contact contact;
  contact.normal_W = *stopped.normal_W;
  for (int axis = 0; axis < 3; ++axis) contact.normal_W[axis] += noise.normal * normal(random);
  contact.normal_W.normalize();
  contact.p_W = *stopped.touched_W + noise.place * normal(random) * *stopped.normal_W;
  contact.deviation = 0.001;
  return contact;
}

}  // namespace

std::string FingertipToucher::touch(const geometry::MeshQuery& truth_W, Told told,
                                    belief::ObjectBelief* belief) {
  const belief::ProbeOptions probing;
  const auto probe = belief::best_probe(*belief, probing);
  if (!probe) return "no part of it can be reached";
  const Stopped stopped = moved_until_touch(*probe, probing.radius, truth_W);
  std::optional<belief::Contact> contact;
  if (stopped.touched_W) contact = felt(stopped, noise_, random_);
  belief->begin_act();
  if (told == Told::kContacts) {
    if (contact) belief->add(*contact);
  } else {
    belief::add_probe(*probe, stopped.center_W, contact, probing.radius, belief);
  }
  return "";
}

}  // namespace prehend::eval
