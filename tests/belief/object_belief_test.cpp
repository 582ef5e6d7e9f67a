#include "prehend/belief/object_belief.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include <gtest/gtest.h>

#include "prehend/belief/probe.h"
#include "prehend/geometry/errors.h"
#include "prehend/geometry/mesh_query.h"
#include "tests/belief/predicted.h"

namespace prehend::belief {
namespace {

/// A fingertip that is moved from the far side towards the body at a height, and stopped by it.
Probe from_behind(const Predicted& predicted, double height, double aside = 0) {
  const Eigen::Vector3d away(-1, 0, 0);  // the camera looks along it
  const Eigen::Vector3d middle = geometry::bounds(predicted.truth_W).center();
  const Eigen::Vector3d at(middle.x(), middle.y() + aside, height);
  return {at + 0.15 * away, at, at, 0};
}

/// Where the fingertip is stopped by the truth, and what it says.
void touch(const Predicted& predicted, const Probe& probe, double radius, ObjectBelief* belief) {
  const geometry::MeshQuery truth(predicted.truth_W);
  const Eigen::Vector3d way = (probe.end_W - probe.start_W).normalized();
  Eigen::Vector3d center = probe.start_W;
  while ((probe.end_W - center).dot(way) > 0) {
    const auto nearest = truth.nearest(center);
    const double clearance = nearest->distance - radius;
    if (clearance < 1e-5) {
      const Contact contact{nearest->point, (center - nearest->point).normalized(), 0.001};
      add_probe(probe, center, contact, radius, belief);
      return;
    }
    center += clearance * way;
  }
  add_probe(probe, probe.end_W, std::nullopt, radius, belief);
}

TEST(ObjectBelief, WithoutEvidenceIsThePrediction) {
  const Predicted predicted(box());
  const ObjectBelief belief = predicted.belief();
  ASSERT_FALSE(belief.shapes().empty());
  double sum = 0;
  for (const BelievedShape& shape : belief.shapes()) sum += shape.weight;
  EXPECT_NEAR(sum, 1, 1e-12);
  EXPECT_FALSE(belief.contradicted());
  const geometry::TriangleMesh mesh = belief.mesh();
  EXPECT_TRUE(geometry::find_defects(mesh).watertight());
  EXPECT_LT(deviation_of(mesh, predicted.truth_W), 0.0015);
}

// The far side is predicted 2 cm too deep: one touch of it tells, everywhere on it.
TEST(ObjectBelief, OneTouchMovesAWholeSide) {
  const Predicted predicted = too_deep(box(), 0.02);
  ObjectBelief belief = predicted.belief();
  const double before = deviation_of(belief.mesh(), predicted.truth_W);
  EXPECT_GT(before, 0.0015);
  belief.begin_act();
  touch(predicted, from_behind(predicted, 0.05), 0.006, &belief);
  belief.update();
  const geometry::TriangleMesh mesh = belief.mesh();
  EXPECT_TRUE(geometry::find_defects(mesh).watertight());
  EXPECT_LT(deviation_of(mesh, predicted.truth_W), 0.4 * before);
  // Far from the contact, too.
  EXPECT_LT(
      std::abs(geometry::bounds(mesh).min().x() - geometry::bounds(predicted.truth_W).min().x()),
      0.004);
}

// Closing on air is evidence: what was gone through is not there, without any contact.
TEST(ObjectBelief, SweptSpaceIsEmpty) {
  const Predicted predicted = too_deep(box(), 0.03);
  ObjectBelief belief = predicted.belief();
  const double far = geometry::bounds(predicted.truth_W).min().x();
  const double before = geometry::bounds(belief.mesh()).min().x();
  EXPECT_LT(before, far - 0.02);
  belief.begin_act();
  // A plate is moved down behind the body.
  for (double y = -0.05; y <= 0.05; y += 0.005) {
    for (double x = far - 0.05; x <= far - 0.009; x += 0.005) {
      belief.swept().add_path({x, y, 0.14}, {x, y, 0.01}, 0.008);
    }
  }
  belief.update();
  EXPECT_EQ(belief.contacts().size(), 0u);
  const geometry::TriangleMesh mesh = belief.mesh();
  EXPECT_TRUE(geometry::find_defects(mesh).watertight());
  for (const Eigen::Vector3d& p : mesh.vertices) {
    EXPECT_LT(belief.swept().depth(p), 0.006) << p.transpose();
  }
  EXPECT_GT(geometry::bounds(mesh).min().x(), far - 0.012);
}

TEST(ObjectBelief, TheOrderOfEvidenceDoesNotMatter) {
  const Predicted predicted = too_deep(box(), 0.015);
  const std::vector<Probe> probes{from_behind(predicted, 0.03, -0.02),
                                  from_behind(predicted, 0.07, 0.02),
                                  from_behind(predicted, 0.05, 0)};
  std::vector<geometry::TriangleMesh> meshes;
  for (const std::vector<int>& order : {std::vector<int>{0, 1, 2}, {2, 0, 1}, {1, 2, 0}}) {
    ObjectBelief belief = predicted.belief();
    for (const int i : order) touch(predicted, probes[i], 0.006, &belief);
    if (order.front() == 2) belief.update();  // in between, or not
    belief.update();
    meshes.push_back(belief.mesh());
  }
  for (std::size_t i = 1; i < meshes.size(); ++i) {
    ASSERT_EQ(meshes[i].vertices.size(), meshes[0].vertices.size());
    EXPECT_EQ(meshes[i].vertices, meshes[0].vertices);
  }
}

// A body that lies may be as round below as above, or stand on an upright wall: its underside's
// normal tells.
TEST(ObjectBelief, AContactTellsWhichShapeItIs) {
  geometry::RigidTransform X = geometry::RigidTransform::Identity();
  X.linear() = Eigen::AngleAxisd(std::numbers::pi / 2, Eigen::Vector3d::UnitX()).toRotationMatrix();
  const geometry::TriangleMesh lying =
      geometry::transformed(geometry::make_revolution({{0.04, 0}, {0.04, 0.12}}), X);
  const Predicted predicted(shape::standing(lying, 0));
  ObjectBelief belief = predicted.belief();
  const auto weight_of = [&](const std::string& name) {
    double weight = 0;
    for (const BelievedShape& shape : belief.shapes()) {
      if (shape.name == name) weight += shape.weight;
    }
    return weight;
  };
  const std::string below = "mirror, below as above";
  const double before = weight_of(below);
  EXPECT_GT(before, 0.05);
  belief.begin_act();
  for (const double aside : {-0.03, 0.0, 0.03}) {
    touch(predicted, from_behind(predicted, 0.015, aside), 0.006, &belief);
  }
  belief.update();
  EXPECT_GT(weight_of(below), before);
  EXPECT_EQ(belief.shapes().front().name, below);
  EXPECT_LT(deviation_of(belief.mesh(), predicted.truth_W), 0.0025);
}

// A second thing beside it was touched: the shape stays, and what was touched is there as well.
TEST(ObjectBelief, WhatNoShapeExplainsIsAPieceOfItsOwn) {
  const Predicted predicted(box());
  ObjectBelief belief = predicted.belief();
  const geometry::TriangleMesh before = belief.mesh();
  belief.add({{-0.2, 0.15, 0.2}, Eigen::Vector3d::UnitX(), 0.001});
  belief.update();
  EXPECT_LT(surface::mesh_deviation(before, belief.mesh(), {.samples = 3000}).to_second.mean,
            0.001);
  EXPECT_TRUE(belief.contradicted());  // all that was felt is of something else
}

// Every contact says something else: nothing is concluded.
TEST(ObjectBelief, SaysWhenEvidenceContradictsEverything) {
  const Predicted predicted(box());
  ObjectBelief belief = predicted.belief();
  for (int i = 0; i < 12; ++i) {
    belief.add({{0.3 * std::cos(2.1 * i), 0.3 * std::sin(3.7 * i), 0.05 + 0.01 * i},
                Eigen::Vector3d(std::sin(1.3 * i), std::cos(1.3 * i), 0),
                0.0005});
  }
  belief.update();
  EXPECT_TRUE(belief.contradicted());
  EXPECT_NO_THROW(belief.mesh());
}

// Evidence of which no shape's likelihood is a number.
TEST(ObjectBelief, SaysWhenAllWeightsUnderflow) {
  const Predicted predicted(box());
  constexpr double kBeyond = 1e160;  // m, whose square is none
  ObjectBelief belief = predicted.belief();
  belief.begin_act({kBeyond, kBeyond});
  belief.add({{kBeyond, 0, 0.05}, Eigen::Vector3d::UnitX(), 1e-160});
  belief.add({{-0.04, 0, 0.05}, -Eigen::Vector3d::UnitX(), 0.001});
  belief.update();
  EXPECT_TRUE(belief.contradicted());
  double sum = 0;
  for (const BelievedShape& shape : belief.shapes()) sum += shape.weight;
  EXPECT_NEAR(sum, 1, 1e-9);
}

// The hand pushed the object before it felt it: the object moved, its shape did not.
TEST(ObjectBelief, TellsASlideFromAShape) {
  const Predicted predicted(box());
  const Eigen::Vector3d slide(0.012, 0, 0);
  for (const bool may_move : {true, false}) {
    ObjectBelief belief = predicted.belief();
    belief.begin_act(may_move ? Motion{0.015, 0.02} : Motion{});
    const geometry::MeshQuery truth(predicted.truth_W);
    const Eigen::AlignedBox3d box_W = truth.box();
    // On both faces along the slide, and on the top.
    for (const double y : {-0.02, 0.0, 0.02}) {
      for (const double z : {0.03, 0.07}) {
        belief.add({slide + Eigen::Vector3d(box_W.min().x(), y, z), -Eigen::Vector3d::UnitX()});
        belief.add({slide + Eigen::Vector3d(box_W.max().x(), y, z), Eigen::Vector3d::UnitX()});
      }
    }
    belief.update();
    ASSERT_EQ(belief.moved().size(), 1u);
    if (may_move) {
      EXPECT_NEAR(belief.moved()[0].along_W.x(), slide.x(), 0.002);
      EXPECT_NEAR(belief.moved()[0].along_W.y(), 0, 0.002);
      EXPECT_LT(deviation_of(belief.mesh(), predicted.truth_W), 0.002);
    } else {
      EXPECT_TRUE(belief.moved()[0].along_W.isZero());
    }
  }
}

TEST(ObjectBelief, RefusesWhatIsNoEvidence) {
  const Predicted predicted(box());
  ObjectBelief belief = predicted.belief();
  const double nan = std::nan("");
  const Eigen::Vector3d p(0, 0, 0.05), n = Eigen::Vector3d::UnitX();
  EXPECT_THROW(belief.add({{nan, 0, 0}, n}), std::invalid_argument);
  EXPECT_THROW(belief.add({p, {nan, 0, 0}}), std::invalid_argument);
  EXPECT_THROW(belief.add({p, 2 * n}), std::invalid_argument);
  EXPECT_THROW(belief.add({p, n, 0}), std::invalid_argument);
  EXPECT_THROW(belief.add({p, n, nan}), std::invalid_argument);
  EXPECT_THROW(belief.begin_act({-1, 0}), std::invalid_argument);
  EXPECT_THROW(belief.begin_act({0, nan}), std::invalid_argument);
  BeliefOptions options;
  options.prior.correlation_length = 0;
  EXPECT_THROW(predicted.belief(options), std::invalid_argument);
  options = {};
  options.swept_tolerance = nan;
  EXPECT_THROW(predicted.belief(options), std::invalid_argument);
  EXPECT_THROW(ObjectBelief(shape::CompletedShape(), predicted.view.table_W), geometry::InputError);
}

TEST(Probe, GoesWhereNobodyLooked) {
  const Predicted predicted(box());
  ObjectBelief belief = predicted.belief();
  const auto probe = best_probe(belief);
  ASSERT_TRUE(probe);
  // From the far side, over the table, straight, and free.
  const Eigen::Vector3d away(-1, 0, 0);
  EXPECT_GT((probe->start_W - probe->end_W).normalized().dot(away), 0);
  const ProbeOptions options;
  EXPECT_GT(probe->start_W.z(), options.radius);
  EXPECT_GT(probe->end_W.z(), 0);
  const geometry::MeshQuery truth(predicted.truth_W);
  EXPECT_GT(truth.signed_distance(probe->start_W), options.radius);
  EXPECT_GT(probe->gain, 0);
  // What it found is not asked again.
  touch(predicted, *probe, options.radius, &belief);
  belief.update();
  const auto next = best_probe(belief);
  ASSERT_TRUE(next);
  EXPECT_GT((next->at_W - probe->at_W).norm(), 0.005);
  EXPECT_LT(next->gain, probe->gain);
}

TEST(Probe, RefusesOptionsOutOfRange) {
  const Predicted predicted(box());
  const ObjectBelief belief = predicted.belief();
  for (double ProbeOptions::*field :
       {&ProbeOptions::radius, &ProbeOptions::reach, &ProbeOptions::beyond,
        &ProbeOptions::clearance, &ProbeOptions::deviation, &ProbeOptions::steepest_from_below}) {
    for (const double bad : {-1.0, std::nan("")}) {
      ProbeOptions options;
      options.*field = bad;
      EXPECT_THROW(best_probe(belief, options), std::invalid_argument);
    }
  }
  // Nothing can be reached over so much clearance.
  ProbeOptions high;
  high.clearance = 0.5;
  EXPECT_FALSE(best_probe(belief, high));
}

}  // namespace
}  // namespace prehend::belief
