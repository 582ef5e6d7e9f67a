#include "prehend/belief/shape_evidence.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include <Eigen/Geometry>

namespace prehend::belief {
namespace {

constexpr int kMostSites = 1500;  // that are matched and tried
// Of contacts: each but the first with the shape as the one before displaced it.
constexpr int kMatchings = 2;
constexpr int kSweptRounds = 3;            // of sites that are found in swept space
constexpr int kMostInRound = 8;            // of them
constexpr double kFarthest = 0.6;          // of the extent, that a site leaves swept space
constexpr double kSweptDeviation = 0.001;  // m
constexpr float kLeastAlike = 0.5f;        // cosine of normals of a contact and the site it is of
constexpr float kUnexplained = 25;         // chi^2 of a contact's place: beyond, it is of no site
constexpr double kContradicting = 49;      // the same, beside what the others make expected
constexpr double kBeside =
    0.025;  // of the extent: what was seen there is told no better by a guess
constexpr float kWithin = 0.004f;      // m: no surface is so far within a body
constexpr double kBeforeSeen = 0.004;  // m: a guess so far before what was seen is wrong

double extent_of(const geometry::PointCloud& cloud) {
  Eigen::AlignedBox3f box;
  for (const Eigen::Vector3f& p : cloud.points) box.extend(p);
  return static_cast<double>(box.sizes().maxCoeff());
}

/// The points that were seen, or their normals.
std::vector<Eigen::Vector3f> of_seen(const ShapeHypothesis& hypothesis,
                                     const std::vector<Eigen::Vector3f>& values) {
  std::vector<Eigen::Vector3f> seen;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (hypothesis.points.basis[i] == surface::SurfaceOrigin::kSeen) seen.push_back(values[i]);
  }
  return seen;
}

/// A look saw that nothing is there.
bool is_seen_empty(const Eigen::Vector3d& p_W, std::span<const shape::SeenSpace> spaces) {
  return std::any_of(spaces.begin(), spaces.end(), [&](const shape::SeenSpace& space) {
    return !space.empty_until.empty() &&
           shape::depth_in_empty_space(space, space.X_WC.inverse(Eigen::Isometry) * p_W) >
               kBeforeSeen;
  });
}

/// A disc of the surface about a contact.
void add_disc(const Contact& contact, geometry::PointCloud* cloud) {
  constexpr double kSpacing = 0.0015;  // m
  constexpr int kRings = 3;
  if (contact.normal_W.isZero()) return;
  const Eigen::Vector3d x = contact.normal_W.unitOrthogonal(), y = contact.normal_W.cross(x);
  for (int ring = 0; ring <= kRings; ++ring) {
    const int count = std::max(1, 6 * ring);
    for (int i = 0; i < count; ++i) {
      const double angle = 2 * std::numbers::pi * i / count;
      const Eigen::Vector3d p =
          contact.p_W + ring * kSpacing * (std::cos(angle) * x + std::sin(angle) * y);
      cloud->points.push_back(p.cast<float>());
      cloud->normals.push_back(contact.normal_W.cast<float>());
    }
  }
}

}  // namespace

ShapeEvidence::ShapeEvidence(ShapeHypothesis hypothesis)
    : hypothesis_(std::move(hypothesis)),
      extent_(extent_of(hypothesis_.points.cloud_W)),
      seen_points_(of_seen(hypothesis_, hypothesis_.points.cloud_W.points)),
      seen_normals_(of_seen(hypothesis_, hypothesis_.points.cloud_W.normals)),
      seen_(seen_points_, kBeside * extent_) {
  const auto count = static_cast<int>(hypothesis_.deviation.size());
  const int step = 1 + (count - 1) / kMostSites;
  for (int i = 0; i < count; i += step) {
    sites_.push_back(i);
    log_variance_.push_back(std::log(hypothesis_.variance[i] + 1e-6f));
  }
}

bool ShapeEvidence::is_seen(int point) const {
  return hypothesis_.points.basis[point] == surface::SurfaceOrigin::kSeen;
}

bool ShapeEvidence::is_double(const Eigen::Vector3f& p, const Eigen::Vector3f& normal) const {
  constexpr float kAlike = 0.7f;  // cosine
  bool found = false;
  seen_.each_near(
      p, [&](std::size_t i, float) { found = found || seen_normals_[i].dot(normal) > kAlike; });
  return found;
}

