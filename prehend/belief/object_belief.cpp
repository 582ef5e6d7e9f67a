#include "prehend/belief/object_belief.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <stdexcept>
#include <tuple>
#include <utility>

#include <Eigen/Geometry>

#include "prehend/geometry/errors.h"

namespace prehend::belief {
namespace {

Eigen::AlignedBox3d bounds_of(const geometry::PointCloud& cloud) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3f& p : cloud.points) {
    if (geometry::is_finite(p)) box.extend(p.cast<double>());
  }
  return box;
}

/// The box of the shape and its alternatives, with room for what may be otherwise.
Eigen::AlignedBox3d room_of(const shape::CompletedShape& shape) {
  constexpr double kRoom = 0.3;  // of the extent
  Eigen::AlignedBox3d box = bounds_of(shape.cloud_W);
  for (const auto* others : {&shape.alternatives, &shape.other_methods}) {
    for (const auto& other : *others) box.extend(bounds_of(other.cloud_W));
  }
  if (box.isEmpty()) {
    throw geometry::InputError("the completed shape has no points", "complete the shape again");
  }
  const double room = kRoom * box.sizes().maxCoeff();
  return {box.min().array() - room, box.max().array() + room};
}

double spacing_for(const Eigen::AlignedBox3d& room, const BeliefOptions& options) {
  constexpr double kAcross = 96;
  return options.swept_spacing > 0 ? options.swept_spacing
                                   : std::max(1e-6, room.sizes().maxCoeff() / kAcross);
}

surface::SurfaceOptions coarse(const BeliefOptions& options) {
  surface::SurfaceOptions surface = options.surface;
  int& resolution = surface.fast_poisson.resolution;
  resolution = std::min(resolution, options.coarse_resolution);
  return surface;
}

}  // namespace

void BeliefOptions::validate() const {
  prior.validate();
  const auto require = [](bool holds, const char* name) {
    if (!holds) {
      throw std::invalid_argument(std::string("BeliefOptions.") + name + " is out of range");
    }
  };
  require(coarse_resolution >= 16 && coarse_resolution <= 1024, "coarse_resolution");
  require(swept_tolerance >= 0 && std::isfinite(swept_tolerance), "swept_tolerance");
  require(swept_spacing >= 0 && std::isfinite(swept_spacing), "swept_spacing");
}

ObjectBelief::ObjectBelief(const shape::CompletedShape& shape, const geometry::Plane& table_W,
                           const BeliefOptions& options)
    : options_((options.validate(), options)),
      table_W_(table_W),
      seen_spaces_{shape.seen_space},
      swept_(room_of(shape), spacing_for(room_of(shape), options)) {
  const auto add = [&](const shape::CompletedShape& one) {
    all_.push_back(std::make_unique<ShapeEvidence>(
        hypothesis_of(one, shape, table_W, options.prior, options.surface)));
  };
  std::optional<geometry::InputError> problem;
  try {
    add(shape);
  } catch (const geometry::InputError& error) {
    problem = error;
  }
  for (const auto* others : {&shape.alternatives, &shape.other_methods}) {
    for (const shape::CompletedShape& other : *others) {
      try {
        add(other);
      } catch (const geometry::InputError&) {
        // What gives no surface is no alternative.
      }
    }
  }
  if (all_.empty()) throw *problem;
  extent_ = bounds_of(all_.front()->hypothesis().points.cloud_W).sizes().maxCoeff();
  update();
}

void ObjectBelief::begin_act(const Motion& motion) {
  if (!(motion.along >= 0) || !(motion.turn >= 0) || !std::isfinite(motion.along) ||
      !std::isfinite(motion.turn)) {
    throw std::invalid_argument("ObjectBelief: an act's motion is no standard deviation");
  }
  motions_.push_back(motion);
}

void ObjectBelief::add(const Contact& contact) {
  if (!contact.p_W.allFinite() || !contact.normal_W.allFinite() || !(contact.deviation > 0) ||
      !std::isfinite(contact.deviation)) {
    throw std::invalid_argument("ObjectBelief: a contact is not finite or has no deviation");
  }
  if (!contact.normal_W.isZero() && std::abs(contact.normal_W.norm() - 1) > 1e-3) {
    throw std::invalid_argument("ObjectBelief: a contact's normal is not of unit length");
  }
  contacts_.push_back(contact);
  acts_.push_back(static_cast<int>(motions_.size()));
}

void ObjectBelief::add_seen(const geometry::PointCloud& seen_W) {
  if (seen_W.normals.size() != seen_W.points.size()) {
    throw std::invalid_argument("ObjectBelief: seen points have no normals");
  }
  for (std::size_t i = 0; i < seen_W.size(); ++i) {
    if (!geometry::is_finite(seen_W.points[i]) || !geometry::is_finite(seen_W.normals[i])) {
      throw std::invalid_argument("ObjectBelief: a seen point is not finite");
    }
  }
  seen_.points.insert(seen_.points.end(), seen_W.points.begin(), seen_W.points.end());
  seen_.normals.insert(seen_.normals.end(), seen_W.normals.begin(), seen_W.normals.end());
}

