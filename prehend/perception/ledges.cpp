#include "prehend/perception/ledges.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <utility>

#include <opencv2/imgproc.hpp>

#include "prehend/perception/mean_color.h"
#include "prehend/text/require.h"

namespace prehend::perception {
namespace {

constexpr int kMostParts = 6;             // of a cluster
constexpr std::size_t kLeastPoints = 60;  // of a part
constexpr double kOverLedge = 0.004;      // m: noise of the ledge
constexpr double kRisen = 0.01;           // m over a ledge: what is higher is not of it
constexpr int kReach = 4;                 // cells between a ledge and what rises beside it
constexpr int kLeastContact = 8;          // cells of the ledge within that
constexpr double kLeastLedgeShare = 0.2;  // of the area that rises
constexpr double kLeastRim = 0.1;         // of it, where the colours differ by twice the least
constexpr double kMostEnclosed = 0.4;     // of the ledge, by what rises: else it is a hollow
constexpr double kWallGoesOn = 0.5;       // of the points per height above the ledge
constexpr double kLeastWall = 0.012;      // m of height that shows a wall
constexpr double kLowShare = 0.05;        // of all points, where the step shows none

void check(const LedgeOptions& o) {
  const text::Require require{"LedgeOptions: "};
  require(std::isfinite(o.cell) && o.cell > 0, "cell must be positive");
  require(std::isfinite(o.flatness) && o.flatness > 0, "flatness must be positive");
  require(std::isfinite(o.least_step) && o.least_step > o.flatness,
          "least_step must exceed flatness");
  require(o.least_height >= 0 && o.least_plate >= 0 && o.least_width >= 0,
          "lengths and areas must not be negative");
  require(o.least_color_difference >= 0 && o.least_hue_difference >= 0,
          "differences must not be negative");
  require(o.least_level_share >= 0 && o.least_level_share <= 1,
          "least_level_share must be in [0, 1]");
}

/// Points of a cluster over the table: heights, cells, and the map of tops.
class Tops {
 public:
  Tops(const geometry::PointCloud& cloud_C, const geometry::Plane& table_C,
       const std::vector<int>& members, const LedgeOptions& options)
      : options_(options) {
    const Eigen::Vector3d x = table_C.normal.unitOrthogonal();
    const Eigen::Vector3d y = table_C.normal.cross(x);
    Eigen::AlignedBox2d box;
    std::vector<Eigen::Vector2d> flat;
    for (const int i : members) {
      const Eigen::Vector3d p = cloud_C.points[i].cast<double>();
      heights.push_back(table_C.signed_distance(p));
      flat.emplace_back(x.dot(p), y.dot(p));
      box.extend(flat.back());
    }
    towards_camera_ = -Eigen::Vector2d(box.center()).normalized();
    camera_distance_ = box.center().norm();
    camera_height_ = table_C.signed_distance(Eigen::Vector3d::Zero());
    const Eigen::Array2d size = (box.sizes() / options.cell).array().floor() + 1;
    if (!(size.maxCoeff() < kMostCells)) return;  // wider than anything that one grasps
    top = cv::Mat(static_cast<int>(size.y()), static_cast<int>(size.x()), CV_32F, cv::Scalar(0));
    for (std::size_t k = 0; k < members.size(); ++k) {
      const Eigen::Vector2d q = (flat[k] - box.min()) / options.cell;
      cells.emplace_back(static_cast<int>(q.x()), static_cast<int>(q.y()));
      float& highest = top.at<float>(cells.back());
      highest = std::max(highest, static_cast<float>(heights[k]));
    }
    cv::medianBlur(top, top, 3);  // single points that fly
  }

