#include "prehend/belief/probe.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

namespace prehend::belief {
namespace {

constexpr int kMostCandidates = 120;

/// Least distance of the sites to the fingertip's centre on its way, to `stop` before the surface;
/// those that the way ends at are left out.
bool is_free(const std::vector<ObjectBelief::Site>& sites, const Eigen::Vector3d& at,
             const Eigen::Vector3d& out, const ProbeOptions& options) {
  constexpr double kMargin = 0.004;  // m
  const double touch = options.radius + 0.003;
  for (const ObjectBelief::Site& site : sites) {
    const Eigen::Vector3d r = site.p_W - at;
    const double along = r.dot(out);
    if (along <= touch) continue;
    const double aside = (r - std::min(along, options.reach) * out).norm();
    if (aside < options.radius + kMargin) return false;
  }
  return true;
}

/// Something was touched on the fingertip's way, or next to its end: it would be stopped there
/// again.
bool was_touched(const std::vector<Contact>& contacts, const Eigen::Vector3d& center,
                 const Eigen::Vector3d& out, const ProbeOptions& options) {
  constexpr double kSame = 0.002;  // m
  return std::any_of(contacts.begin(), contacts.end(), [&](const Contact& contact) {
    const Eigen::Vector3d r = contact.p_W - center;
    const double along = std::clamp(r.dot(out), 0.0, options.reach);
    return (r - along * out).norm() < options.radius + kSame;
  });
}

}  // namespace

void ProbeOptions::validate() const {
  const auto require = [](bool holds, const char* name) {
    if (!holds) {
      throw std::invalid_argument(std::string("ProbeOptions.") + name + " is out of range");
    }
  };
  require(radius > 0 && radius < 0.1, "radius");
  require(reach > 0 && reach < 1, "reach");
  require(beyond > 0 && beyond < 1, "beyond");
  require(clearance >= 0 && clearance < 1, "clearance");
  require(deviation > 0 && deviation < 1, "deviation");
  require(steepest_from_below >= 0 && steepest_from_below < 1.6, "steepest_from_below");
}

std::optional<Probe> best_probe(const ObjectBelief& belief, const ProbeOptions& options) {
  const std::vector<Probe> best = best_probes(belief, 1, options);
  return best.empty() ? std::nullopt : std::optional(best.front());
}

std::vector<Probe> best_probes(const ObjectBelief& belief, int count, const ProbeOptions& options,
                               double apart) {
  options.validate();
  if (count < 1) throw std::invalid_argument("best_probes: count must be positive");
  const std::vector<ObjectBelief::Site> sites = belief.sites();
  const Eigen::Vector3d& up = belief.table_W().normal;
  const double lowest = -std::sin(options.steepest_from_below);
  std::vector<std::pair<ObjectBelief::Site, Eigen::Vector3d>> reachable;
  for (const ObjectBelief::Site& site : sites) {
    if (site.seen) continue;
    Eigen::Vector3d out = site.normal_W;
    const double rise = out.dot(up);
    if (rise < -0.8) continue;  // it faces the support
    if (rise < lowest) out += (lowest - rise) * up;
    out.normalize();
    const Eigen::Vector3d center = site.p_W + options.radius * out;
    const double least_height = options.radius + options.clearance;
    if (belief.table_W().signed_distance(center) < least_height ||
        belief.table_W().signed_distance(center - options.beyond * out) < 0 ||
        belief.table_W().signed_distance(center + options.reach * out) < least_height) {
      continue;
    }
    reachable.emplace_back(site, out);
  }
  const std::size_t step = 1 + reachable.size() / kMostCandidates;
  std::vector<Probe> all;
  for (std::size_t i = 0; i < reachable.size(); i += step) {
    const auto& [site, out] = reachable[i];
    const Eigen::Vector3d center = site.p_W + options.radius * out;
    if (!is_free(sites, site.p_W, out, options) ||
        was_touched(belief.contacts(), center, out, options)) {
      continue;
    }
    const double gain =
        belief.expected_gain(site, options.deviation) / static_cast<double>(sites.size());
    all.push_back({center + options.reach * out, center - options.beyond * out, site.p_W, gain});
  }
  std::stable_sort(all.begin(), all.end(),
                   [](const Probe& a, const Probe& b) { return a.gain > b.gain; });
  std::vector<Probe> best;
  for (const Probe& probe : all) {
    if (best.size() == static_cast<std::size_t>(count)) break;
    const bool is_near = std::any_of(best.begin(), best.end(), [&](const Probe& other) {
      return (probe.at_W - other.at_W).norm() < apart;
    });
    if (!is_near) best.push_back(probe);
  }
  return best;
}

void add_probe(const Probe& probe, const Eigen::Vector3d& stopped_W,
               const std::optional<Contact>& contact, double radius, ObjectBelief* belief) {
  belief->swept().add_path(probe.start_W, stopped_W, radius);
  if (contact) belief->add(*contact);
}

}  // namespace prehend::belief
