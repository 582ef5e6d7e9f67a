#include "prehend/perception/dark_background.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include <opencv2/imgproc.hpp>

#include "prehend/geometry/errors.h"
#include "prehend/perception/disc.h"
#include "prehend/perception/masks.h"
#include "prehend/perception/segmentation.h"
#include "prehend/perception/stereo.h"

namespace prehend::perception {
namespace {

using geometry::InputError;

// Of the image that must be darker than the threshold for the background to count as black.
constexpr double kLeastDark = 0.05;
constexpr double kLowestPoints = 0.01;  // quantile of the heights that stands on the table
constexpr double kLeastContrast = 25;   // grey levels between the means of bright and dark

void check(const DarkBackgroundOptions& o) {
  const auto require = [](bool condition, const char* what) {
    if (!condition) throw std::invalid_argument(std::string("DarkBackgroundOptions: ") + what);
  };
  require(o.threshold >= 0 && o.threshold <= 254, "threshold must be 0..254");
  require(o.open_radius >= 0 && o.open_radius <= 50, "open_radius must be 0..50");
  require(o.close_radius >= 0 && o.close_radius <= 50, "close_radius must be 0..50");
  require(o.min_points > 0, "min_points must be positive");
  require(o.max_distance > 0, "max_distance must be positive");
  require(o.max_depth_spread > 0, "max_depth_spread must be positive");
  require(o.max_objects > 0, "max_objects must be positive");
}

// 255 where the image is bright.
cv::Mat bright_pixels(const geometry::ColorImage& image, const DarkBackgroundOptions& options) {
  cv::Mat level(image.height, image.width, CV_8UC1);
  for (int v = 0; v < image.height; ++v) {
    for (int u = 0; u < image.width; ++u) {
      const geometry::Rgb& c = image.at(u, v);
      level.at<std::uint8_t>(v, u) = std::max({c[0], c[1], c[2]});
    }
  }
  cv::Mat bright;
  if (options.threshold > 0) {
    cv::threshold(level, bright, options.threshold, 255, cv::THRESH_BINARY);
  } else {
    cv::threshold(level, bright, 0, 255, cv::THRESH_BINARY | cv::THRESH_OTSU);
  }
  const double dark_share =
      1 - cv::countNonZero(bright) / static_cast<double>(bright.rows * bright.cols);
  const double contrast = cv::mean(level, bright)[0] - cv::mean(level, ~bright)[0];
  if (dark_share < kLeastDark || dark_share == 1 || contrast < kLeastContrast) {
    throw InputError("The image has no bright objects before a dark background (" +
                         std::to_string(std::lround(100 * dark_share)) + " % is dark, contrast " +
                         std::to_string(std::lround(contrast)) + " grey levels)",
                     "Is the background black? Else segment with a table");
  }
  if (options.open_radius > 0) {
    cv::morphologyEx(bright, bright, cv::MORPH_OPEN, disc(options.open_radius));
  }
  if (options.close_radius > 0) {
    cv::morphologyEx(bright, bright, cv::MORPH_CLOSE, disc(options.close_radius));
  }
  return bright;
}

// Without the points that are far from their median depth.
std::vector<int> without_wrong_matches(const geometry::PointCloud& cloud, std::vector<int> members,
                                       double spread) {
  std::vector<float> depths;
  for (const int i : members) depths.push_back(cloud.points[i].z());
  const auto middle = depths.begin() + static_cast<std::ptrdiff_t>(depths.size() / 2);
  std::nth_element(depths.begin(), middle, depths.end());
  const float median = *middle;
  std::erase_if(members, [&](int i) {
    return static_cast<double>(std::abs(cloud.points[i].z() - median)) > spread;
  });
  return members;
}

}  // namespace

SegmentedScene segment_on_dark_background(const geometry::PointCloud& cloud_C,
                                          const geometry::ColorImage& image,
                                          const geometry::PinholeCamera& camera,
                                          const std::optional<Eigen::Vector3d>& up_C,
                                          const std::optional<geometry::RigidTransform>& X_WC,
                                          const DarkBackgroundOptions& options) {
  check(options);
  if (!cloud_C.organized() || cloud_C.width != camera.width || cloud_C.height != camera.height ||
      image.width != camera.width || image.height != camera.height) {
    throw std::invalid_argument(
        "segment_on_dark_background: cloud and image must be of the camera's size");
  }
  if (up_C && (!up_C->allFinite() || up_C->norm() < 1e-9)) {
    throw std::invalid_argument("segment_on_dark_background: up_C must be a direction");
  }
  cv::Mat names;
  const int count = cv::connectedComponents(bright_pixels(image, options), names, 8, CV_32S);
  std::vector<std::vector<int>> members(static_cast<std::size_t>(count));
  std::vector<geometry::MaskImage> masks(static_cast<std::size_t>(count),
                                         geometry::MaskImage(camera.width, camera.height));
  for (int i = 0; i < camera.width * camera.height; ++i) {
    const int name = names.at<int>(i / camera.width, i % camera.width);
    if (name == 0) continue;
    masks[name].data[i] = 255;
    const Eigen::Vector3f& p = cloud_C.points[i];
    if (geometry::is_finite(p) && static_cast<double>(p.norm()) <= options.max_distance) {
      members[name].push_back(i);
    }
  }
  std::vector<int> order;
  for (int name = 1; name < count; ++name) {
    if (members[name].empty()) continue;
    members[name] = without_wrong_matches(cloud_C, members[name], options.max_depth_spread);
    if (static_cast<int>(members[name].size()) >= options.min_points) order.push_back(name);
  }
  std::stable_sort(order.begin(), order.end(),
                   [&](int a, int b) { return members[a].size() > members[b].size(); });
  order.resize(std::min(order.size(), static_cast<std::size_t>(options.max_objects)));
  if (order.empty()) {
    throw InputError(
        "No bright region has " + std::to_string(options.min_points) + " points with depth",
        "Bring the objects nearer, give them texture, or lower min_points");
  }

  geometry::Plane table_C;
  table_C.normal = -Eigen::Vector3d::UnitY();
  if (X_WC) table_C.normal = X_WC->linear().transpose() * Eigen::Vector3d::UnitZ();
  if (up_C) table_C.normal = up_C->normalized();
  std::vector<double> heights;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const int name : order) {
    for (const int i : members[name]) {
      heights.push_back(table_C.normal.dot(cloud_C.points[i].cast<double>()));
      sum += cloud_C.points[i].cast<double>();
    }
  }
  const auto lowest = heights.begin() + static_cast<std::ptrdiff_t>(
                                            kLowestPoints * static_cast<double>(heights.size()));
  std::nth_element(heights.begin(), lowest, heights.end());
  table_C.offset = *lowest;

  SegmentedScene scene;
  scene.camera = camera;
  scene.X_WC = X_WC ? *X_WC : world_from_table(table_C, sum / static_cast<double>(heights.size()));
  scene.depth = depth_of(cloud_C);
  scene.table_W.normal = scene.X_WC.linear() * table_C.normal;
  scene.table_W.offset = table_C.offset + scene.table_W.normal.dot(scene.X_WC.translation());
  const PixelRectangle area{0, 0, camera.width - 1, camera.height - 1};
  for (std::size_t k = 0; k < order.size(); ++k) {
    ObjectHypothesis object;
    object.id = static_cast<int>(k);
    object.cloud_W =
        geometry::transformed(geometry::select(cloud_C, members[order[k]]), scene.X_WC);
    object.mask = std::move(masks[order[k]]);
    object.touches_image_border = touches_border(object.mask, area, options.close_radius);
    scene.objects.push_back(std::move(object));
  }
  return scene;
}

}  // namespace prehend::perception
