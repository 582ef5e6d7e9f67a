// What the memory of attempts makes of pads that say what is not so. A hand closes on a box that
// was predicted too deep, so that its pads touch the side that was seen and the one that was not.

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "eval/belief/hand_closing.h"
#include "prehend/belief/attempt_memory.h"
#include "prehend/geometry/mesh_query.h"
#include "prehend/surface/deviation.h"
#include "tests/belief/predicted.h"

namespace prehend::belief {
namespace {

using Eigen::Vector3d;
using geometry::RigidTransform;

constexpr double kTooDeep = 0.014;  // m
constexpr double kPadsHeight = 0.09;

const robot::HandModel& jaws() {
  static const robot::HandModel hand = robot::read_hand_model("config/robots/pg70.yaml");
  return hand;
}

const geometry::MeshQuery& truth() {
  static const geometry::MeshQuery body(shape::standing(geometry::make_box({0.05, 0.05, 0.14}), 0));
  return body;
}

const Predicted& prediction() {
  static const Predicted predicted = too_deep(truth().mesh(), kTooDeep);
  return predicted;
}

double error(const geometry::TriangleMesh& mesh) {
  return surface::mesh_deviation(truth().mesh(), mesh, {.samples = 4000}).to_second.mean;
}
const geometry::TriangleMesh& predicted_mesh() {
  static const geometry::TriangleMesh mesh =
      surface::mesh_of(prediction().shape, prediction().view.table_W);
  return mesh;
}

/// The jaws come from above and close along the world's x, `beside` its middle [m].
const eval::HandClosing& closing(double beside) {
  static std::map<double, eval::HandClosing> closings;
  const auto known = closings.find(beside);
  if (known != closings.end()) return known->second;
  const robot::Preshape& preshape = jaws().preshape("open");
  RigidTransform X_WG = RigidTransform::Identity();
  X_WG.linear() =
      (Eigen::AngleAxisd(M_PI / 2, Vector3d::UnitZ()) * Eigen::AngleAxisd(M_PI, Vector3d::UnitX()))
          .toRotationMatrix();
  X_WG.translation() = Vector3d(beside, 0, kPadsHeight);
  const RigidTransform X_WH = X_WG * (jaws().X_HP * preshape.X_PG).inverse(Eigen::Isometry);
  RigidTransform X_WH_start = X_WH;
  X_WH_start.translation().z() += 0.08;
  robot::ClosingWay way = robot::closing_way(jaws(), preshape, preshape.open, preshape.open);
  way.closed = way.at(0.5);
  return closings
      .emplace(beside,
               eval::close_hand(grasp::HandToClose(jaws()), way, X_WH_start, X_WH, &truth()))
      .first->second;
}

using Fault = std::function<void(std::vector<touch::PadFrame>&)>;

/// Free until shortly before it touches, then the contacts that its pads claim.
Attempt attempt_of(const eval::HandClosing& closed, const Fault& fault) {
  constexpr double kBeforeTouch = 0.003;  // m, of a jaw
  std::vector<touch::PadFrame> frames = closed.frames;
  if (fault) fault(frames);
  Act act;
  for (const HandSample& sample : closed.way) {
    const bool touches =
        (sample.X_WH.translation() - closed.way.back().X_WH.translation()).norm() < kBeforeTouch &&
        (sample.joints - closed.way.back().joints).cwiseAbs().maxCoeff() < kBeforeTouch;
    if (!touches) act.free_way.push_back(sample);
  }
  act.contacts = HandEvidence(jaws()).contacts(closed.way.back(), frames);
  return {act};
}

/// What is believed when it is seen again, or why nothing is made of what was felt.
struct Seen {
  std::optional<Recollection> known;
  std::string problem;
  double error = 0;  // m, of what is believed then
};
Seen seen_again(double beside, const Fault& fault) {
  AttemptMemory memory(jaws());
  memory.add(attempt_of(closing(beside), fault), prediction().shape, prediction().view.table_W,
             predicted_mesh());
  Seen seen;
  seen.known = memory.recall(prediction().shape, prediction().view.table_W);
  seen.problem = memory.problem();
  seen.error = error(seen.known ? seen.known->model.mesh_W : predicted_mesh());
  return seen;
}

int touching(const std::vector<touch::PadFrame>& frames) {
  int pads = 0;
  for (const touch::PadFrame& frame : frames) {
    const bool touches = std::any_of(frame.counts.begin(), frame.counts.end(),
                                     [](double counts) { return counts > 0; });
    pads += touches ? 1 : 0;
  }
  return pads;
}

/// The row with most counts of every pad.
std::size_t strongest_row(const touch::PadFrame& frame, std::size_t columns) {
  std::size_t best = 0;
  double most = -1;
  for (std::size_t row = 0; row < frame.counts.size() / columns; ++row) {
    double sum = 0;
    for (std::size_t c = 0; c < columns; ++c) sum += frame.counts[row * columns + c];
    if (sum <= most) continue;
    most = sum;
    best = row;
  }
  return best;
}

TEST(FaultyEvidence, WithSoundPadsTheUnseenSideIsWhereItWasTouched) {
  ASSERT_EQ(touching(closing(0).frames), 2);
  const Seen seen = seen_again(0, nullptr);
  ASSERT_TRUE(seen.known) << seen.problem;
  EXPECT_LT(seen.error, 0.5 * error(predicted_mesh()));
}

TEST(FaultyEvidence, ADeadRowOfTexelsMakesNoOtherBody) {
  constexpr std::size_t columns = 6;
  const double sound = seen_again(0, nullptr).error;
  for (const double says : {0.0, std::nan("")}) {
    SCOPED_TRACE(says);
    const Seen seen = seen_again(0, [&](std::vector<touch::PadFrame>& frames) {
      for (touch::PadFrame& frame : frames) {
        ASSERT_EQ(frame.counts.size() % columns, 0u);
        const std::size_t row = strongest_row(frame, columns);
        for (std::size_t c = 0; c < columns; ++c) frame.counts[row * columns + c] = says;
      }
    });
    ASSERT_TRUE(seen.known) << seen.problem;
    EXPECT_GT(seen.known->contacts.size(), 2u);
    EXPECT_LT(seen.error, sound + 0.0005);
  }
}

TEST(FaultyEvidence, APadBiasedByAFifthMakesNoOtherBody) {
  const double sound = seen_again(0, nullptr).error;
  for (const double gain : {0.8, 1.2}) {
    for (const std::size_t pad : {0u, 1u}) {
      SCOPED_TRACE(testing::Message() << gain << " of pad " << pad);
      const Seen seen = seen_again(0, [&](std::vector<touch::PadFrame>& frames) {
        for (double& counts : frames.at(pad).counts) counts *= gain;
      });
      ASSERT_TRUE(seen.known) << seen.problem;
      EXPECT_LT(seen.error, sound + 0.0005);
    }
  }
}

// Left and right swapped. Of a hand that is not in the middle one pad touches first, and the other
// one claims it: in the air before the side that is seen, which is said, or behind the body, where
// nobody can know better than the prediction.
TEST(FaultyEvidence, SwappedPadsEndRightOrAreSaid) {
  const double before = error(predicted_mesh());
  int said = 0;
  for (const double beside : {-0.006, 0.0, 0.006}) {
    SCOPED_TRACE(beside);
    const Seen seen = seen_again(beside, [](std::vector<touch::PadFrame>& frames) {
      ASSERT_EQ(frames.size(), 2u);
      std::swap(frames[0].counts, frames[1].counts);
    });
    EXPECT_LT(seen.error, before + 0.0005) << seen.problem;
    if (seen.known) continue;
    ++said;
    EXPECT_THAT(seen.problem, testing::HasSubstr("contradicts"));
  }
  EXPECT_GT(said, 0) << "what is felt in the air before what is seen is no body";
}

}  // namespace
}  // namespace prehend::belief