  /// Connected tops: 1, 2, ... in `labels`, their heights [m] and numbers of cells.
  struct Plates {
    cv::Mat labels;  // CV_32S
    std::vector<double> heights;
    std::vector<int> cells;
  };
  /// What something may stand on: `level`, without a slope. What rises may be round: all that is
  /// about at one height.
  Plates plates(bool level) const {
    cv::Mat flat(top.size(), CV_8U, cv::Scalar(0));
    for (int v = 1; v + 1 < top.rows; ++v) {
      for (int u = 1; u + 1 < top.cols; ++u) {
        constexpr int kLeastAround = 6;  // of nine
        int around = 0;
        for (int dv = -1; dv <= 1; ++dv) {
          for (int du = -1; du <= 1; ++du) {
            const float h = top.at<float>(v + dv, u + du);
            around += h > 0 &&
                      std::abs(static_cast<double>(h - top.at<float>(v, u))) <= options_.flatness;
          }
        }
        const bool is_flat = top.at<float>(v, u) > 0 && around >= kLeastAround;
        flat.at<std::uint8_t>(v, u) = is_flat && !(level && slopes(u, v)) ? 255 : 0;
      }
    }
    Plates plates;
    plates.labels = cv::Mat(top.size(), CV_32S, cv::Scalar(0));
    for (int v = 0; v < top.rows; ++v) {
      for (int u = 0; u < top.cols; ++u) {
        if (flat.at<std::uint8_t>(v, u) != 0 && plates.labels.at<int>(v, u) == 0) {
          grow(flat, {u, v}, plates);
        }
      }
    }
    return plates;
  }

  cv::Mat top;                   // CV_32F, greatest height over each cell [m]; 0: no point
  std::vector<double> heights;   // m, one a member
  std::vector<cv::Point> cells;  // likewise

  /// `risen` and what it hides at `low` [m] behind it, when it is `high`.
  cv::Mat with_shadow(const cv::Mat& risen, double high, double low) const {
    const double over = std::max(camera_height_ - high, 1e-3);
    const double length = std::min((high - low) * camera_distance_ / over, kLongestShadow);
    cv::Mat result = risen.clone(), moved;
    for (int k = 1; k <= std::ceil(length / options_.cell); ++k) {
      const cv::Matx23d shift(1, 0, -k * towards_camera_.x(), 0, 1, -k * towards_camera_.y());
      cv::warpAffine(risen, moved, shift, risen.size(), cv::INTER_NEAREST);
      result |= moved;
    }
    return result;
  }

  /// The edge that faces the camera: `region` without the same, moved a little away from the
  /// camera.
  cv::Mat near_edge(const cv::Mat& region) const {
    constexpr double kWidth = 2;  // cells
    const cv::Matx23d shift(1, 0, -kWidth * towards_camera_.x(), 0, 1,
                            -kWidth * towards_camera_.y());
    cv::Mat moved;
    cv::warpAffine(region, moved, shift, region.size(), cv::INTER_NEAREST);
    return region & ~moved;
  }

 private:
  static constexpr double kMostCells = 1000;
  static constexpr double kLongestShadow = 0.15;  // m

  /// Whether the top slopes by more than 10 degrees along an axis, to both sides alike: what falls
  /// to one side only is an edge.
  bool slopes(int u, int v) const {
    constexpr int kRun = 2;          // cells
    constexpr double kSteep = 0.18;  // tangent
    const double least = kSteep * kRun * options_.cell;
    for (const cv::Point& step : {cv::Point(kRun, 0), cv::Point(0, kRun)}) {
      const cv::Point before = cv::Point(u, v) - step, after = cv::Point(u, v) + step;
      if (before.x < 0 || before.y < 0 || after.x >= top.cols || after.y >= top.rows) continue;
      if (top.at<float>(before) <= 0 || top.at<float>(after) <= 0) continue;
      const auto rise = static_cast<double>(top.at<float>(v, u) - top.at<float>(before));
      const auto next = static_cast<double>(top.at<float>(after) - top.at<float>(v, u));
      if (rise * next > 0 && std::min(std::abs(rise), std::abs(next)) > least) return true;
    }
    return false;
  }

