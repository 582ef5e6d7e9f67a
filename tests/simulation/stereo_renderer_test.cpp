#include "prehend/simulation/stereo_renderer.h"

#include <cmath>
#include <stdexcept>

#include <gtest/gtest.h>

namespace prehend::simulation {
namespace {

Scene small_scene() {
  Scene scene;
  scene.camera.camera.left = {256, 192, 275, 275, 127.5, 95.5};
  SceneObject box;
  box.name = "box";
  box.size = {0.08, 0.1, 0.06};
  scene.objects.push_back(box);
  return scene;
}

TEST(StereoRenderer, DepthAgreesWithThePlaneAndTheBox) {
  const Scene scene = small_scene();
  const World world(scene);
  const StereoImages images = render_stereo(scene, world.visible_bodies());
  const geometry::PinholeCamera& camera = scene.camera.camera.left;
  const geometry::RigidTransform X_WC = scene.camera.X_WC();
  int table_pixels = 0, box_pixels = 0;
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const int label = images.labels.at(u, v);
      if (label < -1) continue;
      const Eigen::Vector3d p = X_WC * camera.unproject(u, v, images.depth.at(u, v));
      if (label == -1) {
        ++table_pixels;
        ASSERT_NEAR(p.z(), 0, 1e-5);
      } else {
        ++box_pixels;
        const Eigen::Vector3d out =
            (p - Eigen::Vector3d(0, 0, 0.03)).cwiseAbs() - Eigen::Vector3d(0.04, 0.05, 0.03);
        ASSERT_NEAR(out.maxCoeff(), 0, 1e-5) << "on the box's surface";
      }
    }
  }
  EXPECT_GT(table_pixels, 20000);
  EXPECT_GT(box_pixels, 1000);
}

// What the left camera sees at depth z, the right one sees fx b / z further left.
TEST(StereoRenderer, RightImageIsShiftedByTheDisparity) {
  Scene scene = small_scene();
  scene.camera.noise = 0;
  const World world(scene);
  const StereoImages images = render_stereo(scene, world.visible_bodies());
  const geometry::PinholeCamera& camera = scene.camera.camera.left;
  double error = 0, unshifted = 0;
  int count = 0;
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 60; u < camera.width; ++u) {
      if (images.labels.at(u, v) != -1) continue;
      const double disparity = camera.fx * scene.camera.camera.baseline / images.depth.at(u, v);
      const double x = u - disparity;
      const int x0 = static_cast<int>(std::floor(x));
      if (x0 < 0) continue;
      const double f = x - x0;
      const double right = (1 - f) * images.right.at(x0, v)[1] + f * images.right.at(x0 + 1, v)[1];
      error += std::abs(images.left.at(u, v)[1] - right);
      unshifted += std::abs(images.left.at(u, v)[1] - images.right.at(u, v)[1]);
      ++count;
    }
  }
  EXPECT_GT(count, 10000);
  EXPECT_LT(error / count, 4) << "grey levels; interpolation and occlusion only";
  EXPECT_GT(unshifted / count, 2 * error / count);
}

TEST(StereoRenderer, SameSeedSameImageInAnyNumberOfThreads) {
  const Scene scene = small_scene();
  const World world(scene);
  const auto bodies = world.visible_bodies();
  const StereoImages one = render_stereo(scene, bodies, 0, {1, true, 1});
  const StereoImages three = render_stereo(scene, bodies, 0, {1, true, 3});
  const StereoImages later = render_stereo(scene, bodies, 1, {1, true, 1});
  EXPECT_EQ(one.left.data, three.left.data);
  EXPECT_EQ(one.right.data, three.right.data);
  EXPECT_NE(one.left.data, later.left.data) << "the noise differs from frame to frame";
}

TEST(StereoRenderer, NoiseHasTheGivenDeviation) {
  Scene scene = small_scene();
  const World world(scene);
  const auto noisy = render_stereo(scene, world.visible_bodies());
  scene.camera.noise = 0;
  const auto clean = render_stereo(scene, world.visible_bodies());
  double sum = 0, squares = 0;
  for (std::size_t i = 0; i < clean.left.data.size(); ++i) {
    const double difference = double(noisy.left.data[i][0]) - clean.left.data[i][0];
    sum += difference;
    squares += difference * difference;
  }
  const double n = static_cast<double>(clean.left.data.size());
  EXPECT_NEAR(sum / n, 0, 0.05);
  EXPECT_NEAR(std::sqrt(squares / n), 2.0, 0.15);
}

TEST(StereoRenderer, RefusesBadOptions) {
  const Scene scene = small_scene();
  EXPECT_THROW(render_stereo(scene, {}, 0, {0, true, 1}), std::invalid_argument);
  EXPECT_THROW(render_stereo(scene, {}, 0, {1, true, 0}), std::invalid_argument);
  Scene bad = scene;
  bad.camera.camera.baseline = 0;
  EXPECT_THROW(render_stereo(bad, {}), std::invalid_argument);
}

}  // namespace
}  // namespace prehend::simulation
