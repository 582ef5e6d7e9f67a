#include "prehend/planning/touch_prediction.h"

#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "prehend/geometry/errors.h"
#include "prehend/simulation/shapes.h"

namespace prehend::planning {
namespace {

using geometry::RigidTransform;
using testing::HasSubstr;

robot::HandModel hand_of(const std::string& name) {
  return robot::read_hand_model("config/robots/" + name + ".yaml");
}

// From above, the tool at the height `z` over the table, closing by `way` [rad].
GraspToFeel from_above(const robot::HandModel& hand, const std::string& preshape, double z,
                       double way) {
  GraspToFeel grasp;
  grasp.preshape = preshape;
  grasp.X_WG.linear() = Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX()).toRotationMatrix();
  grasp.X_WG.translation() = Eigen::Vector3d(0, 0, z);
  const robot::Preshape& shape = hand.preshape(preshape);
  grasp.open = shape.open;
  grasp.closed = shape.open;
  for (int i = 0; i < hand.size(); ++i) {
    grasp.closed[i] += way * shape.closing[static_cast<std::size_t>(i)].rate;
  }
  return grasp;
}

ObjectToFeel box(const Eigen::Vector3d& size, double mass = 0.4) {
  return {simulation::make_standing_box(size), {}, mass};
}

const PredictedPad& pad_of(const PredictedTouch& touch, const std::string& name) {
  for (const PredictedPad& pad : touch.pads) {
    if (pad.name == name) return pad;
  }
  throw std::runtime_error("no pad " + name);
}

TEST(TouchPrediction, ABoxInTheMiddleIsFeltAlikeOnBothSides) {
  const robot::HandModel hand = hand_of("sdh2");
  // Fingers 1 and 2 against each other; beside each other, against the thumb.
  for (const char* preshape : {"pinch", "parallel"}) {
    const PredictedTouch touch =
        predict_touch(hand, from_above(hand, preshape, 0.09, 0.3), box({0.06, 0.06, 0.14}));
    ASSERT_EQ(touch.outcome, TouchOutcome::kPredicted) << touch.problem;
    ASSERT_EQ(touch.pads.size(), hand.pads.size());
    const PredictedPad& one = pad_of(touch, "finger_1_distal");
    const PredictedPad& two = pad_of(touch, "finger_2_distal");
    EXPECT_GT(one.sum, 5);
    EXPECT_NEAR(one.sum, two.sum, 0.01 * one.sum) << preshape;
    EXPECT_DOUBLE_EQ(one.area, two.area) << preshape;
    EXPECT_NEAR(one.center_P.x(), -two.center_P.x(), 1e-4) << "mirror images";
    EXPECT_NEAR(one.center_P.y(), two.center_P.y(), 1e-4);
    EXPECT_EQ(pad_of(touch, "finger_1_proximal").sum, 0);
  }
}

// The mean is of the pads that touch, the image is in counts, its centre lies where it is touched.
TEST(TouchPrediction, SumAreaAndCentreAreThoseOfTheImage) {
  const robot::HandModel hand = hand_of("sdh2");
  const PredictedTouch touch =
      predict_touch(hand, from_above(hand, "pinch", 0.07, 0.3), box({0.06, 0.06, 0.06}));
  ASSERT_EQ(touch.outcome, TouchOutcome::kPredicted) << touch.problem;
  double sum = 0, area = 0;
  int pads = 0;
  for (std::size_t i = 0; i < touch.pads.size(); ++i) {
    const PredictedPad& pad = touch.pads[i];
    const robot::TactilePadModel& model = hand.pads[i].model;
    double counts = 0, touched = 0;
    ASSERT_EQ(pad.counts.size(), static_cast<std::size_t>(pad.rows * pad.columns));
    for (const std::uint16_t count : pad.counts) {
      counts += count;
      touched += count > robot::kTouchCounts ? 1 : 0;
    }
    EXPECT_NEAR(counts * model.newton_per_count, pad.sum, 0.01 * pad.sum + 0.06);
    EXPECT_NEAR(touched * model.texel_pitch * model.texel_pitch, pad.area, 0.1 * pad.area);
    if (pad.sum <= 0.3) continue;
    ++pads;
    sum += pad.sum;
    area += pad.area;
    EXPECT_GT(pad.center_P.y(), 0.003) << "a low box is met by the tips";
  }
  ASSERT_EQ(touch.mean.pads, pads);
  EXPECT_NEAR(touch.mean.sum, sum / pads, 1e-9);
  EXPECT_NEAR(touch.mean.area, area / pads, 1e-12);
  const robot::Preshape& shape = hand.preshape("pinch");
  ASSERT_EQ(touch.stopped.size(), hand.size());
  EXPECT_GT(touch.stopped[1], shape.open[1]) << "the finger has closed";
}

TEST(TouchPrediction, PadsFeelTheForceThatIsAskedFor) {
  const robot::HandModel hand = hand_of("sdh2");
  for (const double force : {5.0, 10.0}) {
    GraspToFeel grasp = from_above(hand, "pinch", 0.09, 0.3);
    grasp.force = force;
    grasp.effort = 0.3;
    const PredictedTouch by_plan = predict_touch(hand, grasp, box({0.06, 0.06, 0.14}));
    EXPECT_NEAR(by_plan.mean.sum, force, 0.15 * force) << by_plan.problem;
    grasp.force = 0;
    TouchPredictionOptions options;
    options.grip.grip_force = force;
    EXPECT_EQ(predict_touch(hand, grasp, box({0.06, 0.06, 0.14}), options).mean.sum,
              by_plan.mean.sum);
  }
}

// Gravity is along the table's normal, which points wherever it may.
TEST(TouchPrediction, ATiltedTableChangesNothing) {
  const robot::HandModel hand = hand_of("sdh2");
  const GraspToFeel level = from_above(hand, "parallel", 0.09, 0.3);
  const ObjectToFeel object = box({0.06, 0.06, 0.14});
  RigidTransform X_WT = RigidTransform::Identity();
  X_WT.linear() = (Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitX()) *
                   Eigen::AngleAxisd(-0.2, Eigen::Vector3d::UnitY()))
                      .toRotationMatrix();
  X_WT.translation() = Eigen::Vector3d(0.4, -0.2, 0.7);
  GraspToFeel tilted = level;
  tilted.X_WG = X_WT * level.X_WG;
  ObjectToFeel there = object;
  there.mesh_W = geometry::transformed(object.mesh_W, X_WT);
  there.table_W.normal = X_WT.linear().col(2);
  there.table_W.offset = there.table_W.normal.dot(X_WT.translation());
  const PredictedTouch here = predict_touch(hand, level, object);
  const PredictedTouch felt = predict_touch(hand, tilted, there);
  ASSERT_EQ(felt.outcome, TouchOutcome::kPredicted) << felt.problem;
  EXPECT_NEAR(felt.mean.sum, here.mean.sum, 0.02 * here.mean.sum);
  EXPECT_NEAR(felt.mean.area, here.mean.area, 0.05 * here.mean.area);
}

