#pragma once

#include <functional>
#include <vector>

#include "prehend/geometry/camera_model.h"
#include "prehend/geometry/plane.h"
#include "prehend/geometry/point_cloud.h"
#include "prehend/perception/segmented_scene.h"

namespace prehend::perception {

/// Log odds that an object of the scene is one body, judged by what the view says of its completed
/// shape: shape::log_odds_of_one_body(). A function object, since shapes are made on the floor
/// above.
using BodyEvidence = std::function<double(const SegmentedScene&, const ObjectHypothesis&)>;

/// Knobs of splitting where two completed shapes explain a cluster better than one.
struct BodySplitOptions {
  /// By which the parts' mean log odds, weighted by points, exceed the whole's: what one more body
  /// must be worth. >= 0.
  double least_gain = 0.5;
  /// By which the worse part's log odds exceed the whole's.
  double least_part_gain = 0.2;
  double least_share = 0.04;  // of the cluster's points, for a part; in (0, 0.5]
  /// Round the border the surface is fitted within this [m] on either side, > 0. On the mean over
  /// the border the parts must lean towards each other: two bodies meet in a valley.
  double reach = 0.012;
};

/// A cluster of an organized cloud and what is about it.
struct ClusterView {
  const geometry::PointCloud& cloud_C;
  const geometry::PinholeCamera& camera;
  const geometry::Plane& table_C;
  std::vector<std::vector<int>> others;  // indices of the other objects' points: what hides it
};

/// Splits a cluster in two, and the parts again, as long as the completed shapes of both parts
/// agree with the view clearly better than that of the whole. Places to cut are inward creases
/// (splitting.h) and ledges (ledges.h) whatever the colours on either side. A part of which
/// `is_object` does not hold is none. What stands in a row across the view, symmetric as a whole,
/// stays whole; a body with a valley whose symmetry is not upright (a toy on its side) may be cut.
/// @param members indices of the cluster's points. @returns disjoint parts that together are
/// `members`, ascending, largest first. Cost: some 20 ms, and two completions for each place.
/// @throws std::invalid_argument for a cloud that is not organized, no evidence, or a bad option.
std::vector<std::vector<int>> split_into_bodies(
    const ClusterView& cluster, const std::vector<int>& members, const BodyEvidence& evidence,
    const std::function<bool(const std::vector<int>&)>& is_object,
    const BodySplitOptions& options = {});

}  // namespace prehend::perception
