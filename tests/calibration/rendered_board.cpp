#include "tests/calibration/rendered_board.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "prehend/calibration/board_view.h"

namespace prehend::testing {
namespace {

constexpr int kSamples = 5;      // a pixel's side
constexpr int kDrawn = 160;      // pixels a square
constexpr double kWhite = 0.05;  // m round the board

cv::Mat pinhole_matrix(const perception::CameraCalibration& camera) {
  return (cv::Mat_<double>(3, 3) << camera.K(0, 0), 0, camera.K(0, 2), 0, camera.K(1, 1),
          camera.K(1, 2), 0, 0, 1);
}

}  // namespace

BoardRenderer::BoardRenderer(const calibration::CalibrationBoard& board,
                             const perception::CameraCalibration& camera, const ImageFlaws& flaws)
    : board_(board),
      camera_(camera),
      flaws_(flaws),
      drawn_(calibration::draw_board(board, kDrawn)) {
  std::vector<cv::Point2f> corners, straight;  // of pixels; between them rays are nearly linear
  for (int v = 0; v <= camera.height; ++v) {
    for (int u = 0; u <= camera.width; ++u) corners.emplace_back(u - 0.5f, v - 0.5f);
  }
  cv::undistortPoints(corners, straight, pinhole_matrix(camera), camera.distortion, cv::noArray(),
                      cv::noArray(), {cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 30, 1e-7});
  for (const cv::Point2f& p : straight) rays_.emplace_back(p.x, p.y);
}

geometry::ColorImage BoardRenderer::image(const geometry::RigidTransform& X_CT,
                                          std::mt19937& random) const {
  // From a ray to the board: the homography's inverse.
  Eigen::Matrix3d onto;
  onto << X_CT.linear().col(0), X_CT.linear().col(1), X_CT.translation();
  const Eigen::Matrix3f H = onto.inverse().cast<float>();
  const Eigen::Vector2f size = board_.size().cast<float>();
  const auto scale = static_cast<float>(drawn_.scale);
  const auto level_at = [&](const Eigen::Vector2f& ray) {
    const Eigen::Vector3f p = H * Eigen::Vector3f(ray.x(), ray.y(), 1);
    const float x = p.x() / p.z(), y = p.y() / p.z();
    if (x >= 0 && y >= 0 && x < size.x() && y < size.y()) {
      return drawn_.image.at(std::min(static_cast<int>(x * scale), drawn_.image.width - 1),
                             std::min(static_cast<int>(y * scale), drawn_.image.height - 1)) /
             255.f;
    }
    const bool white = x > -kWhite && y > -kWhite && x < size.x() + kWhite && y < size.y() + kWhite;
    return white ? 1.f : 0.4f;
  };
  // Levels of the pixels' corners, row by row; a pixel whose corners and middle are alike is of
  // one.
  const auto columns = static_cast<std::size_t>(camera_.width) + 1;
  std::vector<float> upper(columns), lower(columns);
  for (std::size_t u = 0; u < columns; ++u) lower[u] = level_at(rays_[u]);
  cv::Mat ideal(camera_.height, camera_.width, CV_32F);
  for (int v = 0; v < camera_.height; ++v) {
    std::swap(upper, lower);
    const Eigen::Vector2f* const first = &rays_[static_cast<std::size_t>(v) * columns];
    for (std::size_t u = 0; u < columns; ++u) lower[u] = level_at(first[columns + u]);
    for (int u = 0; u < camera_.width; ++u) {
      const auto i = static_cast<std::size_t>(u);
      const Eigen::Vector2f& origin = first[i];
      float level = upper[i];
      if (upper[i + 1] != level || lower[i] != level || lower[i + 1] != level ||
          level_at(0.5f * (origin + first[columns + i + 1])) != level) {
        const Eigen::Vector2f right = (first[i + 1] - origin) / kSamples;
        const Eigen::Vector2f down = (first[columns + i] - origin) / kSamples;
        float sum = 0;
        for (int k = 0; k < kSamples * kSamples; ++k) {
          sum += level_at(origin + (k % kSamples + 0.5f) * right + (k / kSamples + 0.5f) * down);
        }
        level = sum / (kSamples * kSamples);
      }
      // Black paper is not black, and the light comes from one side.
      const float light = 0.85f + 0.15f * static_cast<float>(u) / camera_.width;
      ideal.at<float>(v, u) = light * (25 + 195 * level);
    }
  }
  if (flaws_.blur > 0) cv::GaussianBlur(ideal, ideal, {0, 0}, flaws_.blur);
  cv::Mat noise(ideal.size(), CV_32F);
  cv::RNG(random()).fill(noise, cv::RNG::NORMAL, 0, flaws_.noise);
  geometry::ColorImage image(camera_.width, camera_.height);
  for (int v = 0; v < camera_.height; ++v) {
    for (int u = 0; u < camera_.width; ++u) {
      const auto level =
          cv::saturate_cast<std::uint8_t>(ideal.at<float>(v, u) + noise.at<float>(v, u));
      image.at(u, v) = {level, level, level};
    }
  }
  return image;
}

std::vector<geometry::RigidTransform> board_poses(const calibration::CalibrationBoard& board,
                                                  const perception::CameraCalibration& camera,
                                                  int count, std::mt19937& random) {
  std::uniform_real_distribution<double> unit(-1, 1);
  std::vector<geometry::RigidTransform> poses;
  const Eigen::Vector2d middle = 0.5 * board.size();
  while (static_cast<int>(poses.size()) < count) {
    const double angle = M_PI * unit(random), tilt = 0.35 + 0.35 * std::abs(unit(random));
    geometry::RigidTransform X_CT = geometry::RigidTransform::Identity();
    X_CT.linear() = (Eigen::AngleAxisd(tilt, Eigen::Vector3d(std::cos(angle), std::sin(angle), 0)) *
                     Eigen::AngleAxisd(0.5 * unit(random), Eigen::Vector3d::UnitZ()))
                        .toRotationMatrix();
    const double depth =
        (1.25 + 0.35 * unit(random)) * board.size().x() * camera.K(0, 0) / camera.width;
    const Eigen::Vector3d p_C(0.35 * unit(random) * depth * camera.width / camera.K(0, 0),
                              0.35 * unit(random) * depth * camera.height / camera.K(1, 1), depth);
    X_CT.translation() = p_C - X_CT.linear() * Eigen::Vector3d(middle.x(), middle.y(), 0);
    bool seen = true;
    for (const Eigen::Vector2d& corner :
         {Eigen::Vector2d(0, 0), Eigen::Vector2d(board.size().x(), 0), board.size(),
          Eigen::Vector2d(0, board.size().y())}) {
      const Eigen::Vector3d p = X_CT * Eigen::Vector3d(corner.x(), corner.y(), 0);
      if (p.z() < 0.05) {
        seen = false;
        continue;
      }
      const Eigen::Vector2d pixel = calibration::project(camera, p);
      seen = seen && pixel.x() > 5 && pixel.y() > 5 && pixel.x() < camera.width - 6 &&
             pixel.y() < camera.height - 6;
    }
    if (seen) poses.push_back(X_CT);
  }
  return poses;
}

perception::CameraCalibration bent_camera() {
  perception::CameraCalibration camera;
  camera.width = 1280;
  camera.height = 960;
  camera.K << 1204.6, 0, 647.4, 0, 1201.8, 472.8, 0, 0, 1;
  camera.distortion = {-0.12, 0.08, 0.0008, -0.0005, 0};
  camera.P.leftCols<3>() = camera.K;
  return camera;
}

perception::CameraCalibration small_camera() {
  perception::CameraCalibration camera = bent_camera();
  camera.width /= 2;
  camera.height /= 2;
  camera.K.topRows<2>() *= 0.5;
  camera.P.leftCols<3>() = camera.K;
  return camera;
}

calibration::CalibrationBoard charuco_board() {
  calibration::CalibrationBoard board;
  board.kind = calibration::CalibrationBoard::Kind::kCharuco;
  board.columns = 10;
  board.rows = 7;
  board.square = 0.03;
  board.marker = 0.022;
  board.dictionary = "5x5_100";
  return board;
}

calibration::CalibrationBoard chessboard() {
  calibration::CalibrationBoard board;
  board.kind = calibration::CalibrationBoard::Kind::kChessboard;
  board.columns = 10;
  board.rows = 7;
  board.square = 0.03;
  return board;
}

calibration::CalibrationBoard apriltag_grid() {
  calibration::CalibrationBoard board;
  board.kind = calibration::CalibrationBoard::Kind::kAprilTagGrid;
  board.columns = 6;
  board.rows = 4;
  board.marker = 0.036;
  board.gap = 0.0108;
  board.dictionary = "36h11";
  return board;
}

double angle_between(const geometry::RigidTransform& a, const geometry::RigidTransform& b) {
  return Eigen::AngleAxisd(a.linear().transpose() * b.linear()).angle();
}

}  // namespace prehend::testing
