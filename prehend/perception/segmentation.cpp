#include "prehend/perception/segmentation.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <stdexcept>
#include <string>
#include <utility>

#include "prehend/perception/cloud_partition.h"
#include "prehend/perception/cut_objects.h"
#include "prehend/perception/masks.h"
#include "prehend/perception/mean_color.h"
#include "prehend/perception/organized_components.h"
#include "prehend/perception/points_over_table.h"
#include "prehend/perception/seen_width.h"
#include "prehend/perception/supports.h"
#include "prehend/text/require.h"
#include "prehend/text/told_apart.h"

namespace prehend::perception {
namespace {

using geometry::Plane;
using geometry::PointCloud;
using geometry::RigidTransform;

constexpr int kMinClusterVoxels = 3;    // smaller ones are noise
constexpr int kLeastObjectPoints = 30;  // of an object: fewer have no shape
constexpr double kSliver = 0.005;       // m: what shows less for its height is a rim of a thing
constexpr double kThread = 0.0015;      // m: what shows less for its length is strewn points
constexpr int kLeastTold = 30;          // points of a dropped cluster that is worth a word

void check_options(const SegmentationOptions& o) {
  const text::Require require{"SegmentationOptions: "};
  require(std::isfinite(o.min_height) && o.min_height >= 0, "min_height must not be negative");
  require(o.max_height > o.min_height, "max_height must exceed min_height");
  require(o.max_distance > 0, "max_distance must be positive");
  require(std::isfinite(o.cluster_tolerance) && o.cluster_tolerance > 0,
          "cluster_tolerance must be positive");
  require(o.leaf_size >= 0 && o.leaf_size < o.cluster_tolerance,
          "leaf_size must be 0 or more and under cluster_tolerance");
  require(std::isfinite(o.min_area) && o.min_area >= 0, "min_area must not be negative");
  require(o.pixel_reach >= 1 && o.pixel_reach <= 20, "pixel_reach must be 1..20");
  require(o.min_object_height >= 0, "min_object_height must not be negative");
  require(std::isfinite(o.hull_margin), "hull_margin must be finite");
  require(o.close_radius >= 0 && o.close_radius <= 50, "close_radius must be 0..50");
  require(std::isfinite(o.baseline) && o.baseline >= 0, "baseline must not be negative");
  require(o.max_objects > 0, "max_objects must be positive");
  require(o.split != Splitting::kShapes || o.body_evidence, "split by shapes needs body_evidence");
  require(std::isfinite(o.least_split_width) && o.least_split_width >= 0,
          "least_split_width must not be negative");
  require(o.parts.contact_height >= 0 && o.parts.join_gap >= 0 && o.parts.drop_height >= 0,
          "parts must not have negative lengths");
  require(o.parts.most_hue_difference >= 0 && o.parts.most_color_difference >= 0,
          "parts must not have negative differences");
}

// Clusters of the points over the table: voxels and which of them are together.
struct ClusteredVoxels {
  VoxelGrid grid;
  std::vector<std::vector<int>> clusters;  // indices of voxels
};

ClusteredVoxels cluster(const PointCloud& cloud_C, const std::vector<int>& indices,
                        const SegmentationOptions& options) {
  ClusteredVoxels result;
  if (options.clustering == Clustering::kEuclidean || !cloud_C.organized()) {
    result.grid = make_voxel_grid(cloud_C.points, indices, options.leaf_size);
    result.clusters =
        euclidean_clusters(result.grid.centroids, options.cluster_tolerance, kMinClusterVoxels);
    return result;
  }
  for (const std::vector<int>& component : organized_components(
           cloud_C, indices, options.cluster_tolerance, options.pixel_reach, kMinClusterVoxels)) {
    VoxelGrid grid = make_voxel_grid(cloud_C.points, component, options.leaf_size);
    const auto first = static_cast<int>(result.grid.centroids.size());
    std::vector<int>& voxels = result.clusters.emplace_back(grid.centroids.size());
    std::iota(voxels.begin(), voxels.end(), first);
    result.grid.centroids.insert(result.grid.centroids.end(), grid.centroids.begin(),
                                 grid.centroids.end());
    std::move(grid.members.begin(), grid.members.end(), std::back_inserter(result.grid.members));
  }
  return result;
}

// A cluster's height [m]; a stray point is none.
double height_of(const PointCloud& cloud_C, const std::vector<int>& members, const Table& table) {
  std::vector<double> heights;
  for (const int i : members) {
    heights.push_back(table.plane_C.signed_distance(cloud_C.points[i].cast<double>()));
  }
  const auto high = heights.end() - 1 - static_cast<std::ptrdiff_t>(heights.size() / 200);
  std::nth_element(heights.begin(), high, heights.end());
  return *high;
}

// Area of a cluster as the camera sees it [m^2]: of its pixels, or of its voxels.
double seen_area(const PointCloud& cloud_C, const geometry::PinholeCamera& camera,
                 const std::vector<int>& members, const SegmentationOptions& options) {
  if (!cloud_C.organized()) {
    const double leaf = options.leaf_size > 0 ? options.leaf_size : 0.005;
    return leaf * leaf * static_cast<double>(voxel_centroids(cloud_C.points, members, leaf).size());
  }
  double area = 0;
  for (const int i : members) {
    const double z = cloud_C.points[i].z();
    area += z / camera.fx * z / camera.fy;
  }
  return area;
}

// Which points are objects, and which look like one and are none.
struct FoundObjects {
  struct Dropped {
    std::vector<int> members;
    std::string reason;
  };
  std::vector<LedgePart> objects;  // largest first
  std::vector<Dropped> dropped;    // likewise
  PointsLeftOut left_out;
};

// Tells objects from what is none.
class ObjectFinder {
 public:
  ObjectFinder(const PointCloud& cloud_C, const geometry::PinholeCamera& camera, const Table& table,
               const SegmentationOptions& options)
      : cloud_C_(cloud_C), camera_(camera), table_(table), options_(options) {}

