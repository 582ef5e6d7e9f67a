// How far a predicted object's size can be relied on.

#include <cmath>
#include <cstdio>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "prehend/shape/symmetry.h"
#include "prehend/surface/model.h"
#include "prehend/surface/size_on_table.h"
#include "tests/shape/synthetic_view.h"

namespace prehend::surface {
namespace {

using Eigen::Vector3d;

const geometry::Plane kTable{Vector3d::UnitZ(), 0};
constexpr double kOneDeviation = 0.6826894921;  // of a normal error

// 120 x 50 x 30 mm on the table; what lies at x < 0 was not seen.
ObjectModel half_seen(float confidence, double seen_deviation) {
  ObjectModel model;
  model.mesh_W = geometry::make_box({0.12, 0.05, 0.03});
  for (Vector3d& p : model.mesh_W.vertices) {
    p.z() += 0.015;
    const bool is_seen = p.x() > 0;
    model.vertex_origin.push_back(is_seen ? SurfaceOrigin::kSeen : SurfaceOrigin::kPredicted);
    model.vertex_confidence.push_back(is_seen ? 1 : confidence);
  }
  model.seen_deviation = seen_deviation;
  return model;
}

TEST(PredictedSize, OfWhatWasSeenIsTheNoise) {
  ObjectModel model = half_seen(1, 0.001);
  model.vertex_origin.assign(model.vertex_origin.size(), SurfaceOrigin::kSeen);
  const PredictedSize predicted = predicted_size(model, kTable);
  EXPECT_LT((predicted.size - Vector3d(0.12, 0.05, 0.03)).norm(), 1e-9);
  const double n = std::sqrt(std::numbers::pi / 2) * 0.001;
  EXPECT_LT((predicted.deviation - n * Vector3d(std::sqrt(8), std::sqrt(8), std::sqrt(5))).norm(),
            1e-9);
  model.vertex_origin.clear();  // a mesh that is known
  model.seen_deviation = 0;
  EXPECT_EQ(predicted_size(model, kTable).deviation, Vector3d::Zero());
}

TEST(PredictedSize, OfAGuessIsWhatItsConfidenceSays) {
  const PredictedSize one = predicted_size(half_seen(kOneDeviation, 0), kTable);
  EXPECT_NEAR(one.deviation.x(), 0.005, 1e-6);  // one end was guessed, the other seen
  EXPECT_NEAR(one.deviation.y(), 0.005, 1e-6);  // half of either end
  EXPECT_NEAR(one.deviation.z(), 0.005 / std::sqrt(2), 1e-6);
  EXPECT_EQ(size_text(one), "120 +- 5 x 50 +- 5 x 30 +- 4 mm");
  double last = 0;
  for (const float confidence : {1.0f, 0.9f, 0.5f, 0.2f, 0.05f, 0.0f}) {
    const PredictedSize size = predicted_size(half_seen(confidence, 0), kTable);
    EXPECT_GE(size.deviation.x(), last) << confidence;
    last = size.deviation.x();
    EXPECT_TRUE((size.deviation.array() <= size.size.array() / 2 + 1e-12).all()) << confidence;
  }
}

TEST(PredictedSize, HoldsForSimulatedShapes) {
  const std::vector<geometry::TriangleMesh> solids{
      geometry::make_box({0.06, 0.09, 0.12}),
      geometry::make_box({0.05, 0.16, 0.04}),
      geometry::make_box({0.08, 0.08, 0.05}),
      geometry::make_revolution({{0.035, 0}, {0.035, 0.1}}, 96),
      geometry::make_revolution({{0.03, 0}, {0.03, 0.10}, {0.012, 0.13}, {0.012, 0.16}}, 96),
      geometry::make_revolution({{0.02, 0}, {0.045, 0.09}}, 96)};
  int all = 0, within_one = 0, within_two = 0;
  double sum = 0;
  for (const auto& solid : solids) {
    for (const double yaw : {0.0, 0.3, 0.6}) {
      for (const double noise : {0.0, 0.001, 0.002}) {
        const auto truth = shape::standing(solid, yaw);
        const auto view =
            shape::synthetic_view(truth, {.depth_noise = noise, .width = 320, .seed = 3});
        const ObjectModel model =
            make_object_model(shape::complete_by_symmetry(view.view()), view.table_W);
        const PredictedSize predicted = predicted_size(model, view.table_W);
        const Vector3d error = predicted.size - size_on_table(truth, view.table_W);
        for (int axis = 0; axis < 3; ++axis) {
          const double deviations = std::abs(error[axis]) / predicted.deviation[axis];
          ++all;
          within_one += deviations <= 1;
          within_two += deviations <= 2;
          sum += predicted.deviation[axis];
        }
      }
    }
  }
  std::printf("of %d extents %d within one deviation, %d within two; mean deviation %.1f mm\n", all,
              within_one, within_two, 1e3 * sum / all);
  EXPECT_GT(within_one, 0.68 * all);
  EXPECT_GT(within_two, 0.9 * all);
  EXPECT_LT(sum / all, 0.006);  // and not because they are boundless
}

}  // namespace
}  // namespace prehend::surface
