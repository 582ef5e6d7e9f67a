#include "prehend/contact/pad_layout.h"

#include <cmath>
#include <limits>
#include <stdexcept>

#include <gtest/gtest.h>

#include "pads.h"
#include "prehend/contact/compression_curve.h"
#include "prehend/contact/grasp_stepper.h"
#include "prehend/contact/parallel_grasp.h"

namespace prehend::contact {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

// Runs `work`, which must refuse its input by a message that names `name`.
template <class Work>
void expect_refused(Work work, const std::string& name) {
  try {
    work();
    FAIL() << name << " was accepted";
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find(name), std::string::npos) << error.what();
  }
}

TEST(PadLayout, FlatIsTheDsa9205ByDefault) {
  const PadLayout pad = PadLayout::flat({});
  ASSERT_EQ(pad.size(), 84u);
  EXPECT_EQ(pad.padded_size() % PadLayout::kLanes, 0u);
  EXPECT_TRUE(pad.is_flat());
  EXPECT_NEAR(pad.x[0], -2.5 * 0.0034, 1e-15);
  EXPECT_NEAR(pad.y[0], 6.5 * 0.0034, 1e-15) << "row 0 at +y";
  EXPECT_NEAR(pad.x[1] - pad.x[0], 0.0034, 1e-15) << "row by row";
  double area = 0;
  for (std::size_t i = 0; i < pad.size(); ++i) area += pad.area(i);
  EXPECT_NEAR(area, 0.0204 * 0.0476, 1e-15);
}

TEST(PadLayout, RefiningKeepsTheArea) {
  for (const int factor : {2, 3, 11}) {
    const PadLayout pad = PadLayout::flat(refined({}, factor));
    EXPECT_EQ(pad.size(), 84u * factor * factor);
    double scale = 0;
    for (const double s : pad.scale) scale += s;
    EXPECT_NEAR(scale, 84, 1e-10) << "that of 84 reference texels";
  }
  EXPECT_THROW(refined({}, 0), std::invalid_argument);
}

TEST(PadLayout, CurvedHasATexelAtEachVertexWithTheMeanNormal) {
  const PadLayout pad = testing::fingertip();
  double area = 0;
  for (std::size_t i = 0; i < pad.size(); ++i) {
    const Eigen::Vector3d n = pad.normal(i), p = pad.position(i);
    EXPECT_NEAR(n.norm(), 1, 1e-12);
    // On the rim the mean is of the upper triangles only and so tilts up.
    if (p.z() > 0.003) {
      EXPECT_GT(n.dot(p.normalized()), 0.98) << "radial, as far as the facets allow";
    }
    Eigen::Matrix3d frame;
    frame << pad.first_tangent(i), pad.second_tangent(i), n;
    EXPECT_LT((frame.transpose() * frame - Eigen::Matrix3d::Identity()).norm(), 1e-12);
    EXPECT_NEAR(frame.determinant(), 1, 1e-12);
    area += pad.area(i);
  }
  EXPECT_NEAR(area, 2 * M_PI * 1e-4, 0.06 * area) << "half a ball of 10 mm, in flat triangles";
}

TEST(PadLayout, RefusesBadInputByName) {
  expect_refused([] { PadLayout::flat({.rows = 0}); }, "rows");
  PadGrid grid;
  grid.width = kNan;
  expect_refused([&] { PadLayout::flat(grid); }, "width");
  grid = {};
  grid.thickness = -1;
  expect_refused([&] { PadLayout::flat(grid); }, "thickness");
  const geometry::TriangleMesh ball = geometry::make_sphere(0.01, 8);
  expect_refused([&] { PadLayout::curved(ball, 0); }, "thickness");
  expect_refused([] { PadLayout::curved({}, 0.002); }, "no triangles");
  geometry::TriangleMesh broken = ball;
  broken.triangles[3][1] = 10000;
  expect_refused([&] { PadLayout::curved(broken, 0.002); }, "10000");
  broken = ball;
  broken.vertices[5].x() = kNan;
  expect_refused([&] { PadLayout::curved(broken, 0.002); }, "vertex");
  // Two triangles back to back: no side is out.
  broken = {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 2, 1}}};
  expect_refused([&] { PadLayout::curved(broken, 0.002); }, "mean normal");
  expect_refused([] { PadLayout::flat({}).reordered({1, 2, 3}); }, "order");
}

