#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "prehend/geometry/camera_model.h"
#include "prehend/geometry/cloud_files.h"
#include "prehend/geometry/plane.h"
#include "prehend/geometry/point_cloud.h"
#include "prehend/geometry/rigid_transform.h"
#include "prehend/perception/segmentation.h"
#include "prehend/perception/segmented_scene.h"

namespace prehend::perception {

struct RecordedCloudOptions {
  double scale = 1.0;  // metres per unit of the file
  /// Pose X_FC of the camera's optical frame (z forward, y down) in the file's frame F; wins over
  /// what the file says and over every guess. Metres, after scaling.
  std::optional<geometry::RigidTransform> viewpoint;
  std::optional<Eigen::Vector3d> up;  // direction in F, away from the table
  /// The cloud is one object without a table. Unset: decided from the cloud.
  std::optional<bool> single_object;
};

/// A recorded cloud brought into the optical frame C of a real or virtual camera.
struct RecordedCloud {
  geometry::PointCloud cloud_C;
  geometry::PinholeCamera camera;                       // fitted (organized) or virtual
  geometry::RigidTransform X_FC;                        // camera in the file's frame
  std::optional<Eigen::Vector3d> up_C;                  // unit, if known or guessed
  std::optional<geometry::Plane> hypothetical_table_C;  // set: the whole cloud is one object
  std::vector<std::uint32_t> labels;                    // of cloud_C's points, or empty
  std::vector<std::string> notes;  // what was assumed, in words, for the log and the report
};

/// Works out from which camera a cloud was seen; files often say it wrong. In this order:
///  1. options.viewpoint;
///  2. an organized cloud that is a pinhole image: optical frame, or turned by 180 degrees about x
///     when the camera looks along -z; a VIEWPOINT header that disagrees is ignored with a note;
///  3. an unorganized cloud wholly in front of the origin (z > 0, or z < 0: turned) within a
///     plausible field of view;
///  4. a VIEWPOINT header other than the identity that has the points in front of it;
///  5. else the cloud has no camera: a plausible_viewpoint is made up.
/// A small cloud without a plane that carries things is one object: it is put on a hypothetical
/// table under its lowest points. Up is options.up, else the principal axis of an elongated object
/// (nearest to the camera's up if the camera is known, else with its dominant component positive),
/// else the camera's up or the file's z. Where its viewpoint was made up too, the points that this
/// camera could not see are left out, as in any other view: a model scanned from all sides is used
/// like an object seen from one.
/// @throws geometry::InputError for an empty cloud, one without finite points, one point, collinear
/// or coplanar points, and one that looks like millimetres (extent over 20 m);
/// std::invalid_argument for a bad option.
RecordedCloud interpret_recorded_cloud(const geometry::CloudFile& file,
                                       const RecordedCloudOptions& options = {});

/// The world in which objects are given.
enum class RecordedWorld {
  kTable,  // made from the table, see segment_on_table
  kFile,   // the file's frame: several clouds in one frame have the same world
};

/// The objects of a recorded cloud: segment, or the whole cloud on its hypothetical table.
SegmentedScene segment_recorded_cloud(const RecordedCloud& recorded,
                                      const SegmentationOptions& options = {},
                                      const TableOptions& table_options = {},
                                      RecordedWorld world = RecordedWorld::kTable);

}  // namespace prehend::perception
