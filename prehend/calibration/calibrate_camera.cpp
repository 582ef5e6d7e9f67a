#include "prehend/calibration/calibrate_camera.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <fmt/format.h>
#include <opencv2/calib3d.hpp>

#include "prehend/calibration/degenerate_data.h"
#include "prehend/calibration/opencv_values.h"
#include "prehend/calibration/view_collection.h"

namespace prehend::calibration {
namespace {

constexpr std::size_t kLeastViews = 4;
constexpr double kMostFocalDeviation = 0.02;  // relative
constexpr double kGoodRms = 0.05;             // pixels: nothing better is suspected

// What a calibration of the chosen views gave.
struct Solved {
  cv::Mat K, distortion, deviations;
  std::vector<cv::Mat> rotations, translations;
};

Solved solve(const std::vector<BoardView>& views, const std::vector<int>& chosen,
             const CalibrationBoard& board, int width, int height, int coefficients) {
  std::vector<std::vector<cv::Point3f>> points;
  std::vector<std::vector<cv::Point2f>> pixels;
  for (const int i : chosen) {
    points.push_back(board_points(views[static_cast<std::size_t>(i)], board));
    pixels.push_back(view_pixels(views[static_cast<std::size_t>(i)]));
  }
  Solved solved;
  cv::Mat object_deviations, per_view;
  try {
    cv::calibrateCamera(points, pixels, {width, height}, solved.K, solved.distortion,
                        solved.rotations, solved.translations, solved.deviations, object_deviations,
                        per_view, coefficients == 8 ? cv::CALIB_RATIONAL_MODEL : 0,
                        {cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 100, 1e-10});
  } catch (const cv::Exception& error) {
    throw DegenerateData("focal length not determined", "OpenCV: " + std::string(error.err),
                         "Take more views, tilted to all sides");
  }
  return solved;
}

double middle(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2),
                   values.end());
  return values[values.size() / 2];
}

}  // namespace

CameraFit calibrate_camera(const std::vector<BoardView>& views, const CalibrationBoard& board,
                           int width, int height, const CameraOptions& options) {
  if (options.coefficients != 5 && options.coefficients != 8) {
    throw std::invalid_argument("a lens has 5 or 8 coefficients");
  }
  if (!(options.worst_view > 1)) throw std::invalid_argument("worst_view must be above 1");
  require_views(views, board, width, height, static_cast<int>(kLeastViews));
  CameraFit fit;
  std::vector<int> chosen;
  for (std::size_t i = 0; i < views.size(); ++i) {
    ViewFit view;
    view.name = views[i].name;
    view.corners = static_cast<int>(views[i].ids.size());
    if (views[i].ids.empty()) {
      view.why_not = "board not found";
    } else if (views[i].ids.size() < kLeastViewCorners || is_in_line(views[i], board)) {
      view.why_not = "too few corners";
    } else {
      view.used = true;
      chosen.push_back(static_cast<int>(i));
    }
    fit.views.push_back(view);
  }
  while (true) {
    const Solved solved = solve(views, chosen, board, width, height, options.coefficients);
    fit.calibration.name = options.name;
    fit.calibration.width = width;
    fit.calibration.height = height;
    fit.calibration.K = eigen_of(solved.K);
    fit.calibration.distortion = numbers_of(solved.distortion);
    fit.calibration.distortion.resize(static_cast<std::size_t>(options.coefficients));
    fit.calibration.P.setZero();
    fit.calibration.P.leftCols<3>() = fit.calibration.K;
    const std::vector<double> deviations = numbers_of(solved.deviations);
    fit.fx_deviation = deviations[0];
    fit.fy_deviation = deviations[1];
    fit.cx_deviation = deviations[2];
    fit.cy_deviation = deviations[3];
    fit.corners.clear();
    double sum = 0;
    std::vector<double> errors;
    for (std::size_t n = 0; n < chosen.size(); ++n) {
      const auto i = static_cast<std::size_t>(chosen[n]);
      std::vector<cv::Point2f> predicted;
      cv::projectPoints(board_points(views[i], board), solved.rotations[n], solved.translations[n],
                        solved.K, solved.distortion, predicted);
      double of_view = 0;
      for (std::size_t k = 0; k < predicted.size(); ++k) {
        CornerFit corner;
        corner.view = chosen[n];
        corner.pixel = views[i].pixels[k];
        corner.residual = corner.pixel - Eigen::Vector2d(predicted[k].x, predicted[k].y);
        of_view += corner.residual.squaredNorm();
        fit.corners.push_back(corner);
      }
      sum += of_view;
      fit.views[i].rms = std::sqrt(of_view / static_cast<double>(predicted.size()));
      fit.views[i].X_CT = transform_of(cv::Vec3d(solved.rotations[n].reshape(1, 3)),
                                       cv::Vec3d(solved.translations[n].reshape(1, 3)));
      errors.push_back(fit.views[i].rms);
    }
    fit.rms = std::sqrt(sum / static_cast<double>(fit.corners.size()));
    const double limit = options.worst_view * std::max(middle(errors), kGoodRms);
    const auto worst = std::max_element(errors.begin(), errors.end());
    if (!(*worst > limit) || chosen.size() <= kLeastViews) break;
    ViewFit& out = fit.views[static_cast<std::size_t>(
        chosen[static_cast<std::size_t>(worst - errors.begin())])];
    out.used = false;
    out.why_not = fmt::format("off by {:.2g} pixels, {:.1f} times the middle view", out.rms,
                              out.rms / middle(errors));
    chosen.erase(chosen.begin() + (worst - errors.begin()));
  }
  std::vector<BoardView> used;
  for (const int i : chosen) used.push_back(views[static_cast<std::size_t>(i)]);
  require_views(used, board, width, height, static_cast<int>(kLeastViews));
  const double off = std::max(fit.fx_deviation / fit.calibration.K(0, 0),
                              fit.fy_deviation / fit.calibration.K(1, 1));
  if (!(off <= kMostFocalDeviation)) {
    throw DegenerateData("focal length not determined",
                         fmt::format("its standard deviation is {:.1f} % of it", 100 * off),
                         "Take more views, tilted by 20 to 40 degrees to all sides");
  }
  for (const std::string& missing : still_missing(used, board, width, height)) {
    fit.remarks.push_back("It would be better with " + missing + ".");
  }
  return fit;
}

}  // namespace prehend::calibration
