#pragma once

#include <Eigen/Core>

namespace prehend::grasp {

using Vector6 = Eigen::Matrix<double, 6, 1>;
/// Wrenches as columns; see primitive_wrenches() in force_closure.h.
using Wrenches = Eigen::Matrix<double, 6, Eigen::Dynamic>;

/// The convex hull of wrenches, as far as the origin's place in it is concerned.
struct WrenchHull {
  /// The origin is strictly inside: the grasp holds against any wrench.
  bool closed = false;
  int rank = 0;  // dimensions of the hull; a closed grasp has 6
  /// Radius of the largest ball round the origin in the hull (Ferrari and Canny, "Planning optimal
  /// grasps", ICRA 1992), in the wrenches' unit; 0 when not closed.
  double epsilon = 0;
  /// The unit wrench that is resisted least, by epsilon times it; when not closed, one that is not
  /// resisted at all.
  Vector6 weakest = Vector6::Zero();
  double distance = 0;  // of the origin from the hull; 0 when it is inside or on it
  int facets = 0;       // that were made to know
};

struct WrenchHullOptions {
  /// Stop as soon as it is known whether the grasp is closed; epsilon is then a lower bound of the
  /// true one, above 0 when closed.
  bool closure_only = false;
  /// Stop when epsilon is known to this fraction of itself, in [0, 1): it is then a lower bound,
  /// and at most that much below the true one. 0: to rounding.
  double precision = 0;
  /// What counts as zero, as a fraction of the largest wrench. Larger than rounding, smaller than
  /// what friction makes of a grasp.
  double tolerance = 1e-9;
};

/// Whether `wrenches` can be closed at all, fast and on the safe side: false only when they lie in
/// one half-space, which their mean and the axes show. @pre finite columns.
bool may_be_closed(const Wrenches& wrenches);

/// Closure and epsilon. The point of the hull nearest to the origin (P. Wolfe, "Finding the nearest
/// point in a polytope", 1976) either separates them, or its points, with others to six dimensions,
/// make a simplex that holds the origin. That is grown: the facet nearest to the origin is moved
/// out to the farthest wrench along its normal until there is none farther (van den Bergen's
/// expanding polytope, in six dimensions). Only facets near the origin are made, where a hull
/// algorithm makes them all. Where facets are too thin for double precision, Qhull decides.
/// @throws std::invalid_argument for a wrench that is not finite or a bad tolerance.
WrenchHull wrench_hull(const Wrenches& wrenches, const WrenchHullOptions& options = {});

/// An upper bound of epsilon in a microsecond: how far the hull reaches along the six axes, both
/// ways, at least. 0 when it does not hold the origin along one of them. @pre finite columns.
double epsilon_bound(const Wrenches& wrenches);

/// Volume of the hull, by Qhull; 0 when it is flat. @throws std::invalid_argument as above.
double wrench_volume(const Wrenches& wrenches);

/// The whole hull by Qhull. The oracle of wrench_hull(), and slow: `closed`, `rank`, `epsilon` and
/// `weakest` alone are filled. @throws as above.
WrenchHull reference_wrench_hull(const Wrenches& wrenches, double tolerance = 1e-9);

}  // namespace prehend::grasp
