#include "prehend/calibration/board_view.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include <opencv2/aruco/charuco.hpp>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "prehend/calibration/marker_dictionary.h"
#include "prehend/calibration/opencv_values.h"

namespace prehend::calibration {
namespace {

using Kind = CalibrationBoard::Kind;

constexpr int kLargeImage = 1000;  // pixels wide: a chessboard is looked for at half the size first

struct FoundCorner {
  int id;
  cv::Point2f pixel;
};

BoardView as_view(const std::string& name, std::vector<FoundCorner> corners) {
  std::sort(corners.begin(), corners.end(),
            [](const FoundCorner& a, const FoundCorner& b) { return a.id < b.id; });
  BoardView view;
  view.name = name;
  for (const FoundCorner& corner : corners) {
    view.ids.push_back(corner.id);
    view.pixels.emplace_back(corner.pixel.x, corner.pixel.y);
  }
  return view;
}

// Half of the window of a refinement: as large as the printed pattern round the corner allows.
int half_window(double free_side) {
  return static_cast<int>(std::clamp(std::floor(0.4 * free_side), 2.0, 7.0));
}

void refine(const cv::Mat& grey, cv::Point2f& pixel, int half) {
  std::vector<cv::Point2f> one{pixel};
  cv::cornerSubPix(grey, one, {half, half}, {-1, -1},
                   {cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 60, 1e-4});
  pixel = one.front();
}

double distance_of(const cv::Point2f& a, const cv::Point2f& b) {
  return std::hypot(a.x - b.x, a.y - b.y);
}

// Mean grey level of the quadrilateral cell whose corners are given.
double level_in(const cv::Mat& grey, const std::array<cv::Point2f, 4>& cell) {
  double sum = 0;
  int count = 0;
  for (const double s : {0.35, 0.5, 0.65}) {
    for (const double t : {0.35, 0.5, 0.65}) {
      const cv::Point2f p = cell[0] * ((1 - s) * (1 - t)) + cell[1] * (s * (1 - t)) +
                            cell[2] * (s * t) + cell[3] * ((1 - s) * t);
      const int u = cvRound(p.x), v = cvRound(p.y);
      if (u < 0 || v < 0 || u >= grey.cols || v >= grey.rows) continue;
      sum += grey.at<std::uint8_t>(v, u);
      ++count;
    }
  }
  return count > 0 ? sum / count : 0;
}

// The corners roughly; empty unless there are all.
std::vector<cv::Point2f> chessboard_corners(const cv::Mat& grey, int columns, int rows) {
  std::vector<cv::Point2f> pixels;
  if (!cv::findChessboardCorners(
          grey, {columns, rows}, pixels,
          cv::CALIB_CB_ADAPTIVE_THRESH | cv::CALIB_CB_NORMALIZE_IMAGE | cv::CALIB_CB_FAST_CHECK) ||
      pixels.size() != static_cast<std::size_t>(columns * rows)) {
    return {};
  }
  return pixels;
}

std::vector<FoundCorner> find_chessboard(const cv::Mat& grey, const CalibrationBoard& board) {
  const int columns = board.columns - 1, rows = board.rows - 1;
  std::vector<cv::Point2f> pixels;
  if (grey.cols >= kLargeImage) {  // four times as fast, and enough to begin with
    cv::Mat half;
    cv::resize(grey, half, {}, 0.5, 0.5, cv::INTER_AREA);
    cv::GaussianBlur(half, half, {0, 0}, 1.0);  // noise makes many quadrangles
    pixels = chessboard_corners(half, columns, rows);
    for (cv::Point2f& pixel : pixels) pixel = 2 * pixel + cv::Point2f(0.5f, 0.5f);
  }
  if (pixels.empty()) pixels = chessboard_corners(grey, columns, rows);
  if (pixels.empty()) return {};
  double side = 1e9;
  for (int i = 0; i + 1 < columns * rows; ++i) {
    const auto k = static_cast<std::size_t>(i);
    if ((i + 1) % columns != 0) side = std::min(side, distance_of(pixels[k], pixels[k + 1]));
    if (i + columns < columns * rows) {
      side = std::min(side, distance_of(pixels[k], pixels[k + static_cast<std::size_t>(columns)]));
    }
  }
  for (cv::Point2f& pixel : pixels) refine(grey, pixel, half_window(side));
  const auto at = [&](int column, int row) {
    return pixels[static_cast<std::size_t>(row * columns + column)];
  };
  // Rows and columns must turn as the board's do, or it is seen in a mirror; and between the first
  // four inner corners is a black square, if the upper left one is.
  const cv::Point2f x = at(columns - 1, 0) - at(0, 0), y = at(0, rows - 1) - at(0, 0);
  if (x.x * y.y - x.y * y.x < 0) {
    for (int row = 0; row < rows; ++row) {
      std::reverse(pixels.begin() + row * columns, pixels.begin() + (row + 1) * columns);
    }
  }
  const double here = level_in(grey, {at(0, 0), at(1, 0), at(1, 1), at(0, 1)});
  const double beside = columns > 2 ? level_in(grey, {at(1, 0), at(2, 0), at(2, 1), at(1, 1)})
                                    : level_in(grey, {at(0, 1), at(1, 1), at(1, 2), at(0, 2)});
  if (here > beside) std::reverse(pixels.begin(), pixels.end());
  std::vector<FoundCorner> corners;
  for (int i = 0; i < columns * rows; ++i) {
    corners.push_back({i, pixels[static_cast<std::size_t>(i)]});
  }
  return corners;
}

cv::Ptr<cv::aruco::DetectorParameters> detector_parameters() {
  const auto parameters = cv::aruco::DetectorParameters::create();
  parameters->cornerRefinementMethod = cv::aruco::CORNER_REFINE_NONE;
  parameters->minMarkerPerimeterRate = 0.015;
  parameters->minMarkerDistanceRate = 0.01;
  return parameters;
}

std::vector<FoundCorner> find_charuco(const cv::Mat& grey, const CalibrationBoard& board) {
  const auto pattern = charuco_board(board);
  std::vector<std::vector<cv::Point2f>> markers;
  std::vector<int> ids;
  cv::aruco::detectMarkers(grey, pattern->dictionary, markers, ids, detector_parameters());
  if (ids.empty()) return {};
  std::vector<cv::Point2f> pixels;
  std::vector<int> found;
  cv::aruco::interpolateCornersCharuco(markers, ids, grey, pattern, pixels, found);
  std::vector<FoundCorner> corners;
  for (std::size_t i = 0; i < found.size(); ++i) {
    const cv::Point3f p = pattern->chessboardCorners[static_cast<std::size_t>(found[i])];
    const int column = cvRound(p.x / board.square) - 1;
    const int row = cvRound(p.y / board.square) - 1;
    // From the corner to the nearest marker all is white.
    double nearest = 1e9, side = 0;
    for (const auto& marker : markers) {
      for (std::size_t k = 0; k < 4; ++k) {
        const double away = distance_of(marker[k], pixels[i]);
        if (away >= nearest) continue;
        nearest = away;
        side = std::min(distance_of(marker[k], marker[(k + 1) % 4]),
                        distance_of(marker[k], marker[(k + 3) % 4]));
      }
    }
    refine(grey, pixels[i],
           half_window(1.25 * side / board.marker * (board.square - board.marker)));
    corners.push_back({row * (board.columns - 1) + column, pixels[i]});
  }
  return corners;
}

// Without the corners that are not where their neighbours say: refined to something else.
std::vector<FoundCorner> without_strays(const std::vector<FoundCorner>& corners,
                                        const CalibrationBoard& board) {
  constexpr std::size_t kNeighbors = 16;
  if (corners.size() <= kNeighbors) return corners;
  std::vector<FoundCorner> kept;
  for (const FoundCorner& corner : corners) {
    const Eigen::Vector3d here = board.corner_T(corner.id);
    std::vector<std::pair<double, std::size_t>> near;
    for (std::size_t i = 0; i < corners.size(); ++i) {
      if (corners[i].id == corner.id) continue;
      near.emplace_back((board.corner_T(corners[i].id) - here).norm(), i);
    }
    std::partial_sort(near.begin(), near.begin() + kNeighbors, near.end());
    std::vector<cv::Point2f> on_board, in_image;
    for (std::size_t n = 0; n < kNeighbors; ++n) {
      const Eigen::Vector3d p = board.corner_T(corners[near[n].second].id);
      on_board.emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()));
      in_image.push_back(corners[near[n].second].pixel);
    }
    const cv::Mat found = cv::findHomography(on_board, in_image, cv::RANSAC, 1.5);
    if (found.empty()) continue;
    const Eigen::Vector3d p = eigen_of(found) * Eigen::Vector3d(here.x(), here.y(), 1);
    if (std::hypot(p.x() / p.z() - corner.pixel.x, p.y() / p.z() - corner.pixel.y) > 1.5) continue;
    kept.push_back(corner);
  }
  return kept;
}

