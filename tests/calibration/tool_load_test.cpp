#include "prehend/calibration/tool_load.h"

#include <gtest/gtest.h>

#include <cmath>

#include <Eigen/Geometry>

#include "prehend/calibration/degenerate_data.h"

namespace prehend::testing {
namespace {

using calibration::StillWrench;

// The FT 300 with a hand on it: 0.1 N and 5 mN m of noise.
class ToolLoad : public ::testing::Test {
 protected:
  StillWrench at(const Eigen::Matrix3d& R_WS) {
    std::normal_distribution<double> normal(0, 1);
    const auto noise = [&](double deviation) {
      return Eigen::Vector3d(deviation *
                             Eigen::Vector3d(normal(random_), normal(random_), normal(random_)));
    };
    StillWrench pose;
    pose.R_WS = R_WS;
    const Eigen::Vector3d weight = mass_ * (R_WS.transpose() * Eigen::Vector3d(0, 0, -9.81));
    pose.force_S = force_bias_ + weight + noise(0.1);
    pose.torque_S = torque_bias_ + center_.cross(weight) + noise(0.005);
    return pose;
  }
  std::vector<StillWrench> tilted(int count, double most) {
    std::uniform_real_distribution<double> unit(-1, 1);
    std::vector<StillWrench> poses;
    for (int i = 0; i < count; ++i) {
      const double side = M_PI * unit(random_);
      poses.push_back(at((Eigen::AngleAxisd(M_PI * unit(random_), Eigen::Vector3d::UnitZ()) *
                          Eigen::AngleAxisd(most * std::abs(unit(random_)),
                                            Eigen::Vector3d(std::cos(side), std::sin(side), 0)))
                             .toRotationMatrix()));
    }
    return poses;
  }
  std::string refused_as(const std::vector<StillWrench>& poses) {
    try {
      calibration::calibrate_tool_load(poses);
    } catch (const calibration::DegenerateData& error) {
      return error.name();
    }
    return "";
  }

  std::mt19937 random_{1};
  double mass_ = 2.3;
  Eigen::Vector3d center_{0.004, -0.012, 0.085}, force_bias_{3, -5, 12},
      torque_bias_{0.2, 0.1, -0.3};
};

TEST_F(ToolLoad, BiasMassAndCentreAreFound) {
  double worst = 0;
  for (int trial = 0; trial < 20; ++trial) {
    const auto fit = calibration::calibrate_tool_load(tilted(12, 2.0));
    EXPECT_NEAR(fit.mass, mass_, 0.02);
    EXPECT_LT((fit.center_S - center_).norm(), 1e-3);
    EXPECT_LT((fit.force_bias - force_bias_).norm(), 0.25);
    EXPECT_LT((fit.torque_bias - torque_bias_).norm(), 0.015);
    worst = std::max(worst, (fit.center_S - center_).norm());
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_LT(std::abs(fit.center_S(axis) - center_(axis)), 5 * fit.center_deviation(axis));
      EXPECT_LT(std::abs(fit.force_bias(axis) - force_bias_(axis)),
                5 * fit.force_bias_deviation(axis));
    }
    EXPECT_NEAR(fit.force_rms, 0.1, 0.05);
  }
  RecordProperty("worst_center_mm", std::to_string(1e3 * worst));
}

TEST_F(ToolLoad, ATouchedToolIsLeftOut) {
  std::vector<StillWrench> poses = tilted(15, 2.0);
  poses[3].force_S += Eigen::Vector3d(0, 4, 0);
  poses[8].torque_S += Eigen::Vector3d(0.5, 0, 0);
  poses[11].force_S += Eigen::Vector3d(-9, 2, 5);
  const auto fit = calibration::calibrate_tool_load(poses);
  EXPECT_FALSE(fit.poses[3].used);
  EXPECT_FALSE(fit.poses[8].used);
  EXPECT_FALSE(fit.poses[11].used);
  EXPECT_NEAR(fit.mass, mass_, 0.03);
  EXPECT_LT((fit.center_S - center_).norm(), 1.5e-3);
}

TEST_F(ToolLoad, DegenerateDataIsRefusedByName) {
  EXPECT_EQ(refused_as(tilted(5, 2.0)), "too few poses");
  // Turned about the vertical alone; tilted about one axis by little to both sides.
  std::vector<StillWrench> upright, one_side;
  for (int i = 0; i < 12; ++i) {
    upright.push_back(at(Eigen::AngleAxisd(0.5 * i, Eigen::Vector3d::UnitZ()).toRotationMatrix()));
    one_side.push_back(
        at(Eigen::AngleAxisd(0.03 * (i - 6), Eigen::Vector3d::UnitX()).toRotationMatrix()));
  }
  EXPECT_EQ(refused_as(upright), "no tilt");
  EXPECT_EQ(refused_as(one_side), "tilt to one side alone");
  std::vector<StillWrench> reversed = tilted(12, 2.0);
  for (StillWrench& pose : reversed) pose.force_S = -pose.force_S;
  EXPECT_EQ(refused_as(reversed), "signs reversed");
  mass_ = 0;
  EXPECT_EQ(refused_as(tilted(12, 2.0)), "no load");
  mass_ = 2.3;
  std::vector<StillWrench> bad = tilted(12, 2.0);
  bad[2].force_S.x() = std::nan("");
  EXPECT_THROW(calibration::calibrate_tool_load(bad), std::invalid_argument);
  bad = tilted(12, 2.0);
  bad[2].R_WS *= 2;
  EXPECT_THROW(calibration::calibrate_tool_load(bad), std::invalid_argument);
}

}  // namespace
}  // namespace prehend::testing
