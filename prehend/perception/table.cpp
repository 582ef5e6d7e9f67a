#include "prehend/perception/table.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <random>
#include <stdexcept>
#include <string>
#include <utility>

#include <pcl/point_cloud.h>
#include <pcl/point_types.h>
#include <pcl/sample_consensus/ransac.h>
#include <pcl/sample_consensus/sac_model_perpendicular_plane.h>
#include <pcl/sample_consensus/sac_model_plane.h>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include "prehend/geometry/errors.h"
#include "prehend/perception/cloud_partition.h"
#include "prehend/text/require.h"

namespace prehend::perception {
namespace {

using geometry::InputError;
using geometry::Plane;

// Of the points within three tolerances of a plane, the share that must lie within one.
constexpr double kLeastDistinctness = 0.45;
constexpr int kMinVoxels = 30;      // of a plane
constexpr double kPatchGap = 0.15;  // m, larger gaps separate a plane's patches
constexpr double kLowestTiltFactor = 0.05;
constexpr double kBareTable = 0.05;   // score of a plane without anything on it
constexpr double kManyThings = 0.05;  // voxels of things per voxel of table: half the full score
constexpr int kMinThingVoxels = 15;   // of something that stands on a plane

void check_options(const TableOptions& o) {
  const text::Require require{"TableOptions: "};
  require(std::isfinite(o.inlier_distance) && o.inlier_distance > 0,
          "inlier_distance must be positive");
  require(o.max_iterations > 0, "max_iterations must be positive");
  require(o.max_planes > 0, "max_planes must be positive");
  require(o.min_support >= 0 && o.min_support <= 1, "min_support must be 0..1");
  require(std::isfinite(o.min_extent) && o.min_extent >= 0, "min_extent must not be negative");
  require(o.max_tilt > 0 && o.max_tilt <= 1.5708, "max_tilt must be in (0, pi/2]");
  require(std::isfinite(o.leaf_size) && o.leaf_size >= 0, "leaf_size must not be negative");
  require(o.max_distance > 0, "max_distance must be positive");
  require(o.contact_height > 0, "contact_height must be positive");
  require(o.min_object_height > 0 && o.max_object_height > o.min_object_height,
          "max_object_height must exceed min_object_height, both positive");
  require(o.max_object_extent > 0, "max_object_extent must be positive");
}

// Mean and scatter axes of points, smallest spread first.
struct PrincipalAxes {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Vector3d deviations = Eigen::Vector3d::Zero();  // m
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();    // columns
};

PrincipalAxes principal_axes(const std::vector<Eigen::Vector3f>& points,
                             const std::vector<int>& indices) {
  PrincipalAxes result;
  const double n = static_cast<double>(indices.size());
  for (const int i : indices) result.mean += points[i].cast<double>() / n;
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const int i : indices) {
    const Eigen::Vector3d d = points[i].cast<double>() - result.mean;
    scatter += d * d.transpose() / n;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(scatter);
  result.deviations = solver.eigenvalues().cwiseMax(0).cwiseSqrt();
  result.axes = solver.eigenvectors();
  return result;
}

// Depth noise of stereo and structured light grows with the square of the depth.
double tolerance_at(const Eigen::Vector3f& p, const TableOptions& options) {
  const double z = static_cast<double>(p.z());
  return options.inlier_distance * std::clamp(z * z, 1.0, 4.0);
}

Plane facing_camera(const Eigen::Vector3d& normal, const Eigen::Vector3d& point) {
  Plane plane{normal.normalized(), 0};
  plane.offset = plane.normal.dot(point);
  if (plane.offset > 0) plane = {-plane.normal, -plane.offset};
  return plane;
}

std::vector<int> inliers_of(const Plane& plane, const std::vector<Eigen::Vector3f>& points,
                            const std::vector<int>& among, const TableOptions& options,
                            double factor) {
  std::vector<int> inliers;
  for (const int i : among) {
    if (std::abs(plane.signed_distance(points[i].cast<double>())) <=
        factor * tolerance_at(points[i], options)) {
      inliers.push_back(i);
    }
  }
  return inliers;
}

// A plane stands out from what is round it; scattered points give a third here.
bool stands_out(const Plane& plane, const std::vector<Eigen::Vector3f>& points,
                const TableOptions& options) {
  std::size_t within = 0, round_it = 0;
  for (const Eigen::Vector3f& p : points) {
    const double distance = std::abs(plane.signed_distance(p.cast<double>()));
    const double tolerance = tolerance_at(p, options);
    within += distance <= tolerance;
    round_it += distance <= 3 * tolerance;
  }
  return static_cast<double>(within) >= kLeastDistinctness * static_cast<double>(round_it);
}

std::optional<Plane> ransac_plane(const std::vector<Eigen::Vector3f>& points,
                                  const std::vector<int>& remaining, const TableOptions& options,
                                  const std::optional<Eigen::Vector3d>& up_C) {
  const auto cloud = pcl::make_shared<pcl::PointCloud<pcl::PointXYZ>>();
  for (const int i : remaining) cloud->emplace_back(points[i].x(), points[i].y(), points[i].z());
  pcl::SampleConsensusModelPlane<pcl::PointXYZ>::Ptr model;
  if (up_C) {
    const auto tilted =
        pcl::make_shared<pcl::SampleConsensusModelPerpendicularPlane<pcl::PointXYZ>>(cloud);
    tilted->setAxis(up_C->normalized().cast<float>());
    tilted->setEpsAngle(options.max_tilt);
    model = tilted;
  } else {
    model = pcl::make_shared<pcl::SampleConsensusModelPlane<pcl::PointXYZ>>(cloud);
  }
  silence_pcl();
  pcl::RandomSampleConsensus<pcl::PointXYZ> ransac(model, options.inlier_distance);
  ransac.setMaxIterations(options.max_iterations);
  ransac.setProbability(0.9999);
  if (!ransac.computeModel()) return std::nullopt;
  Eigen::VectorXf coefficients;
  ransac.getModelCoefficients(coefficients);
  const Eigen::Vector3d normal = coefficients.head<3>().cast<double>();
  if (!normal.allFinite() || normal.norm() < 1e-6) return std::nullopt;
  const double n = normal.norm();
  return facing_camera(normal / n, -static_cast<double>(coefficients[3]) / n * (normal / n));
}

// Voxels of things that stand on the plane within its outline.
int standing_voxels(const Plane& plane, const PlaneOutline& outline,
                    const std::vector<Eigen::Vector3f>& voxels, const TableOptions& options) {
  std::vector<Eigen::Vector3f> above;
  for (const Eigen::Vector3f& p : voxels) {
    const double height = plane.signed_distance(p.cast<double>());
    if (height > 1.5 * tolerance_at(p, options) && height < 2 * options.max_object_height &&
        outline.contains(p.cast<double>(), 0)) {
      above.push_back(p);
    }
  }
  int count = 0;
  const double tolerance = std::max(0.02, 2.5 * options.leaf_size);
  for (const auto& cluster : euclidean_clusters(above, tolerance, kMinThingVoxels)) {
    double lowest = 1e9;
    double highest = 0;
    Eigen::AlignedBox3f box;
    for (const int i : cluster) {
      const double height = plane.signed_distance(above[i].cast<double>());
      lowest = std::min(lowest, height);
      highest = std::max(highest, height);
      box.extend(above[i]);
    }
    if (lowest <= options.contact_height && highest >= options.min_object_height &&
        highest <= options.max_object_height &&
        static_cast<double>(box.sizes().maxCoeff()) <= options.max_object_extent) {
      count += static_cast<int>(cluster.size());
    }
  }
  return count;
}

// 1 for a plane that faces the camera's own up, falling to 0.05 for one that faces down: with a
// camera that looks down, walls and the fronts of boxes face down.
double tilt_factor(const Plane& plane) {
  const double cosine = -plane.normal.y();
  return kLowestTiltFactor + (1 - kLowestTiltFactor) * std::clamp((cosine + 0.25) / 0.4, 0.0, 1.0);
}

struct Candidate {
  Plane plane;
  std::vector<int> voxels;  // inliers
  double score = 0;
  int standing = 0;
};

// The largest group of points without a gap over kPatchGap; a coarse grid is enough to tell.
std::vector<int> largest_patch(const std::vector<Eigen::Vector3f>& points,
                               const std::vector<int>& indices) {
  const VoxelGrid coarse = make_voxel_grid(points, indices, kPatchGap / 2);
  std::vector<int> largest;
  for (const auto& patch : euclidean_clusters(coarse.centroids, kPatchGap, 1)) {
    std::vector<int> members;
    for (const int v : patch) {
      members.insert(members.end(), coarse.members[v].begin(), coarse.members[v].end());
    }
    if (members.size() > largest.size()) largest = std::move(members);
  }
  std::sort(largest.begin(), largest.end());
  return largest;
}

// Refines by least squares over the inliers and keeps the largest connected patch.
std::optional<Candidate> refined(Plane plane, const std::vector<Eigen::Vector3f>& voxels,
                                 const std::vector<int>& remaining, const TableOptions& options) {
  Candidate candidate;
  for (int round = 0; round < 3; ++round) {
    candidate.voxels = inliers_of(plane, voxels, remaining, options, 1.0);
    if (candidate.voxels.size() < kMinVoxels) return std::nullopt;
    candidate.voxels = largest_patch(voxels, candidate.voxels);
    if (candidate.voxels.size() < kMinVoxels) return std::nullopt;
    const PrincipalAxes axes = principal_axes(voxels, candidate.voxels);
    if (axes.deviations[1] * std::sqrt(12.0) < options.min_extent) return std::nullopt;
    plane = facing_camera(axes.axes.col(0), axes.mean);
  }
  // The feet of what stands on it are within the tolerance and lift the plane; its own noise is
  // often far less.
  double squares = 0;
  for (const int i : candidate.voxels) {
    const double d =
        plane.signed_distance(voxels[i].cast<double>()) / tolerance_at(voxels[i], options);
    squares += d * d;
  }
  const double noise = std::sqrt(squares / static_cast<double>(candidate.voxels.size()));
  const std::vector<int> core =
      inliers_of(plane, voxels, candidate.voxels, options, std::clamp(2 * noise, 0.02, 1.0));
  if (core.size() >= kMinVoxels) {
    const PrincipalAxes axes = principal_axes(voxels, core);
    plane = facing_camera(axes.axes.col(0), axes.mean);
  }
  candidate.plane = plane;
  return candidate;
}

std::vector<int> near_and_finite(const geometry::PointCloud& cloud, double max_distance) {
  std::vector<int> indices;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3f& p = cloud.points[i];
    if (geometry::is_finite(p) && static_cast<double>(p.norm()) <= max_distance) {
      indices.push_back(static_cast<int>(i));
    }
  }
  return indices;
}

// The best candidate's voxels back to points, with a last fit over all of them.
Table make_table(const Candidate& best, const geometry::PointCloud& cloud,
                 const std::vector<int>& indices, const std::vector<Eigen::Vector3f>& voxels,
                 const TableOptions& options) {
  Table table;
  table.object_points = best.standing;
  std::vector<Eigen::Vector3f> members;
  for (const int i : best.voxels) members.push_back(voxels[i]);
  const PlaneOutline outline(best.plane, members);
  for (const int i : inliers_of(best.plane, cloud.points, indices, options, 1.0)) {
    if (outline.contains(cloud.points[i].cast<double>(), options.leaf_size)) {
      table.inliers.push_back(i);
    }
  }
  // Voxels weigh near and far alike, as the area does; points would favour the near part.
  table.plane_C = best.plane;
  table.hull_C = outline.vertices();
  double sum = 0;
  for (const int i : table.inliers) {
    const double d = table.plane_C.signed_distance(cloud.points[i].cast<double>());
    sum += d * d;
  }
  table.rms = std::sqrt(sum / std::max<double>(1, static_cast<double>(table.inliers.size())));
  return table;
}

// Every plane that may be a table, in the order in which RANSAC met them; `best_alone`: not those
// that score no more than one before, as a plane's score is no more than the share of the voxels
// that are left for it.
std::vector<Candidate> find_candidates(const std::vector<Eigen::Vector3f>& voxels,
                                       const TableOptions& options,
                                       const std::optional<Eigen::Vector3d>& up_C,
                                       bool best_alone) {
  std::vector<int> remaining(voxels.size());
  for (std::size_t i = 0; i < remaining.size(); ++i) remaining[i] = static_cast<int>(i);
  std::vector<Candidate> candidates;
  const std::size_t fewest = std::max<std::size_t>(
      kMinVoxels,
      static_cast<std::size_t>(options.min_support * static_cast<double>(voxels.size())));
  double best = 0;
  const auto is_beaten = [&](double most) { return best_alone && most <= best; };
  const auto share = [&](std::size_t count) {
    return static_cast<double>(count) / static_cast<double>(voxels.size());
  };
  for (int k = 0; k < options.max_planes && remaining.size() >= fewest; ++k) {
    if (is_beaten(share(remaining.size()))) break;
    const std::optional<Plane> plane = ransac_plane(voxels, remaining, options, up_C);
    if (!plane) break;
    if (auto candidate = refined(*plane, voxels, remaining, options)) {
      const double support = share(candidate->voxels.size());
      const double most = support * (up_C ? 1.0 : tilt_factor(candidate->plane));
      const bool upright =
          up_C ? candidate->plane.normal.dot(up_C->normalized()) >= std::cos(options.max_tilt)
               : tilt_factor(candidate->plane) > kLowestTiltFactor;
      if (support >= options.min_support && upright && !is_beaten(most) &&
          stands_out(candidate->plane, voxels, options)) {
        std::vector<Eigen::Vector3f> members;
        for (const int i : candidate->voxels) members.push_back(voxels[i]);
        const PlaneOutline outline(candidate->plane, members);
        candidate->standing = standing_voxels(candidate->plane, outline, voxels, options);
        const double things = candidate->standing;
        const double standing =
            things / (things + kManyThings * static_cast<double>(members.size()));
        candidate->score = most * (kBareTable + (1 - kBareTable) * standing);
        best = std::max(best, candidate->score);
        candidates.push_back(std::move(*candidate));
      }
    }
    const std::vector<int> taken = inliers_of(*plane, voxels, remaining, options, 1.5);
    std::vector<int> rest;
    std::set_difference(remaining.begin(), remaining.end(), taken.begin(), taken.end(),
                        std::back_inserter(rest));
    if (rest.size() == remaining.size()) break;
    remaining = std::move(rest);
  }
  return candidates;
}

// `most` of them, at least one.
std::vector<Table> best_tables(const geometry::PointCloud& cloud_C, const TableOptions& options,
                               const std::optional<Eigen::Vector3d>& up_C, std::size_t most) {
  check_options(options);
  if (up_C && (!up_C->allFinite() || up_C->norm() < 1e-9)) {
    throw std::invalid_argument("find_table: up_C must be a direction");
  }
  const std::vector<int> indices = near_and_finite(cloud_C, options.max_distance);
  if (indices.size() < 3) {
    throw InputError("No table: the cloud has " + std::to_string(indices.size()) +
                         " valid points within " + std::to_string(options.max_distance) +
                         " m of the camera",
                     "Look at a table, or raise max_distance");
  }
  std::vector<Eigen::Vector3f> voxels = voxel_centroids(cloud_C.points, indices, options.leaf_size);
  // PCL draws with a fixed seed; the order of the points makes ours count.
  std::mt19937_64 random(options.seed);
  for (std::size_t i = voxels.size(); i > 1; --i) {
    const std::size_t j = random() % i;
    std::swap(voxels[i - 1], voxels[j]);
  }
  std::vector<Candidate> candidates = find_candidates(voxels, options, up_C, most == 1);
  if (candidates.empty()) {
    throw InputError("No table: none of the planes in the cloud of " +
                         std::to_string(indices.size()) +
                         " points is large enough, upright and stands out from its surroundings",
                     "Look at a table, give the up direction, or lower min_support and min_extent");
  }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.score > b.score; });
  if (candidates.size() > most) candidates.resize(most);
  std::vector<Table> tables;
  for (const Candidate& candidate : candidates) {
    tables.push_back(make_table(candidate, cloud_C, indices, voxels, options));
  }
  return tables;
}

}  // namespace

