// What something nearer hides is missing evidence, not evidence of nothing.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "prehend/geometry/errors.h"
#include "prehend/shape/confidence.h"
#include "prehend/shape/seen_map.h"
#include "prehend/shape/symmetry.h"
#include "tests/shape/synthetic_view.h"

namespace prehend::shape {
namespace {

/// A box seen from in front, its right third behind something.
SyntheticView half_hidden() {
  SyntheticView view = synthetic_view(standing(geometry::make_box({0.08, 0.15, 0.1}), 0.3),
                                      {.elevation = 0.5, .depth_noise = 0.0005});
  int left = view.camera.width, right = 0;
  for (int v = 0; v < view.mask.height; ++v) {
    for (int u = 0; u < view.mask.width; ++u) {
      if (view.mask.at(u, v) == 0) continue;
      left = std::min(left, u);
      right = std::max(right, u);
    }
  }
  hide_columns(view, right - (right - left) / 3, view.camera.width - 1, 0.4);
  return view;
}

/// The share of the whole box's surface that has a completed point within 8 mm.
double covered(const CompletedShape& shape) {
  const geometry::MeshQuery truth(standing(geometry::make_box({0.08, 0.15, 0.1}), 0.3));
  const SyntheticView all = synthetic_view(truth.mesh(), {.elevation = 0.5});
  double near = 0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < all.cloud_W.points.size(); i += 40, ++count) {
    float nearest = 1;
    for (const Eigen::Vector3f& p : shape.cloud_W.points) {
      nearest = std::min(nearest, (p - all.cloud_W.points[i]).norm());
    }
    near += nearest < 0.008f;
  }
  return near / static_cast<double>(count);
}

TEST(Occlusion, WhatIsHiddenStaysPossible) {
  SyntheticView view = half_hidden();
  const double known = covered(complete_by_symmetry(view.view()));
  view.nearer = {};
  const double unknown = covered(complete_by_symmetry(view.view()));
  EXPECT_GT(known, 0.85);
  EXPECT_LT(unknown, known - 0.1);
}

TEST(Occlusion, IsKnownToTheConfidence) {
  const SyntheticView view = half_hidden();
  const CompletedShape shape = complete_by_symmetry(view.view());
  EXPECT_GT(shape.evidence.occluded, 0.1);
  EXPECT_LT(shape.evidence.occluded, 0.4);
  Evidence whole = shape.evidence;
  whole.occluded = 0;
  EXPECT_LT(shape.confidence, confidence(whole));
}

TEST(Occlusion, WhatIsBeforeTheHidingThingIsContradicted) {
  const SyntheticView view = half_hidden();
  const SeenMap map = make_seen_map(view.view(), {0, 0, view.camera.width, view.camera.height});
  const auto at = [&](double depth) {
    return evidence_about(map, view.camera,
                          view.camera.unproject(view.camera.width - 10, 200, depth), 0.003);
  };
  EXPECT_EQ(at(0.3).contradicted, 1);
  EXPECT_EQ(at(0.5).contradicted, 0);
  EXPECT_GT(at(0.5).behind, 0.09);
  EXPECT_FALSE(at(0.5).unseen);
}

TEST(Occlusion, AnImageOfAnotherSizeIsRefused) {
  SyntheticView view = half_hidden();
  view.nearer = geometry::DepthImage(3, 3, 1.f);
  EXPECT_THROW(complete_by_symmetry(view.view()), geometry::InputError);
}

}  // namespace
}  // namespace prehend::shape
