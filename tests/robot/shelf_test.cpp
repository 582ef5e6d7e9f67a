// Arms and hands of config/robots that were written from published figures, against these figures.

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "prehend/robot/kinematic_chain.h"
#include "prehend/robot/platform.h"

namespace prehend::robot {
namespace {

using Eigen::Matrix4d;

constexpr double kHalf = std::numbers::pi / 2;

Matrix4d turned(int axis, double angle) {
  Matrix4d T = Matrix4d::Identity();
  const int a = (axis + 1) % 3, b = (axis + 2) % 3;
  T(a, a) = T(b, b) = std::cos(angle);
  T(b, a) = std::sin(angle);
  T(a, b) = -T(b, a);
  return T;
}
Matrix4d shifted(double x, double z) {
  Matrix4d T = Matrix4d::Identity();
  T(0, 3) = x;
  T(2, 3) = z;
  return T;
}

struct Row {
  double a, d, alpha;
};

/// The textbook's products: of the classic rows, and of Craig's.
Matrix4d classic(const std::vector<Row>& rows, const Eigen::VectorXd& q) {
  Matrix4d T = Matrix4d::Identity();
  for (std::size_t i = 0; i < rows.size(); ++i) {
    T = T * turned(2, q[static_cast<int>(i)]) * shifted(rows[i].a, rows[i].d) *
        turned(0, rows[i].alpha);
  }
  return T;
}
Matrix4d craig(const std::vector<Row>& rows, const Eigen::VectorXd& q) {
  Matrix4d T = Matrix4d::Identity();
  for (std::size_t i = 0; i < rows.size(); ++i) {
    T = T * turned(0, rows[i].alpha) * shifted(rows[i].a, 0) * turned(2, q[static_cast<int>(i)]) *
        shifted(0, rows[i].d);
  }
  return T;
}

template <class Product>
void expect_same(const std::string& urdf, const Product& product) {
  const RobotModel model = read_urdf("config/robots/" + urdf);
  const KinematicChain chain(model, "base_link", "tool0");
  std::mt19937 random(3);
  std::uniform_real_distribution<double> angle(-3, 3);
  for (int i = 0; i < 100; ++i) {
    Eigen::VectorXd q(chain.size());
    for (int j = 0; j < q.size(); ++j) q[j] = angle(random);
    EXPECT_LT((chain.forward(q).matrix() - product(q)).norm(), 1e-6) << urdf;
  }
}

TEST(Shelf, Ur5eIsThatOfItsMakersTable) {
  const std::vector<Row> rows{{0, 0.1625, kHalf}, {-0.425, 0, 0},      {-0.3922, 0, 0},
                              {0, 0.1333, kHalf}, {0, 0.0997, -kHalf}, {0, 0.0996, 0}};
  expect_same("ur5e.urdf", [&](const Eigen::VectorXd& q) { return classic(rows, q); });
}

TEST(Shelf, PandaIsThatOfItsMakersTable) {
  const std::vector<Row> rows{{0, 0.333, 0},      {0, 0, -kHalf},           {0, 0.316, kHalf},
                              {0.0825, 0, kHalf}, {-0.0825, 0.384, -kHalf}, {0, 0, kHalf},
                              {0.088, 0, kHalf}};
  expect_same("franka_panda.urdf", [&](const Eigen::VectorXd& q) {
    return Matrix4d(craig(rows, q) * shifted(0, 0.107));
  });
}

TEST(Shelf, IiwaIsThatOfItsMakersTable) {
  const std::vector<Row> rows{{0, 0.36, -kHalf}, {0, 0, kHalf}, {0, 0.42, kHalf}, {0, 0, -kHalf},
                              {0, 0.4, -kHalf},  {0, 0, kHalf}, {0, 0.126, 0}};
  expect_same("iiwa14.urdf", [&](const Eigen::VectorXd& q) { return classic(rows, q); });
}

TEST(Shelf, FingertipsOfThe2F85StayParallelAndMeet) {
  const HandModel hand = read_hand_model("config/robots/robotiq_2f85.yaml");
  const int left = hand.model.link_index("left_tip"), right = hand.model.link_index("right_tip");
  std::vector<geometry::RigidTransform> poses;
  const auto gap = [&](double knuckle) {
    hand.link_poses(hand.all_positions(Eigen::VectorXd::Constant(1, knuckle)), poses);
    for (const int tip : {left, right}) {
      EXPECT_LT(
          (poses[static_cast<std::size_t>(tip)].linear() - Eigen::Matrix3d::Identity()).norm(),
          1e-9);
    }
    // Pads' faces, as their boxes have them.
    const auto face = [&](int link, double sign) {
      const CollisionShape& box = hand.model.links[static_cast<std::size_t>(link)].shapes[0];
      return (poses[static_cast<std::size_t>(link)] * box.X_LS.translation()).y() -
             sign * box.size.y() / 2;
    };
    return face(left, 1) - face(right, -1);
  };
  EXPECT_NEAR(gap(0), 0.085, 1e-6);
  EXPECT_NEAR(gap(0.8), 0, 0.006);
  // By virtual work 235 N on each pad, where both face each other, are the motor's effort.
  const Joint& motor = hand.model.joints[static_cast<std::size_t>(hand.actuated[0])];
  const double h = 1e-4, middle = 0.3;
  double most = 0;  // N
  for (double q = middle; q < 0.8; q += 0.05) {
    most = std::max(most, motor.max_effort / ((gap(q - h) - gap(q + h)) / (2 * h)));
    EXPECT_GE(motor.max_effort / ((gap(q - h) - gap(q + h)) / (2 * h)), 234) << q;
  }
  EXPECT_LT(most, 300);
}

/// Where the tips of the SensorHand are, in the plane that they move in, as its URDF has them.
struct Tripod {
  Eigen::Vector3d axis, tip;  // of a finger
  Eigen::Vector3d thumb_axis, thumb_tip;
  double radii = 0;  // of both tips