/// Another look saw the side of the object that was guessed to be there: another place along its
/// normal.
bool ShapeEvidence::is_replaced(const Eigen::Vector3f& p, const Eigen::Vector3f& normal,
                                const geometry::PointCloud& seen) const {
  constexpr float kAlike = 0.7f;     // cosine
  constexpr double kFarther = 0.25;  // of the extent
  const auto beside = static_cast<float>(kBeside * extent_);
  const auto along = static_cast<float>(kFarther * extent_);
  for (std::size_t i = 0; i < seen.size(); ++i) {
    if (seen.normals[i].dot(normal) < kAlike) continue;
    const Eigen::Vector3f r = p - seen.points[i];
    const float way = r.dot(seen.normals[i]);
    if (std::abs(way) > along) continue;
    if (r.squaredNorm() - way * way < beside * beside) return true;
  }
  return false;
}

bool ShapeEvidence::is_known(std::size_t site) const {
  const int point = sites_[site];
  return is_seen(point) || is_double(places_[site], hypothesis_.points.cloud_W.normals[point]);
}

/// The site that a contact is most likely of: as far off along the normal as the site may be
/// displaced and the object moved, near it along the surface, and facing the same way. None when it
/// is not likely of any.
std::optional<std::size_t> ShapeEvidence::matched(const Contact& contact, int act,
                                                  const Evidence& evidence) const {
  const Eigen::Vector3d p_W =
      displacement_ ? displacement_->before_motions(contact.p_W, act) : contact.p_W;
  const Eigen::Vector3f p = p_W.cast<float>(), n = contact.normal_W.cast<float>();
  double noise = contact.deviation * contact.deviation;
  bool may_have_moved = false;
  for (int m = 0; m < act; ++m) {
    const Motion& motion = evidence.motions[m];
    noise += motion.along * motion.along + 0.25 * std::pow(motion.turn * extent_, 2);
    may_have_moved = may_have_moved || motion.along > 0 || motion.turn > 0;
  }
  const auto per_aside = static_cast<float>(1 / (hypothesis_.aside * hypothesis_.aside));
  const auto turned = n.isZero() ? 0 : static_cast<float>(2 * hypothesis_.normal_scale);
  float least = std::numeric_limits<float>::infinity(), of_place = 0;
  std::size_t best = 0;
  for (std::size_t s = 0; s < sites_.size(); ++s) {
    const Eigen::Vector3f& normal = hypothesis_.points.cloud_W.normals[sites_[s]];
    if (!n.isZero() && n.dot(normal) < kLeastAlike) continue;
    const Eigen::Vector3f r = p - places_[s];
    const float along = r.dot(normal);
    const float variance = hypothesis_.variance[sites_[s]] + static_cast<float>(noise);
    const float log_variance = may_have_moved ? std::log(variance) : log_variance_[s];
    const float chi_squared = along * along / variance +
                              (r.squaredNorm() - along * along) * per_aside +
                              turned * (1 - n.dot(normal));
    if (chi_squared + log_variance < least) {
      least = chi_squared + log_variance;
      of_place = chi_squared;
      best = s;
    }
  }
  if (least == std::numeric_limits<float>::infinity() || of_place > kUnexplained) {
    return std::nullopt;
  }
  return best;
}

std::optional<Observation> ShapeEvidence::observed(const Contact& contact, int act,
                                                   const Evidence& evidence) const {
  const std::optional<std::size_t> match = matched(contact, act, evidence);
  if (!match) return std::nullopt;
  const int point = sites_[*match];
  const Eigen::Vector3d n = hypothesis_.points.cloud_W.normals[point].cast<double>();
  const Eigen::Vector3d p = hypothesis_.points.cloud_W.points[point].cast<double>();
  return Observation{point, n.dot(contact.p_W - p), contact.deviation, act};
}

/// How far the site at `place` is to be displaced to leave swept space along its normal; none when
/// nothing of the body is left there.
std::optional<double> ShapeEvidence::way_out(const Eigen::Vector3d& place, int point,
                                             const geometry::SweptSpace& swept) const {
  const Eigen::Vector3d n = hypothesis_.points.cloud_W.normals[point].cast<double>();
  const double step = 0.5 * swept.spacing();
  for (double way = step; way < kFarthest * extent_; way += step) {
    if (!(swept.depth(place - way * n) > 0)) return way;
  }
  return std::nullopt;
}