  void grow(const cv::Mat& flat, const cv::Point& from, Plates& plates) const {
    const int label = static_cast<int>(plates.heights.size()) + 1;
    double sum = 0;
    int count = 0;
    std::vector<cv::Point> reached{from};
    plates.labels.at<int>(from) = label;
    while (!reached.empty()) {
      const cv::Point at = reached.back();
      reached.pop_back();
      sum += static_cast<double>(top.at<float>(at));
      ++count;
      for (const cv::Point& step : {cv::Point(1, 0), {-1, 0}, {0, 1}, {0, -1}}) {
        const cv::Point next = at + step;
        if (next.x < 0 || next.y < 0 || next.x >= top.cols || next.y >= top.rows) continue;
        if (flat.at<std::uint8_t>(next) == 0 || plates.labels.at<int>(next) != 0) continue;
        if (std::abs(top.at<float>(next) - top.at<float>(at)) >
                static_cast<float>(options_.flatness) ||
            std::abs(static_cast<double>(top.at<float>(next)) - sum / count) > kOverLedge) {
          continue;
        }
        plates.labels.at<int>(next) = label;
        reached.push_back(next);
      }
    }
    plates.heights.push_back(sum / count);
    plates.cells.push_back(count);
  }

  const LedgeOptions& options_;
  Eigen::Vector2d towards_camera_ = Eigen::Vector2d::Zero();  // along the table, unit
  double camera_distance_ = 0;                                // m, along the table
  double camera_height_ = 0;                                  // m, over the table
};

cv::Mat widened(const cv::Mat& region, int cells) {
  cv::Mat result;
  cv::dilate(region, result,
             cv::getStructuringElement(cv::MORPH_RECT, {2 * cells + 1, 2 * cells + 1}));
  return result;
}

/// The convex hull of a region's cells.
cv::Mat convex(const cv::Mat& region) {
  std::vector<cv::Point> points, hull;
  cv::findNonZero(region, points);
  cv::Mat result(region.size(), CV_8U, cv::Scalar(0));
  if (points.empty()) return result;
  cv::convexHull(points, hull);
  cv::fillConvexPoly(result, hull, cv::Scalar(255));
  return result;
}

/// Of each cell, how far it is from the region [cells].
cv::Mat distance_to(const cv::Mat& region) {
  cv::Mat distance;
  cv::distanceTransform(255 - region, distance, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  return distance;
}

/// What rises over the ledge at `height` and has `plate` on top; 255 within.
cv::Mat risen_region(const Tops& tops, const cv::Mat& plate, double height) {
  const cv::Mat over = tops.top > height;
  cv::Mat labels, region(over.size(), CV_8U, cv::Scalar(0));
  cv::connectedComponents(over, labels, 8, CV_32S);
  int label = 0;
  for (int v = 0; v < over.rows && label == 0; ++v) {
    for (int u = 0; u < over.cols && label == 0; ++u) {
      if (plate.at<std::uint8_t>(v, u) != 0) label = labels.at<int>(v, u);
    }
  }
  if (label > 0) region = labels == label;
  return region;
}

/// Whether the ledge is a ledge of what rises, and that a thing of its own.
bool is_step(const cv::Mat& ledge, const cv::Mat& level, const cv::Mat& risen,
             const cv::Mat& shadow, const LedgeOptions& options) {
  const double risen_cells = cv::countNonZero(risen);
  const double ledge_cells = cv::countNonZero(ledge);
  if (ledge_cells < kLeastRim * risen_cells) return false;
  if (cv::countNonZero(level & risen) < options.least_level_share * risen_cells) return false;
  if (cv::countNonZero(ledge & widened(shadow, kReach)) < kLeastContact) return false;
  cv::Mat thick;
  const int width = std::max(1, static_cast<int>(options.least_width / options.cell));
  cv::erode(risen, thick, cv::getStructuringElement(cv::MORPH_RECT, {width, width}));
  if (cv::countNonZero(thick) == 0) return false;
  return cv::countNonZero(ledge & convex(risen)) <= kMostEnclosed * ledge_cells;
}

/// Whether what rises stands before the ledge, so that no wall under it can be seen.
bool is_behind(const Tops& tops, const cv::Mat& ledge, const cv::Mat& shadow) {
  constexpr double kMostInView = 0.3;  // of the ledge's near edge
  const cv::Mat edge = tops.near_edge(ledge);
  const int hidden = cv::countNonZero(edge & widened(shadow, kReach));
  return hidden > 0 && hidden > (1 - kMostInView) * cv::countNonZero(edge);
}

/// Whether a wall was seen under the ledge: a wing, a brim has none.
bool is_carried(const Tops& tops, const cv::Mat& ledge, const cv::Mat& risen, double height) {
  constexpr double kLeastShare = 0.02;  // of all points
  const cv::Mat about = widened(ledge, kReach) & ~widened(risen, 1);
  std::size_t under = 0;
  for (std::size_t k = 0; k < tops.cells.size(); ++k) {
    under += about.at<std::uint8_t>(tops.cells[k]) != 0 && tops.heights[k] > 0.3 * height &&
             tops.heights[k] < 0.75 * height;
  }
  return static_cast<double>(under) > kLeastShare * static_cast<double>(tops.cells.size());
}

using Parts = std::pair<std::vector<int>, std::vector<int>>;

/// Whether what rises goes on down to the table beside the ledge, rather than stands on it: then
/// its wall is seen under the ledge's height as well. Where the walls of two are flush that looks
/// alike; the colours, if there are any, decide: the lower wall has the upper's or the ledge's.
bool stands_beside(const geometry::PointCloud& cloud_C, const Tops& tops,
                   const std::vector<int>& members, const cv::Mat& ledge, const cv::Mat& risen,
                   double ledge_height, double top_height, const LedgeOptions& options) {
  constexpr double kFoot = 0.01;     // m over the table, where points are lost
  constexpr double kMargin = 0.008;  // m under the ledge, where its edge is
  const cv::Mat about = widened(risen, 1);
  std::vector<int> above, below, on_ledge;
  for (std::size_t k = 0; k < members.size(); ++k) {
    const double h = tops.heights[k];
    if (ledge.at<std::uint8_t>(tops.cells[k]) != 0 && h > ledge_height - kOverLedge) {
      on_ledge.push_back(members[k]);
    }
    if (about.at<std::uint8_t>(tops.cells[k]) == 0) continue;
    if (h > ledge_height + kOverLedge && h < top_height - kOverLedge) above.push_back(members[k]);
    if (h > kFoot && h < ledge_height - kMargin) below.push_back(members[k]);
  }
  const double step = top_height - ledge_height - 2 * kOverLedge;
  const double under = std::max(ledge_height - kMargin - kFoot, 1e-3);
  const auto count = static_cast<double>(below.size());
  const bool wall_goes_on =
      step >= kLeastWall ? count / under > kWallGoesOn * static_cast<double>(above.size()) / step
                         : count > kLowShare * static_cast<double>(members.size());
  if (!wall_goes_on || cloud_C.colors.size() != cloud_C.size() || above.empty())
    return wall_goes_on;
  // Walls are in the shade of what is above them, so the hues tell more, where there are two.
  const auto difference = hue_difference(cloud_C, above, on_ledge) >= options.least_hue_difference
                              ? hue_difference
                              : color_difference;
  return difference(cloud_C, below, above) <= difference(cloud_C, below, on_ledge);
}

/// The members that belong to what rises, and the others. What stands beside the ledge has what is
/// nearer to it; what stands on it has what is over it, and what hangs or leans over its edge down
/// to the table.
Parts divided(const Tops& tops, const std::vector<int>& members, const cv::Mat& ledge,
              const cv::Mat& risen, double ledge_height, bool beside) {
  constexpr float kWall = 2;      // cells round what rises, where its wall is
  constexpr int kLedgesWall = 4;  // cells round the ledge, likewise
  const cv::Mat to_risen = distance_to(risen), to_ledge = distance_to(ledge);
  const cv::Mat to_lower = distance_to(widened(convex(ledge), kLedgesWall));
  Parts parts;
  for (std::size_t k = 0; k < members.size(); ++k) {
    const cv::Point& cell = tops.cells[k];
    const float away = to_risen.at<float>(cell);
    const bool rises = beside ? away < to_ledge.at<float>(cell)
                              : (tops.heights[k] > ledge_height + kOverLedge && away <= kWall) ||
                                    away < to_lower.at<float>(cell);
    (rises ? parts.first : parts.second).push_back(members[k]);
  }
  return parts;
}

/// Whether the parts have colours of their own, not two shades of one. A rim alone may be a lid's:
/// then the colours must be known and differ by twice as much.
bool differ(const geometry::PointCloud& cloud_C, const Parts& parts, bool is_rim,
            const LedgeOptions& options) {
  constexpr double kBeyondShade = 5;  // times the least difference: no shade makes that
  if (cloud_C.colors.size() != cloud_C.size()) return !is_rim;
  const double factor = is_rim ? 2 : 1;
  const double difference = color_difference(cloud_C, parts.first, parts.second);
  return difference >= factor * options.least_color_difference &&
         (hue_difference(cloud_C, parts.first, parts.second) >=
              factor * options.least_hue_difference ||
          difference >= factor * kBeyondShade * options.least_color_difference);
}

/// @param alike  set where a ledge was found whose sides have colours of one thing
std::optional<Parts> split_once(const geometry::PointCloud& cloud_C, const geometry::Plane& table_C,
                                const std::vector<int>& members, const LedgeOptions& options,
                                bool* alike) {
  if (members.size() < 2 * kLeastPoints) return std::nullopt;
  const Tops tops(cloud_C, table_C, members, options);
  if (tops.top.empty()) return std::nullopt;
  const Tops::Plates lows = tops.plates(true), highs = tops.plates(false);
  const cv::Mat level = highs.labels > 0;
  const double least_cells = options.least_plate / (options.cell * options.cell);
  for (std::size_t low = 0; low < lows.heights.size(); ++low) {
    const double height = lows.heights[low];
    if (lows.cells[low] < least_cells || height < options.least_height) continue;
    // What stands in its middle may cut a ledge in two.
    cv::Mat ledge(lows.labels.size(), CV_8U, cv::Scalar(0));
    for (std::size_t k = 0; k < lows.heights.size(); ++k) {
      if (std::abs(lows.heights[k] - height) <= kOverLedge) {
        ledge |= lows.labels == static_cast<int>(k) + 1;
      }
    }
    for (std::size_t high = 0; high < highs.heights.size(); ++high) {
      const double step = highs.heights[high] - height;
      if (highs.cells[high] < least_cells || step < options.least_step) continue;
      const cv::Mat plate = highs.labels == static_cast<int>(high) + 1;
      // With all that is between, such as the middle one of three.
      const cv::Mat risen = risen_region(tops, plate, height + std::min(0.5 * step, kRisen));
      const cv::Mat shadow = tops.with_shadow(risen, highs.heights[high], height);
      if (!is_step(ledge, level, risen, shadow, options)) continue;
      if (!is_carried(tops, ledge, risen, height) && !is_behind(tops, ledge, shadow)) continue;
      const bool beside =
          stands_beside(cloud_C, tops, members, ledge, risen, height, highs.heights[high], options);
      Parts parts = divided(tops, members, ledge, risen, height, beside);
      if (std::min(parts.first.size(), parts.second.size()) < kLeastPoints) continue;
      const bool is_rim = cv::countNonZero(ledge) < kLeastLedgeShare * cv::countNonZero(risen);
      if (!differ(cloud_C, parts, is_rim, options)) {
        *alike = *alike || !is_rim;
        continue;
      }
      return parts;
    }
  }
  return std::nullopt;
}

}  // namespace

std::vector<LedgePart> split_at_ledges(const geometry::PointCloud& cloud_C,
                                       const geometry::Plane& table_C,
                                       const std::vector<int>& members,
                                       const LedgeOptions& options) {
  check(options);
  std::vector<std::vector<int>> open{members};
  std::vector<LedgePart> parts;
  while (!open.empty()) {
    LedgePart part{std::move(open.back())};
    open.pop_back();
    std::optional<Parts> two;
    if (parts.size() + open.size() + 1 < kMostParts) {
      two = split_once(cloud_C, table_C, part.members, options, &part.may_be_several);
    }
    if (two) {
      open.push_back(std::move(two->first));
      open.push_back(std::move(two->second));
    } else {
      parts.push_back(std::move(part));
    }
  }
  std::sort(parts.begin(), parts.end(), [](const LedgePart& a, const LedgePart& b) {
    return a.members.size() != b.members.size() ? a.members.size() > b.members.size()
                                                : a.members < b.members;
  });
  return parts;
}

}  // namespace prehend::perception
