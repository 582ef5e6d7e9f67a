#pragma once

#include <string>
#include <vector>

#include "prehend/geometry/camera_model.h"
#include "prehend/geometry/image.h"
#include "prehend/geometry/point_cloud.h"
#include "prehend/geometry/triangle_mesh.h"

/// Pictures of what the robot saw, predicted and felt, for people to look at.
namespace prehend::report {

/// A colour that is told apart easily from those of the next indices.
geometry::Rgb category_color(int index);

/// `values` in false colour from low (blue) to high (red), NaN black. The range is the 2nd to the
/// 98th percentile of the known values. An image without any is black.
geometry::ColorImage color_values(const geometry::Image<float>& values);

/// `image` with each mask (same size; 255 inside) tinted and outlined in category_color(its index).
geometry::ColorImage overlay_masks(const geometry::ColorImage& image,
                                   const std::vector<geometry::MaskImage>& masks);

/// The finite points of `cloud_W` in `colors` (one each) as squares of `point_size` pixels, nearest
/// in front, on white; seen by `camera` at X_WC.
geometry::ColorImage draw_cloud(const geometry::PointCloud& cloud_W,
                                const std::vector<geometry::Rgb>& colors,
                                const geometry::PinholeCamera& camera,
                                const geometry::RigidTransform& X_WC, int point_size = 2);

struct ColoredMesh {
  geometry::TriangleMesh mesh_W;
  geometry::Rgb color{200, 200, 200};
};

/// The meshes, shaded by their angle to the camera, on white; seen by `camera` at X_WC.
geometry::ColorImage draw_meshes(const std::vector<ColoredMesh>& meshes,
                                 const geometry::PinholeCamera& camera,
                                 const geometry::RigidTransform& X_WC);

/// A tactile image (rows * columns values) in false colour, `cell` pixels a texel; `full` is white
/// hot, 0 black.
geometry::ColorImage draw_tactile(const std::vector<double>& values, int rows, int columns,
                                  double full, int cell = 18);

/// A cell of a tactile pad in the plane that it is drawn in, y up.
struct DrawnCell {
  Eigen::Vector2d center = Eigen::Vector2d::Zero();  // m
  double side = 0;                                   // m, of a square
  double value = 0;
};

/// A tactile image whose cells lie anywhere, those that come later in front, in the false colours
/// of draw_tactile(); `longest` pixels for its longer side. @throws std::invalid_argument without
/// cells, or when one has no size.
geometry::ColorImage draw_cells(const std::vector<DrawnCell>& cells, double full,
                                int longest = 216);

/// A camera of width x height pixels with the given horizontal field of view [rad].
geometry::PinholeCamera picture_camera(int width, int height, double field_of_view = 0.6);

/// Pose from which picture_camera's whole image shows a ball of `radius` [m] round `center_W`, from
/// the given azimuth and elevation [rad] in a frame whose z is up.
geometry::RigidTransform orbit(const Eigen::Vector3d& center_W, double radius, double azimuth,
                               double elevation, double field_of_view = 0.6);

/// PNG bytes. @throws std::runtime_error when the encoder fails.
std::string encode_png(const geometry::ColorImage& image);

}  // namespace prehend::report
