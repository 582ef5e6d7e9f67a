#include "nodes/report/touch_section.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace prehend::nodes {
namespace {

using testing::HasSubstr;
using testing::Not;

msgs::TactileFrame frame_of(const std::string& pad, std::uint32_t counts) {
  msgs::TactileFrame frame;
  frame.mutable_header()->set_frame_id(pad);
  frame.set_rows(2);
  frame.set_columns(1);
  frame.add_intensity(counts);
  frame.add_intensity(0);
  frame.set_sum(0.01 * counts);
  return frame;
}

// A run that executed the only grasp of object 3.
Collected run_of(const msgs::PredictedPercepts& predicted) {
  Collected collected;
  collected.result.emplace();
  collected.result->set_attempts(1);
  collected.result->set_object_id(3);
  *collected.plans[3].add_grasps()->mutable_predicted() = predicted;
  return collected;
}

std::string page_of(const Collected& collected) {
  report::Page page("touch");
  add_touch(page, collected);
  return page.html();
}

TEST(TouchSection, PredictedBesideFelt) {
  msgs::PredictedPercepts predicted;
  *predicted.add_pads()->mutable_image() = frame_of("thumb_distal", 400);
  Collected collected = run_of(predicted);
  collected.snapshots.push_back({control::Phase::kGrasp,
                                 {{"thumb_distal", frame_of("thumb_distal", 390)},
                                  {"finger_1_distal", frame_of("finger_1_distal", 120)},
                                  {"finger_2_distal", frame_of("finger_2_distal", 0)}},
                                 {}});
  const std::string html = page_of(collected);
  const auto to_be = html.find("thumb distal pad, predicted: 4.0 N");
  const auto is = html.find("thumb distal pad, end of grasp: 3.9 N");
  ASSERT_NE(to_be, std::string::npos) << html;
  ASSERT_NE(is, std::string::npos);
  EXPECT_LT(to_be, is);
  EXPECT_THAT(html, HasSubstr("finger 1 distal pad, end of grasp: 1.2 N")) << "a surprise";
  EXPECT_THAT(html, Not(HasSubstr("finger 2 distal"))) << "neither felt nor predicted";
}

// The predictor's setting and its error were in its log only.
TEST(TouchSection, SaysHowTouchWasPredictedWhereThatWasChosen) {
  Collected collected = run_of({});
  EXPECT_THAT(page_of(collected), Not(HasSubstr("measured front")));
  msgs::FidelityChoice& choice = *collected.plans[3].mutable_touch_fidelity();
  choice.set_knobs("step 0.003");
  choice.set_seconds(0.009);
  choice.set_error(0.023);
  const std::string html = page_of(collected);
  for (const char* part : {"step 0.003", "9 ms of processor", "2.3 % of the largest sum"}) {
    EXPECT_THAT(html, HasSubstr(part));
  }
  collected.result->set_attempts(0);
  EXPECT_THAT(page_of(collected), Not(HasSubstr("measured front"))) << "nothing was to be felt";
}

TEST(TouchSection, WhatTheFramesMeanStandsBesideThem) {
  Collected collected = run_of({});
  msgs::PadTouch touch;
  touch.set_pad("left");
  touch.set_touched(5);
  touch.set_force(3.14);
  touch.set_area(57.8e-6);
  touch.mutable_center()->set_y(0.0042);
  touch.set_holding_torque(0.0123);
  touch.add_not_determined("curvature: 5 texels to fit, 6 are needed");
  collected.snapshots.push_back(
      {control::Phase::kLift, {{"left", frame_of("left", 300)}}, {{"left", touch}}});
  const std::string html = page_of(collected);
  for (const char* part : {"3.1 N", "58 mm2", "0.0, 4.2 mm", "12 mN m", "6 are needed"}) {
    EXPECT_THAT(html, HasSubstr(part));
  }
  collected.snapshots.back().touch.clear();
  EXPECT_THAT(page_of(collected), Not(HasSubstr("frames mean")));
}

TEST(TouchSection, SaysWhyNothingWasPredictedAndThatNothingWasTouched) {
  msgs::PredictedPercepts predicted;
  predicted.set_not_predicted("the hand 'bh8' has no tactile pads");
  const std::string html = page_of(run_of(predicted));
  EXPECT_THAT(html, HasSubstr("was not predicted: the hand "));
  EXPECT_THAT(html, HasSubstr("Nothing was touched."));
  EXPECT_THAT(page_of(Collected()), HasSubstr("Nothing was touched."));
}

// A pad that is no grid is one row of counts; where its cells are known, they are drawn there.
TEST(TouchSection, CellsOfACurvedPadAreDrawnWhereTheyAre) {
  Collected collected;
  msgs::TactileFrame frame = frame_of("tip", 300);
  frame.set_rows(1);
  frame.set_columns(2);
  collected.snapshots.push_back({control::Phase::kGrasp, {{"tip", frame}}});
  const std::string row = page_of(collected);
  EXPECT_THAT(row, HasSubstr("tip pad, end of grasp: 3.0 N"));
  msgs::PadCells& cells = collected.cells["tip"];
  cells.set_rows(1);
  cells.set_columns(2);
  for (const double x : {0.0, 0.0, 0.01, 0.0, 0.008, 0.006}) cells.add_position(x);
  for (const double x : {0.0, 0.0, 1.0, 0.0, 0.8, 0.6}) cells.add_normal(x);
  for (int i = 0; i < 2; ++i) cells.add_area(1e-5);
  const std::string placed = page_of(collected);
  EXPECT_NE(placed, row);
  cells.add_area(1e-5);
  EXPECT_EQ(page_of(collected), row) << "cells of another pad";
}

}  // namespace
}  // namespace prehend::nodes
