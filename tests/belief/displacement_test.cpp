#include "prehend/belief/displacement.h"

#include <cmath>
#include <numbers>
#include <stdexcept>

#include <gtest/gtest.h>

namespace prehend::belief {
namespace {

const geometry::Plane kTable{Eigen::Vector3d::UnitZ(), 0};

/// Points on a wall x = 0 that face +x, 1 cm apart along y, half a metre up.
ShapeHypothesis wall(int count, double deviation, double length) {
  ShapeHypothesis hypothesis;
  for (int i = 0; i < count; ++i) {
    hypothesis.points.cloud_W.points.emplace_back(0.f, 0.01f * static_cast<float>(i), 0.5f);
    hypothesis.points.cloud_W.normals.push_back(Eigen::Vector3f::UnitX());
    hypothesis.points.basis.push_back(surface::SurfaceOrigin::kPredicted);
    hypothesis.points.origin.push_back(shape::PointOrigin::kMirrored);
    hypothesis.deviation.push_back(static_cast<float>(deviation));
  }
  hypothesis.correlation_length = length;
  hypothesis.detail_length = length;
  return hypothesis;
}

// One measurement of a normal variable: the classical posterior.
TEST(Displacement, OfOneObservationIsInClosedForm) {
  const double prior = 0.01, noise = 0.002, found = 0.006, length = 0.05;
  const ShapeHypothesis hypothesis = wall(11, prior, length);
  const Displacement displacement(hypothesis, kTable, {}, {{0, found, noise, 0}});
  const double total = prior * prior + noise * noise;
  const double gain = prior * prior / total;
  const auto places = displacement.places({0, 5, 10});
  const auto variances = displacement.variances({0, 5, 10});
  const int points[] = {0, 5, 10};
  for (int i = 0; i < 3; ++i) {
    const double apart = 0.01 * points[i];
    const double alike = std::exp(-apart * apart / (2 * length * length));
    EXPECT_NEAR(places[i].x(), gain * alike * found, 1e-7);
    EXPECT_NEAR(variances[i], prior * prior * (1 - gain * alike * alike), 1e-9);
    EXPECT_NEAR(displacement.covariances({points[i]}, 0)[0], prior * prior * alike * (1 - gain),
                1e-9);
  }
  EXPECT_NEAR(displacement.log_likelihood(),
              -0.5 * (found * found / total + std::log(2 * std::numbers::pi * total)), 1e-5);
  EXPECT_NEAR(displacement.misfit(), found * found / total, 1e-5);
}

TEST(Displacement, WithoutObservationsIsThePrior) {
  const ShapeHypothesis hypothesis = wall(3, 0.01, 0.05);
  const Displacement displacement(hypothesis, kTable, {{0.01, 0.1}}, {});
  EXPECT_EQ(displacement.places({0, 2})[1], hypothesis.points.cloud_W.points[2]);
  EXPECT_NEAR(displacement.variances({1})[0], 1e-4, 1e-9);
  EXPECT_EQ(displacement.log_likelihood(), 0);
  EXPECT_TRUE(displacement.moved().front().along_W.isZero());
}

// A side that moves as a whole takes what points agree on; they keep what they differ by.
TEST(Displacement, TellsAWholeSideFromItsPoints) {
  ShapeHypothesis hypothesis = wall(21, 0.001, 0.005);
  Eigen::Matrix3Xf side = Eigen::Matrix3Xf::Zero(3, 21);
  side.row(0).setConstant(0.02f);
  hypothesis.motions = {side};
  std::vector<Observation> observations;
  for (int i = 0; i < 21; i += 5) observations.push_back({i, 0.013, 0.0005, 0});
  const Displacement displacement(hypothesis, kTable, {}, observations);
  EXPECT_NEAR(displacement.theta()[0], 0.013 / 0.02, 0.01);
  EXPECT_NEAR(displacement.places({12})[0].x(), 0.013, 2e-4);  // between the observed ones
}

// The object was pushed by the first act: all of it moved, and it kept its shape.
TEST(Displacement, WhatMovedDidNotChangeItsShape) {
  const ShapeHypothesis hypothesis = wall(21, 0.001, 0.05);
  const std::vector<Motion> motions{{0.03, 0}, {0, 0}};
  std::vector<Observation> observations;
  for (int i = 0; i < 21; i += 4) observations.push_back({i, 0.02, 0.0005, i % 8 == 0 ? 1 : 2});
  const Displacement displacement(hypothesis, kTable, motions, observations);
  EXPECT_NEAR(displacement.moved()[0].along_W.x(), 0.02, 5e-4);
  EXPECT_NEAR(displacement.moved()[1].along_W.norm(), 0, 1e-9);
  EXPECT_NEAR(displacement.places({10})[0].x(), 0, 5e-4);
  // Observed before the push they would be of the shape.
  for (Observation& o : observations) o.act = 0;
  const Displacement before(hypothesis, kTable, motions, observations);
  EXPECT_NEAR(before.moved()[0].along_W.norm(), 0, 1e-9);
  EXPECT_GT(before.places({10})[0].x(), 0.015);
  EXPECT_LT(before.log_likelihood(), displacement.log_likelihood() - 10);
}

TEST(Displacement, LeavesOneOutAsIfItHadNotBeen) {
  const ShapeHypothesis hypothesis = wall(21, 0.004, 0.03);
  const std::vector<Observation> all{
      {0, 0.001, 0.001, 0}, {4, 0.002, 0.001, 0}, {8, 0.03, 0.001, 0}};
  const Displacement displacement(hypothesis, kTable, {}, all);
  const Eigen::VectorXd misfits = displacement.left_out_misfits();
  for (int left_out = 0; left_out < 3; ++left_out) {
    std::vector<Observation> others = all;
    others.erase(others.begin() + left_out);
    const Displacement without(hypothesis, kTable, {}, others);
    const int point = all[left_out].point;
    const double expected = static_cast<double>(without.places({point})[0].x());
    const double variance = without.variances({point})[0] + 1e-6;
    EXPECT_NEAR(misfits[left_out], std::pow(all[left_out].displacement - expected, 2) / variance,
                1e-3 * misfits[left_out] + 1e-6);
  }
  Eigen::Index worst = 0;
  misfits.maxCoeff(&worst);
  EXPECT_EQ(worst, 2);
}

TEST(Displacement, RefusesObservationsOutOfRange) {
  const ShapeHypothesis hypothesis = wall(3, 0.01, 0.05);
  const double nan = std::nan("");
  for (const Observation& bad :
       {Observation{-1, 0, 0.001, 0}, Observation{3, 0, 0.001, 0}, Observation{0, nan, 0.001, 0},
        Observation{0, 0, 0, 0}, Observation{0, 0, nan, 0}, Observation{0, 0, 0.001, 1}}) {
    EXPECT_THROW(Displacement(hypothesis, kTable, {}, {bad}), std::invalid_argument);
  }
}

// Exact and repeated measurements, on points that err alike to the last digit.
TEST(Displacement, StaysFiniteAtTheExtremes) {
  for (const double noise : {1e-6, 1e-4, 1.0}) {
    const ShapeHypothesis hypothesis = wall(40, 0.01, 10);
    std::vector<Observation> observations;
    for (int i = 0; i < 40; ++i) observations.push_back({i, 0.005, noise, 0});
    const Displacement displacement(hypothesis, kTable, {}, observations);
    EXPECT_TRUE(std::isfinite(displacement.log_likelihood()));
    const auto place = displacement.places({20})[0];
    EXPECT_NEAR(place.x(), 0.005 / (1 + noise * noise / (40 * 1e-4)), 1e-5);
    EXPECT_GE(displacement.variances({20})[0], 0);
  }
}

}  // namespace
}  // namespace prehend::belief
