#include "prehend/perception/rectification.h"

#include <cmath>

#include <gtest/gtest.h>

#include "prehend/geometry/errors.h"
#include "prehend/perception/stereo.h"

namespace prehend::perception {
namespace {

constexpr int kWidth = 320;
constexpr int kHeight = 240;

StereoCalibration test_calibration() {
  StereoCalibration calibration;
  calibration.width = kWidth;
  calibration.height = kHeight;
  calibration.K_left << 300, 0, 159.5, 0, 300, 119.5, 0, 0, 1;
  calibration.K_right = calibration.K_left;
  calibration.X_RL.translation() = Eigen::Vector3d(-0.08, 0, 0);
  return calibration;
}

// Brightness of the plane z = `depth` of the left camera at (x, y) [m].
double texture(double x, double y) {
  return 128 + 50 * std::sin(140 * x + 3 * std::sin(60 * y)) +
         50 * std::sin(120 * y + 2 * std::sin(90 * x));
}

// What a camera with pose X_LC sees of the plane z = 1 in the left camera's frame.
geometry::ColorImage view_of_plane(const Eigen::Matrix3d& K, const geometry::RigidTransform& X_LC) {
  geometry::ColorImage image(kWidth, kHeight);
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      const Eigen::Vector3d ray = X_LC.linear() * (K.inverse() * Eigen::Vector3d(u, v, 1));
      const double t = (1.0 - X_LC.translation().z()) / ray.z();
      const Eigen::Vector3d p = X_LC.translation() + t * ray;
      image.at(u, v).fill(static_cast<std::uint8_t>(std::lround(texture(p.x(), p.y()))));
    }
  }
  return image;
}

TEST(Rectify, PassesRectifiedImagesThrough) {
  const geometry::ColorImage image(kWidth, kHeight, {10, 20, 30});
  const RectifiedPair pair = rectify(image, image, test_calibration());
  EXPECT_EQ(pair.left.data, image.data);
  EXPECT_NEAR(pair.camera.baseline, 0.08, 1e-12);
}

TEST(Rectify, TurnedCamerasGiveThePlanesDepth) {
  StereoCalibration calibration = test_calibration();
  calibration.K_right(0, 0) = calibration.K_right(1, 1) = 310;
  calibration.X_RL.linear() = (Eigen::AngleAxisd(0.03, Eigen::Vector3d::UnitZ()) *
                               Eigen::AngleAxisd(-0.02, Eigen::Vector3d::UnitX()))
                                  .toRotationMatrix();
  calibration.X_RL.translation() = Eigen::Vector3d(-0.08, 0.002, -0.001);
  const geometry::ColorImage left =
      view_of_plane(calibration.K_left, geometry::RigidTransform::Identity());
  const geometry::ColorImage right = view_of_plane(calibration.K_right, calibration.X_RL.inverse());
  const RectifiedPair pair = rectify(left, right, calibration);
  EXPECT_NEAR(pair.camera.baseline, calibration.baseline(), 1e-9);

  const DisparityImage disparity = disparity_by_sgbm(pair.left, pair.right, pair.camera);
  double error = 0;
  int valid = 0;
  for (int v = 60; v < 180; ++v) {
    for (int u = 80; u < 240; ++u) {
      if (std::isnan(disparity.at(u, v))) continue;
      const double z =
          pair.camera.left.fx * pair.camera.baseline / static_cast<double>(disparity.at(u, v));
      error += std::abs(z - 1.0);  // the rectified frame is turned by a degree or two at most
      ++valid;
    }
  }
  EXPECT_GT(valid, 0.9 * 120 * 160);
  EXPECT_LT(error / valid, 0.02);
}

TEST(Rectify, RejectsWhatDoesNotBelongTogether) {
  const geometry::ColorImage image(kWidth, kHeight);
  EXPECT_THROW(rectify(image, geometry::ColorImage(kWidth, 10), test_calibration()),
               geometry::InputError);
  EXPECT_THROW(
      rectify(geometry::ColorImage(640, 480), geometry::ColorImage(640, 480), test_calibration()),
      geometry::InputError);
  StereoCalibration swapped = test_calibration();
  swapped.X_RL.translation() *= -1;
  EXPECT_THROW(rectify(image, image, swapped), geometry::InputError);
}

}  // namespace
}  // namespace prehend::perception