TEST(GraspModel, RefusesBadValuesByName) {
  const auto refused = [](auto change, const std::string& name) {
    GraspModel model = parallel_grasp({});
    change(model);
    expect_refused([&] { GraspSystem system(model); }, name);
  };
  refused([](GraspModel& m) { m.mass = 0; }, "mass");
  refused([](GraspModel& m) { m.mass = kNan; }, "mass");
  refused([](GraspModel& m) { m.inertia(0, 0) = -1; }, "inertia");
  refused([](GraspModel& m) { m.inertia(0, 1) = 1; }, "inertia");
  refused([](GraspModel& m) { m.gravity.x() = kNan; }, "gravity");
  refused([](GraspModel& m) { m.pads[0].law.stiffness = -1; }, "stiffness");
  refused([](GraspModel& m) { m.pads[1].law.elastic_limit = 1; }, "elastic_limit");
  refused([](GraspModel& m) { m.pads[1].law.exponent = 0.5; }, "exponent");
  refused([](GraspModel& m) { m.pads[1].law.normal_law = NormalLaw::kTabulated; }, "curve");
  refused([](GraspModel& m) { m.pads[1].slide = 2; }, "pads[1].slide");
  refused([](GraspModel& m) { m.slides[1].mass = 0; }, "slides[1].mass");
  refused([](GraspModel& m) { m.slides[0].dynamic_friction = 1; }, "dynamic_friction");
  refused([](GraspModel& m) { m.X_WB.translation().z() = kNan; }, "X_WB");
  GraspSystem system(parallel_grasp({}));
  expect_refused([&] { system.set_command(2, {}, 0); }, "slide 2");
  expect_refused([&] { system.set_command(0, {.force = kNan}, 0); }, "force");
  expect_refused([&] { system.set_body_wrench(Vector6::Constant(kNan)); }, "wrench");
  expect_refused([] { GraspStepper(parallel_grasp({}), {.step = 0}); }, "step");
  expect_refused([] { integration_from_name("euler"); }, "first_order");
}

TEST(CompressionCurve, MeetsItsSamplesAndIsMonotoneAndSmooth) {
  const std::vector<CompressionCurve::Sample> samples{
      {0, 0}, {5e-4, 0.4}, {1e-3, 0.4}, {2e-3, 0.9}, {3e-3, 8}};
  const CompressionCurve curve(samples);
  for (const auto& sample : samples) EXPECT_NEAR(curve.force(sample.depth), sample.force, 1e-12);
  double before = 0;
  for (double d = 1e-6; d < 4e-3; d += 1e-6) {
    EXPECT_GE(curve.force(d), before - 1e-15);
    const double slope = (curve.force(d + 1e-9) - curve.force(d - 1e-9)) / 2e-9;
    EXPECT_NEAR(curve.stiffness(d), slope, 1e-3 * (100 + slope)) << d;
    before = curve.force(d);
  }
  EXPECT_EQ(curve.force(-1), 0);
  EXPECT_NEAR(curve.stiffness(1), curve.stiffness(3e-3), 1e-9) << "goes on straight";
  using Samples = std::vector<CompressionCurve::Sample>;
  expect_refused([] { CompressionCurve c(Samples{{0, 0}}); }, "two samples");
  expect_refused([] { CompressionCurve c(Samples{{0, 0}, {1e-3, 1}, {1e-3, 2}}); }, "sample 2");
  expect_refused([] { CompressionCurve c(Samples{{0, 0}, {1e-3, 1}, {2e-3, 0.5}}); }, "sample 2");
  expect_refused([] { CompressionCurve c(Samples{{0, 1}, {1e-3, 2}}); }, "sample 0");
  expect_refused([] { CompressionCurve c(Samples{{0, 0}, {kNan, 2}}); }, "sample 1");
  expect_refused([] { CompressionCurve c(Samples{{0, 0}, {1, 0}}); }, "sample 1");
}

}  // namespace
}  // namespace prehend::contact
