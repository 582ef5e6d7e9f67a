#include "prehend/belief/attempt_memory.h"

#include <cmath>
#include <limits>
#include <stdexcept>

#include <gmock/gmock.h>

#include "prehend/geometry/mesh_query.h"
#include "prehend/robot/hand_model.h"
#include "prehend/robot/robot_files.h"
#include "prehend/surface/deviation.h"
#include "tests/belief/predicted.h"

namespace prehend::belief {
namespace {

using Eigen::Vector3d;
using geometry::RigidTransform;
using ::testing::HasSubstr;

constexpr double kDepth = 0.02;  // m, by which the far side is predicted too far

const robot::HandModel& hand() {
  static const robot::HandModel hand = robot::read_hand_model("config/robots/pg70.yaml");
  return hand;
}

geometry::TriangleMesh box() { return shape::standing(geometry::make_box({0.08, 0.06, 0.1}), 0); }

RigidTransform moved_by(double x, double y, double turn) {
  RigidTransform X = RigidTransform::Identity();
  X.linear() = Eigen::AngleAxisd(turn, Vector3d::UnitZ()).toRotationMatrix();
  X.translation() = Vector3d(x, y, 0);
  return X;
}

/// Contacts on the side of the body that no camera at azimuth 0 sees, and how it is known to move.
Attempt touches_behind(const geometry::TriangleMesh& truth_W) {
  const Eigen::AlignedBox3d box = geometry::bounds(truth_W);
  Act act;
  for (const double y : {-0.015, 0.0, 0.015}) {
    act.contacts.push_back(
        {{box.min().x(), box.center().y() + y, box.center().z()}, -Vector3d::UnitX(), 0.0007});
  }
  return {act};
}

double error_of(const geometry::TriangleMesh& mesh, const geometry::TriangleMesh& truth) {
  return surface::mesh_deviation(truth, mesh, {.samples = 4000}).to_second.mean;
}

geometry::TriangleMesh predicted_surface(const Predicted& predicted) {
  return surface::mesh_of(predicted.shape, predicted.view.table_W);
}

TEST(AttemptMemory, WithoutAttemptsThereIsNothingToRecall) {
  const Predicted predicted(box());
  AttemptMemory memory(hand());
  EXPECT_FALSE(memory.recall(predicted.shape, predicted.view.table_W));
  EXPECT_EQ(memory.problem(), "");
  memory.add({}, predicted.shape, predicted.view.table_W, predicted_surface(predicted));
  memory.add({Act{}}, predicted.shape, predicted.view.table_W, predicted_surface(predicted));
  EXPECT_TRUE(memory.empty()) << "an attempt that found nothing out";
}

TEST(AttemptMemory, WhatWasTouchedStaysKnownWhenItIsSeenAgain) {
  const Predicted predicted = too_deep(box(), kDepth);
  const geometry::TriangleMesh before = predicted_surface(predicted);
  AttemptMemory memory(hand());
  memory.add(touches_behind(predicted.truth_W), predicted.shape, predicted.view.table_W, before);
  const auto known = memory.recall(predicted.shape, predicted.view.table_W);
  ASSERT_TRUE(known) << memory.problem();
  EXPECT_LT(error_of(known->model.mesh_W, predicted.truth_W),
            0.4 * error_of(before, predicted.truth_W));
  EXPECT_TRUE(known->model.defects.watertight());
  EXPECT_EQ(known->contacts.size(), 3);
  EXPECT_EQ(known->looks, 1);
  EXPECT_GT(known->change, 0.001);
  EXPECT_LT(known->X_moved.translation().norm(), 0.001);
  // Where it was touched nothing is guessed any more.
  const auto& origin = known->model.vertex_origin;
  EXPECT_GT(std::count(origin.begin(), origin.end(), surface::SurfaceOrigin::kTouched), 3);
  // The same again, to the last bit.
  const auto again = memory.recall(predicted.shape, predicted.view.table_W);
  ASSERT_TRUE(again);
  EXPECT_LT(error_of(again->model.mesh_W, known->model.mesh_W), 2e-4);
}

// The attempt has pushed it away, and turned it.
TEST(AttemptMemory, GoesAlongWithWhatHasMoved) {
  const Predicted first = too_deep(box(), kDepth);
  AttemptMemory memory(hand());
  memory.add(touches_behind(first.truth_W), first.shape, first.view.table_W,
             predicted_surface(first));
  const RigidTransform X_moved = moved_by(0.02, -0.015, 0.2);
  const Predicted second = too_deep(geometry::transformed(box(), X_moved), kDepth);
  const auto known = memory.recall(second.shape, second.view.table_W);
  ASSERT_TRUE(known) << memory.problem();
  const Vector3d corner(0.04, 0.03, 0.1);
  EXPECT_LT((known->X_moved * corner - X_moved * corner).norm(), 0.004);
  EXPECT_LT(error_of(known->model.mesh_W, second.truth_W),
            0.7 * error_of(predicted_surface(second), second.truth_W));
}

// It was gripped, which pushed it, lifted, and came down elsewhere; or farther than it is looked
// for.
TEST(AttemptMemory, WhatWasHeldIsKnownWhereItWasPutDown) {
  const Predicted first = too_deep(box(), kDepth);
  const Eigen::AlignedBox3d body = geometry::bounds(first.truth_W);
  Attempt attempt = touches_behind(first.truth_W);
  constexpr double kPushed = 0.006;  // m, by the grip
  Act grip;
  grip.motion = {0.008, 0.05};
  for (const double y : {-0.015, 0.0, 0.015}) {
    grip.contacts.push_back(
        {{body.min().x() + kPushed, y, body.center().z()}, -Vector3d::UnitX(), 0.0007});
    grip.contacts.push_back(
        {{body.max().x() + kPushed, y, body.center().z()}, Vector3d::UnitX(), 0.0007});
  }
  attempt.push_back(grip);
  AttemptMemory memory(hand());
  memory.add(attempt, first.shape, first.view.table_W, predicted_surface(first));
  const Predicted far = too_deep(geometry::transformed(box(), moved_by(0.25, 0.1, 0.3)), kDepth);
  EXPECT_FALSE(memory.recall(far.shape, far.view.table_W));
  EXPECT_THAT(memory.problem(), HasSubstr("looks like it"));
  const Predicted put_down =
      too_deep(geometry::transformed(box(), moved_by(0.04, 0.07, 0.1)), kDepth);
  const auto known = memory.recall(put_down.shape, put_down.view.table_W);
  ASSERT_TRUE(known) << memory.problem();
  EXPECT_EQ(known->contacts.size(), 9u);
  EXPECT_LT(error_of(known->model.mesh_W, put_down.truth_W),
            0.7 * error_of(predicted_surface(put_down), put_down.truth_W));
}

// A can with a flat back that the first look takes for a whole one, as it sees none of the back.
geometry::TriangleMesh half_can() {
  geometry::TriangleMesh can = shape::standing(
      geometry::make_revolution({{0.0, 0.0}, {0.04, 0.0}, {0.04, 0.1}, {0.0, 0.1}}), 0);
  for (Vector3d& p : can.vertices) p.x() = std::max(p.x(), -0.01);
  return can;
}

// Another side of it, not as it was believed: it stands where it stood, and is the same.
TEST(AttemptMemory, WhatNothingHasTouchedIsTheSameFromElsewhere) {
  const Predicted front(half_can(), 0);
  const Predicted back(half_can(), 2.6);
  AttemptMemory memory(hand());
  memory.add_look(front.shape, front.view.table_W, predicted_surface(front));
  EXPECT_FALSE(memory.empty());
  const auto known = memory.recall(back.shape, back.view.table_W);
  ASSERT_TRUE(known) << memory.problem();
  EXPECT_EQ(known->looks, 1);
  EXPECT_TRUE(known->X_moved.isApprox(RigidTransform::Identity()));
  const double both = error_of(known->model.mesh_W, front.truth_W);
  EXPECT_LT(both, 0.6 * error_of(predicted_surface(front), front.truth_W));
  EXPECT_LT(both, error_of(predicted_surface(back), front.truth_W) + 2e-4);
}

// A look that shows again what was seen at first takes nothing of what was seen in between.
TEST(AttemptMemory, WhatWasSeenFromElsewhereStays) {
  const Predicted front(half_can(), 0), back(half_can(), 2.6), again(half_can(), 5.8);
  AttemptMemory memory(hand());
  memory.add_look(front.shape, front.view.table_W, predicted_surface(front));
  const auto two = memory.recall(back.shape, back.view.table_W);
  ASSERT_TRUE(two) << memory.problem();
  memory.add_look(back.shape, back.view.table_W, two->model.mesh_W);
  const auto three = memory.recall(again.shape, again.view.table_W);
  ASSERT_TRUE(three) << memory.problem();
  EXPECT_EQ(three->looks, 2);
  EXPECT_LT(error_of(two->model.mesh_W, front.truth_W), 3e-4);
  EXPECT_LT(error_of(three->model.mesh_W, front.truth_W), 5e-4);
  EXPECT_LT(error_of(three->model.mesh_W, front.truth_W),
            0.6 * error_of(predicted_surface(again), front.truth_W));
}

// Somebody has taken it away meanwhile, or pushed it: neither look may be laid onto the other.
TEST(AttemptMemory, WhatTheOtherLookSeesThroughIsNotTheSame) {
  const Predicted front(box(), 0);
  for (const double away : {0.05, 0.3}) {
    AttemptMemory memory(hand());
    memory.add_look(front.shape, front.view.table_W, predicted_surface(front));
    const Predicted elsewhere(geometry::transformed(box(), moved_by(0, away, 0)), 2.6);
    EXPECT_FALSE(memory.recall(elsewhere.shape, elsewhere.view.table_W)) << away;
    EXPECT_THAT(memory.problem(), HasSubstr("looks like it"));
  }
  AttemptMemoryOptions contacts;
  contacts.use = EvidenceUse::kEmptySpace;
  AttemptMemory without_looks(hand(), contacts);
  without_looks.add_look(front.shape, front.view.table_W, predicted_surface(front));
  EXPECT_TRUE(without_looks.empty()) << "looks are no evidence that is used";
}

// It is gone, and what is seen is something else.
TEST(AttemptMemory, SaysThatNothingLooksLikeItWhenItIsGone) {
  const Predicted first(box());
  AttemptMemory memory(hand());
  memory.add(touches_behind(first.truth_W), first.shape, first.view.table_W,
             predicted_surface(first));
  const Predicted other(geometry::transformed(
      shape::standing(geometry::make_revolution({{0.03, 0}, {0.03, 0.12}}), 0),
      moved_by(0.3, 0.1, 0)));
  EXPECT_FALSE(memory.recall(other.shape, other.view.table_W));
  EXPECT_THAT(memory.problem(), HasSubstr("looks like it"));
}

// It fell over: what is seen at its place does not fit what was there.
TEST(AttemptMemory, BeginsAgainWhereItLiesOtherwise) {
  const auto tall = shape::standing(geometry::make_box({0.04, 0.06, 0.2}), 0);
  const Predicted first(tall);
  AttemptMemory memory(hand());
  memory.add(touches_behind(first.truth_W), first.shape, first.view.table_W,
             predicted_surface(first));
  const Predicted lying(geometry::transformed(
      shape::standing(geometry::make_box({0.2, 0.06, 0.04}), 0), moved_by(-0.08, 0, 0)));
  const auto known = memory.recall(lying.shape, lying.view.table_W);
  if (known) {  // it may be laid onto its other side: then what was felt must not spoil it
    EXPECT_LT(error_of(known->model.mesh_W, lying.truth_W),
              error_of(predicted_surface(lying), lying.truth_W) + 0.0005);
  } else {
    EXPECT_NE(memory.problem(), "");
  }
}

// Two things are touched at once, and the table.
TEST(AttemptMemory, ContactsWithOthersAreNoneOfIts) {
  const Predicted predicted(box());
  const geometry::TriangleMesh neighbour_W = geometry::transformed(box(), moved_by(0, 0.09, 0));
  Attempt attempt = touches_behind(predicted.truth_W);
  const Vector3d on_neighbour(0, 0.06, 0.05), on_table(-0.05, 0, 0.0005);
  attempt.front().contacts.push_back({on_neighbour, -Vector3d::UnitY(), 0.0007});
  attempt.front().contacts.push_back({on_table, Vector3d::UnitZ(), 0.0007});
  AttemptMemory memory(hand());
  memory.add(attempt, predicted.shape, predicted.view.table_W, predicted_surface(predicted),
             {neighbour_W});
  const auto known = memory.recall(predicted.shape, predicted.view.table_W);
  ASSERT_TRUE(known) << memory.problem();
  EXPECT_EQ(known->contacts.size(), 3);
  EXPECT_LT(error_of(known->model.mesh_W, predicted.truth_W), 0.002);
}

// What the camera sees is not where it was felt: no shape explains both.
TEST(AttemptMemory, ContactsThatContradictEverythingAreForgottenAndThatIsSaid) {
  const Predicted predicted(box());
  for (const double behind : {0.015, 0.025, 0.04}) {
    SCOPED_TRACE(behind);
    Act act;
    for (const double y : {-0.004, -0.002, 0.0, 0.002, 0.004}) {
      // Behind the side that is seen, facing the camera.
      act.contacts.push_back({{0.04 - behind, y, 0.05}, Vector3d::UnitX(), 0.0007});
    }
    AttemptMemory memory(hand());
    memory.add({act}, predicted.shape, predicted.view.table_W, predicted_surface(predicted));
    EXPECT_FALSE(memory.recall(predicted.shape, predicted.view.table_W));
    EXPECT_THAT(memory.problem(), HasSubstr("contradicts"));
    EXPECT_TRUE(memory.empty()) << "it starts again from the look";
  }
}

// In the air before it, where the camera looked through.
TEST(AttemptMemory, ContactsInTheAirAreForgottenAndThatIsSaid) {
  const Predicted predicted(box());
  Act act;
  for (const double y : {-0.004, 0.0, 0.004}) {
    act.contacts.push_back({{0.055, y, 0.05}, Vector3d::UnitX(), 0.0007});
  }
  AttemptMemory memory(hand());
  memory.add({act}, predicted.shape, predicted.view.table_W, predicted_surface(predicted));
  EXPECT_FALSE(memory.recall(predicted.shape, predicted.view.table_W));
  EXPECT_THAT(memory.problem(), HasSubstr("contradicts"));
}

// The other look shows the side that this one does not.
TEST(AttemptMemory, LooksBeforeShowOtherSides) {
  const Predicted from_behind(box(), std::numbers::pi);
  const Predicted now = too_deep(box(), kDepth);
  AttemptMemory memory(hand());
  Act air;  // far from it
  air.free_way = {{moved_by(0, 0, 0),
                   Eigen::VectorXd::Zero(static_cast<Eigen::Index>(hand().model.joints.size()))}};
  air.free_way.front().X_WH.translation().z() = 1;
  memory.add({air}, from_behind.shape, from_behind.view.table_W, predicted_surface(from_behind));
  const auto known = memory.recall(now.shape, now.view.table_W);
  ASSERT_TRUE(known) << memory.problem();
  EXPECT_GT(known->contacts.size(), 5) << "of what was seen then";
  EXPECT_LT(error_of(known->model.mesh_W, now.truth_W),
            0.65 * error_of(predicted_surface(now), now.truth_W));
}

TEST(AttemptMemory, UsesWhatItIsToldToUse) {
  const Predicted predicted = too_deep(box(), kDepth);
  AttemptMemoryOptions options;
  options.use = EvidenceUse::kNone;
  AttemptMemory none(hand(), options);
  none.add(touches_behind(predicted.truth_W), predicted.shape, predicted.view.table_W,
           predicted_surface(predicted));
  EXPECT_TRUE(none.empty());
  options.tolerance = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(AttemptMemory(hand(), options), std::invalid_argument);
}

}  // namespace
}  // namespace prehend::belief