/// Where sites are in swept space: the deepest, and others that are not about the same.
void ShapeEvidence::add_swept(const Evidence& evidence,
                              std::vector<Observation>* observations) const {
  std::vector<std::pair<double, std::size_t>> deepest;
  for (std::size_t s = 0; s < sites_.size(); ++s) {
    if (is_seen(sites_[s])) continue;
    const double depth = evidence.swept->depth(places_[s].cast<double>());
    if (depth > evidence.swept_tolerance) deepest.emplace_back(-depth, s);
  }
  std::sort(deepest.begin(), deepest.end());
  std::vector<std::size_t> chosen;
  const auto apart = static_cast<float>(0.5 * hypothesis_.correlation_length);
  for (const auto& [depth, s] : deepest) {
    if (chosen.size() == kMostInRound) break;
    const bool is_near = std::any_of(chosen.begin(), chosen.end(), [&](std::size_t other) {
      return (places_[s] - places_[other]).norm() < apart;
    });
    if (is_near) continue;
    const Eigen::Vector3d place = places_[s].cast<double>();
    const std::optional<double> way = way_out(place, sites_[s], *evidence.swept);
    if (!way) continue;
    chosen.push_back(s);
    const Eigen::Vector3d n = hypothesis_.points.cloud_W.normals[sites_[s]].cast<double>();
    const Eigen::Vector3d from = hypothesis_.points.cloud_W.points[sites_[s]].cast<double>();
    observations->push_back({sites_[s], n.dot(place - from) - *way, kSweptDeviation,
                             static_cast<int>(evidence.motions.size())});
  }
}

void ShapeEvidence::condition(const Evidence& evidence,
                              const std::vector<Observation>& observations) {
  displacement_.emplace(hypothesis_, evidence.table_W, evidence.motions, observations);
  places_ = displacement_->places(sites_);
}

/// Of the observations from `first` on the one that all others speak against, if they do: that
/// without which the others are likeliest.
std::optional<std::size_t> ShapeEvidence::contradiction(
    const Evidence& evidence, const std::vector<Observation>& observations,
    std::size_t first) const {
  if (observations.size() < 2) return std::nullopt;
  const Eigen::VectorXd misfits = displacement_->left_out_misfits();
  std::optional<std::size_t> worst;
  double most = -std::numeric_limits<double>::infinity();
  for (std::size_t i = first; i < observations.size(); ++i) {
    if (!(misfits[static_cast<Eigen::Index>(i)] > kContradicting)) continue;
    std::vector<Observation> others = observations;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(i));
    const Displacement without(hypothesis_, evidence.table_W, evidence.motions, std::move(others));
    if (!(without.log_likelihood() > most)) continue;
    most = without.log_likelihood();
    worst = i;
  }
  return worst;
}

std::vector<std::size_t> ShapeEvidence::take_in_contacts(const Evidence& evidence,
                                                         std::vector<Observation>* observations) {
  std::vector<std::size_t> explained;
  const auto erase = [](auto& list, std::size_t i) {
    list.erase(list.begin() + static_cast<std::ptrdiff_t>(i));
  };
  for (int matching = 0; matching < kMatchings; ++matching) {
    observations->clear();
    explained.clear();
    unexplained_.clear();
    for (std::size_t i = 0; i < evidence.contacts.size(); ++i) {
      const auto& [contact, act] = evidence.contacts[i];
      if (const auto observation = observed(contact, act, evidence)) {
        observations->push_back(*observation);
        explained.push_back(i);
      } else {
        unexplained_.push_back(contact);
      }
    }
    condition(evidence, *observations);
    while (const auto odd = contradiction(evidence, *observations, 0)) {
      unexplained_.push_back(evidence.contacts[explained[*odd]].first);
      erase(*observations, *odd);
      erase(explained, *odd);
      condition(evidence, *observations);
    }
  }
  return explained;
}

void ShapeEvidence::take_in_swept(const Evidence& evidence,
                                  std::vector<Observation>* observations) {
  const std::size_t contacts = observations->size();
  for (int round = 0; round < kSweptRounds; ++round) {
    const std::size_t before = observations->size();
    add_swept(evidence, observations);
    if (observations->size() == before) return;
    condition(evidence, *observations);
    // What contradicts the others is only cut away.
    while (const auto odd = contradiction(evidence, *observations, contacts)) {
      observations->erase(observations->begin() + static_cast<std::ptrdiff_t>(*odd));
      condition(evidence, *observations);
    }
  }
}

