#pragma once

#include <array>
#include <memory>
#include <vector>

#include <Eigen/Core>

namespace prehend::grasp {

/// Points of a surface with unit normals, and what the surface looks like around each.
struct DescribedPoints {
  static constexpr int kFeatureSize = 33;  // three histograms of 11 bins
  using Feature = std::array<float, kFeatureSize>;
  std::vector<Eigen::Vector3d> points;   // n, m
  std::vector<Eigen::Vector3d> normals;  // n, unit, outwards
  std::vector<Feature> features;         // n
};

/// One point a cube of `spacing` [m]: the mean of those inside, in the order of the first ones.
std::vector<Eigen::Vector3d> thinned(const std::vector<Eigen::Vector3d>& points, double spacing);

/// Normals from the neighbours within 3 `spacing`, turned towards `eye`; points that have too few
/// neighbours for one are dropped from `points`.
std::vector<Eigen::Vector3d> normals_towards(const Eigen::Vector3d& eye, double spacing,
                                             std::vector<Eigen::Vector3d>& points);

/// FPFH (Rusu et al., ICRA 2009) with the neighbours within 5 `spacing` [m]. Points whose
/// surroundings say nothing get zeros.
std::vector<DescribedPoints::Feature> features_of(const std::vector<Eigen::Vector3d>& points,
                                                  const std::vector<Eigen::Vector3d>& normals,
                                                  double spacing);

/// Finds the points of a model whose surroundings look alike.
class FeatureIndex {
 public:
  explicit FeatureIndex(const std::vector<DescribedPoints::Feature>& features);
  ~FeatureIndex();
  FeatureIndex(FeatureIndex&&) noexcept;
  /// The `count` (or all) most similar ones, the best first.
  std::vector<int> nearest(const DescribedPoints::Feature& feature, int count) const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace prehend::grasp
