#include "prehend/perception/merged_views.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <stdexcept>
#include <string>

#include <pcl/point_cloud.h>
#include <pcl/point_types.h>
#include <pcl/search/kdtree.h>
#include <Eigen/Geometry>

#include "prehend/geometry/errors.h"
#include "prehend/perception/cloud_partition.h"
#include "prehend/perception/masks.h"

namespace prehend::perception {
namespace {

using geometry::InputError;
using geometry::PointCloud;
using geometry::RigidTransform;

constexpr double kMostTableTurn = 0.35;   // rad, between the tables of two views
constexpr double kMostTableShift = 0.05;  // m
constexpr int kCloseRadius = 2;           // pixels, of splatted masks

void check(const MergeOptions& o) {
  const auto require = [](bool condition, const char* what) {
    if (!condition) throw std::invalid_argument(std::string("MergeOptions: ") + what);
  };
  require(o.min_footprint_overlap > 0 && o.min_footprint_overlap <= 1,
          "min_footprint_overlap must be in (0, 1]");
  require(std::isfinite(o.footprint_margin), "footprint_margin must be finite");
  require(o.max_correspondence > 0, "max_correspondence must be positive");
  require(o.max_iterations > 0, "max_iterations must be positive");
  require(o.leaf_size >= 0, "leaf_size must not be negative");
  require(o.min_correspondences > 0 && o.min_correspondences <= 1,
          "min_correspondences must be in (0, 1]");
}

void check_tables(const std::vector<SegmentedScene>& views) {
  const geometry::Plane& first = views.front().table_W;
  for (std::size_t v = 1; v < views.size(); ++v) {
    const geometry::Plane& table = views[v].table_W;
    const double turn = std::acos(std::clamp(first.normal.dot(table.normal), -1.0, 1.0));
    const Eigen::Vector3d anchor = first.project(
        views.front().objects.empty() ? Eigen::Vector3d::Zero().eval()
                                      : geometry::centroid(views.front().objects.front().cloud_W));
    if (turn > kMostTableTurn || std::abs(table.signed_distance(anchor)) > kMostTableShift) {
      throw InputError("The tables of views 0 and " + std::to_string(v) + " do not lie together",
                       "Check the cameras' poses; all must be in one world frame");
    }
  }
}

// All object points of a view, one a voxel.
std::vector<Eigen::Vector3f> voxels_of(const SegmentedScene& view, double leaf_size) {
  std::vector<Eigen::Vector3f> points;
  for (const ObjectHypothesis& object : view.objects) {
    points.insert(points.end(), object.cloud_W.points.begin(), object.cloud_W.points.end());
  }
  std::vector<int> all(points.size());
  std::iota(all.begin(), all.end(), 0);
  return voxel_centroids(points, all, leaf_size);
}

// The motion of `moving` that brings it onto `fixed`, if enough of it has a partner there.
std::optional<RigidTransform> alignment(const std::vector<Eigen::Vector3f>& moving,
                                        const std::vector<Eigen::Vector3f>& fixed,
                                        const MergeOptions& options) {
  if (moving.size() < 12 || fixed.size() < 12) return std::nullopt;
  const auto cloud = pcl::make_shared<pcl::PointCloud<pcl::PointXYZ>>();
  for (const Eigen::Vector3f& p : fixed) cloud->emplace_back(p.x(), p.y(), p.z());
  pcl::search::KdTree<pcl::PointXYZ> tree(false);
  tree.setInputCloud(cloud);
  RigidTransform motion = RigidTransform::Identity();
  const auto limit = static_cast<float>(options.max_correspondence * options.max_correspondence);
  for (int iteration = 0; iteration < options.max_iterations; ++iteration) {
    std::vector<Eigen::Vector3d> from, to;
    std::vector<int> nearest(1);
    std::vector<float> distance(1);
    for (const Eigen::Vector3f& p : moving) {
      const Eigen::Vector3d moved = motion * p.cast<double>();
      const pcl::PointXYZ query(static_cast<float>(moved.x()), static_cast<float>(moved.y()),
                                static_cast<float>(moved.z()));
      if (tree.nearestKSearch(query, 1, nearest, distance) < 1 || distance[0] > limit) continue;
      from.push_back(moved);
      to.push_back(fixed[nearest[0]].cast<double>());
    }
    if (static_cast<double>(from.size()) <
        options.min_correspondences * static_cast<double>(moving.size())) {
      return std::nullopt;
    }
    const Eigen::Map<const Eigen::Matrix3Xd> a(from.front().data(), 3,
                                               static_cast<Eigen::Index>(from.size()));
    const Eigen::Map<const Eigen::Matrix3Xd> b(to.front().data(), 3,
                                               static_cast<Eigen::Index>(to.size()));
    const RigidTransform step(Eigen::umeyama(a, b, false));
    motion = step * motion;
    if (step.translation().norm() < 1e-6 && Eigen::AngleAxisd(step.linear()).angle() < 1e-6) {
      break;
    }
  }
  // A correction beyond what it was looked for within has slid away along a face.
  double farthest = 0;
  for (const Eigen::Vector3f& p : moving) {
    farthest = std::max(farthest, (motion * p.cast<double>() - p.cast<double>()).norm());
  }
  if (farthest > options.max_correspondence) return std::nullopt;
  return motion;
}

void move(SegmentedScene& view, const RigidTransform& motion) {
  view.X_WC = motion * view.X_WC;
  view.table_W.normal = motion.linear() * view.table_W.normal;
  view.table_W.offset += view.table_W.normal.dot(motion.translation());
  for (ObjectHypothesis& object : view.objects) {
    object.cloud_W = geometry::transformed(object.cloud_W, motion);
  }
}

double share_over(const PointCloud& cloud, const PlaneOutline& footprint, double margin) {
  double over = 0;
  for (const Eigen::Vector3f& p : cloud.points)
    over += footprint.contains(p.cast<double>(), margin);
  return over / static_cast<double>(std::max<std::size_t>(cloud.size(), 1));
}

double footprint_overlap(const PointCloud& a, const PointCloud& b, const geometry::Plane& table,
                         double margin) {
  const PlaneOutline footprint_a(table, a.points), footprint_b(table, b.points);
  return std::max(share_over(a, footprint_b, margin), share_over(b, footprint_a, margin));
}

void append(MergedObject& merged, const PointCloud& cloud, int view) {
  const bool colored =
      cloud.colors.size() == cloud.size() && merged.cloud_W.colors.size() == merged.cloud_W.size();
  auto& points = merged.cloud_W.points;
  points.insert(points.end(), cloud.points.begin(), cloud.points.end());
  if (colored) {
    auto& colors = merged.cloud_W.colors;
    colors.insert(colors.end(), cloud.colors.begin(), cloud.colors.end());
  } else {
    merged.cloud_W.colors.clear();
  }
  merged.view.resize(points.size(), view);
}

}  // namespace

MergedViews merge_views(std::vector<SegmentedScene> views, const MergeOptions& options) {
  check(options);
  if (views.empty()) throw InputError("There are no views to merge", "Pass at least one");
  check_tables(views);
  if (options.align) {
    std::vector<Eigen::Vector3f> fixed = voxels_of(views.front(), options.leaf_size);
    for (std::size_t v = 1; v < views.size(); ++v) {
      const auto motion = alignment(voxels_of(views[v], options.leaf_size), fixed, options);
      if (motion) move(views[v], *motion);
      const std::vector<Eigen::Vector3f> more = voxels_of(views[v], options.leaf_size);
      fixed.insert(fixed.end(), more.begin(), more.end());
    }
  }
  MergedViews result;
  result.table_W.normal.setZero();
  for (const SegmentedScene& view : views) {
    result.table_W.normal += view.table_W.normal;
    result.table_W.offset += view.table_W.offset / static_cast<double>(views.size());
  }
  result.table_W.normal.normalize();

  for (std::size_t v = 0; v < views.size(); ++v) {
    std::vector<char> taken(result.objects.size(), 0);
    for (std::size_t h = 0; h < views[v].objects.size(); ++h) {
      const PointCloud& cloud = views[v].objects[h].cloud_W;
      std::size_t best = result.objects.size();
      double most = options.min_footprint_overlap;
      for (std::size_t k = 0; k < taken.size(); ++k) {
        if (taken[k]) continue;
        const double overlap = footprint_overlap(cloud, result.objects[k].cloud_W, result.table_W,
                                                 options.footprint_margin);
        if (overlap < most) continue;
        most = overlap;
        best = k;
      }
      if (best == result.objects.size()) {
        result.objects.emplace_back().hypothesis.assign(views.size(), -1);
      } else {
        taken[best] = 1;
      }
      append(result.objects[best], cloud, static_cast<int>(v));
      result.objects[best].hypothesis[v] = static_cast<int>(h);
    }
  }
  std::stable_sort(result.objects.begin(), result.objects.end(),
                   [](const MergedObject& a, const MergedObject& b) {
                     return a.cloud_W.size() > b.cloud_W.size();
                   });
  result.views = std::move(views);
  return result;
}

SegmentedScene as_scene(const MergedViews& merged) {
  std::vector<int> seen(merged.views.size(), 0);
  for (const MergedObject& object : merged.objects) {
    for (std::size_t v = 0; v < seen.size(); ++v) seen[v] += object.hypothesis[v] >= 0;
  }
  const std::size_t chosen =
      static_cast<std::size_t>(std::max_element(seen.begin(), seen.end()) - seen.begin());
  const SegmentedScene& view = merged.views.at(chosen);
  SegmentedScene scene;
  scene.camera = view.camera;
  scene.X_WC = view.X_WC;
  scene.depth = view.depth;
  scene.table_W = merged.table_W;
  for (const MergedObject& object : merged.objects) {
    ObjectHypothesis& out = scene.objects.emplace_back();
    out.id = static_cast<int>(scene.objects.size()) - 1;
    out.cloud_W = object.cloud_W;
    out.touches_image_border = true;
    out.occluded_share = 1;
    out.may_be_several = true;
    for (std::size_t v = 0; v < merged.views.size(); ++v) {
      if (object.hypothesis[v] < 0) continue;
      const ObjectHypothesis& one =
          merged.views[v].objects[static_cast<std::size_t>(object.hypothesis[v])];
      out.touches_image_border = out.touches_image_border && one.touches_image_border;
      out.occluded_share = std::min(out.occluded_share, one.occluded_share);
      out.may_be_several = out.may_be_several && one.may_be_several;
    }
    if (object.hypothesis[chosen] >= 0) {
      out.mask = view.objects[static_cast<std::size_t>(object.hypothesis[chosen])].mask;
    } else {
      const PointCloud cloud_C = geometry::transformed(object.cloud_W, view.X_WC.inverse());
      std::vector<int> all(cloud_C.size());
      std::iota(all.begin(), all.end(), 0);
      out.mask = draw_objects(cloud_C, view.camera, {all}, kCloseRadius).masks.front();
    }
  }
  return scene;
}

}  // namespace prehend::perception