std::vector<Table> find_tables(const geometry::PointCloud& cloud_C, const TableOptions& options,
                               const std::optional<Eigen::Vector3d>& up_C) {
  return best_tables(cloud_C, options, up_C, std::numeric_limits<std::size_t>::max());
}

Table find_table(const geometry::PointCloud& cloud_C, const TableOptions& options,
                 const std::optional<Eigen::Vector3d>& up_C) {
  return std::move(best_tables(cloud_C, options, up_C, 1).front());
}

Table table_of_plane(const geometry::PointCloud& cloud_C, const geometry::Plane& plane_C,
                     const TableOptions& options) {
  check_options(options);
  Table table;
  table.plane_C = plane_C;
  std::vector<Eigen::Vector3f> over;
  double squares = 0;
  for (std::size_t i = 0; i < cloud_C.size(); ++i) {
    const Eigen::Vector3f& p = cloud_C.points[i];
    if (!geometry::is_finite(p) || p.norm() > options.max_distance) continue;
    const double height = plane_C.signed_distance(p.cast<double>());
    const double tolerance = tolerance_at(p, options);
    if (height < -tolerance) continue;
    over.push_back(p);
    if (height > tolerance) continue;
    table.inliers.push_back(static_cast<int>(i));
    squares += height * height;
  }
  if (over.size() < 3) {
    throw geometry::InputError("No point of the cloud is on or over the table that was given",
                               "Give its normal towards the objects, in the file's frame and unit");
  }
  if (!table.inliers.empty()) {
    table.rms = std::sqrt(squares / static_cast<double>(table.inliers.size()));
  }
  table.hull_C = PlaneOutline(plane_C, over).vertices();
  return table;
}

}  // namespace prehend::perception
