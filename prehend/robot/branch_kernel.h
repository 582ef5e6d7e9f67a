#pragma once

#include <array>
#include <cstdint>

namespace prehend::robot {

constexpr int kBranches = 8;

/// A six-axis arm with a spherical wrist whose second and third axes are parallel, at position 0 in
/// the base frame.
struct BranchArm {
  using Vector = std::array<double, 3>;
  std::array<Vector, 6> axis{};         // unit
  Vector point0{}, point1{};            // of the first and second axis [m]
  Vector wrist{};                       // m
  Vector upper{}, lower{};              // second to third axis, third to wrist, across the axes [m]
  std::array<double, 6> low{}, high{};  // limits [rad], may be infinite
};

struct BranchInput {
  std::array<double, 9> R{};     // by rows: with t, the tip's motion from where it is at position 0
  std::array<double, 3> t{};     // m
  std::array<double, 6> seed{};  // rad
};

struct BranchOutput {
  std::array<std::array<double, kBranches>, 6> q{};  // rad, lane by lane; whole turns as near to
                                                     // the seed as the limits allow
  std::array<double, kBranches> distance{};          // squared, from the seed [rad^2]
  std::uint32_t within = 0;                          // lanes that solve it within the limits
  /// A root is double or an axis coincides with another: the lanes are of no use.
  bool is_doubtful = false;
};

/// The eight branches of the closed form, one in each lane of the machine's vector instructions:
/// signs of the roots for the first, third and fifth axis. Sines and cosines are carried instead of
/// angles, so that six arcus tangents in all remain.
void solve_branches(const BranchArm& arm, const BranchInput& input, BranchOutput& output);

}  // namespace prehend::robot