  FoundObjects find() {
    const PointsOverTable points = points_over_table(cloud_C_, camera_, table_, options_);
    found_.left_out = points.left_out;
    const ClusteredVoxels voxels = cluster(cloud_C_, points.indices, options_);
    std::vector<char> is_cut;
    for (const std::vector<int>& of_cluster : voxels.clusters) {
      is_cut.push_back(
          goes_on(cloud_C_, members_of(voxels, of_cluster), camera_, table_, options_));
    }
    const auto look_alike = [&](std::size_t a, std::size_t b) {
      const std::vector<int> first = members_of(voxels, voxels.clusters[a]);
      const std::vector<int> second = members_of(voxels, voxels.clusters[b]);
      // Infinite without colours.
      return color_difference(cloud_C_, first, second) <= options_.parts.most_color_difference &&
             hue_difference(cloud_C_, first, second) <= options_.parts.most_hue_difference;
    };
    const JoinedParts joined = joined_parts(voxels.grid.centroids, voxels.clusters, is_cut,
                                            table_.plane_C, options_.parts, look_alike);
    for (const std::vector<int>& part : joined.objects) take(members_of(voxels, part));
    for (const std::vector<int>& part : joined.hanging) {
      drop(members_of(voxels, part),
           words("it begins more than %.0f mm over the table and goes on beyond what was looked at "
                 "(drop_height)",
                 1e3 * options_.parts.drop_height));
    }
    sort();
    if (options_.split == Splitting::kShapes && cloud_C_.organized()) split_into_shapes();
    while (found_.objects.size() > static_cast<std::size_t>(options_.max_objects)) {
      drop(std::move(found_.objects.back().members),
           words("there are %.0f larger objects (max_objects)", options_.max_objects));
      found_.objects.pop_back();
    }
    sort();
    return std::move(found_);
  }

 private:
  template <class... Numbers>
  static std::string words(const char* format, Numbers... numbers) {
    char text[200];
    std::snprintf(text, sizeof text, format, static_cast<double>(numbers)...);
    return text;
  }

  static std::vector<int> members_of(const ClusteredVoxels& voxels, const std::vector<int>& part) {
    std::vector<int> members;
    for (const int voxel : part) {
      const std::vector<int>& points = voxels.grid.members[voxel];
      members.insert(members.end(), points.begin(), points.end());
    }
    std::sort(members.begin(), members.end());
    return members;
  }

  void take(std::vector<int> members) {
    if (options_.split == Splitting::kNone) return take_part({std::move(members)});
    for (LedgePart& part : split_at_ledges(cloud_C_, table_.plane_C, members, options_.ledges)) {
      std::sort(part.members.begin(), part.members.end());
      take_part(std::move(part));
    }
  }