TEST(TouchPrediction, AHandWithoutPadsIsTold) {
  robot::HandModel hand = hand_of("bh8");
  hand.pads.clear();
  const PredictedTouch touch =
      predict_touch(hand, from_above(hand, "spread_0", 0.09, 1.0), box({0.06, 0.06, 0.14}));
  EXPECT_EQ(touch.outcome, TouchOutcome::kNoPads);
  EXPECT_THAT(touch.problem, HasSubstr("'bh8' has no tactile pads"));
  EXPECT_TRUE(touch.pads.empty());
  EXPECT_FALSE(touch.is_refuted());
}

// Each with its reason, and no number.
TEST(TouchPrediction, WhatIsNotFeltIsNoNumber) {
  const robot::HandModel hand = hand_of("sdh2");
  const auto expect_none = [](const PredictedTouch& touch, TouchOutcome outcome,
                              const std::string& words) {
    EXPECT_EQ(touch.outcome, outcome) << touch.problem;
    EXPECT_THAT(touch.problem, HasSubstr(words));
    EXPECT_TRUE(touch.pads.empty());
    EXPECT_EQ(touch.mean.pads, 0);
    EXPECT_EQ(touch.mean.sum, 0);
    EXPECT_EQ(touch.stopped.size(), 0);
  };
  const GraspToFeel grasp = from_above(hand, "parallel", 0.09, 0.3);
  GraspToFeel beside = grasp;
  beside.X_WG.translation().x() = 0.4;
  expect_none(predict_touch(hand, beside, box({0.06, 0.06, 0.14})), TouchOutcome::kMissed,
              "beside the object");

  // On its edge.
  ObjectToFeel leaning = box({0.06, 0.06, 0.14});
  RigidTransform X = RigidTransform::Identity();
  X.linear() = Eigen::AngleAxisd(0.8, Eigen::Vector3d::UnitX()).toRotationMatrix();
  leaning.mesh_W = geometry::transformed(leaning.mesh_W, X);
  const double lowest = geometry::bounds(leaning.mesh_W).min().z();
  for (Eigen::Vector3d& p : leaning.mesh_W.vertices) p.z() -= lowest;
  expect_none(predict_touch(hand, beside, leaning), TouchOutcome::kNotStanding, "does not stand");

  // The thumb pushes it over, between the two fingers.
  expect_none(
      predict_touch(hand, from_above(hand, "parallel", 0.12, 0.3), box({0.02, 0.02, 0.16}, 0.05)),
      TouchOutcome::kFallsOver, "falls over");

  ObjectToFeel open = box({0.06, 0.06, 0.14});
  open.mesh_W.triangles.resize(1);
  expect_none(predict_touch(hand, grasp, open), TouchOutcome::kNotSimulated, "volume");

  TouchPredictionOptions hurried;
  hurried.budget = 1e-6;
  expect_none(predict_touch(hand, grasp, box({0.06, 0.06, 0.14}), hurried),
              TouchOutcome::kBudgetUsed, "budget");
}