void ShapeEvidence::take_in(const Evidence& evidence) {
  displacement_.reset();
  places_.clear();
  for (const int i : sites_) places_.push_back(hypothesis_.points.cloud_W.points[i]);
  std::vector<Observation> observations;
  const std::vector<std::size_t> explained = take_in_contacts(evidence, &observations);
  log_likelihood_ = displacement_->log_likelihood() - 0.5 * static_cast<double>(kUnexplained) *
                                                          static_cast<double>(unexplained_.size());
  double aside = 0;
  for (std::size_t k = 0; k < explained.size(); ++k) {
    const auto& [contact, act] = evidence.contacts[explained[k]];
    const int point = observations[k].point;
    const Eigen::Vector3d n = hypothesis_.points.cloud_W.normals[point].cast<double>();
    const Eigen::Vector3d r = displacement_->before_motions(contact.p_W, act) -
                              displacement_->places({point}).front().cast<double>();
    aside += (r - n.dot(r) * n).squaredNorm();
    if (contact.normal_W.isZero()) continue;
    log_likelihood_ -= hypothesis_.normal_scale * (1 - n.dot(contact.normal_W));
  }
  aside /= hypothesis_.aside * hypothesis_.aside;
  log_likelihood_ -= 0.5 * aside;
  aside_misfit_ = explained.empty() ? 0 : aside / static_cast<double>(explained.size());
  if (!evidence.swept || evidence.swept->empty()) return;
  const auto chi_squared = [&] {
    return displacement_->misfit() * static_cast<double>(observations.size());
  };
  const double touched = chi_squared();
  take_in_swept(evidence, &observations);
  // Of what is only known not to be there, the density says nothing: its misfit counts.
  log_likelihood_ -= 0.5 * std::max(0.0, chi_squared() - touched);
}

std::size_t ShapeEvidence::impossible(const Evidence& evidence) const {
  const auto is_within = [&](const Eigen::Vector3f& p) {
    float least = std::numeric_limits<float>::infinity(), over = 0;
    for (std::size_t s = 0; s < sites_.size(); ++s) {
      const Eigen::Vector3f r = p - places_[s];
      if (r.squaredNorm() >= least) continue;
      least = r.squaredNorm();
      over = r.dot(hypothesis_.points.cloud_W.normals[sites_[s]]);
    }
    return over < -kWithin;
  };
  return static_cast<std::size_t>(
      std::count_if(unexplained_.begin(), unexplained_.end(), [&](const Contact& contact) {
        return is_within(contact.p_W.cast<float>()) ||
               is_seen_empty(contact.p_W, evidence.seen_spaces);
      }));
}

geometry::PointCloud ShapeEvidence::displaced(const Evidence& evidence) const {
  const geometry::PointCloud& before = hypothesis_.points.cloud_W;
  std::vector<int> all(before.size());
  std::iota(all.begin(), all.end(), 0);
  const std::vector<Eigen::Vector3f> places = displacement_->places(all);
  const auto is_there = [&](std::size_t i) {
    const Eigen::Vector3d p_W = places[i].cast<double>();
    const bool is_swept = evidence.swept && evidence.swept->depth(p_W) > evidence.swept_tolerance;
    return !is_swept && !is_seen_empty(p_W, evidence.seen_spaces) &&
           !is_double(places[i], before.normals[i]) &&
           !(evidence.seen && is_replaced(places[i], before.normals[i], *evidence.seen));
  };
  geometry::PointCloud cloud;
  const auto add = [&cloud](const Eigen::Vector3f& p, const Eigen::Vector3f& normal) {
    cloud.points.push_back(p);
    cloud.normals.push_back(normal);
  };
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (is_seen(static_cast<int>(i)) || is_there(i)) add(places[i], before.normals[i]);
  }
  for (std::size_t i = 0; evidence.seen && i < evidence.seen->size(); ++i) {
    const Eigen::Vector3f& p = evidence.seen->points[i];
    if (!is_seen_empty(p.cast<double>(), evidence.seen_spaces)) add(p, evidence.seen->normals[i]);
  }
  for (const Contact& contact : unexplained_) add_disc(contact, &cloud);
  return cloud;
}

}  // namespace prehend::belief