  void take_part(LedgePart part) {
    if (options_.split != Splitting::kTouching || !cloud_C_.organized())
      return take_piece(std::move(part));
    auto pieces = split_touching(cloud_C_, camera_, part.members, options_.splitting);
    const bool may_be_several = part.may_be_several && pieces.size() == 1;
    for (auto& piece : pieces) take_piece({std::move(piece), may_be_several});
  }

  void take_piece(LedgePart piece) {
    if (std::string reason = why_no_object(piece.members); !reason.empty()) {
      drop(std::move(piece.members), std::move(reason));
    } else {
      found_.objects.push_back(std::move(piece));
    }
  }

  // Empty when they are one.
  std::string why_no_object(const std::vector<int>& members) const {
    if (members.size() < kLeastObjectPoints) {
      return words("fewer than %.0f points have no shape", kLeastObjectPoints);
    }
    const double area = seen_area(cloud_C_, camera_, members, options_);
    const double height = height_of(cloud_C_, members, table_);
    const double least_area =
        std::max({options_.min_area, kSliver * height, kThread * length_of(members)});
    if (area < least_area) {
      const auto [seen, least] = text::told_apart(1e4 * area, 1e4 * least_area, 1);
      return seen + " cm^2 of it are seen, less than " + least +
             " cm^2 (min_area, 5 mm for its height, 1.5 mm for its length)";
    }
    if (const double least = least_object_height(members); height < least) {
      const auto [high, enough] = text::told_apart(1e3 * height, 1e3 * least, 1);
      return high + " mm high, less than " + enough +
             " mm (min_object_height, or 2.5 times min_height: what the table's noise reaches)";
    }
    return {};
  }

  // Each object among the others, as they are by then.
  void split_into_shapes() {
    const auto is_object = [this](const std::vector<int>& members) {
      return why_no_object(members).empty();
    };
    std::vector<LedgePart> whole = std::move(found_.objects);
    found_.objects.clear();
    for (std::size_t k = 0; k < whole.size(); ++k) {
      if (stays_whole(whole[k].members)) {
        found_.objects.push_back(std::move(whole[k]));
        continue;
      }
      ClusterView cluster{cloud_C_, camera_, table_.plane_C, {}};
      for (const LedgePart& object : found_.objects) cluster.others.push_back(object.members);
      for (std::size_t j = k + 1; j < whole.size(); ++j) {
        cluster.others.push_back(whole[j].members);
      }
      auto bodies = split_into_bodies(cluster, whole[k].members, options_.body_evidence, is_object,
                                      options_.body_splitting);
      if (bodies.size() == 1) {
        found_.objects.push_back(std::move(whole[k]));
        continue;
      }
      for (std::vector<int>& body : bodies) {
        // A step that was cut is none any more.
        const bool may_be_several =
            whole[k].may_be_several &&
            split_at_ledges(cloud_C_, table_.plane_C, body, options_.ledges).front().may_be_several;
        found_.objects.push_back({std::move(body), may_be_several});
      }
    }
    sort();
  }

  bool stays_whole(const std::vector<int>& members) const {
    if (options_.least_split_width <= 0) return false;
    return sides_over_plane(cloud_C_, members, table_.plane_C)[0] < options_.least_split_width;
  }

  double length_of(const std::vector<int>& members) const {
    Eigen::AlignedBox3f box;
    for (const int i : members) box.extend(cloud_C_.points[i]);
    return static_cast<double>(box.diagonal().norm());
  }

  // What the table's noise reaches may look like a thing.
  double least_object_height(const std::vector<int>& members) const {
    constexpr double kOverNoise = 2.5;
    double depth = 0;
    for (const int i : members) depth += static_cast<double>(cloud_C_.points[i].z());
    depth /= static_cast<double>(members.size());
    return std::max(options_.min_object_height,
                    kOverNoise * least_height(table_, options_) * noise_growth(depth));
  }

  void drop(std::vector<int> members, std::string reason) {
    if (members.size() < kLeastTold) return;
    found_.dropped.push_back({std::move(members), std::move(reason)});
  }