Evidence ObjectBelief::evidence() const {
  Evidence evidence;
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    evidence.contacts.emplace_back(contacts_[i], acts_[i]);
  }
  std::sort(evidence.contacts.begin(), evidence.contacts.end(), [](const auto& a, const auto& b) {
    const auto key = [](const std::pair<Contact, int>& one) {
      const Contact& c = one.first;
      return std::tuple(one.second, c.p_W.x(), c.p_W.y(), c.p_W.z(), c.deviation, c.normal_W.x(),
                        c.normal_W.y(), c.normal_W.z());
    };
    return key(a) < key(b);
  });
  evidence.motions = motions_;
  evidence.swept = &swept_;
  evidence.swept_tolerance = options_.swept_tolerance;
  evidence.table_W = table_W_;
  evidence.seen = &seen_;
  evidence.seen_spaces = seen_spaces_;
  return evidence;
}

void ObjectBelief::update() {
  const Evidence all_evidence = evidence();
  for (const auto& shape : all_) shape->take_in(all_evidence);
  // Evidence without measure (a place beyond all numbers) speaks against a shape for good.
  constexpr double kNone = -std::numeric_limits<double>::infinity();
  const auto log_weight = [&](std::size_t i) {
    const double weight = all_[i]->hypothesis().log_prior + all_[i]->log_likelihood();
    return std::isfinite(weight) ? weight : kNone;
  };
  order_.resize(all_.size());
  std::iota(order_.begin(), order_.end(), 0);
  std::stable_sort(order_.begin(), order_.end(),
                   [&](std::size_t a, std::size_t b) { return log_weight(a) > log_weight(b); });
  const double most = log_weight(order_.front());
  const auto share = [&](std::size_t i) {
    return std::isfinite(most) ? std::exp(log_weight(i) - most) : 1;  // then none is likelier
  };
  double sum = 0;
  for (const std::size_t i : order_) sum += share(i);
  shapes_.clear();
  for (const std::size_t i : order_) {
    shapes_.push_back({all_[i]->hypothesis().name, static_cast<int>(i), share(i) / sum,
                       all_[i]->misfit(), all_[i]->log_likelihood(),
                       all_[i]->hypothesis().prior_terms});
  }
  contradicted_ = std::all_of(all_.begin(), all_.end(), [&](const auto& shape) {
    return !(shape->misfit() + shape->aside_misfit() <= kContradiction * kContradiction) ||
           !std::isfinite(shape->log_likelihood()) ||
           2 * shape->unexplained().size() > contacts_.size() ||
           3 * shape->impossible(all_evidence) > contacts_.size();
  });
}

const std::vector<Displacement::Moved>& ObjectBelief::moved() const {
  return shape(0).displacement().moved();
}

geometry::TriangleMesh ObjectBelief::mesh(std::size_t i) const { return mesh(i, options_.surface); }

geometry::TriangleMesh ObjectBelief::coarse_mesh(std::size_t i) const {
  return mesh(i, coarse(options_));
}

geometry::TriangleMesh ObjectBelief::mesh(std::size_t i,
                                          const surface::SurfaceOptions& surface) const {
  surface::EmptySpace empty;
  for (const shape::SeenSpace& space : seen_spaces_) {
    if (!space.empty_until.empty()) empty.seen.push_back(&space);
  }
  if (!swept_.empty()) empty.swept = &swept_;
  return surface::reconstruct(shape(i).displaced(evidence()), table_W_, surface, empty,
                              shape(i).hypothesis().bounds_W);
}

std::vector<ObjectBelief::Site> ObjectBelief::sites() const {
  const ShapeEvidence& likeliest = shape(0);
  const Eigen::VectorXd variances = likeliest.displacement().variances(likeliest.sites());
  std::vector<Site> sites;
  for (std::size_t s = 0; s < likeliest.sites().size(); ++s) {
    const int point = likeliest.sites()[s];
    sites.push_back({likeliest.places()[s].cast<double>(),
                     likeliest.hypothesis().points.cloud_W.normals[point].cast<double>(),
                     std::sqrt(variances[static_cast<Eigen::Index>(s)]), likeliest.is_known(s),
                     point});
  }
  return sites;
}

double ObjectBelief::expected_gain(const Site& site, double deviation) const {
  const ShapeEvidence& likeliest = shape(0);
  std::vector<int> unknown;
  for (std::size_t s = 0; s < likeliest.sites().size(); ++s) {
    if (!likeliest.is_known(s)) unknown.push_back(likeliest.sites()[s]);
  }
  const Eigen::VectorXd covariance = likeliest.displacement().covariances(unknown, site.point);
  return covariance.squaredNorm() / (site.deviation * site.deviation + deviation * deviation);
}

}  // namespace prehend::belief
