#include "prehend/perception/recorded_cloud.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>
#include <utility>

#include <Eigen/Eigenvalues>

#include "prehend/geometry/errors.h"
#include "prehend/perception/binning.h"
#include "prehend/perception/cloud_partition.h"
#include "prehend/perception/masks.h"
#include "prehend/perception/virtual_camera.h"

namespace prehend::perception {
namespace {

using geometry::InputError;
using geometry::Plane;
using geometry::PointCloud;
using geometry::RigidTransform;

constexpr double kLargestExtent = 8;       // m, more is not in metres
constexpr double kSmallestExtent = 0.003;  // m, less looks like a wrong scale
constexpr double kFlatness = 1e-3;         // ratio of deviations under which a cloud has no depth
constexpr double kPinholeShare = 0.8;      // inliers of a cloud that is an image
constexpr double kFrontShare = 0.98;       // points in front of a camera that saw them
constexpr double kWidestTangent = 1.5;     // of half the plausible field of view, 56 degrees
constexpr double kObjectExtent = 0.6;      // m, the largest cloud that may be one object
constexpr double kElongation = 1.3;        // ratio of deviations that tells an axis
constexpr double kUprightCosine = 0.77;    // 40 degrees: an axis that near to up is up
constexpr double kTableGap = 0.0005;       // m between an object and its hypothetical table

struct Shape {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Vector3d deviations = Eigen::Vector3d::Zero();  // ascending [m]
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
  Eigen::Vector3d extent = Eigen::Vector3d::Zero();  // between the 2 % and 98 % quantiles [m]
};

Shape shape_of(const PointCloud& cloud) {
  Shape shape;
  std::array<std::vector<float>, 3> values;
  for (const Eigen::Vector3f& p : cloud.points) {
    if (!geometry::is_finite(p)) continue;
    for (int k = 0; k < 3; ++k) values[k].push_back(p[k]);
  }
  const std::size_t n = values[0].size();
  if (n == 0) return shape;
  shape.mean = geometry::centroid(cloud);
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < n; ++i) {
    const Eigen::Vector3d d =
        Eigen::Vector3f(values[0][i], values[1][i], values[2][i]).cast<double>() - shape.mean;
    scatter += d * d.transpose() / static_cast<double>(n);
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(scatter);
  shape.deviations = solver.eigenvalues().cwiseMax(0).cwiseSqrt();
  shape.axes = solver.eigenvectors();
  for (int k = 0; k < 3; ++k) {
    std::sort(values[k].begin(), values[k].end());
    shape.extent[k] =
        static_cast<double>(values[k][(n - 1) - n / 50]) - static_cast<double>(values[k][n / 50]);
  }
  return shape;
}

std::string text(const char* format, double value) {
  std::array<char, 128> buffer{};
  std::snprintf(buffer.data(), buffer.size(), format, value);
  return buffer.data();
}

void check_cloud(const PointCloud& cloud, const Shape& shape) {
  std::size_t finite = 0;
  for (const Eigen::Vector3f& p : cloud.points) finite += geometry::is_finite(p);
  const std::string again = "Record the cloud again";
  if (cloud.empty()) throw InputError("The cloud is empty", again);
  if (finite == 0) {
    throw InputError(
        "The cloud has no valid point: all " + std::to_string(cloud.size()) + " are NaN", again);
  }
  if (finite == 1) throw InputError("The cloud has only one valid point", again);
  if (shape.extent.maxCoeff() > kLargestExtent) {
    const double extent = shape.extent.maxCoeff();
    throw InputError("The cloud would be " + text("%.4g", extent) +
                         " m large, so its unit is not the metre. It is " +
                         text("%.3g", 0.0254 * extent) + " m large if it is in inches, " +
                         text("%.3g", 0.01 * extent) + " m if in centimetres, " +
                         text("%.3g", 0.001 * extent) + " m if in millimetres",
                     "Pass the scale that is right: 0.0254, 0.01 or 0.001");
  }
  if (shape.deviations[2] < 1e-9) {
    throw InputError("All " + std::to_string(finite) + " valid points of the cloud are one point",
                     again);
  }
  if (shape.deviations[1] < kFlatness * shape.deviations[2]) {
    throw InputError("The cloud's points are collinear: they lie on one line", again);
  }
  if (shape.deviations[0] < kFlatness * shape.deviations[2]) {
    throw InputError("The cloud's points are coplanar: there is a plane, but nothing on it",
                     "Record a cloud with objects");
  }
  if (shape.extent.maxCoeff() < kSmallestExtent) {
    throw InputError("The cloud is only " + text("%.3g", shape.extent.maxCoeff()) + " m large",
                     "Pass a larger scale");
  }
}

bool is_identity(const RigidTransform& X) { return X.isApprox(RigidTransform::Identity(), 1e-6); }

// Share of the finite points with z * sign > 0 whose direction is within the field of view.
double share_in_view(const PointCloud& cloud, double sign) {
  double seen = 0;
  double count = 0;
  for (const Eigen::Vector3f& p : cloud.points) {
    if (!geometry::is_finite(p)) continue;
    count += 1;
    const double z = sign * static_cast<double>(p.z());
    seen += z > 0.05 && static_cast<double>(p.head<2>().norm()) < kWidestTangent * z;
  }
  return seen / std::max(count, 1.0);
}

RigidTransform turned_about_x() {
  RigidTransform X = RigidTransform::Identity();
  X.linear() = Eigen::Vector3d(1, -1, -1).asDiagonal();
  return X;
}

// The pose of the camera that made an organized cloud, from the order of its pixels.
std::optional<RigidTransform> pose_from_pixels(const PointCloud& cloud) {
  if (!cloud.organized()) return std::nullopt;
  const FittedCamera fitted = fit_camera(cloud);
  if (fitted.inlier_share < kPinholeShare) return std::nullopt;
  double behind = 0;
  double count = 0;
  for (const Eigen::Vector3f& p : cloud.points) {
    if (!geometry::is_finite(p)) continue;
    count += 1;
    behind += p.z() < 0;
  }
  if (std::min(behind, count - behind) > (1 - kFrontShare) * count) return std::nullopt;
  const Eigen::Vector3d signs(fitted.x_flipped ? -1 : 1, fitted.y_flipped ? -1 : 1,
                              2 * behind > count ? -1 : 1);
  if (signs.prod() < 0) {
    throw InputError(
        "The organized cloud is mirrored: its pixel order and its axes do not belong "
        "to one camera",
        "Export it with rows from the top and columns from the left");
  }
  RigidTransform X_FC = RigidTransform::Identity();
  X_FC.linear() = signs.asDiagonal();
  return X_FC;
}

// A direction up for a cloud without camera.
Eigen::Vector3d guess_up_without_camera(const Shape& shape, std::vector<std::string>& notes) {
  const bool elongated = shape.deviations[2] > kElongation * shape.deviations[1] &&
                         shape.extent.maxCoeff() < kObjectExtent;
  if (!elongated) {
    notes.emplace_back("up is unknown: the file's +z is taken");
    return Eigen::Vector3d::UnitZ();
  }
  Eigen::Vector3d up = shape.axes.col(2);
  Eigen::Index dominant = 0;
  up.cwiseAbs().maxCoeff(&dominant);
  if (up[dominant] < 0) up = -up;
  notes.push_back("up is unknown: the long axis (" + text("%.2f ", up.x()) + text("%.2f ", up.y()) +
                  text("%.2f", up.z()) + " in the file) is taken");
  return up;
}

struct Viewpoint {
  RigidTransform X_FC = RigidTransform::Identity();
  bool made_up = false;
};

// See the header for the order.
Viewpoint find_viewpoint(const PointCloud& cloud_F, const geometry::CloudFile& file,
                         const RecordedCloudOptions& options, const Shape& shape,
                         std::optional<Eigen::Vector3d>& up_F, std::vector<std::string>& notes) {
  const bool header_says = file.viewpoint && !is_identity(*file.viewpoint);
  const auto note_ignored_header = [&] {
    if (header_says) {
      notes.emplace_back(
          "the file's VIEWPOINT is ignored: the points are in the frame of a camera "
          "at the origin");
    }
  };
  const auto note_turned = [&](const RigidTransform& X_FC) {
    if (!is_identity(X_FC)) {
      notes.emplace_back("the file's camera axes are turned to x right, y down, z forward");
    }
  };
  if (options.viewpoint) return {*options.viewpoint};
  if (const auto X_FC = pose_from_pixels(cloud_F)) {
    note_ignored_header();
    note_turned(*X_FC);
    return {*X_FC};
  }
  for (const double sign : {1.0, -1.0}) {
    if (share_in_view(cloud_F, sign) < kFrontShare) continue;
    const RigidTransform X_FC = sign > 0 ? RigidTransform::Identity() : turned_about_x();
    note_ignored_header();
    note_turned(X_FC);
    return {X_FC};
  }
  if (header_says) {
    RigidTransform X_FC = *file.viewpoint;
    X_FC.translation() *= options.scale;
    const PointCloud cloud_C = geometry::transformed(cloud_F, X_FC.inverse());
    if (share_in_view(cloud_C, 1) >= kFrontShare) {
      notes.emplace_back("the file's VIEWPOINT is used");
      return {X_FC};
    }
    if (share_in_view(cloud_C, -1) >= kFrontShare) {
      notes.emplace_back("the file's VIEWPOINT is used, turned to look forward");
      return {X_FC * turned_about_x()};
    }
  }
  if (!up_F) up_F = guess_up_without_camera(shape, notes);
  const RigidTransform X_FC = plausible_viewpoint(cloud_F, *up_F);
  const Eigen::Vector3d eye = X_FC.translation();
  notes.push_back("the viewpoint is unknown: a virtual camera is put at (" +
                  text("%.2f ", eye.x()) + text("%.2f ", eye.y()) + text("%.2f", eye.z()) +
                  ") m of the file; give viewpoint:= if you know it");
  return {X_FC, true};
}

// Sets cloud, camera and labels; points behind the camera are dropped from unorganized clouds.
void set_camera_and_cloud(RecordedCloud& recorded, const PointCloud& cloud_F,
                          const std::vector<std::uint32_t>& labels) {
  PointCloud cloud_C = geometry::transformed(cloud_F, recorded.X_FC.inverse());
  if (cloud_C.organized()) {
    const FittedCamera fitted = fit_camera(cloud_C);
    if (fitted.inlier_share >= kPinholeShare && !fitted.x_flipped && !fitted.y_flipped) {
      recorded.camera = fitted.camera;
      recorded.cloud_C = std::move(cloud_C);
      recorded.labels = labels;
      return;
    }
    recorded.notes.emplace_back("the cloud's rows and columns are no image from this viewpoint");
  }
  std::vector<int> indices;
  for (std::size_t i = 0; i < cloud_C.size(); ++i) {
    const Eigen::Vector3f& p = cloud_C.points[i];
    if (geometry::is_finite(p) && p.z() > 1e-3F) indices.push_back(static_cast<int>(i));
  }
  if (indices.empty()) {
    throw InputError("No point of the cloud is in front of the viewpoint", "Correct viewpoint");
  }
  recorded.cloud_C = geometry::select(cloud_C, indices);
  if (!labels.empty()) {
    for (const int i : indices) recorded.labels.push_back(labels[i]);
  }
  recorded.camera = make_virtual_camera(recorded.cloud_C);
  recorded.notes.push_back("a virtual camera of " + std::to_string(recorded.camera.width) + " x " +
                           std::to_string(recorded.camera.height) + " pixels is used");
}

// Whether the plane is seen around or under what stands on it. The face of a body has its other
// faces beside it, not within it.
bool is_around_things(const PointCloud& cloud_C, const Table& table) {
  constexpr double kMostCovered = 0.6;  // of the table's outline, by what is over it
  if (table.object_points == 0) return false;
  std::vector<Eigen::Vector3f> corners, above;
  for (const Eigen::Vector3d& p : table.hull_C) corners.push_back(p.cast<float>());
  const PlaneOutline outline(table.plane_C, corners);
  constexpr double kOver = 0.015;  // m
  for (const Eigen::Vector3f& p : cloud_C.points) {
    if (!geometry::is_finite(p)) continue;
    const Eigen::Vector3d at = p.cast<double>();
    if (table.plane_C.signed_distance(at) > kOver && outline.contains(at, 0)) above.push_back(p);
  }
  if (above.size() < 3) return false;
  try {
    return PlaneOutline(table.plane_C, above).area() < kMostCovered * outline.area();
  } catch (const InputError&) {
    return true;  // what is over it is a line on it
  }
}

// A camera may hang on its head, or on its side: where no table is below, however far, the first
// turn of the image that shows one around things is taken.
void find_up(RecordedCloud& recorded) {
  if (recorded.up_C) return;
  TableOptions however_far;
  however_far.max_distance = 10;
  try {
    find_table(recorded.cloud_C, however_far);
    return;
  } catch (const InputError&) {
    // None is below.
  }
  for (const auto& [degrees, how] :
       {std::pair{180, "on its head"}, {90, "on its side"}, {-90, "on its side"}}) {
    const RigidTransform turn =
        geometry::make_transform(Eigen::Quaterniond(Eigen::AngleAxisd(
                                     degrees * std::numbers::pi / 180, Eigen::Vector3d::UnitZ())),
                                 Eigen::Vector3d::Zero());
    const PointCloud turned = geometry::transformed(recorded.cloud_C, turn);
    try {
      const Table table = find_table(turned);
      if (!is_around_things(turned, table)) continue;
      recorded.up_C = turn.linear().transpose() * table.plane_C.normal;
      recorded.notes.push_back("the camera is " + std::string(how) + ": so a table is below");
      return;
    } catch (const InputError&) {
      // The next turn, or the words of the search in segment_recorded_cloud().
    }
  }
}

bool is_single_object(const RecordedCloud& recorded, const RecordedCloudOptions& options,
                      const Shape& shape) {
  if (options.table.kind != TableChoice::Kind::kAuto) {
    return options.table.kind == TableChoice::Kind::kNone;
  }
  constexpr double kThinnest = 0.002;  // m, deviation: less is a plane, an empty table
  if (shape.extent.norm() > kObjectExtent || shape.deviations[0] < kThinnest) return false;
  try {
    return !is_around_things(recorded.cloud_C, find_table(recorded.cloud_C, {}, recorded.up_C));
  } catch (const InputError&) {
    return true;  // small, and no plane in it could be a table
  }
}

void put_on_hypothetical_table(RecordedCloud& recorded, bool up_known) {
  const Shape shape = shape_of(recorded.cloud_C);
  if (!up_known) {
    const Eigen::Vector3d camera_up = recorded.up_C.value_or(-Eigen::Vector3d::UnitY());
    Eigen::Vector3d up = camera_up;
    const Eigen::Vector3d axis =
        shape.axes.col(2) * (shape.axes.col(2).dot(camera_up) < 0 ? -1 : 1);
    if (shape.deviations[2] > kElongation * shape.deviations[1] &&
        axis.dot(camera_up) > kUprightCosine) {
      up = axis;
      recorded.notes.emplace_back("up is unknown: the object's long axis is taken");
    } else if (!recorded.up_C) {
      recorded.notes.emplace_back("up is unknown: the camera's up is taken");
    }
    recorded.up_C = up;
  }
  Plane table{*recorded.up_C, 1e9};
  for (const Eigen::Vector3f& p : recorded.cloud_C.points) {
    table.offset = std::min(table.offset, table.normal.dot(p.cast<double>()));
  }
  table.offset -= kTableGap;
  recorded.hypothetical_table_C = table;
  recorded.notes.emplace_back(
      "there is no table: one object on a hypothetical table under its "
      "lowest point");
}

// Cameras of this trade see from some decimetres to some metres.
void note_distance(RecordedCloud& recorded) {
  std::vector<float> distances;
  for (const Eigen::Vector3f& p : recorded.cloud_C.points) {
    if (geometry::is_finite(p)) distances.push_back(p.norm());
  }
  const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
  std::nth_element(distances.begin(), middle, distances.end());
  if (*middle > 0.15F && *middle < 5.0F) return;
  recorded.notes.push_back("half of the points are within " + text("%.3g", *middle) +
                           " m of the camera: is the scale right?");
}

// A made-up camera sees one side, like a real one.
void drop_hidden_points(RecordedCloud& recorded) {
  const std::vector<int> visible =
      visible_points(recorded.cloud_C, recorded.camera, point_spacing(recorded.cloud_C));
  if (visible.empty() || visible.size() == recorded.cloud_C.size()) return;
  recorded.notes.push_back(std::to_string(recorded.cloud_C.size() - visible.size()) + " of " +
                           std::to_string(recorded.cloud_C.size()) +
                           " points are hidden from the virtual camera and left out");
  std::vector<std::uint32_t> labels;
  if (!recorded.labels.empty()) {
    for (const int i : visible) labels.push_back(recorded.labels[i]);
  }
  recorded.labels = std::move(labels);
  recorded.cloud_C = geometry::select(recorded.cloud_C, visible);
}

}  // namespace

RecordedCloud interpret_recorded_cloud(const geometry::CloudFile& file,
                                       const RecordedCloudOptions& options) {
  if (!std::isfinite(options.scale) || options.scale <= 0) {
    throw std::invalid_argument("RecordedCloudOptions: scale must be positive");
  }
  if (options.up && (!options.up->allFinite() || options.up->norm() < 1e-9)) {
    throw std::invalid_argument("RecordedCloudOptions: up must be a direction");
  }
  PointCloud cloud_F = file.cloud;
  constexpr float kInvalid = std::numeric_limits<float>::quiet_NaN();
  for (Eigen::Vector3f& p : cloud_F.points) {
    if (p.isZero(0)) p.setConstant(kInvalid);
    p *= static_cast<float>(options.scale);
  }
  const Shape shape = shape_of(cloud_F);
  check_cloud(cloud_F, shape);

  RecordedCloud recorded;
  std::optional<Eigen::Vector3d> up_F = options.up;
  if (up_F) up_F->normalize();
  const Viewpoint viewpoint = find_viewpoint(cloud_F, file, options, shape, up_F, recorded.notes);
  recorded.X_FC = viewpoint.X_FC;
  if (up_F) recorded.up_C = recorded.X_FC.linear().transpose() * *up_F;
  set_camera_and_cloud(recorded, cloud_F, file.labels);
  note_distance(recorded);
  if (options.table.kind == TableChoice::Kind::kPlane) {
    const RigidTransform X_CF = recorded.X_FC.inverse();
    geometry::Plane table_C;
    table_C.normal = X_CF.linear() * options.table.plane_F.normal;
    table_C.offset =
        options.table.plane_F.offset + table_C.normal.dot(Eigen::Vector3d(X_CF.translation()));
    recorded.given_table_C = table_C;
    recorded.up_C = table_C.normal;
    return recorded;
  }
  if (options.table.kind != TableChoice::Kind::kNone && !viewpoint.made_up) find_up(recorded);
  if (is_single_object(recorded, options, shape)) {
    put_on_hypothetical_table(recorded, up_F.has_value());
    if (viewpoint.made_up) drop_hidden_points(recorded);
  }
  return recorded;
}

RecordedCloud thinned(RecordedCloud recorded, int points) {
  const int n = binning_to(recorded.cloud_C, points);
  if (n == 1) return recorded;
  if (!recorded.labels.empty()) {
    std::vector<std::uint32_t> labels;
    for (const int i : binned_points(recorded.cloud_C, n)) {
      labels.push_back(i < 0 ? 0 : recorded.labels[static_cast<std::size_t>(i)]);
    }
    recorded.labels = std::move(labels);
  }
  recorded.cloud_C = binned(recorded.cloud_C, n);
  recorded.camera = binned(recorded.camera, n);
  return recorded;
}

SegmentedScene segment_recorded_cloud(const RecordedCloud& recorded,
                                      const SegmentationOptions& options,
                                      const TableOptions& table_options, RecordedWorld world) {
  std::optional<geometry::RigidTransform> X_WC;
  if (world == RecordedWorld::kFile) X_WC = recorded.X_FC;
  if (!recorded.hypothetical_table_C) {
    if (needs_organized(options.split) && !recorded.cloud_C.organized()) {
      throw InputError(
          "Taking things apart by creases (split touching, shapes or wide) needs an "
          "organized cloud, and this is none",
          "Choose split tops or none");
    }
    const Table table =
        recorded.given_table_C
            ? table_of_plane(recorded.cloud_C, *recorded.given_table_C, table_options)
            : find_table(recorded.cloud_C, table_options, recorded.up_C);
    return segment_on_table(recorded.cloud_C, recorded.camera, table, X_WC, options);
  }
  std::vector<int> all;
  for (std::size_t i = 0; i < recorded.cloud_C.size(); ++i) {
    if (geometry::is_finite(recorded.cloud_C.points[i])) all.push_back(static_cast<int>(i));
  }
  ObjectImages images =
      draw_objects(recorded.cloud_C, recorded.camera, {all}, options.close_radius);
  SegmentedScene scene;
  scene.camera = recorded.camera;
  const geometry::Plane& table_C = *recorded.hypothetical_table_C;
  scene.X_WC = X_WC ? *X_WC : world_from_table(table_C, geometry::centroid(recorded.cloud_C));
  scene.table_W.normal = scene.X_WC.linear() * table_C.normal;
  scene.table_W.offset =
      table_C.offset + scene.table_W.normal.dot(Eigen::Vector3d(scene.X_WC.translation()));
  scene.depth = std::move(images.depth);
  ObjectHypothesis object;
  object.cloud_W = geometry::transformed(geometry::select(recorded.cloud_C, all), scene.X_WC);
  object.mask = std::move(images.masks[0]);
  object.touches_image_border =
      touches_border(object.mask, {0, 0, object.mask.width - 1, object.mask.height - 1}, 0);
  scene.objects.push_back(std::move(object));
  return scene;
}

}  // namespace prehend::perception
