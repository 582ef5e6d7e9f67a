// Graph-cut refinement, black background, several views.

#include <cmath>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "prehend/geometry/errors.h"
#include "prehend/perception/dark_background.h"
#include "prehend/perception/merged_views.h"
#include "prehend/perception/refinement.h"
#include "prehend/perception/segmentation.h"
#include "tests/perception/synthetic_view.h"

namespace prehend::perception {
namespace {

using geometry::InputError;
using ::testing::HasSubstr;
using testing::standing_box;

// Colours of a view by its boxes, with noise.
geometry::ColorImage picture(const testing::SyntheticView& view,
                             const std::vector<geometry::Rgb>& colors) {
  geometry::DepthImage depth;
  const geometry::Image<int> owner = testing::owners(view, depth);
  std::mt19937_64 random(2);
  geometry::ColorImage image(view.camera.width, view.camera.height);
  for (std::size_t i = 0; i < image.data.size(); ++i) {
    if (owner.data[i] < 0) continue;
    for (int c = 0; c < 3; ++c) {
      const int value = colors.at(owner.data[i])[c] + static_cast<int>(random() % 21) - 10;
      image.data[i][c] = static_cast<std::uint8_t>(std::clamp(value, 0, 255));
    }
  }
  return image;
}

double overlap(const geometry::MaskImage& mask, const geometry::Image<int>& owner, int box) {
  double both = 0, either = 0;
  for (std::size_t i = 0; i < mask.data.size(); ++i) {
    const bool a = mask.data[i] != 0, b = owner.data[i] == box;
    both += a && b;
    either += a || b;
  }
  return both / either;
}

testing::SyntheticView one_box() {
  testing::SyntheticView view;
  view.boxes = {testing::table_top(), standing_box(0, 0, {0.12, 0.1, 0.14})};
  return view;
}

// Widens the mask by a border, as stereo does, with points that have the object's depth.
void fatten(SegmentedScene& scene, int border) {
  ObjectHypothesis& object = scene.objects.at(0);
  const geometry::MaskImage before = object.mask;
  const double depth = (scene.X_WC.inverse() * geometry::centroid(object.cloud_W)).z();
  for (int v = border; v + border < before.height; ++v) {
    for (int u = border; u + border < before.width; ++u) {
      if (before.at(u, v) != 0) continue;
      bool near = false;
      for (int d = -border; d <= border; ++d) {
        near = near || before.at(u + d, v) != 0 || before.at(u, v + d) != 0;
      }
      if (!near) continue;
      object.mask.at(u, v) = 255;
      object.cloud_W.points.push_back(
          (scene.X_WC * scene.camera.unproject(u, v, depth)).cast<float>());
    }
  }
}

TEST(RefineMasks, TakesOffTheBorderThatStereoAdds) {
  const testing::SyntheticView view = one_box();
  const geometry::ColorImage image = picture(view, {{150, 130, 100}, {40, 60, 160}});
  geometry::DepthImage depth;
  const geometry::Image<int> owner = testing::owners(view, depth);
  SegmentedScene scene = segment(testing::render(view), view.camera, view.X_WC);
  ASSERT_EQ(scene.objects.size(), 1U);
  fatten(scene, 4);
  const double before = overlap(scene.objects[0].mask, owner, 1);
  const std::size_t points = scene.objects[0].cloud_W.size();
  refine_masks(scene, image);
  EXPECT_LT(before, 0.9);
  EXPECT_GT(overlap(scene.objects[0].mask, owner, 1), 0.96);
  EXPECT_LT(scene.objects[0].cloud_W.size(), 0.93 * static_cast<double>(points));
}

TEST(RefineMasks, KeepsTheMaskWhereColoursTellNothingAndIsRepeatable) {
  const testing::SyntheticView view = one_box();
  const geometry::ColorImage image = picture(view, {{150, 130, 100}, {150, 130, 100}});
  SegmentedScene scene = segment(testing::render(view), view.camera, view.X_WC);
  SegmentedScene again = scene;
  const geometry::MaskImage before = scene.objects.at(0).mask;
  refine_masks(scene, image);
  double both = 0, either = 0;
  for (std::size_t i = 0; i < before.data.size(); ++i) {
    both += before.data[i] != 0 && scene.objects[0].mask.data[i] != 0;
    either += before.data[i] != 0 || scene.objects[0].mask.data[i] != 0;
  }
  EXPECT_GE(both / either, 0.7);
  refine_masks(again, image);
  EXPECT_EQ(again.objects[0].mask.data, scene.objects[0].mask.data);
  EXPECT_THROW(refine_masks(scene, geometry::ColorImage(10, 10)), InputError);
  EXPECT_THROW(refine_masks(scene, image, {.band = 0}), std::invalid_argument);
}

TEST(DarkBackground, FindsTheBrightObjectsAndTheTableUnderThem) {
  testing::SyntheticView view;
  view.boxes = {standing_box(-0.15, 0, {0.1, 0.08, 0.12}),
                standing_box(0.15, 0, {0.06, 0.06, 0.2})};
  const geometry::ColorImage image = picture(view, {{180, 160, 60}, {90, 200, 120}});
  const SegmentedScene scene = segment_on_dark_background(testing::render(view), image, view.camera,
                                                          std::nullopt, view.X_WC);
  ASSERT_EQ(scene.objects.size(), 2U);
  EXPECT_NEAR(scene.table_W.normal.z(), 1, 1e-9);
  EXPECT_NEAR(scene.table_W.offset, 0, 0.004);
  geometry::DepthImage depth;
  const geometry::Image<int> owner = testing::owners(view, depth);
  for (const ObjectHypothesis& object : scene.objects) {
    const int box = geometry::centroid(object.cloud_W).x() < 0 ? 0 : 1;
    EXPECT_GT(overlap(object.mask, owner, box), 0.95);
    EXPECT_FALSE(object.touches_image_border);
  }
}

TEST(DarkBackground, SaysWhenThereIsNone) {
  const testing::SyntheticView view = one_box();
  const geometry::PointCloud cloud = testing::render(view);
  const auto error_of = [&](const geometry::ColorImage& image) -> std::string {
    try {
      segment_on_dark_background(cloud, image, view.camera);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  geometry::ColorImage image(view.camera.width, view.camera.height, {0, 0, 0});
  EXPECT_THAT(error_of(image), HasSubstr("no bright objects"));
  image = geometry::ColorImage(view.camera.width, view.camera.height, {200, 200, 200});
  EXPECT_THAT(error_of(image), HasSubstr("no bright objects"));
  EXPECT_THROW(segment_on_dark_background(cloud, geometry::ColorImage(3, 3), view.camera),
               std::invalid_argument);
  EXPECT_THROW(segment_on_dark_background(cloud, image, view.camera, Eigen::Vector3d::Zero()),
               std::invalid_argument);
}

// Views of one table from 0.8 m to both sides of `azimuth` [rad] from -y.
std::vector<SegmentedScene> two_views(const geometry::RigidTransform& pose_error,
                                      double azimuth = 1.45) {
  std::vector<SegmentedScene> views;
  for (const double angle : {-azimuth, azimuth}) {
    testing::SyntheticView view;
    view.X_WC = geometry::look_at({0.8 * std::sin(angle), -0.8 * std::cos(angle), 0.6}, {0, 0, 0});
    view.boxes = {testing::table_top(), standing_box(-0.15, 0, {0.1, 0.08, 0.12}),
                  standing_box(0.15, 0.02, {0.06, 0.06, 0.2})};
    views.push_back(segment(testing::render(view), view.camera,
                            angle < 0 ? view.X_WC : pose_error * view.X_WC));
  }
  return views;
}

TEST(MergeViews, JoinsTheSidesOfEachObject) {
  const std::vector<SegmentedScene> views = two_views(geometry::RigidTransform::Identity());
  ASSERT_EQ(views[0].objects.size(), 2U);
  ASSERT_EQ(views[1].objects.size(), 2U);
  const MergedViews merged = merge_views(views);
  ASSERT_EQ(merged.objects.size(), 2U);
  for (const MergedObject& object : merged.objects) {
    ASSERT_EQ(object.hypothesis.size(), 2U);
    EXPECT_GE(object.hypothesis[0], 0);
    EXPECT_GE(object.hypothesis[1], 0);
    EXPECT_EQ(object.view.size(), object.cloud_W.size());
    // The faces of both sides are there.
    Eigen::AlignedBox3f box;
    for (const Eigen::Vector3f& p : object.cloud_W.points) box.extend(p);
    const double width = box.center().x() < 0 ? 0.1 : 0.06;
    EXPECT_NEAR(box.sizes().x(), width, 0.006);
  }
  EXPECT_NEAR(merged.table_W.offset, 0, 0.002);
}

// The view without the object on the left (x < 0) or the one on the right.
SegmentedScene without(SegmentedScene view, bool left) {
  std::erase_if(view.objects, [left](const ObjectHypothesis& object) {
    return (geometry::centroid(object.cloud_W).x() < 0) == left;
  });
  return view;
}

TEST(MergeViews, AsOneSceneKeepsTheCameraThatSawMost) {
  std::vector<SegmentedScene> views = two_views(geometry::RigidTransform::Identity());
  for (ObjectHypothesis& object : views[1].objects) {
    object.touches_image_border = true;
    object.occluded_share = 0.4;
  }
  views[0] = without(views[0], true);
  const SegmentedScene scene = as_scene(merge_views(views));
  EXPECT_EQ(scene.X_WC.matrix(), views[1].X_WC.matrix());
  ASSERT_EQ(scene.objects.size(), 2U);
  for (const ObjectHypothesis& object : scene.objects) {
    // The right one is whole in the other view.
    const bool left = geometry::centroid(object.cloud_W).x() < 0;
    EXPECT_EQ(object.touches_image_border, left);
    EXPECT_EQ(object.occluded_share, left ? 0.4 : 0);
    EXPECT_EQ(object.mask.width, scene.camera.width);
  }
}

TEST(MergeViews, AsOneSceneDrawsWhatItsCameraDidNotSee) {
  const std::vector<SegmentedScene> views = two_views(geometry::RigidTransform::Identity());
  const SegmentedScene scene =
      as_scene(merge_views({without(views[0], true), without(views[1], false)}));
  EXPECT_EQ(scene.X_WC.matrix(), views[0].X_WC.matrix());
  ASSERT_EQ(scene.objects.size(), 2U);
  for (const ObjectHypothesis& object : scene.objects) {
    int inside = 0;
    for (const Eigen::Vector3f& p : object.cloud_W.points) {
      const Eigen::Vector2d pixel = scene.camera.project(scene.X_WC.inverse() * p.cast<double>());
      const int u = static_cast<int>(std::lround(pixel.x()));
      const int v = static_cast<int>(std::lround(pixel.y()));
      inside += u >= 0 && v >= 0 && u < scene.camera.width && v < scene.camera.height &&
                object.mask.at(u, v) == 255;
    }
    EXPECT_GT(inside, 0.95 * static_cast<double>(object.cloud_W.size()));
  }
}

TEST(MergeViews, AlignmentTakesOutAPoseError) {
  geometry::RigidTransform error = geometry::RigidTransform::Identity();
  error.translation() = Eigen::Vector3d(0.006, 0.004, 0);
  const double azimuth = 0.3;
  const geometry::RigidTransform truth =
      two_views(geometry::RigidTransform::Identity(), azimuth)[1].X_WC;
  MergeOptions options;
  options.align = true;
  const MergedViews merged = merge_views(two_views(error, azimuth), options);
  // What is left, where the objects are.
  const geometry::RigidTransform rest = merged.views[1].X_WC * truth.inverse();
  for (const double x : {-0.15, 0.15}) {
    const Eigen::Vector3d p(x, 0, 0.1);
    EXPECT_LT((rest * p - p).norm(), 0.4 * error.translation().norm());
  }
}

// Opposite views share top faces only, along which one cloud can slide on the other.
TEST(MergeViews, AlignmentDoesNoHarmWhereViewsShareLittle) {
  MergeOptions options;
  options.align = true;
  const auto views = two_views(geometry::RigidTransform::Identity(), 2.8);
  const MergedViews merged = merge_views(views, options);
  const geometry::RigidTransform rest = merged.views[1].X_WC * views[1].X_WC.inverse();
  const Eigen::Vector3d p(0.15, 0, 0.1);
  EXPECT_LT((rest * p - p).norm(), 0.01);
}

TEST(MergeViews, RefusesPosesThatCannotBeAndNothing) {
  EXPECT_THROW(merge_views({}), InputError);
  geometry::RigidTransform error = geometry::RigidTransform::Identity();
  error.translation().z() = 0.3;
  EXPECT_THROW(merge_views(two_views(error)), InputError);
  const std::vector<SegmentedScene> views = two_views(geometry::RigidTransform::Identity());
  EXPECT_THROW(merge_views(views, {.min_footprint_overlap = 0}), std::invalid_argument);
  // A view without objects changes nothing.
  std::vector<SegmentedScene> with_empty = {views[0], views[1]};
  with_empty[1].objects.clear();
  EXPECT_EQ(merge_views(with_empty).objects.size(), 2U);
}

}  // namespace
}  // namespace prehend::perception
