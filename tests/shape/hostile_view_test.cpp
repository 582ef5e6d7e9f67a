#include <functional>
#include <limits>
#include <stdexcept>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "prehend/geometry/errors.h"
#include "prehend/shape/symmetry.h"
#include "tests/shape/synthetic_view.h"

namespace prehend::shape {
namespace {

using testing::HasSubstr;

SyntheticView good_view() {
  return synthetic_view(standing(geometry::make_box({0.06, 0.09, 0.12}), 0.3), {.width = 320});
}

/// What complete_by_symmetry complains of; "" when it does not.
std::string hostile_complaint(const SyntheticView& view) {
  try {
    complete_by_symmetry(view.view());
  } catch (const geometry::InputError& error) {
    return error.what();
  }
  return "";
}

TEST(HostileView, TheGoodOneIsAccepted) { EXPECT_EQ(hostile_complaint(good_view()), ""); }

TEST(HostileView, EmptyAndTooSmallClouds) {
  SyntheticView view = good_view();
  view.cloud_W.points.clear();
  EXPECT_THAT(hostile_complaint(view), HasSubstr("0 seen points"));
  view.cloud_W.points.emplace_back(0.f, 0.f, 0.1f);
  EXPECT_THAT(hostile_complaint(view), HasSubstr("1 seen points"));
}

TEST(HostileView, NotFinitePoints) {
  for (const float bad :
       {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    SyntheticView view = good_view();
    view.cloud_W.points[5].y() = bad;
    EXPECT_THAT(hostile_complaint(view), HasSubstr("not finite"));
    for (auto& p : view.cloud_W.points) p.setConstant(bad);
    EXPECT_THAT(hostile_complaint(view), HasSubstr("not finite"));
  }
}

TEST(HostileView, CoincidentCollinearAndCoplanarPoints) {
  SyntheticView view = good_view();
  for (auto& p : view.cloud_W.points) p = view.cloud_W.points[0];
  EXPECT_THAT(hostile_complaint(view), HasSubstr("coincide"));

  view = good_view();
  for (std::size_t i = 0; i < view.cloud_W.size(); ++i) {
    view.cloud_W.points[i] = Eigen::Vector3f(0.001f, 0.0005f, 0.001f) * static_cast<float>(i);
  }
  EXPECT_THAT(hostile_complaint(view), HasSubstr("on a line"));

  view = good_view();
  for (auto& p : view.cloud_W.points) p.x() = 0.03f;
  EXPECT_THAT(hostile_complaint(view), HasSubstr("in one plane"));
}

TEST(HostileView, MasksThatDoNotFit) {
  SyntheticView view = good_view();
  view.mask.data.assign(view.mask.data.size(), 0);
  EXPECT_THAT(hostile_complaint(view), HasSubstr("mask is empty"));

  view = good_view();
  view.mask = geometry::MaskImage(10, 10, 255);
  EXPECT_THAT(hostile_complaint(view), HasSubstr("10 x 10"));

  view = good_view();
  view.mask = geometry::MaskImage(view.camera.width, view.camera.height, 0);
  view.mask.at(0, 0) = 255;
  EXPECT_THAT(hostile_complaint(view), HasSubstr("project into the object's mask"));
}

TEST(HostileView, CamerasThatCannotBe) {
  SyntheticView view = good_view();
  view.camera.fx = 0;
  EXPECT_THAT(hostile_complaint(view), HasSubstr("camera"));

  view = good_view();
  view.X_WC.linear() *= Eigen::AngleAxisd(3.14159, Eigen::Vector3d::UnitY()).toRotationMatrix();
  EXPECT_THAT(hostile_complaint(view), HasSubstr("behind the camera"));

  view = good_view();
  view.table_W.normal.setZero();
  EXPECT_THAT(hostile_complaint(view), HasSubstr("table's normal"));
}

TEST(HostileView, OptionsOutOfRangeAreNamed) {
  const SyntheticView view = good_view();
  const auto named = [&](const std::function<void(CompletionOptions&)>& spoil) -> std::string {
    CompletionOptions options;
    spoil(options);
    try {
      complete_by_symmetry(view.view(), options);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(named([](auto& o) { o.orientations = 4; }), HasSubstr("orientations"));
  EXPECT_THAT(named([](auto& o) { o.orientations = 0; }), HasSubstr("orientations"));
  EXPECT_THAT(named([](auto& o) { o.max_angle = 3; }), HasSubstr("max_angle"));
  EXPECT_THAT(named([](auto& o) { o.shifts = 1; }), HasSubstr("shifts"));
  EXPECT_THAT(named([](auto& o) { o.max_shift = o.min_shift; }), HasSubstr("min_shift"));
  EXPECT_THAT(named([](auto& o) { o.thinning = -1; }), HasSubstr("thinning"));
  EXPECT_THAT(named([](auto& o) { o.depth_tolerance = NAN; }), HasSubstr("depth_tolerance"));
  EXPECT_THAT(named([](auto& o) { o.support_weight = -1; }), HasSubstr("support_weight"));
  EXPECT_THAT(named([](auto& o) { o.planes = 0; }), HasSubstr("planes"));
  EXPECT_THAT(named([](auto& o) { o.max_tilt = 2; }), HasSubstr("max_tilt"));
  EXPECT_THAT(named([](auto& o) { o.fill_holes = 2; }), HasSubstr("fill_holes"));
  EXPECT_THAT(named([](auto& o) { o.max_contradicted = NAN; }), HasSubstr("max_contradicted"));
}

}  // namespace
}  // namespace prehend::shape