std::vector<FoundCorner> find_tags(const cv::Mat& grey, const CalibrationBoard& board) {
  std::vector<std::vector<cv::Point2f>> tags;
  std::vector<int> ids;
  const auto dictionary = marker_dictionary(board.kind, board.dictionary);
  cv::aruco::detectMarkers(grey, dictionary, tags, ids, detector_parameters());
  std::vector<FoundCorner> corners;
  for (std::size_t t = 0; t < ids.size(); ++t) {
    if (ids[t] >= board.columns * board.rows || std::count(ids.begin(), ids.end(), ids[t]) > 1) {
      continue;
    }
    double side = 1e9;
    for (std::size_t i = 0; i < 4; ++i)
      side = std::min(side, distance_of(tags[t][i], tags[t][(i + 1) % 4]));
    const int half = half_window(side / board.marker * board.gap);
    for (std::size_t i = 0; i < 4; ++i) {
      cv::Point2f pixel = tags[t][i];
      refine(grey, pixel, half);
      // A refinement that wanders off has found another corner.
      if (distance_of(pixel, tags[t][i]) > half) continue;
      corners.push_back({4 * ids[t] + static_cast<int>(i), pixel});
    }
  }
  return without_strays(corners, board);
}

}  // namespace

BoardView find_board(const geometry::ColorImage& image, const CalibrationBoard& board,
                     const std::string& name) {
  if (image.empty()) throw std::invalid_argument("the image is empty");
  const cv::Mat color(image.height, image.width, CV_8UC3,
                      const_cast<geometry::Rgb*>(image.data.data()));
  cv::Mat grey;
  cv::cvtColor(color, grey, cv::COLOR_RGB2GRAY);
  switch (board.kind) {
    case Kind::kChessboard:
      return as_view(name, find_chessboard(grey, board));
    case Kind::kCharuco:
      return as_view(name, find_charuco(grey, board));
    case Kind::kAprilTagGrid:
      return as_view(name, find_tags(grey, board));
  }
  return {};
}

