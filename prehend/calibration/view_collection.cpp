#include "prehend/calibration/view_collection.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>
#include <opencv2/calib3d.hpp>

#include "prehend/calibration/degenerate_data.h"
#include "prehend/calibration/opencv_values.h"

namespace prehend::calibration {
namespace {

constexpr int kRaster = 5;
constexpr double kParallel = 0.087;   // rad, 5 degrees between the two most different views
constexpr double kLeastExtent = 0.3;  // of the image's width or height, of all corners

bool is_useful(const BoardView& view, const CalibrationBoard& board) {
  return view.ids.size() >= kLeastViewCorners && !is_in_line(view, board);
}

std::string count_of(int count, const char* one) {
  return fmt::format("{} {}{}", count, one, count == 1 ? "" : "s");
}

// "the upper left", "the middle": of a third of the image.
std::string place_in_image(int column, int row) {
  static constexpr std::array<const char*, 3> kRows{"upper", "middle", "lower"};
  static constexpr std::array<const char*, 3> kColumns{"left", "middle", "right"};
  const int r = row * 3 / kRaster, c = column * 3 / kRaster;
  if (r == 1 && c == 1) return "middle";
  if (r == 1) return kColumns[static_cast<std::size_t>(c)];
  if (c == 1) return kRows[static_cast<std::size_t>(r)];
  return std::string(kRows[static_cast<std::size_t>(r)]) + " " +
         kColumns[static_cast<std::size_t>(c)];
}

}  // namespace

std::vector<Eigen::Vector3d> board_normals(const std::vector<BoardView>& views,
                                           const CalibrationBoard& board, int width, int height,
                                           double focal) {
  std::vector<Eigen::Vector3d> normals;
  for (const BoardView& view : views) {
    normals.emplace_back(Eigen::Vector3d::Zero());
    if (!is_useful(view, board)) continue;
    std::vector<cv::Point2f> flat;
    for (const cv::Point3f& p : board_points(view, board)) flat.emplace_back(p.x, p.y);
    const cv::Mat found = cv::findHomography(flat, view_pixels(view));
    if (found.empty()) continue;
    Eigen::Matrix3d K;
    K << focal, 0, 0.5 * (width - 1), 0, focal, 0.5 * (height - 1), 0, 0, 1;
    const Eigen::Matrix3d H = K.inverse() * eigen_of(found);
    const Eigen::Vector3d normal = H.col(0).cross(H.col(1));
    if (!(normal.norm() > 0) || !normal.allFinite()) continue;
    normals.back() = normal.normalized() * (normal.z() < 0 ? -1 : 1);
  }
  return normals;
}

std::vector<std::string> still_missing(const std::vector<BoardView>& views,
                                       const CalibrationBoard& board, int width, int height,
                                       const CollectionGoal& goal) {
  int found = 0;
  std::array<std::array<bool, kRaster>, kRaster> seen{};
  for (const BoardView& view : views) {
    if (!is_useful(view, board)) continue;
    ++found;
    for (const Eigen::Vector2d& p : view.pixels) {
      const auto cell = [](double x, int size) {
        return static_cast<std::size_t>(
            std::clamp(static_cast<int>(kRaster * (x + 0.5) / size), 0, kRaster - 1));
      };
      seen[cell(p.y(), height)][cell(p.x(), width)] = true;
    }
  }
  std::vector<std::string> missing;
  if (found < goal.views) missing.push_back(count_of(goal.views - found, "more view"));
  int cells = 0;
  std::vector<std::string> places;
  for (int r = 0; r < kRaster; ++r) {
    for (int c = 0; c < kRaster; ++c) {
      if (seen[static_cast<std::size_t>(r)][static_cast<std::size_t>(c)]) {
        ++cells;
        continue;
      }
      const std::string place = place_in_image(c, r);
      if (!std::count(places.begin(), places.end(), place)) places.push_back(place);
    }
  }
  if (cells < goal.coverage * kRaster * kRaster) {
    missing.push_back(
        fmt::format("corners in these parts of the image: {}", fmt::join(places, ", ")));
  }
  std::array<double, 4> tilts{};  // left edge nearer, right, upper, lower
  for (const Eigen::Vector3d& n : board_normals(views, board, width, height, width)) {
    if (n.isZero()) continue;
    const double about_vertical = std::atan2(n.x(), n.z()),
                 about_horizontal = std::atan2(n.y(), n.z());
    tilts[0] = std::max(tilts[0], about_vertical);
    tilts[1] = std::max(tilts[1], -about_vertical);
    tilts[2] = std::max(tilts[2], about_horizontal);
    tilts[3] = std::max(tilts[3], -about_horizontal);
  }
  // z points away: where the normal goes to the right, the right edge is nearer.
  static constexpr std::array<const char*, 4> kNearer{"right", "left", "lower", "upper"};
  for (std::size_t i = 0; i < tilts.size(); ++i) {
    if (tilts[i] >= goal.tilt) continue;
    missing.push_back(fmt::format("a view with the {} edge {:.0f} degrees nearer to the camera",
                                  kNearer[i], goal.tilt * 180 / M_PI));
  }
  return missing;
}

void require_views(const std::vector<BoardView>& views, const CalibrationBoard& board, int width,
                   int height, int least) {
  std::vector<BoardView> useful;
  for (const BoardView& view : views) {
    if (is_useful(view, board)) useful.push_back(view);
  }
  if (useful.empty()) {
    throw DegenerateData(
        "board not found", fmt::format("in none of {} images", views.size()),
        "Check the board's file against the board: kind, columns, rows, dictionary; and that all "
        "of a chessboard is in view");
  }
  if (static_cast<int>(useful.size()) < least) {
    throw DegenerateData("too few views",
                         fmt::format("the board is in {} of {} images, {} are needed",
                                     useful.size(), views.size(), least),
                         "Take 20, with the board tilted to all sides and in all of the image");
  }
  Eigen::Array2d low = Eigen::Array2d::Constant(1e9), high = -low;
  for (const BoardView& view : useful) {
    for (const Eigen::Vector2d& p : view.pixels) {
      low = low.min(p.array());
      high = high.max(p.array());
    }
  }
  const Eigen::Array2d extent = (high - low) / Eigen::Array2d(width, height);
  if (extent.maxCoeff() < kLeastExtent) {
    throw DegenerateData("corners in a small part of the image alone",
                         fmt::format("they span {:.0f} % of its width and {:.0f} % of its height",
                                     100 * extent.x(), 100 * extent.y()),
                         "Bring the board nearer and to all edges and corners of the image");
  }
  double widest = 0;
  const auto normals = board_normals(useful, board, width, height, width);
  for (std::size_t i = 0; i < normals.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      if (normals[i].isZero() || normals[k].isZero()) continue;
      widest = std::max(
          widest, std::atan2(normals[i].cross(normals[k]).norm(), normals[i].dot(normals[k])));
    }
  }
  if (widest < kParallel) {
    throw DegenerateData(
        "all views parallel",
        fmt::format("the board's directions differ by {:.1f} degrees at most", widest * 180 / M_PI),
        "Tilt the board by 20 to 40 degrees, to all sides");
  }
}

}  // namespace prehend::calibration
