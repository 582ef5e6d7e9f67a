#pragma once

#include <vector>

#include "prehend/geometry/plane.h"
#include "prehend/geometry/point_cloud.h"
#include "prehend/perception/segmented_scene.h"

namespace prehend::perception {

struct MergeOptions {
  /// Two hypotheses are the same object when this share of the points of either is over the
  /// other's convex footprint.
  double min_footprint_overlap = 0.35;  // 0..1
  double footprint_margin = 0.01;       // m by which a footprint is widened
  /// Correct each view's pose by iterative closest points against the views before it.
  bool align = false;
  double max_correspondence = 0.015;  // m, farther points are not each other's
  int max_iterations = 30;            // of the alignment
  double leaf_size = 0.003;           // m, voxels that are aligned
  double min_correspondences = 0.3;   // 0..1 of the view's voxels, else its pose is kept
};

/// An object as seen in several views of one world.
struct MergedObject {
  geometry::PointCloud cloud_W;  // of all views, in their order
  std::vector<int> view;         // of each point
  std::vector<int> hypothesis;   // in each view the index into its objects; -1: not seen there
};

/// Several views in one world frame.
struct MergedViews {
  std::vector<SegmentedScene> views;  // their poses corrected when asked for
  geometry::Plane table_W;            // mean of the views' tables
  std::vector<MergedObject> objects;  // most points first
};

/// Merges views with known poses: one cloud for each object and its mask in each view
/// (`views[v].objects[hypothesis[v]].mask`). Objects that no view sees both ways stay apart; the
/// hypotheses of one view are never merged with each other.
///
/// The alignment is point-to-point (Besl and McKay, "A method for registration of 3-D shapes", PAMI
/// 1992) with pairs beyond `max_correspondence` left out. A view keeps its pose when few of its
/// points have a partner or the correction would move one by more than `max_correspondence`: views
/// that share flat faces only can slide along them.
/// @throws geometry::InputError without views or when the tables of two views differ by more than
/// 20 degrees or 5 cm (the poses are wrong); std::invalid_argument for a bad option.
MergedViews merge_views(std::vector<SegmentedScene> views, const MergeOptions& options = {});

/// The merged objects as one scene, for what works on one view: seen by the camera of the view that
/// has most of the objects (of equals the first), with the masks of that view; objects that it does
/// not have get the mask of their merged points, splatted. An object is cut by the image's border
/// when it is in every view that has it; `occluded_share` is the least of these views, and it
/// `may_be_several` when it is in all.
/// @pre merge_views() made it.
SegmentedScene as_scene(const MergedViews& merged);

}  // namespace prehend::perception
