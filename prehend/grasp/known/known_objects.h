#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "prehend/geometry/camera_model.h"
#include "prehend/geometry/image.h"
#include "prehend/geometry/plane.h"
#include "prehend/geometry/point_cloud.h"
#include "prehend/geometry/rigid_transform.h"
#include "prehend/geometry/triangle_mesh.h"

namespace prehend::grasp {

/// One object as a camera sees it.
struct SeenObject {
  geometry::PointCloud cloud_W;  // its points, not those of table and neighbours [m]
  geometry::PinholeCamera camera;
  geometry::RigidTransform X_WC = geometry::RigidTransform::Identity();  // optical frame
  geometry::DepthImage depth;  // of the whole view, of the camera's size [m], NaN: unknown
  std::optional<geometry::Plane> table_W;  // normal upwards: nothing of an object is below it
};

struct RecognitionOptions {
  double spacing = 0.005;    // m, > 0, of the points that are compared
  double tolerance = 0.004;  // m, > 0, that a seen point may be off the model's surface
  /// Share of the seen points, 0..1, that the model has to explain within the tolerance.
  double least_explained = 0.9;
  /// m, > 0: what the camera saw so far behind a point of the model shows that nothing is there.
  double free_margin = 0.012;
  /// Share of the model's surface that the camera should see, 0..1, that may stand in space that
  /// it saw to be free, or below the table.
  double most_violated = 0.1;
  /// m, >= 0: by so much the seen object may be larger or smaller than the model along each of the
  /// model's axes, beyond three standard deviations of what the points tell about that
  /// (size_estimate.h): stereo widens outlines, and models are not exact.
  double size_margin = 0.004;
  /// m, > 0: within it the errors of the sensor are alike, so that more points tell no more. Stereo
  /// matches in windows and widens outlines: it shifts whole strips of a surface. (At 15 mm the
  /// demo's can was 4 to 8 standard deviations larger than itself.)
  double correlation = 0.04;
  /// Pairs of points that are tried. The honest knob: more find poses of flat or round objects
  /// that fewer miss, in proportional time.
  int samples = 120000;
  int refined = 40;  // > 0, best poses of these that are refined, a fifth of them to the end
  std::uint64_t seed = 1;

  /// @throws std::invalid_argument naming the field that is out of range.
  void validate() const;
};

/// How one model fits what is seen.
struct Recognition {
  std::string hash;  // content_hash() of its mesh
  std::string name;
  geometry::RigidTransform X_WO = geometry::RigidTransform::Identity();
  double explained = 0;  // share of the seen points within the tolerance of its surface
  double violated = 0;   // share of its visible surface in free space or below the table
  double residual = 0;   // m, root mean square distance of the points explained
  /// m, by which the seen object is longer than the model along the axis that speaks most against
  /// it, and the standard deviation of that; 0 where fit, free space or table have refused already.
  double size_difference = 0, size_deviation = 0;
  bool accepted = false;
  std::string reason;  // why not, with the figures; "" when accepted

  /// What models are ranked by.
  double fitness() const { return explained - violated; }
};

/// Models of objects, to be found again in what a camera sees.
///
/// Seen points and points of the models are described by fast point feature histograms (Rusu,
/// Blodow, Beetz, "Fast Point Feature Histograms (FPFH) for 3D registration", ICRA 2009; by PCL).
/// Poses come from pairs of seen points and one of the sixty most similar points of the model for
/// each, where the distance and the angles of the normals agree (point pair features: Drost et al.,
/// "Model globally, match locally", CVPR 2010, equation 1; prerejective sample consensus: Buch et
/// al., "Pose estimation using local structure-specific shape and appearance context", ICRA 2013,
/// section III; PCL's own draws from the process' rand(), so it is neither
/// repeatable nor reentrant). The best are refined by point-to-plane ICP (Chen and Medioni,
/// "Object modelling by registration of multiple range images", 1992) against the exact surface.
/// A fit is believed only when the model explains the seen points, does not stand where the camera
/// looked through, and is not larger or smaller than the points tell: a can lies within the
/// tolerance of one that is a fifth wider all over its seen side, but curves otherwise. Const calls
/// may run in several threads; same input, same answer.
class KnownObjects {
 public:
  /// @throws std::invalid_argument as RecognitionOptions::validate.
  explicit KnownObjects(const RecognitionOptions& options = {});
  ~KnownObjects();
  KnownObjects(KnownObjects&&) noexcept;
  KnownObjects& operator=(KnownObjects&&) noexcept;

  /// Adds a model; some 10 ms. Normals are those of the triangles, outwards.
  /// @throws geometry::InputError for a mesh without area or with vertices that are not finite.
  void add(const std::string& name, const geometry::TriangleMesh& mesh_O);
  std::size_t size() const;

  /// All models, the best fit first; none is accepted when the object is not known. 0.1 to 0.5 s a
  /// model. @throws geometry::InputError for fewer than 30 finite points after thinning to the
  /// spacing, or a depth image that is not of the camera's size.
  std::vector<Recognition> recognise(const SeenObject& seen) const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace prehend::grasp
