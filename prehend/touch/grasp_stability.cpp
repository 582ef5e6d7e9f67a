#include "prehend/touch/grasp_stability.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace prehend::touch {
namespace {

constexpr double kLeastKept = 1e-2;  // of a pad's force, where it has lost the object

const std::vector<std::string> kClosedNames{
    "log_force", "log_squeeze", "net",          "facing",     "lever",
    "width",     "log_area",    "log_pressure", "log_torque", "least_margin",
    "margin",    "tip_margin",  "across",       "along",      "pads"};

// Pairs of pads that press against one another, by how much they do.
struct Opposed {
  double facing = 0, lever = 0, width = 0;
};

Opposed opposed(const std::vector<PadContact>& contacts) {
  Opposed mean;
  double weight = 0;
  for (const PadContact& a : contacts) {
    for (const PadContact& b : contacts) {
      const Eigen::Vector3d way = b.p_H - a.p_H;
      const double length = way.norm();
      const double w = a.force * b.force * std::max(0.0, -a.n_H.dot(b.n_H));
      if (!(w > 0 && length > 0)) continue;
      const double towards = way.dot(a.n_H);
      mean.facing += w * towards / length;
      mean.lever += w * std::sqrt(std::max(0.0, length * length - towards * towards));
      mean.width += w * length;
      weight += w;
    }
  }
  if (weight > 0) {
    mean.facing /= weight;
    mean.lever /= weight;
    mean.width /= weight;
  }
  return mean;
}

std::vector<double> closed_features(const Grip& grip) {
  if (grip.contacts.empty()) throw std::invalid_argument("grip_features: no pad touches anything");
  double force = 0, area = 0, torque = 0, margin = 0, tip_margin = 0;
  double least_margin = grip.contacts.front().margin;
  Eigen::Vector3d net = Eigen::Vector3d::Zero();
  Eigen::Vector2d spread = Eigen::Vector2d::Zero();
  for (const PadContact& contact : grip.contacts) {
    force += contact.force;
    area += contact.area;
    torque += contact.force * contact.arm;
    net += contact.force * contact.n_H;
    spread += contact.force * contact.spread;
    margin += contact.force * contact.margin;
    tip_margin += contact.force * contact.margin_to_tip;
    least_margin = std::min(least_margin, contact.margin);
  }
  const Opposed pairs = opposed(grip.contacts);
  return {std::log(force + 0.1),
          std::log((force - net.norm()) / 2 + 0.05),
          net.norm() / force,
          pairs.facing,
          pairs.lever,
          pairs.width,
          std::log(area),
          std::log(force / area),
          std::log(torque + 1e-4),
          least_margin,
          margin / force,
          tip_margin / force,
          spread.x() / force,
          spread.y() / force,
          static_cast<double>(grip.contacts.size())};
}

Eigen::VectorXd vector_of(const std::vector<double>& values) {
  return Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
}

double logistic(const GraspStability::Weighed& model, const Eigen::VectorXd& features) {
  const Eigen::ArrayXd units = (features - model.mean).array() / model.deviation.array();
  return 1 / (1 + std::exp(-(model.bias + units.matrix().dot(model.weight))));
}

}  // namespace

std::string to_string(GripMoment moment) {
  return moment == GripMoment::kClosed ? "closed" : "lifting";
}

double frame_change(const std::vector<PadFrame>& a, const std::vector<PadFrame>& b) {
  double changed = 0, all = 0;
  for (const PadFrame& then : a) {
    for (const PadFrame& now : b) {
      if (now.pad != then.pad || now.counts.size() != then.counts.size()) continue;
      for (std::size_t i = 0; i < now.counts.size(); ++i) {
        changed += std::abs(now.counts[i] - then.counts[i]);
        all += now.counts[i] + then.counts[i];
      }
    }
  }
  return all > 0 ? changed / all : 0;
}

const std::vector<std::string>& grip_feature_names(GripMoment moment) {
  static const std::vector<std::string> lifting = [] {
    std::vector<std::string> names = kClosedNames;
    for (const char* name : {"change", "log_kept", "log_least_kept", "shift", "area_change"}) {
      names.emplace_back(name);
    }
    return names;
  }();
  return moment == GripMoment::kClosed ? kClosedNames : lifting;
}

Eigen::VectorXd grip_features(const Grip& closed) { return vector_of(closed_features(closed)); }

Eigen::VectorXd grip_features(const Grip& closed, const Grip& lifting) {
  std::vector<double> features = closed_features(closed);
  double then = 0, now = 0, least_kept = 1, still = 0, shift = 0, area_change = 0;
  for (const PadContact& before : closed.contacts) {
    then += before.force;
    const auto after = std::find_if(lifting.contacts.begin(), lifting.contacts.end(),
                                    [&](const auto& one) { return one.pad == before.pad; });
    if (after == lifting.contacts.end()) {
      least_kept = 0;
      continue;
    }
    now += after->force;
    still += before.force;
    least_kept = std::min(least_kept, after->force / before.force);
    shift += before.force * (after->place - before.place).norm();
    area_change += before.force * std::abs(std::log(after->area / before.area));
  }
  features.push_back(frame_change(closed.frames, lifting.frames));
  features.push_back(std::log(std::max(kLeastKept, now / then)));
  features.push_back(std::log(std::max(kLeastKept, least_kept)));
  features.push_back(still > 0 ? shift / still : 0);
  features.push_back(still > 0 ? area_change / still : 0);
  return vector_of(features);
}

Grip pressed_harder(Grip grip, double factor) {
  for (PadContact& contact : grip.contacts) {
    contact.force *= factor;
    contact.largest_pressure *= factor;
  }
  for (PadFrame& frame : grip.frames) {
    for (double& count : frame.counts) count *= factor;
  }
  return grip;
}

GraspStability::GraspStability(Weighed closed, Weighed lifting)
    : closed_(std::move(closed)), lifting_(std::move(lifting)) {
  for (const GripMoment moment : {GripMoment::kClosed, GripMoment::kLifting}) {
    const Weighed& one = of(moment);
    const auto size = static_cast<Eigen::Index>(grip_feature_names(moment).size());
    const bool fits =
        one.mean.size() == size && one.deviation.size() == size && one.weight.size() == size;
    if (!fits || !one.mean.allFinite() || !one.weight.allFinite() || !std::isfinite(one.bias) ||
        !one.deviation.allFinite() || !(one.deviation.minCoeff() > 0)) {
      throw std::invalid_argument("GraspStability: '" + to_string(moment) + "' needs " +
                                  std::to_string(size) +
                                  " finite means and weights, and deviations above 0");
    }
  }
}

double GraspStability::probability(const Grip& closed, const Grip* lifting) const {
  if (closed.contacts.empty()) return 0;
  return lifting == nullptr ? logistic(closed_, grip_features(closed))
                            : logistic(lifting_, grip_features(closed, *lifting));
}

}  // namespace prehend::touch
