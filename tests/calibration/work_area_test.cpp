#include "prehend/calibration/work_area.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "prehend/calibration/degenerate_data.h"
#include "prehend/geometry/camera_model.h"

namespace prehend::testing {
namespace {

using calibration::TableView;
using calibration::WorkAreaFit;

constexpr double kDegree = M_PI / 180;

// A table of 0.8 m x 0.5 m at z = 0.02 over a floor at -0.7, as depth images with 1 mm of noise.
class WorkArea : public ::testing::Test {
 protected:
  TableView view(const Eigen::Vector3d& eye, const Eigen::Vector3d& target) {
    TableView view;
    view.X_AC = geometry::look_at(eye, target);
    const geometry::PinholeCamera camera{320, 240, 260, 260, 159.5, 119.5};
    view.cloud_C.width = camera.width;
    view.cloud_C.height = camera.height;
    std::normal_distribution<double> noise(0, 1e-3);
    const Eigen::Rotation2Dd turn(-angle_);
    for (int v = 0; v < camera.height; ++v) {
      for (int u = 0; u < camera.width; ++u) {
        const Eigen::Vector3d ray = view.X_AC->linear() * camera.unproject(u, v, 1);
        double depth = std::nan("");
        const double to_table = (0.02 - eye.z()) / ray.z(), to_floor = (-0.7 - eye.z()) / ray.z();
        const Eigen::Vector2d hit = turn * ((eye + to_table * ray).head<2>() - center_);
        if (to_table > 0 && std::abs(hit.x()) < 0.4 && std::abs(hit.y()) < 0.25) {
          depth = to_table + noise(random_);
        } else if (to_floor > 0 && to_floor < 2.5) {
          depth = to_floor + noise(random_);
        }
        view.cloud_C.points.push_back(camera.unproject(u, v, depth).cast<float>());
      }
    }
    return view;
  }

  std::mt19937 random_{1};
  double angle_ = 0.3;
  Eigen::Vector2d center_{0.55, 0.1};
};

TEST_F(WorkArea, PlaneAndEdgesOfATableAreFound) {
  const WorkAreaFit fit = calibration::calibrate_work_area(
      {view({0.1, 0, 0.9}, {0.55, 0.1, 0}), view({1.1, 0.3, 0.8}, {0.55, 0.1, 0}),
       view({0.55, -0.5, 0.9}, {0.55, 0.1, 0})});
  EXPECT_LT(std::acos(std::min(1.0, fit.plane_A.normal.z())), 0.1 * kDegree);
  EXPECT_NEAR(fit.plane_A.signed_distance({center_.x(), center_.y(), 0.02}), 0, 5e-4);
  EXPECT_NEAR(fit.length, 0.8, 5e-3);
  EXPECT_NEAR(fit.width, 0.5, 5e-3);
  // Each corner is one of the table's, and none of them is there twice.
  for (const double x : {-0.4, 0.4}) {
    for (const double y : {-0.25, 0.25}) {
      const Eigen::Vector2d flat = center_ + Eigen::Rotation2Dd(angle_) * Eigen::Vector2d(x, y);
      const Eigen::Vector3d corner(flat.x(), flat.y(), 0.02);
      double nearest = 1;
      for (const auto& edge : fit.edges) nearest = std::min(nearest, (edge.from_A - corner).norm());
      EXPECT_LT(nearest, 6e-3);
    }
  }
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_TRUE(fit.edges[i].is_real);
    EXPECT_LT((fit.edges[i].to_A - fit.edges[(i + 1) % 4].from_A).norm(), 1e-9);
  }
  EXPECT_TRUE(fit.remarks.empty());
}

TEST_F(WorkArea, WhereTheImageEndsIsNoEdge) {
  const WorkAreaFit fit =
      calibration::calibrate_work_area({view({0.35, 0.05, 0.5}, {0.36, 0.05, 0.0})});
  int real = 0;
  for (const auto& edge : fit.edges) real += edge.is_real;
  EXPECT_LT(real, 4);
  EXPECT_THAT(fit.remarks, ::testing::Not(::testing::IsEmpty()));
  EXPECT_LT((fit.plane_A.normal - Eigen::Vector3d::UnitZ()).norm(), 5e-3);
}

TEST_F(WorkArea, ViewsThatDisagreeAndNoTableAreRefused) {
  std::vector<TableView> views{view({0.1, 0, 0.9}, {0.55, 0.1, 0}),
                               view({1.1, 0.3, 0.8}, {0.55, 0.1, 0})};
  views[1].X_AC = *views[1].X_AC * Eigen::AngleAxisd(0.08, Eigen::Vector3d::UnitX());
  const auto name_of = [](const std::vector<TableView>& given) -> std::string {
    try {
      calibration::calibrate_work_area(given);
    } catch (const calibration::DegenerateData& error) {
      return error.name();
    }
    return "";
  };
  EXPECT_EQ(name_of(views), "views disagree");
  EXPECT_EQ(name_of({}), "no views");
  views[1].X_AC.reset();
  EXPECT_EQ(name_of(views), "camera's poses missing");
  TableView empty;
  empty.name = "empty.pcd";
  try {
    calibration::calibrate_work_area({empty});
    FAIL();
  } catch (const geometry::InputError& error) {
    EXPECT_THAT(error.what(), ::testing::HasSubstr("empty.pcd"));
  }
}

}  // namespace
}  // namespace prehend::testing
