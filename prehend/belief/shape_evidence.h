#pragma once

#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "prehend/belief/displacement.h"
#include "prehend/belief/evidence.h"
#include "prehend/belief/point_cells.h"
#include "prehend/belief/shape_hypothesis.h"
#include "prehend/geometry/plane.h"
#include "prehend/geometry/point_cloud.h"
#include "prehend/geometry/swept_space.h"
#include "prehend/shape/seen_space.h"

namespace prehend::belief {

/// All that was found out about an object, as one shape takes it in.
struct Evidence {
  /// Each with the number of acts that had begun, in an order that does not depend on when they
  /// came.
  std::vector<std::pair<Contact, int>> contacts;
  std::vector<Motion> motions;  // of the acts
  const geometry::SweptSpace* swept = nullptr;
  double swept_tolerance = 0;  // m
  geometry::Plane table_W;
  const geometry::PointCloud* seen = nullptr;     // of its surface, in other looks; with normals
  std::span<const shape::SeenSpace> seen_spaces;  // of all looks
};

/// One shape, and what the evidence makes of it.
class ShapeEvidence {
 public:
  explicit ShapeEvidence(ShapeHypothesis hypothesis);
  ShapeEvidence(const ShapeEvidence&) = delete;  // the displacement refers to the hypothesis
  ShapeEvidence& operator=(const ShapeEvidence&) = delete;

  /// Forgets what it was told before, and takes in all of this.
  void take_in(const Evidence& evidence);

  const ShapeHypothesis& hypothesis() const { return hypothesis_; }
  const Displacement& displacement() const { return *displacement_; }
  double log_likelihood() const { return log_likelihood_; }  // of the evidence
  double misfit() const { return displacement_->misfit(); }
  /// The same of how far along the surface contacts are from what they are thought to be of.
  double aside_misfit() const { return aside_misfit_; }
  /// Contacts with something that this shape does not have.
  const std::vector<Contact>& unexplained() const { return unexplained_; }
  /// How many of them are of no other part either: within the body, or where a look saw that
  /// nothing is.
  std::size_t impossible(const Evidence& evidence) const;

  /// Some of its points, spread over it, and where each is thought to be [m].
  const std::vector<int>& sites() const { return sites_; }
  const std::vector<Eigen::Vector3f>& places() const { return places_; }
  /// The site was seen, or is where something was seen.
  bool is_known(std::size_t site) const;

  /// Its points where they are thought to be, without those that would be in swept or seen space
  /// or double what was seen, with what other looks saw, and with discs where contacts are that it
  /// does not explain.
  geometry::PointCloud displaced(const Evidence& evidence) const;

 private:
  bool is_seen(int point) const;
  bool is_double(const Eigen::Vector3f& p, const Eigen::Vector3f& normal) const;
  bool is_replaced(const Eigen::Vector3f& p, const Eigen::Vector3f& normal,
                   const geometry::PointCloud& seen) const;
  std::optional<std::size_t> matched(const Contact& contact, int act,
                                     const Evidence& evidence) const;
  std::optional<Observation> observed(const Contact& contact, int act,
                                      const Evidence& evidence) const;
  std::optional<double> way_out(const Eigen::Vector3d& place, int point,
                                const geometry::SweptSpace& swept) const;
  void add_swept(const Evidence& evidence, std::vector<Observation>* observations) const;
  void condition(const Evidence& evidence, const std::vector<Observation>& observations);
  std::optional<std::size_t> contradiction(const Evidence& evidence,
                                           const std::vector<Observation>& observations,
                                           std::size_t first) const;
  /// @return the contacts that it explains, by their index, one for each of the observations.
  std::vector<std::size_t> take_in_contacts(const Evidence& evidence,
                                            std::vector<Observation>* observations);
  void take_in_swept(const Evidence& evidence, std::vector<Observation>* observations);

  ShapeHypothesis hypothesis_;
  double extent_ = 0;                // m
  std::vector<int> sites_;           // of the hypothesis' points
  std::vector<float> log_variance_;  // of the sites' displacement
  std::vector<Eigen::Vector3f> seen_points_, seen_normals_;
  PointCells seen_;
  std::vector<Eigen::Vector3f> places_;
  std::optional<Displacement> displacement_;
  std::vector<Contact> unexplained_;
  double log_likelihood_ = 0, aside_misfit_ = 0;
};

}  // namespace prehend::belief
