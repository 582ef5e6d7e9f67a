#include "prehend/perception/table.h"

#include <gtest/gtest.h>

#include "prehend/geometry/errors.h"
#include "tests/perception/synthetic_view.h"

namespace prehend::perception {
namespace {

using testing::back_wall;
using testing::render;
using testing::standing_box;
using testing::SyntheticView;
using testing::table_top;

// Angle to the true table's normal [rad] and distance of its plane from the world's origin [m].
void expect_true_table(const Table& table, const SyntheticView& view, double angle,
                       double distance) {
  const Eigen::Vector3d up_C = view.X_WC.linear().transpose() * Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d origin_C = view.X_WC.inverse().translation();
  EXPECT_LT(std::acos(std::min(1.0, table.plane_C.normal.dot(up_C))), angle);
  EXPECT_LT(std::abs(table.plane_C.signed_distance(origin_C)), distance);
}

TEST(FindTable, ExactTableWithBoxes) {
  SyntheticView view;
  view.boxes = {table_top(), standing_box(0, 0, {0.1, 0.1, 0.15}),
                standing_box(0.3, 0.1, {0.06, 0.2, 0.1})};
  const Table table = find_table(render(view));
  expect_true_table(table, view, 1e-4, 1e-4);
  EXPECT_GT(table.object_points, 0);
  EXPECT_LT(table.rms, 1e-3);
  EXPECT_GE(table.hull_C.size(), 4U);
}

TEST(FindTable, NoiseOfADepthCamera) {
  SyntheticView view;
  view.noise = 0.003;
  view.boxes = {table_top(), standing_box(0, 0, {0.1, 0.1, 0.15})};
  expect_true_table(find_table(render(view)), view, 0.005, 0.001);
}

TEST(FindTable, TiltedAndLowAndHighCameras) {
  for (const Eigen::Vector3d& eye :
       {Eigen::Vector3d(0.3, -0.9, 0.25), Eigen::Vector3d(-0.2, -0.3, 0.9),
        Eigen::Vector3d(0.6, -0.5, 0.6), Eigen::Vector3d(0.01, -0.02, 1.0)}) {
    SyntheticView view;
    view.noise = 0.001;
    view.X_WC = geometry::look_at(eye, {0, 0, 0.02});
    view.boxes = {table_top(), standing_box(0, 0, {0.12, 0.1, 0.15})};
    expect_true_table(find_table(render(view)), view, 0.01, 0.003);
  }
}

TEST(FindTable, RolledCamera) {
  SyntheticView view;
  view.X_WC.linear() =
      view.X_WC.linear() * Eigen::AngleAxisd(0.6, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  view.boxes = {table_top(), back_wall(), standing_box(0, 0, {0.12, 0.1, 0.15})};
  expect_true_table(find_table(render(view)), view, 0.01, 0.003);
}

TEST(FindTable, WinsOverALargerWall) {
  SyntheticView view;
  view.noise = 0.001;
  view.X_WC = geometry::look_at({0, -0.9, 0.35}, {0, 0.4, 0.25});
  view.boxes = {table_top(), back_wall(), standing_box(0, 0, {0.1, 0.1, 0.15})};
  const geometry::PointCloud cloud = render(view);
  std::size_t wall = 0;
  std::size_t table = 0;
  for (const Eigen::Vector3f& p : cloud.points) {
    const Eigen::Vector3d p_W = view.X_WC * p.cast<double>();
    wall += p_W.y() > 0.85;
    table += std::abs(p_W.z()) < 0.01;
  }
  ASSERT_GT(wall, 2 * table) << "the scene should make the wall the larger plane";
  expect_true_table(find_table(cloud), view, 0.01, 0.003);
}

TEST(FindTable, WinsOverTheFloorAndTheFrontOfALargeBox) {
  SyntheticView view;
  view.noise = 0.001;
  view.X_WC = geometry::look_at({0, -1.0, 0.8}, {0, 0, 0});
  const testing::Box floor{{-3, -3, -0.8}, {3, 3, -0.75}};
  view.boxes = {table_top(0.7, 0.5), floor, standing_box(0, 0.05, {0.12, 0.1, 0.12}),
                standing_box(0.2, 0.05, {0.07, 0.07, 0.2})};
  expect_true_table(find_table(render(view)), view, 0.01, 0.003);
}

TEST(FindTable, KnownUpDirectionRulesTheWallOut) {
  SyntheticView view;
  view.boxes = {back_wall()};
  view.X_WC = geometry::look_at({0, -0.6, 0.5}, {0, 0.9, 0.5});
  const Eigen::Vector3d up_C = view.X_WC.linear().transpose() * Eigen::Vector3d::UnitZ();
  EXPECT_THROW(find_table(render(view), {}, up_C), geometry::InputError);
}

TEST(FindTable, NormalPointsToTheCamera) {
  SyntheticView view;
  view.boxes = {table_top()};
  const Table table = find_table(render(view));
  EXPECT_GT(table.plane_C.signed_distance(Eigen::Vector3d::Zero()), 0.5);
}

TEST(FindTable, SameCloudSameSeedSameBits) {
  SyntheticView view;
  view.noise = 0.002;
  view.boxes = {table_top(), back_wall(), standing_box(0, 0, {0.1, 0.1, 0.15})};
  const geometry::PointCloud cloud = render(view);
  const Table a = find_table(cloud);
  const Table b = find_table(cloud);
  EXPECT_EQ(a.plane_C.normal, b.plane_C.normal);
  EXPECT_EQ(a.plane_C.offset, b.plane_C.offset);
  EXPECT_EQ(a.inliers, b.inliers);
}

// find_table() leaves out what cannot win.
TEST(FindTable, IsTheFirstOfAllTables) {
  const testing::Box floor{{-3, -3, -0.8}, {3, 3, -0.75}};
  const std::vector<testing::Box> things{standing_box(0, 0.05, {0.12, 0.1, 0.12}),
                                         standing_box(0.2, 0.05, {0.07, 0.07, 0.2})};
  std::size_t several = 0;
  for (const Eigen::Vector3d& eye :
       {Eigen::Vector3d(0, -1.0, 0.8), Eigen::Vector3d(0.3, -0.9, 0.35),
        Eigen::Vector3d(0.6, -0.5, 0.6)}) {
    for (const bool has_wall : {false, true}) {
      SyntheticView view;
      view.noise = 0.001;
      view.X_WC = geometry::look_at(eye, {0, 0.2, 0.1});
      view.boxes = {table_top(0.7, 0.5), floor, things[0], things[1]};
      if (has_wall) view.boxes.push_back(back_wall());
      const geometry::PointCloud cloud = render(view);
      const Eigen::Vector3d up_C = view.X_WC.linear().transpose() * Eigen::Vector3d::UnitZ();
      for (const auto& up : {std::optional<Eigen::Vector3d>(), std::optional(up_C)}) {
        const std::vector<Table> all = find_tables(cloud, {}, up);
        const Table one = find_table(cloud, {}, up);
        EXPECT_EQ(one.plane_C.normal, all.front().plane_C.normal);
        EXPECT_EQ(one.plane_C.offset, all.front().plane_C.offset);
        EXPECT_EQ(one.inliers, all.front().inliers);
        EXPECT_EQ(one.object_points, all.front().object_points);
        several += all.size() > 1;
      }
    }
  }
  EXPECT_GT(several, 6u);
}

TEST(FindTable, SaysWhyThereIsNone) {
  EXPECT_THROW(find_table({}), geometry::InputError);
  geometry::PointCloud cloud;
  cloud.points.assign(1000, Eigen::Vector3f::Constant(std::numeric_limits<float>::quiet_NaN()));
  EXPECT_THROW(find_table(cloud), geometry::InputError);
  cloud.points.assign(1000, Eigen::Vector3f(0.1F, 0.2F, 0.8F));
  EXPECT_THROW(find_table(cloud), geometry::InputError);
  for (int i = 0; i < 1000; ++i) {  // a line
    cloud.points[i] = Eigen::Vector3f(0.001F * static_cast<float>(i), 0, 0.8F);
  }
  EXPECT_THROW(find_table(cloud), geometry::InputError);
  std::mt19937_64 random(3);  // a ball: no plane has support
  std::normal_distribution<float> normal;
  for (Eigen::Vector3f& p : cloud.points) {
    p = Eigen::Vector3f(0, 0, 1.2F) +
        0.3F * Eigen::Vector3f(normal(random), normal(random), normal(random)).normalized();
  }
  TableOptions options;
  options.min_support = 0.3;
  EXPECT_THROW(find_table(cloud, options), geometry::InputError);
}

TEST(FindTable, RejectsBadOptions) {
  TableOptions options;
  options.inlier_distance = 0;
  EXPECT_THROW(find_table({}, options), std::invalid_argument);
  options = {};
  options.max_object_height = 0.01;
  EXPECT_THROW(find_table({}, options), std::invalid_argument);
  EXPECT_THROW(find_table({}, {}, Eigen::Vector3d::Zero()), std::invalid_argument);
}

}  // namespace
}  // namespace prehend::perception
