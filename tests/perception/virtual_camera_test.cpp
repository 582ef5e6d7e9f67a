#include "prehend/perception/virtual_camera.h"

#include <gtest/gtest.h>

#include "prehend/geometry/errors.h"
#include "tests/perception/synthetic_view.h"

namespace prehend::perception {
namespace {

using testing::SyntheticView;

SyntheticView box_view() {
  SyntheticView view;
  view.camera = {320, 240, 310, 305, 150.5, 125.5};
  view.boxes = {testing::table_top(), testing::standing_box(0, 0, {0.1, 0.1, 0.15})};
  return view;
}

TEST(FitCamera, RecoversIntrinsics) {
  const SyntheticView view = box_view();
  const FittedCamera fitted = fit_camera(testing::render(view));
  EXPECT_NEAR(fitted.camera.fx, 310, 0.01);
  EXPECT_NEAR(fitted.camera.fy, 305, 0.01);
  EXPECT_NEAR(fitted.camera.cx, 150.5, 0.01);
  EXPECT_NEAR(fitted.camera.cy, 125.5, 0.01);
  EXPECT_LT(fitted.rms, 0.01);
  EXPECT_GT(fitted.inlier_share, 0.999);
  EXPECT_FALSE(fitted.x_flipped || fitted.y_flipped);
}

TEST(FitCamera, SeesACameraThatLooksBackwards) {
  geometry::PointCloud cloud = testing::render(box_view());
  for (Eigen::Vector3f& p : cloud.points) p = Eigen::Vector3f(p.x(), -p.y(), -p.z());
  const FittedCamera fitted = fit_camera(cloud);
  EXPECT_FALSE(fitted.x_flipped);
  EXPECT_TRUE(fitted.y_flipped);
  EXPECT_NEAR(fitted.camera.fy, 305, 0.01);
}

TEST(FitCamera, IgnoresStrayPoints) {
  geometry::PointCloud cloud = testing::render(box_view());
  std::mt19937_64 random(3);
  for (Eigen::Vector3f& p : cloud.points) {
    if (random() % 10 == 0) p += Eigen::Vector3f(0.1F, -0.1F, 0.05F);
  }
  const FittedCamera fitted = fit_camera(cloud);
  EXPECT_NEAR(fitted.camera.fx, 310, 3);
  EXPECT_GT(fitted.inlier_share, 0.85);
}

TEST(FitCamera, ACloudThatIsNoImageHasFewInliers) {
  const SyntheticView view = box_view();
  const geometry::PointCloud cloud_W = geometry::transformed(testing::render(view), view.X_WC);
  EXPECT_LT(fit_camera(cloud_W).inlier_share, 0.5);
}

TEST(FitCamera, SaysWhenItCannotTell) {
  geometry::PointCloud cloud;
  EXPECT_THROW(fit_camera(cloud), geometry::InputError);
  cloud.width = 10;
  cloud.height = 10;
  cloud.points.assign(100, Eigen::Vector3f::Constant(std::numeric_limits<float>::quiet_NaN()));
  EXPECT_THROW(fit_camera(cloud), geometry::InputError);
  cloud.points.assign(100, Eigen::Vector3f(0.1F, 0.1F, 1.0F));
  EXPECT_THROW(fit_camera(cloud), geometry::InputError);
}

TEST(MakeVirtualCamera, SplatsAreWithoutHolesAndWithinTheImage) {
  SyntheticView view;
  view.boxes = {testing::standing_box(0, 0, {0.1, 0.1, 0.15})};
  const geometry::PointCloud cloud = geometry::without_invalid(testing::render(view));
  const geometry::PinholeCamera camera = make_virtual_camera(cloud);
  for (const Eigen::Vector3f& p : cloud.points) {
    const Eigen::Vector2d pixel = camera.project(p.cast<double>());
    EXPECT_GE(pixel.minCoeff(), 0);
    EXPECT_LT(pixel.x(), camera.width);
    EXPECT_LT(pixel.y(), camera.height);
  }
  const geometry::Image<int> nearest = splat(cloud, camera, 1.5 * point_spacing(cloud));
  int holes = 0;
  for (int v = 1; v + 1 < nearest.height; ++v) {
    for (int u = 1; u + 1 < nearest.width; ++u) {
      holes += nearest.at(u, v) < 0 && nearest.at(u - 1, v) >= 0 && nearest.at(u + 1, v) >= 0 &&
               nearest.at(u, v - 1) >= 0 && nearest.at(u, v + 1) >= 0;
    }
  }
  EXPECT_EQ(holes, 0);
}

TEST(Splat, NearerPointsWin) {
  geometry::PointCloud cloud;
  cloud.points = {Eigen::Vector3f(0, 0, 1), Eigen::Vector3f(0, 0, 0.5F), Eigen::Vector3f(0, 0, 2),
                  Eigen::Vector3f(0, 0, -1)};
  const geometry::PinholeCamera camera{11, 11, 10, 10, 5, 5};
  EXPECT_EQ(splat(cloud, camera, 0.01).at(5, 5), 1);
  EXPECT_EQ(splat(cloud, camera, 0.01).at(0, 0), -1);
}

TEST(PlausibleViewpoint, IsOnTheSideThatWasSeen) {
  for (const double azimuth : {0.3, 2.0, 4.5}) {
    SyntheticView view;
    view.X_WC =
        geometry::look_at({0.7 * std::cos(azimuth), 0.7 * std::sin(azimuth), 0.45}, {0, 0, 0.07});
    view.boxes = {testing::standing_box(0, 0, {0.08, 0.08, 0.15})};
    const geometry::PointCloud cloud_W =
        geometry::transformed(geometry::without_invalid(testing::render(view)), view.X_WC);
    const geometry::RigidTransform X_WC = plausible_viewpoint(cloud_W, Eigen::Vector3d::UnitZ());
    const Eigen::Vector2d seen_from(std::cos(azimuth), std::sin(azimuth));
    EXPECT_GT(X_WC.translation().head<2>().normalized().dot(seen_from), 0.7) << azimuth;
    EXPECT_GT(X_WC.translation().z(), 0.1);
  }
}

TEST(PointSpacing, OfAGrid) {
  geometry::PointCloud cloud;
  for (int i = 0; i < 20; ++i) {
    for (int j = 0; j < 20; ++j) {
      cloud.points.emplace_back(0.002F * static_cast<float>(i), 0.002F * static_cast<float>(j),
                                1.0F);
    }
  }
  EXPECT_NEAR(point_spacing(cloud), 0.002, 1e-6);
  cloud.points.assign(5, Eigen::Vector3f(0, 0, 1));
  EXPECT_THROW(point_spacing(cloud), geometry::InputError);
  EXPECT_THROW(point_spacing({}), geometry::InputError);
}

}  // namespace
}  // namespace prehend::perception
