#pragma once

#include <optional>
#include <string_view>

#include "prehend/geometry/camera_model.h"
#include "prehend/geometry/point_cloud.h"
#include "prehend/geometry/rigid_transform.h"
#include "prehend/perception/body_splitting.h"
#include "prehend/perception/ledges.h"
#include "prehend/perception/object_parts.h"
#include "prehend/perception/segmented_scene.h"
#include "prehend/perception/splitting.h"
#include "prehend/perception/table.h"

namespace prehend::perception {

/// How points become clusters.
enum class Clustering {
  kEuclidean,  // PCL, on voxels: any cloud
  kOrganized,  // organized_components(), on pixels: organized clouds; others get kEuclidean
};

/// What takes apart clusters of things that touch each other.
enum class Splitting {
  kNone,
  kTops,      // level tops at different heights, of any cloud: ledges.h
  kTouching,  // that, and creases between colours in organized clouds: splitting.h
  /// kTops, and creases and ledges of organized clouds, whatever their colours, where two completed
  /// shapes explain more than one: body_splitting.h. Needs SegmentationOptions::body_evidence.
  kShapes,
};

/// Whether it looks at a picture's neighbours, which clouds without an order have not.
bool needs_organized(Splitting splitting);

struct SegmentationOptions {
  Clustering clustering = Clustering::kEuclidean;
  /// Lower points belong to the table [m], up to 1 m depth; grows with depth squared beyond. 0: by
  /// the table's own noise, 4 to 8 mm.
  double min_height = 0;
  double max_height = 0.45;         // m over the table: higher points are dropped
  double max_distance = 2.5;        // m from the camera
  double cluster_tolerance = 0.02;  // m, gap that separates two objects
  double leaf_size = 0.005;         // m, voxels that are clustered; 0 clusters every point
  int pixel_reach = 4;     // kOrganized: pixels without a point that do not separate, 1..20
  double min_area = 5e-5;  // m^2 that is seen of the smallest object; of a high one 5 mm
                           // times its height: less is a rim behind something; of a long one
                           // 1.5 mm times its length: less is strewn along another one's edge
  double min_object_height = 0.006;  // m, lower clusters are dropped (paper), and those under 2.5
                                     // times min_height
  double hull_margin = 0.02;         // m, the table's outline is widened by this much
  int close_radius = 2;              // pixels, morphological closing of the masks; 0: none
  int max_objects = 20;
  /// m, of the stereo pair whose left image an organized cloud is: its right image ends earlier,
  /// and cuts what stands there; >= 0; 0: of a sensor that measures all that it sees.
  double baseline = 0;
  PartOptions parts;  // which clusters are one object
  Splitting split = Splitting::kTops;
  LedgeOptions ledges;
  SplitOptions splitting;
  BodySplitOptions body_splitting;
  /// kShapes leaves whole what is narrower [m] than that in one direction across the table, as far
  /// as it is seen: a hand that opens so wide may take it whether it is one body or two. >= 0; 0:
  /// nothing.
  double least_split_width = 0;
  BodyEvidence body_evidence;  // kShapes: shape::log_odds_of_one_body
};

/// Has things that touch taken apart by a name: none, tops, touching or shapes, see Splitting, or
/// wide: shapes, of what is wider across the table than the hand opens (`widest_opening` [m],
/// grasp::widest_opening(); 0: its fingers do not face each other, so that nothing is known to be
/// too wide, and `split` stays).
/// @throws geometry::InputError for another name, and for wide without an opening.
void choose_splitting(std::string_view name, std::optional<double> widest_opening,
                      SegmentationOptions* options);

/// The objects that stand on `table`: points over its convex outline, of organized clouds without
/// flying ones (organized_components.h), voxel grid, Euclidean clusters, parts of one object
/// joined, one mask each. Organized clouds give masks by pixel membership, others by projecting
/// splats with a depth test; small holes are closed. Largest object (points) first, ids 0, 1, ...
/// in that order. Objects cut by the image (of a stereo pair by either) or by max_height, or hidden
/// in part by another one are marked so; one that stands on another has that one's top as its
/// support. What is no object is in `dropped` with the reason; no object is not an error: `objects`
/// is empty.
/// @param cloud_C in the optical frame of `camera`; organized clouds must have the camera's size.
/// @param X_WC pose of the camera in the world. Without it the world is made from the table:
///   z = table normal, x = the camera's x projected into the table, origin = centroid of the
///   objects (or of the table) projected onto the table, so that the table is z = 0.
/// @throws std::invalid_argument for a bad option or a camera of another size.
SegmentedScene segment_on_table(const geometry::PointCloud& cloud_C,
                                const geometry::PinholeCamera& camera, const Table& table,
                                const std::optional<geometry::RigidTransform>& X_WC = std::nullopt,
                                const SegmentationOptions& options = {});

/// find_table, then segment_on_table. With X_WC, the world's +z is up for the table's tilt.
/// @throws geometry::InputError when there is no table.
SegmentedScene segment(const geometry::PointCloud& cloud_C, const geometry::PinholeCamera& camera,
                       const std::optional<geometry::RigidTransform>& X_WC = std::nullopt,
                       const SegmentationOptions& options = {},
                       const TableOptions& table_options = {});

/// Pose X_WC of the camera in the world made from a table (see segment_on_table); `anchor_C` [m] is
/// what the origin lies under.
geometry::RigidTransform world_from_table(const geometry::Plane& table_C,
                                          const Eigen::Vector3d& anchor_C);

/// The same scene in the world made from its table, as segment_on_table() makes it, whatever world
/// it was in: what simulated robots stand in.
SegmentedScene in_table_world(SegmentedScene scene);

}  // namespace prehend::perception
