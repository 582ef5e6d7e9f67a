#include "prehend/belief/hand_evidence.h"

#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "eval/belief/hand_closing.h"
#include "prehend/geometry/mesh_query.h"
#include "prehend/simulation/shapes.h"

namespace prehend::belief {
namespace {

using Eigen::Vector3d;
using geometry::RigidTransform;
using testing::HasSubstr;

constexpr double kDegrees = 180 / M_PI;

/// A hand of config/robots that comes from above, its tool at the height z, and closes.
struct Closed {
  std::string hand, preshape;
  double z = 0;      // m, of its tool
  double width = 0;  // m, of what it closes on
};
void PrintTo(const Closed& closed, std::ostream* out) {
  *out << closed.hand << " " << closed.preshape;
}

robot::HandModel hand_of(const Closed& closed) {
  return robot::read_hand_model("config/robots/" + closed.hand + ".yaml");
}

eval::HandClosing close_from_above(const robot::HandModel& hand, const Closed& closed,
                                   const geometry::MeshQuery* object) {
  const robot::Preshape& preshape = hand.preshape(closed.preshape);
  RigidTransform X_WG = RigidTransform::Identity();
  X_WG.linear() = Eigen::AngleAxisd(M_PI, Vector3d::UnitX()).toRotationMatrix();
  X_WG.translation().z() = closed.z;
  const RigidTransform X_WH = X_WG * (hand.X_HP * preshape.X_PG).inverse(Eigen::Isometry);
  RigidTransform X_WH_start = X_WH;
  X_WH_start.translation().z() += 0.08;
  robot::ClosingWay way = robot::closing_way(hand, preshape, preshape.open, preshape.open);
  way.closed = way.at(0.5);
  return eval::close_hand(grasp::HandToClose(hand), way, X_WH_start, X_WH, object);
}

geometry::SweptSpace space_round(const Eigen::AlignedBox3d& box, double spacing = 0.002) {
  const Vector3d around = Vector3d::Constant(0.03);
  return {Eigen::AlignedBox3d(box.min() - around, box.max() + around), spacing};
}

/// How deep the space reaches into the body, with all that is swept in it [m], and how much is
/// [m^3].
struct Reach {
  double deepest = -1, volume = 0;
};
Reach reach_into(const geometry::MeshQuery& body, const geometry::SweptSpace& space) {
  Reach reach;
  for (int z = 0; z < space.size().z(); ++z) {
    for (int y = 0; y < space.size().y(); ++y) {
      for (int x = 0; x < space.size().x(); ++x) {
        const Vector3d p = space.center(x, y, z);
        if (!(space.depth(p) > 0)) continue;
        reach.deepest = std::max(reach.deepest, -body.signed_distance(p));
        reach.volume += std::pow(space.spacing(), 3);
      }
    }
  }
  return reach;
}

/// It is touched where it is, in at least so many places and some at least so far apart, and what
/// was swept is beside it.
void expect_found(const Closed& closed, const geometry::TriangleMesh& mesh, std::size_t least,
                  double apart) {
  const robot::HandModel hand = hand_of(closed);
  const geometry::MeshQuery body(mesh);
  const eval::HandClosing closing = close_from_above(hand, closed, &body);
  ASSERT_TRUE(closing.arrived);
  const HandEvidence evidence(hand);

  const std::vector<Contact> contacts = evidence.contacts(closing.way.back(), closing.frames);
  ASSERT_GE(contacts.size(), least);
  Vector3d farthest_apart = Vector3d::Zero();
  for (const Contact& contact : contacts) {
    const auto nearest = *body.nearest(contact.p_W);
    const auto& t = mesh.triangles[static_cast<std::size_t>(nearest.triangle)];
    const Vector3d normal = (mesh.vertices[t[1]] - mesh.vertices[t[0]])
                                .cross(mesh.vertices[t[2]] - mesh.vertices[t[0]])
                                .normalized();
    EXPECT_LT(nearest.distance, 0.0015) << contact.p_W.transpose();
    EXPECT_LT(std::acos(std::min(1.0, normal.dot(contact.normal_W))) * kDegrees, 15)
        << contact.p_W.transpose();
    EXPECT_NEAR(contact.normal_W.norm(), 1, 1e-9);
    EXPECT_GT(contact.deviation, 1e-4);
    EXPECT_LT(contact.deviation, 0.002);
    const Vector3d r = contact.p_W - contacts.front().p_W;
    if (r.norm() > farthest_apart.norm()) farthest_apart = r;
  }
  EXPECT_GT(farthest_apart.norm(), apart);

  geometry::SweptSpace space = space_round(body.box());
  evidence.sweep(closing.way, evidence.depths(closing.frames), &space);
  const Reach reach = reach_into(body, space);
  EXPECT_LT(reach.deepest, 0.0005);
  EXPECT_GT(reach.volume, 1e-5) << "it went through what is round the body";
}

class HandEvidenceOf : public testing::TestWithParam<Closed> {};

TEST_P(HandEvidenceOf, ABoxIsTouchedOnItsSides) {
  const double width = GetParam().width;
  expect_found(GetParam(), simulation::make_standing_box({width, width, 0.14}), 8, 0.03);
}

TEST_P(HandEvidenceOf, ACanIsTouchedOnItsSides) {
  expect_found(GetParam(), simulation::make_can(GetParam().width / 2, 0.14), 8, 0.03);
}

// Its fingertips' pads are curved, of few cells, and meet thick things only.
TEST(HandEvidence, ABallIsTouchedByCurvedPads) {
  geometry::TriangleMesh ball = geometry::make_sphere(0.04, 96);
  for (Vector3d& p : ball.vertices) p.z() += 0.12;
  expect_found({"bh8", "spread_0", 0.12}, ball, 3, 0.003);
}

// 2 mm: what would be swept by a pad that does not give way.
TEST(HandEvidence, ABallIsPressedDeepIntoFoam) {
  geometry::TriangleMesh ball = geometry::make_sphere(0.025, 96);
  for (Vector3d& p : ball.vertices) p.z() += 0.09;
  expect_found({"pg70", "open", 0.09}, ball, 8, 0.03);
}

void expect_air(const Closed& closed) {
  const robot::HandModel hand = hand_of(closed);
  const eval::HandClosing closing = close_from_above(hand, closed, nullptr);
  const HandEvidence evidence(hand);
  EXPECT_TRUE(evidence.contacts(closing.way.back(), closing.frames).empty());
  geometry::SweptSpace space =
      space_round(Eigen::AlignedBox3d(Vector3d(-0.03, -0.03, 0.01), Vector3d(0.03, 0.03, 0.14)));
  evidence.sweep(closing.way, {}, &space);
  const Vector3d margin = Vector3d::Constant(2 * space.spacing());
  const Eigen::AlignedBox3d inner(space.box().min() + margin, space.box().max() - margin);
  // Where the fingers went, on the way from the first to where they meet.
  std::vector<RigidTransform> first, last;
  hand.link_poses(closing.way[1].joints, first);
  hand.link_poses(closing.way.back().joints, last);
  int passed = 0, looked = 0;
  for (const robot::HandPad& pad : hand.pads) {
    const auto link = static_cast<std::size_t>(pad.link);
    const RigidTransform& X_WH = closing.way.back().X_WH;
    const Vector3d from = X_WH * first[link] * pad.X_LP.translation();
    const Vector3d to = X_WH * last[link] * pad.X_LP.translation();
    if ((to - from).norm() < 0.02) continue;
    ++passed;
    const std::size_t middle = pad.layout->size() / 2;
    const Vector3d behind_P = pad.layout->position(middle) - 0.003 * pad.layout->normal(middle);
    for (const HandSample& sample : closing.way) {
      std::vector<RigidTransform> poses;
      hand.link_poses(sample.joints, poses);
      const Vector3d p = sample.X_WH * poses[link] * pad.X_LP * behind_P;
      if (!inner.contains(p)) continue;
      ++looked;
      EXPECT_GT(space.depth(p), 0) << pad.name << " at " << p.transpose();
    }
  }
  EXPECT_GE(passed, 1);
  EXPECT_GE(looked, 10);
}

TEST_P(HandEvidenceOf, ClosingOnAirIsSpaceWithoutContacts) { expect_air(GetParam()); }

TEST(HandEvidence, ClosingOnAirWithCurvedPadsIsSpaceWithoutContacts) {
  expect_air({"bh8", "spread_0", 0.12});
}

INSTANTIATE_TEST_SUITE_P(Hands, HandEvidenceOf,
                         testing::Values(Closed{"pg70", "open", 0.09, 0.05},
                                         Closed{"sdh2", "pinch", 0.11, 0.05},
                                         Closed{"sdh2", "parallel", 0.11, 0.05}));

class HandEvidenceInput : public testing::Test {
 protected:
  const robot::HandModel hand_ = hand_of({"sdh2", "pinch"});
  const HandEvidence evidence_{hand_};
  HandSample sample_{RigidTransform::Identity(), hand_.all_positions(hand_.preshapes.front().open)};
  touch::PadFrame frame_{"thumb_distal", touch::felt_pad_of(hand_.pads.back()),
                         std::vector<double>(hand_.pads.back().layout->size(), 0.0)};