  void sort() {
    const auto larger = [](const auto& a, const auto& b) {
      return a.size() != b.size() ? a.size() > b.size() : a.front() < b.front();
    };
    std::sort(found_.objects.begin(), found_.objects.end(),
              [&](const auto& a, const auto& b) { return larger(a.members, b.members); });
    std::sort(found_.dropped.begin(), found_.dropped.end(),
              [&](const auto& a, const auto& b) { return larger(a.members, b.members); });
  }

  const PointCloud& cloud_C_;
  const geometry::PinholeCamera& camera_;
  const Table& table_;
  const SegmentationOptions& options_;
  FoundObjects found_;
};

// Mean of all objects' points, else of the table.
Eigen::Vector3d anchor_of(const PointCloud& cloud_C, const std::vector<std::vector<int>>& objects,
                          const Table& table) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double count = 0;
  for (const auto& members : objects) {
    for (const int i : members) sum += cloud_C.points[i].cast<double>();
    count += static_cast<double>(members.size());
  }
  if (count > 0) return sum / count;
  for (const Eigen::Vector3d& p : table.hull_C) sum += p;
  return table.hull_C.empty() ? Eigen::Vector3d(0, 0, 1)
                              : Eigen::Vector3d(sum / static_cast<double>(table.hull_C.size()));
}

Plane transformed(const Plane& plane_B, const RigidTransform& X_AB) {
  Plane plane_A;
  plane_A.normal = X_AB.linear() * plane_B.normal;
  plane_A.offset = plane_B.offset + plane_A.normal.dot(X_AB.translation());
  return plane_A;
}

}  // namespace

bool needs_organized(Splitting splitting) {
  return splitting == Splitting::kTouching || splitting == Splitting::kShapes;
}

void choose_splitting(std::string_view name, std::optional<double> widest_opening,
                      SegmentationOptions* options) {
  if (name == "none") {
    options->split = Splitting::kNone;
  } else if (name == "tops") {
    options->split = Splitting::kTops;
  } else if (name == "touching") {
    options->split = Splitting::kTouching;
  } else if (name == "shapes") {
    options->split = Splitting::kShapes;
  } else if (name == "wide") {
    if (!widest_opening) {
      throw geometry::InputError("split is 'wide', and nothing is known of the hand",
                                 "Name the platform or hand that grasps, or choose another split");
    }
    if (*widest_opening > 0) {
      options->split = Splitting::kShapes;
      options->least_split_width = *widest_opening;
    }
  } else {
    throw geometry::InputError("split is '" + std::string(name) + "'",
                               "Give none, tops, touching, shapes or wide");
  }
}

RigidTransform world_from_table(const Plane& table_C, const Eigen::Vector3d& anchor_C) {
  const Eigen::Vector3d z = table_C.normal.normalized();
  Eigen::Vector3d x = Eigen::Vector3d::UnitX() - z.x() * z;
  // A camera whose x axis stands on the table: take the viewing direction.
  if (x.norm() < 1e-3) x = Eigen::Vector3d::UnitZ() - z.z() * z;
  x.normalize();
  RigidTransform X_CW = RigidTransform::Identity();
  X_CW.linear() << x, z.cross(x), z;
  X_CW.translation() = table_C.project(anchor_C);
  return X_CW.inverse();
}

SegmentedScene in_table_world(SegmentedScene scene) {
  Eigen::Vector3d sum_W = Eigen::Vector3d::Zero();
  double count = 0;
  for (const ObjectHypothesis& object : scene.objects) {
    for (const Eigen::Vector3f& p : object.cloud_W.points) sum_W += p.cast<double>();
    count += static_cast<double>(object.cloud_W.size());
  }
  const RigidTransform X_CW = scene.X_WC.inverse();
  const Eigen::Vector3d anchor_W =
      count > 0 ? Eigen::Vector3d(sum_W / count) : scene.table_W.project(scene.X_WC.translation());
  const RigidTransform X_NC =
      world_from_table(transformed(scene.table_W, X_CW), Eigen::Vector3d(X_CW * anchor_W));
  const RigidTransform X_NW = X_NC * X_CW;
  for (ObjectHypothesis& object : scene.objects) {
    object.cloud_W = geometry::transformed(object.cloud_W, X_NW);
    if (object.support_W) object.support_W = transformed(*object.support_W, X_NW);
  }
  scene.table_W = transformed(scene.table_W, X_NW);
  scene.X_WC = X_NC;
  return scene;
}