TEST(TouchPrediction, SameArgumentsSameAnswerAloneOrBesideOthers) {
  const robot::HandModel hand = hand_of("sdh2");
  const ObjectToFeel object = box({0.06, 0.06, 0.14});
  std::vector<GraspToFeel> grasps{from_above(hand, "spherical", 0.09, 0.3),
                                  from_above(hand, "parallel", 0.09, 0.3),
                                  from_above(hand, "pinch", 0.10, 0.3)};
  grasps[1].X_WG.translation().x() = 0.004;
  TouchPredictionOptions options;
  options.threads = 1;
  const auto one_after_the_other = predict_touches(hand, grasps, object, options);
  options.threads = 3;
  const auto at_once = predict_touches(hand, grasps, object, options);
  for (std::size_t i = 0; i < grasps.size(); ++i) {
    const PredictedTouch alone = predict_touch(hand, grasps[i], object);
    ASSERT_EQ(alone.outcome, TouchOutcome::kPredicted) << alone.problem;
    for (const PredictedTouch& other : {one_after_the_other[i], at_once[i]}) {
      ASSERT_EQ(other.pads.size(), alone.pads.size());
      EXPECT_EQ(other.mean.sum, alone.mean.sum) << "bitwise, grasp " << i;
      EXPECT_EQ(other.stopped, alone.stopped);
      for (std::size_t p = 0; p < alone.pads.size(); ++p) {
        EXPECT_EQ(other.pads[p].counts, alone.pads[p].counts);
      }
    }
  }
}

// Into the percepts of a plan: numbers, none where the simulation says there is nothing to feel,
// and what was there before where it does not know.
TEST(TouchPrediction, GoesIntoThePlan) {
  const robot::HandModel hand = hand_of("sdh2");
  surface::ObjectModel object;
  object.mesh_W = simulation::make_standing_box({0.06, 0.06, 0.14});
  const GraspToFeel pinch = from_above(hand, "pinch", 0.09, 0.3);
  grasp::Grasp grasp;
  grasp.X_WG = pinch.X_WG;
  grasp.preshape = pinch.preshape;
  grasp.open = pinch.open;
  grasp.closed = pinch.closed;
  grasp.predicted = {0, 1e-6, 1, 0.4};
  std::vector<grasp::Grasp> grasps{grasp, grasp};
  grasps[1].X_WG.translation().x() = 0.4;
  auto touches = add_touch(hand, object, {}, {}, &grasps);
  EXPECT_EQ(touches[0].outcome, TouchOutcome::kPredicted);
  EXPECT_GT(grasps[0].predicted.tactile_sum, 5);
  EXPECT_EQ(grasps[0].predicted.tactile_sum, touches[0].mean.sum);
  EXPECT_EQ(grasps[0].predicted.contact_area, touches[0].mean.area);
  EXPECT_EQ(grasps[0].predicted.lifted_mass, 0.4);
  EXPECT_EQ(touches[1].outcome, TouchOutcome::kMissed);
  EXPECT_EQ(grasps[1].predicted.tactile_sum, 0);
  EXPECT_EQ(grasps[1].predicted.contact_area, 0);
  TouchPredictionOptions hurried;
  hurried.budget = 1e-6;
  grasps = {grasp};
  touches = add_touch(hand, object, {}, hurried, &grasps);
  EXPECT_EQ(touches[0].outcome, TouchOutcome::kBudgetUsed);
  EXPECT_EQ(grasps[0].predicted.tactile_sum, 1) << "as it was";
}

TEST(TouchPrediction, RefusesWhatIsNoGrasp) {
  const robot::HandModel hand = hand_of("sdh2");
  const ObjectToFeel object = box({0.06, 0.06, 0.14});
  const GraspToFeel good = from_above(hand, "pinch", 0.09, 0.3);
  GraspToFeel bad = good;
  bad.closed = Eigen::VectorXd::Zero(3);
  EXPECT_THROW(predict_touch(hand, bad, object), std::invalid_argument);
  bad = good;
  bad.X_WG.translation().x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(predict_touch(hand, bad, object), std::invalid_argument);
  bad = good;
  bad.preshape = "pinsh";
  EXPECT_THROW(predict_touch(hand, bad, object), geometry::InputError);
  bad = good;
  bad.effort = 0;
  EXPECT_THROW(predict_touch(hand, bad, object), std::invalid_argument);
  EXPECT_THROW(predict_touch(hand, good, {object.mesh_W, {}, -1}), std::invalid_argument);
  TouchPredictionOptions options;
  options.largest_tilt = 0;
  EXPECT_THROW(predict_touch(hand, good, object, options), std::invalid_argument);
  EXPECT_EQ(predict_touch(hand, good, {{}, {}, 0.3}).outcome, TouchOutcome::kNotSimulated);
  EXPECT_TRUE(predict_touches(hand, {}, object).empty());
}

}  // namespace
}  // namespace prehend::planning
