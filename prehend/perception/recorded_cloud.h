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

/// Whether a recording shows a table.
struct TableChoice {
  enum class Kind {
    kAuto,   // a table is looked for; a small cloud without one is one object
    kFind,   // there is one, to be found
    kNone,   // there is none: the cloud is one object
    kPlane,  // it is this one
  };
  Kind kind = Kind::kAuto;
  geometry::Plane plane_F;  // kPlane, file's frame, metres; normal towards the objects
};

struct RecordedCloudOptions {
  double scale = 1.0;  // metres per unit of the file
  /// Pose X_FC of the camera's optical frame (z forward, y down) in the file's frame F; wins over
  /// what the file says and over every guess. Metres, after scaling.
  std::optional<geometry::RigidTransform> viewpoint;
  std::optional<Eigen::Vector3d> up;  // direction in F, away from the table
  TableChoice table;
};

/// Options as words of a command line or a parameter; empty ones keep the defaults.
/// @param viewpoint "x y z qw qx qy qz" [m]. @param up "x y z". @param table "auto", "find",
/// "none", or "a b c d" for the plane a x + b y + c z = d [m] with (a, b, c) towards the objects.
/// All in the file's frame. @throws geometry::InputError naming the option and what it takes.
RecordedCloudOptions read_recorded_cloud_options(double scale, const std::string& viewpoint,
                                                 const std::string& up, const std::string& table);

/// A recorded cloud brought into the optical frame C of a real or virtual camera.
struct RecordedCloud {
  geometry::PointCloud cloud_C;
  geometry::PinholeCamera camera;                       // fitted (organized) or virtual
  geometry::RigidTransform X_FC;                        // camera in the file's frame
  std::optional<Eigen::Vector3d> up_C;                  // unit, if known or guessed
  std::optional<geometry::Plane> hypothetical_table_C;  // set: the whole cloud is one object
  std::optional<geometry::Plane> given_table_C;         // TableChoice::Kind::kPlane
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
/// A camera that is known may hang on its head or its side: where no table is below it within 10 m,
/// the first turn of its image by 180, 90 or -90 degrees that shows a table around things gives
/// up_C, with a note. A small cloud (under 0.6 m) without a plane that is seen around things is one
/// object, unless options.table says otherwise: it is put on a hypothetical table under its lowest
/// points. Points that are exactly zero are invalid, as NaN are. Up is options.up, else the
/// principal axis of an elongated object (nearest to the camera's up if the camera is known, else
/// with its dominant component positive), else the camera's up or the file's z. Where its viewpoint
/// was made up too, the points that this camera could not see are left out, as in any other view: a
/// model scanned from all sides is used like an object seen from one.
/// @throws geometry::InputError for an empty cloud, one without finite points, one point, collinear
/// or coplanar points, and one too large for metres (over 8 m), with its size in other units;
/// std::invalid_argument for a bad option.
RecordedCloud interpret_recorded_cloud(const geometry::CloudFile& file,
                                       const RecordedCloudOptions& options = {});

/// Of a cloud that is an image about so many points, of n x n one (binning_to() and binned() of
/// perception/binning.h), and the camera that sees those. A cloud that is no image or has fewer
/// stays as it is; points <= 0: all.
RecordedCloud thinned(RecordedCloud recorded, int points);

/// The world in which objects are given.
enum class RecordedWorld {
  kTable,  // made from the table, see segment_on_table
  kFile,   // the file's frame: several clouds in one frame have the same world
};

/// The objects of a recorded cloud: segment, or the whole cloud on its hypothetical table.
/// @throws geometry::InputError as segment, and for a cloud that is no image where things are to be
/// taken apart by what only images show.
SegmentedScene segment_recorded_cloud(const RecordedCloud& recorded,
                                      const SegmentationOptions& options = {},
                                      const TableOptions& table_options = {},
                                      RecordedWorld world = RecordedWorld::kTable);

}  // namespace prehend::perception
