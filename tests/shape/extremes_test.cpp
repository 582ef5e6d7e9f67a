// Inputs far from the everyday: each gives a right answer or one clear error.

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "prehend/geometry/errors.h"
#include "prehend/shape/symmetry.h"
#include "tests/shape/synthetic_view.h"

namespace prehend::shape {
namespace {

using testing::HasSubstr;

constexpr double kDegree = std::numbers::pi / 180;

geometry::TriangleMesh box(double scale = 1, double yaw = 0.35) {
  return standing(geometry::make_box(scale * Eigen::Vector3d(0.06, 0.09, 0.12)), yaw);
}

SyntheticView box_view(const ViewOptions& options = {.width = 320}) {
  return synthetic_view(box(), options);
}

/// The predicted points' distances to the truth [m], ascending.
std::vector<double> errors(const CompletedShape& shape, const geometry::TriangleMesh& truth) {
  const geometry::MeshQuery query(truth);
  std::vector<double> result;
  for (std::size_t i = 0; i < shape.cloud_W.size(); i += 3) {
    if (shape.origin[i] == PointOrigin::kSeen) continue;
    result.push_back(query.nearest(shape.cloud_W.points[i].cast<double>())->distance);
  }
  std::sort(result.begin(), result.end());
  return result;
}

double median(const std::vector<double>& sorted) { return sorted[sorted.size() / 2]; }

/// Everything about the result is a number.
void expect_sound(const CompletedShape& shape, const SyntheticView& view) {
  ASSERT_GE(shape.cloud_W.size(), view.cloud_W.size());
  ASSERT_EQ(shape.origin.size(), shape.cloud_W.size());
  ASSERT_EQ(shape.support.size(), shape.cloud_W.size());
  ASSERT_EQ(shape.point_confidence.size(), shape.cloud_W.size());
  for (const auto& p : shape.cloud_W.points) ASSERT_TRUE(p.allFinite());
  EXPECT_NEAR(shape.symmetry.normal_W.norm(), 1, 1e-9);
  EXPECT_TRUE(shape.symmetry.point_W.allFinite());
  EXPECT_TRUE(std::isfinite(shape.symmetry.vote));
  EXPECT_GT(shape.confidence, 0);
  EXPECT_LT(shape.confidence, 1);
}

std::string complaint(const SyntheticView& view) {
  try {
    complete_by_symmetry(view.view());
  } catch (const geometry::InputError& error) {
    return error.what();
  }
  return "";
}

TEST(Extremes, FromOneMillimetreToTenMetres) {
  for (const double scale : {0.008, 0.1, 1.0, 10.0, 80.0}) {  // 1 mm to 9.6 m high
    SCOPED_TRACE(scale);
    const geometry::TriangleMesh truth = box(scale);
    const SyntheticView view = synthetic_view(truth, {.distance = 0.7 * scale, .width = 320});
    CompletionOptions options;
    options.depth_tolerance *= scale;
    const CompletedShape shape = complete_by_symmetry(view.view(), options);
    expect_sound(shape, view);
    EXPECT_LT(errors(shape, truth).back(), 0.003 * scale);
  }
}

TEST(Extremes, TenKilometresFromTheOrigin) {
  // Single precision resolves 1 mm there: the cloud is as if measured so.
  const geometry::TriangleMesh truth = box();
  const SyntheticView near = box_view({});
  for (const Eigen::Vector3d& far : {Eigen::Vector3d(1e4, 0, 0), Eigen::Vector3d(7e3, -7e3, 100)}) {
    geometry::RigidTransform X_VW = geometry::RigidTransform::Identity();
    X_VW.translation() = far;
    const SyntheticView view = moved(near, X_VW);
    const CompletedShape shape = complete_by_symmetry(view.view());
    expect_sound(shape, view);
    const auto e = errors(shape, geometry::transformed(truth, X_VW));
    EXPECT_LT(median(e), 0.0015);
    EXPECT_LT(e[e.size() * 9 / 10], 0.004);
  }
}

TEST(Extremes, FromThreePointsUp) {
  const SyntheticView full = box_view();
  const auto thinned = [&](std::size_t count) {
    SyntheticView view = full;
    view.cloud_W.points.clear();
    for (std::size_t i = 0; i < count; ++i) {
      view.cloud_W.points.push_back(full.cloud_W.points[i * full.cloud_W.size() / count]);
    }
    return view;
  };
  EXPECT_THAT(complaint(thinned(3)), HasSubstr("3 seen points"));
  EXPECT_THAT(complaint(thinned(9)), HasSubstr("9 seen points"));
  for (const std::size_t count : {10u, 30u, 100u, 1000u}) {
    SCOPED_TRACE(count);
    const SyntheticView view = thinned(count);
    expect_sound(complete_by_symmetry(view.view()), view);
  }
  // Of a thousand points the box is still known to a few millimetres.
  EXPECT_LT(median(errors(complete_by_symmetry(thinned(1000).view()), box())), 0.003);
}

TEST(Extremes, FiveMillionPoints) {
  SyntheticView view = box_view();
  std::mt19937 random(1);
  const auto seen = view.cloud_W.points;
  const auto jitter = [&] { return 2e-4f * static_cast<float>(random() / 4294967296.0 - 0.5); };
  view.cloud_W.points.reserve(5000000);
  while (view.cloud_W.size() < 5000000) {
    view.cloud_W.points.push_back(seen[random() % seen.size()] +
                                  Eigen::Vector3f(jitter(), jitter(), jitter()));
  }
  CompletionOptions quick;
  quick.second_plane = false;
  const CompletedShape shape = complete_by_symmetry(view.view(), quick);
  ASSERT_GT(shape.cloud_W.size(), 7000000u);
  const CompletedShape of_few = complete_by_symmetry(box_view().view(), quick);
  EXPECT_GT(std::abs(shape.symmetry.normal_W.dot(of_few.symmetry.normal_W)), std::cos(2 * kDegree));
}

TEST(Extremes, DuplicatedPointsChangeNothing) {
  const SyntheticView once = box_view();
  SyntheticView thrice = once;
  for (int i = 0; i < 2; ++i) {
    thrice.cloud_W.points.insert(thrice.cloud_W.points.end(), once.cloud_W.points.begin(),
                                 once.cloud_W.points.end());
  }
  const SymmetryHypothesis a = complete_by_symmetry(once.view()).symmetry;
  const SymmetryHypothesis b = complete_by_symmetry(thrice.view()).symmetry;
  EXPECT_NEAR(a.vote, b.vote, 1e-6);
  EXPECT_NEAR((a.point_W - b.point_W).norm(), 0, 1e-6);
}

TEST(Extremes, NotFiniteNumbersAnywhereAreNamed) {
  const float infinity = std::numeric_limits<float>::infinity();
  SyntheticView view = box_view();
  for (std::size_t i = 0; i < view.cloud_W.size(); i += 50) {
    view.cloud_W.points[i].setConstant(i % 100 == 0 ? NAN : infinity);
  }
  EXPECT_THAT(complaint(view), HasSubstr("not finite"));
  view = box_view();
  view.X_WC.translation().x() = NAN;
  EXPECT_NE(complaint(view), "");
  view = box_view();
  view.table_W.offset = infinity;
  EXPECT_THAT(complaint(view), HasSubstr("table"));
  view = box_view();
  view.camera.cx = NAN;
  EXPECT_THAT(complaint(view), HasSubstr("camera"));
}

TEST(Extremes, NoiseUpToTwentyMillimetres) {
  double last = 1;
  for (const double noise : {0.0, 0.002, 0.005, 0.01, 0.02}) {
    SCOPED_TRACE(noise);
    const SyntheticView view = box_view({.depth_noise = noise, .width = 320});
    CompletionOptions options;
    options.depth_tolerance = std::max(0.003, 1.5 * noise);
    const CompletedShape shape = complete_by_symmetry(view.view(), options);
    expect_sound(shape, view);
    if (noise <= 0.005) {
      EXPECT_LT(median(errors(shape, box())), 0.002 + noise);
    }
    // More noise is not more sure, but for the last digit or so.
    EXPECT_LT(shape.confidence, last + 0.05);
    last = shape.confidence;
  }
}

TEST(Extremes, OutliersUpToAHalf) {
  for (const double share : {0.05, 0.2, 0.5}) {
    SCOPED_TRACE(share);
    SyntheticView view = box_view();
    std::mt19937 random(2);
    const auto uniform = [&] { return static_cast<float>(random() / 4294967296.0 - 0.5); };
    // Wrong depths: outliers of a depth sensor lie on the lines of sight.
    const Eigen::Vector3f eye = view.X_WC.translation().cast<float>();
    for (auto& p : view.cloud_W.points) {
      if (random() / 4294967296.0 < share) p = eye + (1 + 0.2f * uniform()) * (p - eye);
    }
    const CompletedShape shape = complete_by_symmetry(view.view());
    expect_sound(shape, view);
    // It may fail, but not be sure of it.
    const bool right = median(errors(shape, box())) < 0.005;
    EXPECT_TRUE(right || shape.confidence < 0.5);
    if (share >= 0.5) {
      EXPECT_LT(shape.confidence, 0.5);
    }
  }
}

TEST(Extremes, ViewsAlongAndAcrossThePlaneOfSymmetry) {
  // Along: the camera in a plane of symmetry, which then maps the seen side onto itself. Across:
  // the same box's other plane. Both at once for a box seen face on.
  for (const double yaw : {0.0, 90 * kDegree, 180 * kDegree}) {
    const geometry::TriangleMesh truth = box(1, yaw);
    const SyntheticView view = synthetic_view(truth, {});
    const CompletedShape shape = complete_by_symmetry(view.view());
    EXPECT_EQ(shape.method, CompletionMethod::kMirror);
    EXPECT_LT(errors(shape, truth).back(), 0.003);
    EXPECT_GT(std::abs(shape.symmetry.normal_W.x()), std::cos(3 * kDegree));
  }
  // From straight above, there is no direction away from the viewer along the table.
  const SyntheticView above = synthetic_view(box(), {.elevation = 89.9 * kDegree, .width = 320});
  const std::string said = complaint(above);
  EXPECT_TRUE(said.empty() || said.find("in one plane") != std::string::npos) << said;
}

TEST(Extremes, ObjectThatFillsTheImage) {
  const SyntheticView view = synthetic_view(standing(geometry::make_box({0.25, 0.4, 0.3}), 0.2),
                                            {.elevation = 0.75, .distance = 0.3, .width = 160});
  ASSERT_TRUE(std::all_of(view.mask.data.begin(), view.mask.data.end(),
                          [](std::uint8_t pixel) { return pixel != 0; }));
  const std::string said = complaint(view);
  if (!said.empty()) {
    EXPECT_THAT(said, HasSubstr("in one plane"));
    return;
  }
  const CompletedShape shape = complete_by_symmetry(view.view());
  expect_sound(shape, view);
  EXPECT_TRUE(shape.evidence.cut_by_image);
  EXPECT_LT(shape.confidence, complete_by_symmetry(box_view().view()).confidence);
}

// Within the image, but its upper part was not looked at.
TEST(Extremes, WhatIsCutByHeightIsAsUnsure) {
  const SyntheticView view = box_view();
  ObjectView cut = view.view();
  const CompletedShape whole = complete_by_symmetry(cut);
  EXPECT_FALSE(whole.evidence.cut_by_image);
  cut.is_cut = true;
  const CompletedShape shape = complete_by_symmetry(cut);
  EXPECT_TRUE(shape.evidence.cut_by_image);
  EXPECT_LT(shape.confidence, whole.confidence);
}

TEST(Extremes, MaskWithHoles) {
  const SyntheticView whole = box_view();
  SyntheticView holed = whole;
  std::mt19937 random(4);
  int holes = 0;
  for (int i = 0; i < 4000; ++i) {
    const int u = static_cast<int>(random() % 318) + 1, v = static_cast<int>(random() % 238) + 1;
    if (whole.mask.at(u, v) == 0) continue;
    for (int du = 0; du < 2; ++du) holed.mask.at(u - du, v) = 0;
    ++holes;
  }
  ASSERT_GT(holes, 100);
  const CompletedShape a = complete_by_symmetry(whole.view());
  const CompletedShape b = complete_by_symmetry(holed.view());
  EXPECT_GT(std::abs(a.symmetry.normal_W.dot(b.symmetry.normal_W)), std::cos(2 * kDegree));
  EXPECT_LT(errors(b, box()).back(), 0.004);
}

TEST(Extremes, ViewpointWithinTheObject) {
  SyntheticView view = box_view();
  view.X_WC.translation() = Eigen::Vector3d(0, 0, 0.06);
  EXPECT_NE(complaint(view), "");
  // Inside a room-like box every seen point is in front of the camera, all round it in depth.
  SyntheticView inside;
  inside.camera = {160, 120, 60, 60, 79.5, 59.5};
  inside.mask = geometry::MaskImage(160, 120, 255);
  inside.X_WC = geometry::look_at(Eigen::Vector3d(0, 0, 0.5), Eigen::Vector3d(1, 0, 0.4));
  const geometry::MeshQuery room(geometry::make_box({2, 2, 2}));
  for (int v = 0; v < 120; ++v) {
    for (int u = 0; u < 160; ++u) {
      const Eigen::Vector3d ray =
          (inside.X_WC.linear() * inside.camera.unproject(u, v, 1)).normalized();
      const auto hit = room.cast_ray(inside.X_WC.translation(), ray);
      ASSERT_TRUE(hit.has_value());
      inside.cloud_W.points.push_back(
          (inside.X_WC.translation() + hit->distance * ray).cast<float>());
    }
  }
  inside.table_W.offset = -1;
  const std::string said = complaint(inside);
  if (said.empty()) {
    const CompletedShape shape = complete_by_symmetry(inside.view());
    EXPECT_TRUE(shape.evidence.cut_by_image);
    EXPECT_LT(shape.confidence, 0.6);
  } else {
    EXPECT_THAT(said, HasSubstr("viewpoint"));
  }
}

/// Points that single precision still resolves exactly after the motions below.
SyntheticView on_a_grid(SyntheticView view) {
  constexpr float kGrid = 1048576;  // 2^20 per metre
  for (auto& p : view.cloud_W.points) p = (p * kGrid).array().round().matrix() / kGrid;
  return view;
}

TEST(Extremes, MovesWithEveryRigidMotionThatItsPointsSurvive) {
  const SyntheticView view = on_a_grid(box_view({.depth_noise = 0.001, .width = 320}));
  const CompletedShape shape = complete_by_symmetry(view.view());
  // The 24 rotations that permute the axes, with shifts that keep single precision exact: a general
  // motion rounds each point anew, by up to 1e-7 of its distance, and no method undoes that.
  int motions = 0;
  for (int x = 0; x < 3; ++x) {
    for (int y = 0; y < 3; ++y) {
      if (x == y) continue;
      for (int signs = 0; signs < 4; ++signs) {
        geometry::RigidTransform X_VW = geometry::RigidTransform::Identity();
        const Eigen::Vector3d a = (signs & 1 ? -1 : 1) * Eigen::Vector3d::Unit(x);
        const Eigen::Vector3d b = (signs & 2 ? -1 : 1) * Eigen::Vector3d::Unit(y);
        X_VW.linear() << a, b, a.cross(b);
        X_VW.translation() = Eigen::Vector3d(0.5, -0.25 * motions, 0.125);
        const CompletedShape other = complete_by_symmetry(moved(view, X_VW).view());
        EXPECT_NEAR(other.symmetry.vote, shape.symmetry.vote, 1e-6);
        EXPECT_NEAR(other.confidence, shape.confidence, 1e-6);
        EXPECT_LT((other.symmetry.normal_W - X_VW.linear() * shape.symmetry.normal_W).norm(), 1e-6);
        EXPECT_LT((other.symmetry.point_W - X_VW * shape.symmetry.point_W).norm(), 1e-7);
        EXPECT_EQ(other.cloud_W.size(), shape.cloud_W.size());
        motions += motions < 8;
      }
    }
  }
}

TEST(Extremes, OrderOfThePointsAndThreadsDoNotMatter) {
  const SyntheticView view = box_view({.depth_noise = 0.001, .width = 320});
  SyntheticView shuffled = view;
  std::mt19937 random(9);
  for (std::size_t i = shuffled.cloud_W.size(); i > 1; --i) {
    std::swap(shuffled.cloud_W.points[i - 1], shuffled.cloud_W.points[random() % i]);
  }
  const CompletedShape once = complete_by_symmetry(view.view());
  std::vector<CompletedShape> others(4);
  std::vector<std::thread> threads;
  for (std::size_t i = 0; i < others.size(); ++i) {
    threads.emplace_back(
        [&, i] { others[i] = complete_by_symmetry(i % 2 == 0 ? view.view() : shuffled.view()); });
  }
  for (std::thread& thread : threads) thread.join();
  for (const CompletedShape& other : others) {
    EXPECT_EQ(other.symmetry.vote, once.symmetry.vote);
    EXPECT_EQ(other.symmetry.point_W, once.symmetry.point_W);
    EXPECT_EQ(other.symmetry.normal_W, once.symmetry.normal_W);
    EXPECT_EQ(other.confidence, once.confidence);
    EXPECT_EQ(other.cloud_W.size(), once.cloud_W.size());
  }
  EXPECT_EQ(others[0].cloud_W.points, once.cloud_W.points);
}

}  // namespace
}  // namespace prehend::shape