  std::string refusal() const {
    geometry::SweptSpace space = space_round(Eigen::AlignedBox3d(Vector3d::Zero()));
    std::string swept;
    try {
      evidence_.sweep({sample_, sample_}, evidence_.depths({frame_}), &space);
    } catch (const std::invalid_argument& error) {
      swept = error.what();
    }
    try {
      evidence_.contacts(sample_, {frame_});
    } catch (const std::invalid_argument& error) {
      EXPECT_EQ(swept, error.what());
      return error.what();
    }
    EXPECT_EQ(swept, "");
    return "";
  }
};

TEST_F(HandEvidenceInput, IsRefusedByName) {
  EXPECT_EQ(refusal(), "");
  const HandSample good = sample_;
  sample_.joints = Eigen::VectorXd::Zero(3);
  EXPECT_THAT(refusal(), HasSubstr("3 positions for the"));
  sample_ = good;
  const int joint = hand_.actuated[1];
  sample_.joints[joint] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(refusal(), HasSubstr("'finger_1_proximal' of the hand sdh2 is not finite"));
  sample_ = good;
  sample_.X_WH.translation().x() = std::numeric_limits<double>::infinity();
  EXPECT_THAT(refusal(), HasSubstr("X_WH of the hand sdh2 is not finite"));
  sample_ = good;
  frame_.counts.pop_back();
  EXPECT_THAT(refusal(), HasSubstr("77 counts for the 78 texels of the pad 'thumb_distal'"));
  frame_.counts.push_back(0);
  frame_.pad = "thump_distal";
  EXPECT_THAT(refusal(), HasSubstr("has no pad 'thump_distal'"));
  geometry::SweptSpace space = space_round(Eigen::AlignedBox3d(Vector3d::Zero()));
  EXPECT_THROW(evidence_.sweep({}, {}, &space), std::invalid_argument);
  HandEvidenceOptions options;
  options.placement = 0;
  EXPECT_THROW(HandEvidence(hand_, options), std::invalid_argument);
}

// One row of texels that says nothing readable, as a broken wire does.
TEST_F(HandEvidenceInput, WhatIsNotReadableIsLeftOut) {
  for (int column = 0; column < 6; ++column) {
    frame_.counts[static_cast<std::size_t>(column)] = std::numeric_limits<double>::quiet_NaN();
    frame_.counts[static_cast<std::size_t>(60 + column)] = 500;
  }
  const std::vector<Contact> contacts = evidence_.contacts(sample_, {frame_});
  ASSERT_FALSE(contacts.empty());
  for (const Contact& contact : contacts) EXPECT_TRUE(contact.p_W.allFinite());
}

// A full texel is somewhere between what it says and the end of the foam.
TEST_F(HandEvidenceInput, FullTexelsAreLessSure) {
  frame_.counts[40] = 2000;
  const Contact touched = evidence_.contacts(sample_, {frame_}).front();
  frame_.counts[40] = 4095;
  auto felt = *frame_.felt;
  felt.law.stiffness = 4000;
  frame_.felt = std::make_shared<const touch::FeltPad>(felt);
  const Contact full = evidence_.contacts(sample_, {frame_}).front();
  EXPECT_GT(full.deviation, touched.deviation + 1e-4);
}

// However many texels are touched, contacts stay few and apart.
TEST_F(HandEvidenceInput, ContactsAreThinned) {
  frame_.counts.assign(frame_.counts.size(), 800.0);
  const std::vector<Contact> contacts = evidence_.contacts(sample_, {frame_});
  EXPECT_EQ(contacts.size(), 12U);
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      EXPECT_GT((contacts[i].p_W - contacts[j].p_W).norm(), 0.004);
    }
  }
}

}  // namespace
}  // namespace prehend::belief