std::string why_no_objects(const SegmentedScene& scene) {
  if (scene.dropped.empty()) {
    return "The table is empty: nothing stands on it within max_distance and max_height";
  }
  std::string text = "Nothing on the table is taken for an object";
  constexpr std::size_t kMostTold = 3;
  for (std::size_t k = 0; k < std::min(scene.dropped.size(), kMostTold); ++k) {
    text += "; " + scene.dropped[k];
  }
  return text;
}

SegmentedScene segment_on_table(const PointCloud& cloud_C, const geometry::PinholeCamera& camera,
                                const Table& table, const std::optional<RigidTransform>& X_WC,
                                const SegmentationOptions& options) {
  check_options(options);
  if (camera.width <= 0 || camera.height <= 0 ||
      (cloud_C.organized() && (cloud_C.width != camera.width || cloud_C.height != camera.height))) {
    throw std::invalid_argument("segment_on_table: the camera's size is not the cloud's");
  }
  const FoundObjects found = ObjectFinder(cloud_C, camera, table, options).find();
  std::vector<std::vector<int>> members;
  for (const LedgePart& object : found.objects) members.push_back(object.members);
  ObjectImages images = draw_objects(cloud_C, camera, members, options.close_radius);

  SegmentedScene scene;
  scene.camera = camera;
  scene.left_out = found.left_out;
  scene.X_WC = X_WC ? *X_WC : world_from_table(table.plane_C, anchor_of(cloud_C, members, table));
  scene.depth = std::move(images.depth);
  scene.table_W = transformed(table.plane_C, scene.X_WC);
  // An organized cloud is what the sensor measured; a virtual camera's image has no frame.
  const PixelRectangle area = cloud_C.organized()
                                  ? measured_area(scene.depth)
                                  : PixelRectangle{0, 0, camera.width - 1, camera.height - 1};
  const int margin = cloud_C.organized() ? options.close_radius + 1 : 0;
  for (std::size_t k = 0; k < members.size(); ++k) {
    ObjectHypothesis object;
    object.id = static_cast<int>(k);
    object.cloud_W = geometry::transformed(geometry::select(cloud_C, members[k]), scene.X_WC);
    object.mask = std::move(images.masks[k]);
    object.touches_image_border = touches_border(object.mask, area, margin) ||
                                  is_cut_above(cloud_C, members[k], table, options) ||
                                  is_cut_by_right_image(cloud_C, members[k], camera, options);
    object.may_be_several = found.objects[k].may_be_several;
    scene.objects.push_back(std::move(object));
  }
  find_occlusions(scene);
  std::vector<const PointCloud*> clouds_W;
  for (const ObjectHypothesis& object : scene.objects) clouds_W.push_back(&object.cloud_W);
  const std::vector<double> supports = support_heights(clouds_W, scene.table_W);
  for (std::size_t k = 0; k < supports.size(); ++k) {
    if (supports[k] <= 0) continue;
    scene.objects[k].support_W = scene.table_W;
    scene.objects[k].support_W->offset += supports[k];
  }
  for (const FoundObjects::Dropped& dropped : found.dropped) {
    Eigen::Vector3d center_C = Eigen::Vector3d::Zero();
    for (const int i : dropped.members) center_C += cloud_C.points[i].cast<double>();
    center_C /= static_cast<double>(dropped.members.size());
    const Eigen::Vector3d p = scene.X_WC * center_C;
    char place[80];
    std::snprintf(place, sizeof place, "%zu points at (%.2f %.2f %.2f) m: ", dropped.members.size(),
                  p.x(), p.y(), p.z());
    scene.dropped.push_back(place + dropped.reason);
  }
  return scene;
}

SegmentedScene segment(const PointCloud& cloud_C, const geometry::PinholeCamera& camera,
                       const std::optional<RigidTransform>& X_WC,
                       const SegmentationOptions& options, const TableOptions& table_options) {
  std::optional<Eigen::Vector3d> up_C;
  if (X_WC) up_C = X_WC->linear().transpose() * Eigen::Vector3d::UnitZ();
  const Table table = find_table(cloud_C, table_options, up_C);
  return segment_on_table(cloud_C, camera, table, X_WC, options);
}

}  // namespace prehend::perception
