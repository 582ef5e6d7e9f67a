#include "prehend/touch/grasp_stability.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <sstream>
#include <stdexcept>

#include <gtest/gtest.h>

#include "prehend/geometry/errors.h"
#include "prehend/robot/hand_model.h"
#include "tests/touch/pressed.h"

namespace prehend::touch {
namespace {

using testing::fine_pad;
using testing::pressed;

double value(const Eigen::VectorXd& features, GripMoment moment, const std::string& name) {
  const auto& names = grip_feature_names(moment);
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (names[i] == name) return features[static_cast<Eigen::Index>(i)];
  }
  throw std::invalid_argument(name);
}

double closed_value(const Grip& grip, const std::string& name) {
  return value(grip_features(grip), GripMoment::kClosed, name);
}

double lifting_value(const Grip& closed, const Grip& now, const std::string& name) {
  return value(grip_features(closed, now), GripMoment::kLifting, name);
}

/// The PG70 on a thing of `width`: both pads pressed `depth` deep by discs at x, y of the left pad.
Grip grip_at(double x, double y, double depth, double radius = 0.006, double width = 0.04,
             double left_of_right = 1) {
  static const HandTouch hand(robot::read_hand_model("config/robots/pg70.yaml"));
  static const auto pad = std::make_shared<const FeltPad>(fine_pad());
  const auto disc = [=](double x0, double deep) {
    return [=](double px, double py) { return std::hypot(px - x0, py - y) < radius ? deep : 0.0; };
  };
  std::vector<PadFrame> frames{{"left", pad, pressed(*pad, disc(x, depth * left_of_right))},
                               {"right", pad, pressed(*pad, disc(-x, depth))}};
  return {hand.contacts({"opening"}, {width / 2}, frames), frames};
}

TEST(GripFeatures, AreThoseOfTwoPadsThatFaceOneAnother) {
  const Grip grip = grip_at(0, 0.005, 4e-4);
  const double force = grip.contacts[0].force + grip.contacts[1].force;
  EXPECT_NEAR(closed_value(grip, "log_force"), std::log(force + 0.1), 1e-9);
  EXPECT_NEAR(closed_value(grip, "log_squeeze"), std::log(force / 2 + 0.05), 1e-6);
  EXPECT_NEAR(closed_value(grip, "net"), 0, 1e-9);
  EXPECT_NEAR(closed_value(grip, "facing"), 1, 1e-9);
  EXPECT_NEAR(closed_value(grip, "lever"), 0, 1e-5);
  EXPECT_NEAR(closed_value(grip, "width"), 0.04, 1e-6);
  EXPECT_NEAR(closed_value(grip, "margin"), 0.0102, 5e-4);
  EXPECT_EQ(closed_value(grip, "pads"), 2);
}

TEST(GripFeatures, TellTheEdgeAndWhatIsOutOfBalance) {
  const Grip middle = grip_at(0, 0, 4e-4), edge = grip_at(0.007, 0, 4e-4);
  EXPECT_LT(closed_value(edge, "margin"), closed_value(middle, "margin") - 0.003);
  const Grip uneven = grip_at(0, 0, 4e-4, 0.006, 0.04, 3);
  EXPECT_NEAR(closed_value(uneven, "net"), 0.5, 1e-6) << "(3 - 1) / (3 + 1)";
}

TEST(GripFeatures, OfTheSameGripNothingHasChanged) {
  const Grip grip = grip_at(0.001, 0, 4e-4);
  EXPECT_EQ(lifting_value(grip, grip, "change"), 0);
  EXPECT_EQ(lifting_value(grip, grip, "log_kept"), 0);
  EXPECT_EQ(lifting_value(grip, grip, "shift"), 0);
}

TEST(GripFeatures, WhatSlidesMovesItsPattern) {
  const Grip then = grip_at(0, 0.01, 4e-4), now = grip_at(0, 0, 4e-4);
  EXPECT_NEAR(lifting_value(then, now, "shift"), 0.01, 1e-3);
  EXPECT_GT(lifting_value(then, now, "change"), 0.5);
  const Grip none{{}, {}};
  EXPECT_NEAR(lifting_value(then, none, "log_least_kept"), std::log(1e-2), 1e-9) << "lost";
}

TEST(GripFeatures, PressedHarderIsMoreForceOnTheSameArea) {
  const Grip grip = grip_at(0, 0, 4e-4), twice = pressed_harder(grip, 2);
  const double force = grip.contacts[0].force + grip.contacts[1].force;
  EXPECT_NEAR(closed_value(twice, "log_force"), std::log(2 * force + 0.1), 1e-9);
  EXPECT_EQ(closed_value(twice, "log_area"), closed_value(grip, "log_area"));
  EXPECT_NEAR(frame_change(grip.frames, twice.frames), 1.0 / 3, 1e-9) << "(2 - 1) / (2 + 1)";
}

TEST(GripFeatures, NeedSomethingThatTouches) {
  EXPECT_THROW(grip_features(Grip{}), std::invalid_argument);
}

/// Both moments look at one feature alone.
GraspStability of_one(const std::string& feature, double weight, double bias = 0) {
  const auto one = [&](GripMoment moment) {
    const auto& names = grip_feature_names(moment);
    const auto size = static_cast<Eigen::Index>(names.size());
    GraspStability::Weighed model{Eigen::VectorXd::Zero(size), Eigen::VectorXd::Ones(size),
                                  Eigen::VectorXd::Zero(size), bias};
    for (Eigen::Index i = 0; i < size; ++i) {
      if (names[static_cast<std::size_t>(i)] == feature) model.weight[i] = weight;
    }
    return model;
  };
  return {one(GripMoment::kClosed), one(GripMoment::kLifting)};
}

TEST(GraspStability, IsTheLogisticOfItsFeatures) {
  const Grip grip = grip_at(0, 0, 4e-4);
  EXPECT_NEAR(of_one("pads", 0.7, -1).probability(grip), 1 / (1 + std::exp(1 - 2 * 0.7)), 1e-12);
  EXPECT_EQ(of_one("pads", 0.7).probability(Grip{}), 0) << "nothing is felt";
}

TEST(GraspStability, IsReadAsItWasWritten) {
  const auto file = std::filesystem::path(::testing::TempDir()) / "stability.yaml";
  of_one("log_force", 1.25, -0.5).save(file, "made by\na test");
  const GraspStability read = GraspStability::load(file);
  const Grip grip = grip_at(0, 0, 4e-4);
  EXPECT_NEAR(read.probability(grip), of_one("log_force", 1.25, -0.5).probability(grip), 1e-9);
  EXPECT_NEAR(read.probability(grip, &grip),
              of_one("log_force", 1.25, -0.5).probability(grip, &grip), 1e-9);
}

std::string problem_of(const std::function<void(std::string*)>& spoil) {
  const auto file = std::filesystem::path(::testing::TempDir()) / "bad_stability.yaml";
  of_one("log_force", 1).save(file, "a test");
  std::stringstream text;
  text << std::ifstream(file).rdbuf();
  std::string changed = text.str();
  spoil(&changed);
  std::ofstream(file) << changed;
  try {
    GraspStability::load(file);
  } catch (const geometry::InputError& error) {
    return error.what();
  }
  return "";
}

std::function<void(std::string*)> replace(const std::string& what, const std::string& by) {
  return [=](std::string* text) { text->replace(text->find(what), what.size(), by); };
}

TEST(GraspStability, RefusesAFileThatIsNone) {
  EXPECT_EQ(problem_of([](std::string*) {}), "");
  EXPECT_NE(problem_of(replace("version: 1", "version: 9")).find("version"), std::string::npos);
  EXPECT_NE(problem_of(replace("    facing:", "    fasing:")).find("facing"), std::string::npos);
  EXPECT_NE(problem_of(replace("deviation: 1", "deviation: 0")).find("deviation"),
            std::string::npos);
  EXPECT_NE(problem_of(replace("bias: 0", "bias: .nan")).find("bias"), std::string::npos);
  EXPECT_NE(problem_of(replace("lifting:", "lifted:")).find("lifting"), std::string::npos);
  EXPECT_NE(problem_of(replace("weight: 0}", "weight: 0, more: 1}")).find("more"),
            std::string::npos);
  EXPECT_THROW(GraspStability::load("no/such/file.yaml"), geometry::InputError);
}

TEST(GraspStability, NeedsAsManyWeightsAsFeatures) {
  const GraspStability good = of_one("pads", 1);
  GraspStability::Weighed bad = good.of(GripMoment::kClosed);
  bad.weight.conservativeResize(3);
  EXPECT_THROW(GraspStability(bad, good.of(GripMoment::kLifting)), std::invalid_argument);
  bad = good.of(GripMoment::kClosed);
  bad.deviation[0] = 0;
  EXPECT_THROW(GraspStability(bad, good.of(GripMoment::kLifting)), std::invalid_argument);
}

}  // namespace
}  // namespace prehend::touch