std::optional<BoardPose> board_pose(const BoardView& view, const CalibrationBoard& board,
                                    const perception::CameraCalibration& camera) {
  if (view.ids.size() < 4 || is_in_line(view, board)) return std::nullopt;
  const std::vector<cv::Point3f> points = board_points(view, board);
  const std::vector<cv::Point2f> pixels = view_pixels(view);
  const cv::Mat K = matrix_of(camera.K);
  cv::Vec3d rotation, translation;
  if (!cv::solvePnP(points, pixels, K, camera.distortion, rotation, translation, false,
                    cv::SOLVEPNP_IPPE)) {
    return std::nullopt;
  }
  cv::solvePnPRefineLM(points, pixels, K, camera.distortion, rotation, translation,
                       {cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 100, 1e-12});
  if (!(translation[2] > 0)) return std::nullopt;
  BoardPose pose;
  pose.X_CT = transform_of(rotation, translation);
  std::vector<cv::Point2f> again;
  cv::projectPoints(points, rotation, translation, K, camera.distortion, again);
  double sum = 0;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    sum += std::pow(distance_of(again[i], pixels[i]), 2);
  }
  pose.rms = std::sqrt(sum / static_cast<double>(pixels.size()));
  return pose;
}

Eigen::Vector2d project(const perception::CameraCalibration& camera, const Eigen::Vector3d& p_C) {
  const std::vector<cv::Point3d> point{{p_C.x(), p_C.y(), p_C.z()}};
  std::vector<cv::Point2d> pixel;
  cv::projectPoints(point, cv::Vec3d(), cv::Vec3d(), matrix_of(camera.K), camera.distortion, pixel);
  return {pixel.front().x, pixel.front().y};
}

}  // namespace prehend::calibration