  Eigen::Vector3d line() const { return tip - thumb_tip; }  // from the thumb's tip to the finger's
  double opening() const { return line().norm() - radii; }
  /// By which both come nearer a radian, by the levers of the line through them about the axes.
  double closing() const {
    const Eigen::Vector3d along = line().normalized(), x = Eigen::Vector3d::UnitX();
    return x.dot((tip - axis).cross(-along)) - x.dot((thumb_tip - thumb_axis).cross(along));
  }
};

Tripod tripod_of(const HandModel& hand, double drive, const std::string& finger) {
  std::vector<geometry::RigidTransform> poses;
  hand.link_poses(hand.all_positions(Eigen::VectorXd::Constant(1, drive)), poses);
  Tripod found;
  const auto look = [&](const std::string& name, Eigen::Vector3d& axis, Eigen::Vector3d& tip) {
    const auto link = static_cast<std::size_t>(hand.model.link_index(name));
    const CollisionShape& end = hand.model.links[link].shapes.back();  // round in this plane
    axis = poses[link].translation();
    tip = poses[link] * end.X_LS.translation();
    axis.x() = tip.x() = 0;
    found.radii += end.radius;
  };
  look(finger, found.axis, found.tip);
  look("thumb_finger", found.thumb_axis, found.thumb_tip);
  return found;
}

TEST(Shelf, SensorHandOpensPressesAndClosesAsItsMakerSays) {
  const HandModel hand = read_hand_model("config/robots/sensorhand.yaml");
  ASSERT_EQ(hand.size(), 1);
  const Joint& drive = hand.model.joints[static_cast<std::size_t>(hand.actuated[0])];
  for (const std::string finger : {"index_finger", "middle_finger"}) {
    SCOPED_TRACE(finger);
    const Tripod open = tripod_of(hand, drive.lower, finger);
    const Tripod closed = tripod_of(hand, drive.upper, finger);
    EXPECT_NEAR(open.opening(), 0.1, 2e-5);
    EXPECT_NEAR(closed.opening(), 0, 2e-5);
    // By virtual work 100 N on the fingers and on the thumb are the drive's effort.
    EXPECT_NEAR(drive.max_effort / closed.closing(), 100, 0.1);
    EXPECT_NEAR(drive.max_velocity * closed.closing(), 0.3, 5e-4);
    // The levers are the way's slope.
    const double h = 1e-4;
    EXPECT_NEAR(
        (tripod_of(hand, 0.4 - h, finger).opening() - tripod_of(hand, 0.4 + h, finger).opening()) /
            (2 * h),
        tripod_of(hand, 0.4, finger).closing(), 1e-6);
  }
  EXPECT_NEAR(hand.mass(), 0.46, 1e-9);
}

TEST(Shelf, SensorHandHasAHandsLengths) {
  const HandModel hand = read_hand_model("config/robots/sensorhand.yaml");
  // Shares of the hand's length as the URDF gives them, which says which were read; the means of
  // index and middle finger, bent by 60 degrees.
  const double length = 0.185, finger_radius = 0.008, thumb_radius = 0.009;
  const double proximal = (0.245 + 0.266) / 2 * length;
  const double outer = (0.143 + 0.097 + 0.17 + 0.108) / 2 * length - finger_radius;
  const double finger = std::sqrt(proximal * proximal + outer * outer + proximal * outer);
  const Tripod tips = tripod_of(hand, 0, "index_finger");
  EXPECT_NEAR((tips.tip - tips.axis).norm(), finger, 1e-4);
  EXPECT_NEAR((tips.thumb_tip - tips.thumb_axis).norm(), (0.196 + 0.158) * length - thumb_radius,
              1e-4);
  EXPECT_NEAR(tips.axis.z(), (1 - 0.544) * length, 1e-4);
}

}  // namespace
}  // namespace prehend::robot
