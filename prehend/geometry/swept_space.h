#pragma once

#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace prehend::geometry {

/// Space that something was moved through without touching anything, as the union of balls: at
/// each voxel how deep it lies in the deepest ball over it. Of the space itself that is a lower
/// bound.
class SweptSpace {
 public:
  /// Nothing was swept yet of `box`; voxels have the side `spacing` [m].
  /// @throws std::invalid_argument for an empty box, a spacing that is not positive, and one with
  /// which the box has more than 16 million voxels.
  SweptSpace(const Eigen::AlignedBox3d& box, double spacing);

  /// O(voxels of the ball within the box). A radius that is not positive adds nothing.
  void add_ball(const Eigen::Vector3d& center, double radius);
  /// What a ball sweeps that is moved straight from one centre to the other.
  void add_path(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double radius);
  /// What another one swept too. @throws std::invalid_argument when its voxels are others.
  void add(const SweptSpace& other);

  /// How deep `p` lies in swept space, by linear interpolation [m]; 0 or less outside and where
  /// nothing was swept.
  double depth(const Eigen::Vector3d& p) const;

  bool empty() const { return empty_; }
  const Eigen::AlignedBox3d& box() const { return box_; }
  double spacing() const { return spacing_; }
  const Eigen::Vector3i& size() const { return size_; }         // voxels along x, y, z
  const std::vector<float>& depths() const { return depths_; }  // of voxels, x fastest [m]
  Eigen::Vector3d center(int x, int y, int z) const {           // of a voxel
    return box_.min() + spacing_ * (Eigen::Vector3d(x, y, z) + Eigen::Vector3d::Constant(0.5));
  }

 private:
  std::size_t index(int x, int y, int z) const {
    return (static_cast<std::size_t>(z) * size_.y() + y) * size_.x() + x;
  }

  Eigen::AlignedBox3d box_;
  double spacing_;
  Eigen::Vector3i size_;
  std::vector<float> depths_;
  bool empty_ = true;
};

}  // namespace prehend::geometry
