// Pads on curved surfaces beside closed forms. A texel whose ray, along its normal, is shortened by
// d presses with k d for each reference area, so that k' = k / kReferenceTexelArea is the stiffness
// of a unit of area.

#include <cmath>
#include <optional>
#include <stdexcept>

#include <gtest/gtest.h>

#include "prehend/contact/pad_depths.h"
#include "prehend/contact/pad_layout.h"
#include "prehend/contact/pad_readings.h"
#include "prehend/contact/shape.h"

namespace prehend::contact {
namespace {

constexpr double kRadius = 0.01, kThickness = 0.003;
constexpr double kStiffness = 1e3 / kReferenceTexelArea;  // N/m^3

geometry::TriangleMesh half_ball(int segments) {
  geometry::TriangleMesh ball = geometry::make_sphere(kRadius, segments);
  std::erase_if(ball.triangles, [&](const Eigen::Vector3i& t) {
    return ball.vertices[t[0]].z() + ball.vertices[t[1]].z() + ball.vertices[t[2]].z() < 0;
  });
  return ball;
}

struct Pressed {
  double normal = 0;                                // N, sum over texels
  Eigen::Vector3d force = Eigen::Vector3d::Zero();  // N, on what is pressed, in P
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
};

// A body pressed on the pad, by k d at each texel.
Pressed press(const PadLayout& pad, const Shape& shape, const geometry::RigidTransform& X_PB) {
  PadState state(pad);
  find_depths(pad, PadReach(pad), shape, X_PB, 0, state);
  Pressed sum;
  for (std::size_t i = 0; i < pad.size(); ++i) {
    state.normal_force[i] = kStiffness * pad.area(i) * std::max(0.0, state.depth[i]);
    sum.force += state.normal_force[i] * pad.normal(i);
  }
  sum.normal = total_normal_force(pad, state);
  sum.centre = centre_of_pressure(pad, state);
  return sum;
}

// The solid z >= `height` in P, whose face is turned by `tilt` [rad] about x.
Pressed press_plane(const PadLayout& pad, double height, double tilt = 0) {
  geometry::RigidTransform X_PB = geometry::RigidTransform::Identity();
  X_PB.linear() = Eigen::AngleAxisd(tilt, Eigen::Vector3d::UnitX()).toRotationMatrix() *
                  Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX()).toRotationMatrix();
  X_PB.translation() =
      Eigen::AngleAxisd(tilt, Eigen::Vector3d::UnitX()) * Eigen::Vector3d(0, 0, height);
  return press(pad, Shape::half_space(), X_PB);
}

// Of a ball pressed on a plane by d: a texel at the angle t from its pole is shortened by
// R - (R - d) / cos t. Integrals over the cap up to cos t = c = (R - d) / R.
double ball_force(double d) { return M_PI * kRadius * kStiffness * d * d; }
double ball_normal_sum(double d) {
  const double c = (kRadius - d) / kRadius;
  return 2 * M_PI * kRadius * kRadius * kStiffness *
         (kRadius * (1 - c) + (kRadius - d) * std::log(c));
}

std::optional<double> cylinder_height(double x, double /*y*/) {
  if (std::abs(x) > kRadius) return std::nullopt;
  return std::sqrt(kRadius * kRadius - x * x) - kRadius;
}

PadGrid grid_of(int rows, int columns, double width = 0.012) {
  return {rows, columns, width, 0.02, kThickness};
}

TEST(CurvedPads, AHalfBallOnAPlanePressesAsTheIntegralOverItsCap) {
  const double d = 0.002;
  for (const int segments : {32, 64, 128, 256}) {
    const PadLayout pad = PadLayout::curved(half_ball(segments), kThickness);
    const Pressed sum = press_plane(pad, kRadius - d);
    const double error = std::abs(sum.force.z() / ball_force(d) - 1);
    EXPECT_LT(error, 50.0 / (segments * segments)) << "second order, " << pad.size() << " texels";
    EXPECT_LT(sum.force.head<2>().norm(), 1e-9 * sum.force.z()) << "by symmetry";
    EXPECT_LT(sum.centre.head<2>().norm(), 1e-9);
  }
  const Pressed finest = press_plane(PadLayout::curved(half_ball(256), kThickness), kRadius - d);
  EXPECT_NEAR(finest.normal, ball_normal_sum(d), 2e-3 * finest.normal);
}

TEST(CurvedPads, AHalfBallFeelsFromWhereItIsPressed) {
  const PadLayout pad = PadLayout::curved(half_ball(128), kThickness);
  for (const double tilt : {0.2, 0.5}) {
    const Pressed sum = press_plane(pad, kRadius - 0.001, tilt);
    const Eigen::Vector3d way(0, -std::sin(tilt), std::cos(tilt));
    EXPECT_NEAR(sum.force.norm(), ball_force(0.001), 0.02 * ball_force(0.001));
    EXPECT_GT(sum.force.normalized().dot(way), std::cos(0.01));
    EXPECT_GT(sum.centre.normalized().dot(way), std::cos(0.01));
  }
}

// Of a cylinder of length L: 2 k' R L (R sin t - (R - d) t), cos t = (R - d) / R.
TEST(CurvedPads, ABentGridOnACylinderPressesAsTheIntegralOverItsStrip) {
  const double d = 0.001, c = (kRadius - d) / kRadius, t = std::acos(c), length = 0.02;
  const double force =
      2 * kStiffness * kRadius * length * (kRadius * std::sin(t) - (kRadius - d) * t);
  double before = 1;
  for (const int columns : {12, 24, 48, 96}) {
    const PadLayout pad = PadLayout::bent(grid_of(4, columns), cylinder_height);
    const Pressed sum = press_plane(pad, -d);
    const double error = std::abs(sum.force.z() / force - 1);
    EXPECT_LT(error, before);
    before = std::max(error, 1e-3);
    EXPECT_LT(sum.force.head<2>().norm(), 1e-9 * sum.force.z());
  }
  EXPECT_LE(before, 2e-3);
}

TEST(CurvedPads, StiffnessDoesNotDependOnHowABentGridIsDivided) {
  const double exact = 2 * std::asin(0.006 / kRadius) * kRadius * 0.02;  // m^2
  for (const auto& [rows, columns] : {std::pair{2, 2}, {4, 3}, {8, 6}, {14, 20}}) {
    const PadLayout pad = PadLayout::bent(grid_of(rows, columns), cylinder_height);
    EXPECT_EQ(pad.rows(), rows);
    EXPECT_EQ(pad.columns(), columns);
    EXPECT_NEAR(pad.area(), exact, 1e-3 * exact) << rows << " x " << columns;
    for (std::size_t i = 0; i < pad.size(); ++i) {
      const Eigen::Vector3d p = pad.position(i) + Eigen::Vector3d(0, 0, kRadius);
      EXPECT_NEAR(std::hypot(p.x(), p.z()), kRadius, 1e-12) << "on the cylinder";
      const Eigen::Vector3d out = Eigen::Vector3d(p.x(), 0, p.z()).normalized();
      EXPECT_GT(pad.normal(i).dot(out), 0.996);
    }
  }
}

TEST(CurvedPads, AGridBentOnAPlaneIsTheFlatOne) {
  const PadGrid grid = grid_of(5, 3);
  const PadLayout flat = PadLayout::flat(grid);
  const PadLayout bent = PadLayout::bent(grid, [](double, double) { return 0.0; });
  ASSERT_EQ(bent.size(), flat.size());
  for (std::size_t i = 0; i < flat.size(); ++i) {
    EXPECT_LT((bent.position(i) - flat.position(i)).norm(), 1e-15) << "row by row, row 0 at +y";
    EXPECT_LT((bent.normal(i) - flat.normal(i)).norm(), 1e-12);
    EXPECT_LT((bent.first_tangent(i) - flat.first_tangent(i)).norm(), 1e-12);
    EXPECT_NEAR(bent.area(i), flat.area(i), 1e-15);
  }
}

TEST(CurvedPads, CellsThatAreLeftOutKeepTheirPlaceAndFeelNothing) {
  const PadLayout pad = PadLayout::bent(grid_of(7, 4), [](double, double) { return 0.0; },
                                        {{0, 0}, {0, 3}, {6, 0}, {6, 3}});
  EXPECT_EQ(pad.size(), 28u);
  EXPECT_EQ(pad.cells(), 24u);
  EXPECT_NEAR(pad.area(), 24.0 / 28 * 0.012 * 0.02, 1e-12);
  PadState state(pad);
  EXPECT_TRUE(find_depths(
      pad, PadReach(pad), Shape::half_space(),
      [] {
        geometry::RigidTransform X = geometry::RigidTransform::Identity();
        X.linear() = Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX()).toRotationMatrix();
        X.translation().z() = -0.001;
        return X;
      }(),
      0, state));
  for (const std::size_t corner : {0, 3, 24, 27}) EXPECT_EQ(state.depth[corner], PadState::kFar);
  EXPECT_NEAR(state.depth[1], 0.001, 1e-12);
  for (const double p : pressure(pad, state)) EXPECT_EQ(p, 0) << "also of what is no texel";
}

void expect_bent_refused(const PadGrid& grid, const SurfaceHeight& surface,
                         const std::vector<Eigen::Vector2i>& left_out, const std::string& says) {
  try {
    PadLayout::bent(grid, surface, left_out);
    ADD_FAILURE() << says << ": accepted";
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find(says), std::string::npos) << error.what();
  }
}

TEST(CurvedPads, RefuseWhatIsNoPadByItsCell) {
  const auto plane = [](double, double) { return 0.0; };
  expect_bent_refused(grid_of(4, 2, 0.03), cylinder_height, {}, "row 0, column 0");
  expect_bent_refused(
      grid_of(4, 4), [](double x, double) { return x < 0.003 ? 0.0 : -0.05; }, {}, "too steeply");
  expect_bent_refused(grid_of(4, 4), plane, {{4, 0}}, "row 4");
  expect_bent_refused(grid_of(1, 1), plane, {{0, 0}}, "all cells");
  PadGrid thin = grid_of(4, 4);
  thin.thickness = 0;
  expect_bent_refused(thin, plane, {}, "thickness");
}

}  // namespace
}  // namespace prehend::contact
