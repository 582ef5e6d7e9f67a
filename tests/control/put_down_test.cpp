#include "prehend/control/put_down.h"

#include <stdexcept>

#include <gtest/gtest.h>

namespace prehend::control {
namespace {

Eigen::AlignedBox3d box(double x, double y, double half, double height) {
  return {Eigen::Vector3d(x - half, y - half, 0), Eigen::Vector3d(x + half, y + half, height)};
}

TEST(ChooseMove, AloneItGoesAlongY) {
  const Eigen::Vector3d move = choose_move(box(0, 0, 0.03, 0.1), {0, 0, 0.06}, {});
  EXPECT_NEAR((move - Eigen::Vector3d(0, 0.15, 0)).norm(), 0, 1e-12);
}

TEST(ChooseMove, KeepsAwayFromNeighbours) {
  // Neighbours at both sides in y, both in reach of a move by 0.15 m.
  const auto object = box(0, 0, 0.03, 0.1);
  const Eigen::Vector3d move = choose_move(
      object, {0, 0, 0.06}, {box(-0.06, 0.2, 0.048, 0.09), box(0.03, -0.2, 0.045, 0.09)});
  EXPECT_NEAR(move.norm(), 0.15, 1e-12);
  EXPECT_GT(std::abs(move.x()), 0.1);
}

TEST(ChooseMove, TallNeighboursBlockTheWayNotOnlyTheEnd) {
  // A thin tall wall between here and there along +y.
  const Eigen::AlignedBox3d wall(Eigen::Vector3d(-0.5, 0.075, 0), Eigen::Vector3d(0.5, 0.08, 0.5));
  EXPECT_LT(choose_move(box(0, 0, 0.02, 0.1), {0, 0, 0.06}, {wall}).y(), 1e-9);
}

TEST(ChooseMove, StaysInTheWorkspace) {
  PutDownOptions options;
  options.workspace_W = {Eigen::Vector3d(-0.01, -0.2, 0), Eigen::Vector3d(0.01, 0.1, 1)};
  EXPECT_NEAR(choose_move(box(0, 0, 0.02, 0.1), {0, 0, 0.06}, {}, options).y(), -0.15, 1e-9);
  options.workspace_W = {Eigen::Vector3d(-0.01, -0.01, 0), Eigen::Vector3d(0.01, 0.01, 1)};
  EXPECT_TRUE(choose_move(box(0, 0, 0.02, 0.1), {0, 0, 0.06}, {}, options).isZero());
  options.distance = 0;
  EXPECT_THROW(choose_move(box(0, 0, 0.02, 0.1), {0, 0, 0.06}, {}, options), std::invalid_argument);
}

}  // namespace
}  // namespace prehend::control
