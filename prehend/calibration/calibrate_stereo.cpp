#include "prehend/calibration/calibrate_stereo.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include <fmt/format.h>
#include <opencv2/calib3d.hpp>

#include "prehend/calibration/degenerate_data.h"
#include "prehend/calibration/opencv_values.h"
#include "prehend/calibration/view_collection.h"
#include "prehend/perception/rectification.h"

namespace prehend::calibration {
namespace {

constexpr std::size_t kLeastPairs = 4;
constexpr double kGoodPair = 0.1;  // pixels: nothing better is suspected
constexpr double kWorstPair = 5;   // times what the cameras have alone

// Only the corners whose ids both have.
BoardView common_part(const BoardView& view, const BoardView& other) {
  BoardView common;
  common.name = view.name;
  for (std::size_t i = 0; i < view.ids.size(); ++i) {
    if (!std::binary_search(other.ids.begin(), other.ids.end(), view.ids[i])) continue;
    common.ids.push_back(view.ids[i]);
    common.pixels.push_back(view.pixels[i]);
  }
  return common;
}

CameraFit one_camera(const std::vector<StereoView>& views, bool is_left,
                     const CalibrationBoard& board, int width, int height, CameraOptions options) {
  std::vector<BoardView> one;
  for (const StereoView& view : views) one.push_back(is_left ? view.left : view.right);
  options.name = is_left ? "left" : "right";
  try {
    return calibrate_camera(one, board, width, height, options);
  } catch (const DegenerateData& error) {
    throw DegenerateData(error.name(), options.name + " camera: " + error.problem(),
                         "See `prehend calibrate camera` of its images alone");
  }
}

}  // namespace

StereoFit calibrate_stereo(const std::vector<StereoView>& views, const CalibrationBoard& board,
                           int width, int height, const CameraOptions& options) {
  if (board.is_symmetric()) {
    throw DegenerateData(
        "board symmetric", "it looks the same upside down, so the cameras cannot agree on a corner",
        "Use a chessboard with an odd sum of columns and rows, or one with markers");
  }
  StereoFit fit;
  fit.left = one_camera(views, true, board, width, height, options);
  fit.right = one_camera(views, false, board, width, height, options);
  std::vector<std::vector<cv::Point3f>> points;
  std::vector<std::vector<cv::Point2f>> left, right;
  std::vector<int> pairs;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const BoardView l = common_part(views[i].left, views[i].right);
    const BoardView r = common_part(views[i].right, views[i].left);
    if (l.ids.size() < kLeastViewCorners || is_in_line(l, board)) continue;
    if (!fit.left.views[i].used || !fit.right.views[i].used) continue;
    points.push_back(board_points(l, board));
    left.push_back(view_pixels(l));
    right.push_back(view_pixels(r));
    pairs.push_back(static_cast<int>(i));
  }
  if (pairs.size() < kLeastPairs) {
    throw DegenerateData(
        "too few views",
        fmt::format("{} pairs have {} corners in common, {} are needed", pairs.size(),
                    kLeastViewCorners, kLeastPairs),
        "Hold the board where both cameras see it; check that the folders' images are pairs");
  }
  cv::Mat K_left = matrix_of(fit.left.calibration.K), K_right = matrix_of(fit.right.calibration.K);
  cv::Mat d_left = cv::Mat(fit.left.calibration.distortion, true).reshape(1, 1);
  cv::Mat d_right = cv::Mat(fit.right.calibration.distortion, true).reshape(1, 1);
  cv::Mat R, T, E, F;
  cv::Mat per_view;
  const int model = options.coefficients == 8 ? cv::CALIB_RATIONAL_MODEL : 0;
  fit.rms =
      cv::stereoCalibrate(points, left, right, K_left, d_left, K_right, d_right, {width, height}, R,
                          T, E, F, per_view, cv::CALIB_USE_INTRINSIC_GUESS | model,
                          {cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 100, 1e-10});
  perception::StereoCalibration& found = fit.calibration;
  found.width = width;
  found.height = height;
  found.K_left = eigen_of(K_left);
  found.K_right = eigen_of(K_right);
  found.distortion_left = numbers_of(d_left);
  found.distortion_right = numbers_of(d_right);
  found.distortion_left.resize(static_cast<std::size_t>(options.coefficients));
  found.distortion_right.resize(static_cast<std::size_t>(options.coefficients));
  found.X_RL.linear() = eigen_of(R);
  found.X_RL.translation() = Eigen::Vector3d(T.at<double>(0), T.at<double>(1), T.at<double>(2));
  // Each camera alone fits: what is off together is their pose, which did not stay.
  const double alone =
      std::max(std::hypot(fit.left.rms, fit.right.rms) / std::sqrt(2.0), kGoodPair);
  if (!(fit.rms <= kWorstPair * alone)) {
    throw DegenerateData(
        "pairs disagree",
        fmt::format("the cameras alone fit to {:.2g} pixels, together to {:.2g}", alone, fit.rms),
        "Check that the images of a pair are of one moment, in the same order of names, and that "
        "the cameras are mounted firmly");
  }
  if (found.X_RL.translation().x() > 0) {
    throw DegenerateData("cameras exchanged",
                         "the camera that is called left stands to the right of the other one",
                         "Exchange --left and --right");
  }
  for (std::size_t n = 0; n < pairs.size(); ++n) {
    fit.pairs.push_back({pairs[n], static_cast<int>(points[n].size()),
                         per_view.at<double>(static_cast<int>(n), 0),
                         per_view.at<double>(static_cast<int>(n), 1)});
  }

  const perception::StereoRectification rectified = perception::rectification(found, width, height);
  const auto rows_of = [](const std::vector<cv::Point2f>& pixels, const cv::Mat& K,
                          const cv::Mat& distortion, const Eigen::Matrix3d& rotation) {
    std::vector<cv::Point2f> straight;
    cv::undistortPoints(pixels, straight, K, distortion, matrix_of(rotation));
    return straight;
  };
  double rows = 0;
  std::size_t count = 0;
  for (std::size_t n = 0; n < pairs.size(); ++n) {
    const auto l = rows_of(left[n], K_left, d_left, rectified.R_left);
    const auto r = rows_of(right[n], K_right, d_right, rectified.R_right);
    count += l.size();
    for (std::size_t k = 0; k < l.size(); ++k) {
      rows += std::pow(rectified.camera.left.fy * (l[k].y - r[k].y), 2);
    }
  }
  fit.row_rms = std::sqrt(rows / static_cast<double>(count));
  return fit;
}

}  // namespace prehend::calibration
