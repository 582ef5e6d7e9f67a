#include "prehend/control/balance.h"

#include <cmath>

#include <gtest/gtest.h>

namespace prehend::control {
namespace {

using Eigen::Vector3d;

constexpr double kLever = 0.08;  // m, of each finger

// Fingers that close along `closes`, each by one motor at 1 rad for each rad of closing.
struct Fingers {
  explicit Fingers(const std::vector<Vector3d>& closes_in) : closes(closes_in) {
    const auto n = static_cast<Eigen::Index>(closes.size());
    tips.ways.resize(3, n);
    for (Eigen::Index i = 0; i < n; ++i) {
      tips.ways.col(i) = kLever * closes[static_cast<std::size_t>(i)];
      tips.finger.push_back(static_cast<int>(i));
    }
    rate = Eigen::VectorXd::Ones(n);
    predicted = Eigen::VectorXd::Constant(n, 0.7);
    sent = Eigen::VectorXd::Constant(n, 1.5);
  }
  /// Where they stop when the thing is there, and so much narrower on each side [m].
  Eigen::VectorXd stopped(const Vector3d& beside, double narrower) const {
    Eigen::VectorXd at = predicted;
    for (std::size_t i = 0; i < closes.size(); ++i) {
      at[static_cast<Eigen::Index>(i)] += (closes[i].dot(beside) + narrower) / kLever;
    }
    return at;
  }
  Vector3d felt(const Eigen::VectorXd& at) const {
    return displacement_felt(rate, predicted, at, sent, tips);
  }
  std::vector<Vector3d> closes;
  robot::FingertipWays tips;
  Eigen::VectorXd rate, predicted, sent;
};

const Vector3d kX = Vector3d::UnitX(), kY = Vector3d::UnitY();

TEST(DisplacementFelt, IsFoundAlongWhatTheFingersCanTell) {
  const Fingers two({kY, -kY});
  EXPECT_TRUE(two.felt(two.stopped({0.03, 0.012, 0}, 0)).isApprox(Vector3d(0, 0.012, 0), 1e-9))
      << "they feel nothing across";
  const Fingers against_thumb({kY, kY, -kY});
  EXPECT_TRUE(against_thumb.felt(against_thumb.stopped({0, -0.01, 0}, 0.004))
                  .isApprox(Vector3d(0, -0.01, 0), 1e-9));
  const Vector3d a(std::cos(2.1), std::sin(2.1), 0), b(std::cos(4.2), std::sin(4.2), 0);
  const Fingers round({kX, a, b});
  EXPECT_TRUE(round.felt(round.stopped({0.007, -0.011, 0}, -0.003))
                  .isApprox(Vector3d(0.007, -0.011, 0), 1e-9))
      << "and a thing that is wider too";
}

// Regression: of three fingers that close nearly along one line a thing seemed half a metre away.
TEST(DisplacementFelt, IsNotWhatFingersBarelyTell) {
  const double turn = 0.05;
  const Fingers nearly({kY, Vector3d(std::sin(turn), std::cos(turn), 0), -kY});
  Eigen::VectorXd at = nearly.predicted;
  at[0] += 0.1;
  EXPECT_LT(nearly.felt(at).norm(), 0.01) << "m, of a fingertip that is 8 mm farther";
}

TEST(DisplacementFelt, AThingThatIsNarrowerIsNotBeside) {
  const Fingers two({kY, -kY});
  EXPECT_LT(two.felt(two.stopped(Vector3d::Zero(), 0.01)).norm(), 1e-12);
  EXPECT_LT(two.felt(two.predicted).norm(), 1e-12);
}

// Of a finger whose first joint was stopped and whose last one went on, the tip counts.
TEST(DisplacementFelt, JointsOfAFingerCountTogether) {
  Fingers two({kY, kY, -kY});
  two.tips.finger = {0, 0, 1};
  Eigen::VectorXd at = two.predicted;
  at[0] -= 0.1;
  at[1] += 0.1;
  EXPECT_LT(two.felt(at).norm(), 1e-12);
}

TEST(DisplacementFelt, FingersThatMetNothingTellNothing) {
  Fingers two({kY, -kY});
  Eigen::VectorXd at = two.stopped({0, 0.01, 0}, 0);
  at[1] = two.sent[1];
  EXPECT_EQ(two.felt(at), Vector3d::Zero());
  two.rate[0] = 0;
  EXPECT_EQ(two.felt(two.stopped({0, 0.01, 0}, 0)), Vector3d::Zero()) << "one does not close";
}

TEST(FollowedShift, GoesAsFarAsItIsFree) {
  const std::vector<HandShift> shifts{
      {{0, 0.02, 0}, {0.1, 0.2}}, {{0, -0.01, 0}, {-0.05, -0.1}}, {{0.02, 0, 0}, {0.3, 0}}};
  const FollowedShift part = followed({0.01, 0.01, 0}, shifts);
  EXPECT_TRUE(part.way_W.isApprox(Vector3d(0.01, 0.01, 0)));
  EXPECT_NEAR(part.offsets.at(0), 0.5 * 0.1 + 0.5 * 0.3, 1e-12);
  EXPECT_NEAR(part.offsets.at(1), 0.1, 1e-12);
  EXPECT_TRUE(followed({0, -0.05, 0}, shifts).way_W.isApprox(Vector3d(0, -0.01, 0)));
  EXPECT_TRUE(followed({-0.05, 0, 0}, shifts).offsets.empty()) << "not free there";
  EXPECT_TRUE(followed({0.05, 0, 0}, {}).offsets.empty());
}

}  // namespace
}  // namespace prehend::control
