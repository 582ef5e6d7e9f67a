#include "prehend/grasp/known/point_features.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include <pcl/features/fpfh.h>
#include <pcl/features/normal_3d.h>
#include <pcl/kdtree/kdtree_flann.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>
#include <pcl/search/kdtree.h>

namespace prehend::grasp {
namespace {

using Points = pcl::PointCloud<pcl::PointXYZ>;
using Histograms = pcl::PointCloud<pcl::FPFHSignature33>;

Points::Ptr cloud_of(const std::vector<Eigen::Vector3d>& points) {
  auto cloud = std::make_shared<Points>();
  for (const Eigen::Vector3d& p : points) {
    cloud->push_back(pcl::PointXYZ(static_cast<float>(p.x()), static_cast<float>(p.y()),
                                   static_cast<float>(p.z())));
  }
  return cloud;
}

}  // namespace

std::vector<Eigen::Vector3d> thinned(const std::vector<Eigen::Vector3d>& points, double spacing) {
  std::map<std::tuple<long, long, long>, std::size_t> cubes;
  std::vector<Eigen::Vector3d> sums;
  std::vector<int> counts;
  for (const Eigen::Vector3d& p : points) {
    const auto cell = [&](double x) { return std::lround(x / spacing); };
    const auto [cube, is_new] =
        cubes.try_emplace({cell(p.x()), cell(p.y()), cell(p.z())}, sums.size());
    if (is_new) {
      sums.push_back(Eigen::Vector3d::Zero());
      counts.push_back(0);
    }
    sums[cube->second] += p;
    ++counts[cube->second];
  }
  for (std::size_t i = 0; i < sums.size(); ++i) sums[i] /= counts[i];
  return sums;
}

std::vector<Eigen::Vector3d> normals_towards(const Eigen::Vector3d& eye, double spacing,
                                             std::vector<Eigen::Vector3d>& points) {
  constexpr double kRadius = 3;  // spacings
  pcl::NormalEstimation<pcl::PointXYZ, pcl::Normal> estimation;
  estimation.setInputCloud(cloud_of(points));
  estimation.setSearchMethod(std::make_shared<pcl::search::KdTree<pcl::PointXYZ>>());
  estimation.setRadiusSearch(kRadius * spacing);
  estimation.setViewPoint(static_cast<float>(eye.x()), static_cast<float>(eye.y()),
                          static_cast<float>(eye.z()));
  pcl::PointCloud<pcl::Normal> estimated;
  estimation.compute(estimated);
  std::vector<Eigen::Vector3d> kept, normals;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3d normal = estimated[i].getNormalVector3fMap().cast<double>();
    if (!normal.allFinite() || normal.norm() < 0.5) continue;
    kept.push_back(points[i]);
    normals.push_back(normal.normalized());
  }
  points = std::move(kept);
  return normals;
}

std::vector<DescribedPoints::Feature> features_of(const std::vector<Eigen::Vector3d>& points,
                                                  const std::vector<Eigen::Vector3d>& normals,
                                                  double spacing) {
  constexpr double kRadius = 5;  // spacings
  auto pcl_normals = std::make_shared<pcl::PointCloud<pcl::Normal>>();
  for (const Eigen::Vector3d& n : normals) {
    pcl_normals->push_back(pcl::Normal(static_cast<float>(n.x()), static_cast<float>(n.y()),
                                       static_cast<float>(n.z())));
  }
  pcl::FPFHEstimation<pcl::PointXYZ, pcl::Normal, pcl::FPFHSignature33> estimation;
  estimation.setInputCloud(cloud_of(points));
  estimation.setInputNormals(pcl_normals);
  estimation.setSearchMethod(std::make_shared<pcl::search::KdTree<pcl::PointXYZ>>());
  estimation.setRadiusSearch(kRadius * spacing);
  Histograms histograms;
  estimation.compute(histograms);
  std::vector<DescribedPoints::Feature> features(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (int k = 0; k < DescribedPoints::kFeatureSize; ++k) {
      const float value = histograms[i].histogram[k];
      features[i][static_cast<std::size_t>(k)] = std::isfinite(value) ? value : 0.f;
    }
  }
  return features;
}

struct FeatureIndex::Implementation {
  pcl::KdTreeFLANN<pcl::FPFHSignature33> tree;
};

FeatureIndex::FeatureIndex(const std::vector<DescribedPoints::Feature>& features)
    : implementation_(std::make_unique<Implementation>()) {
  auto histograms = std::make_shared<Histograms>();
  for (const auto& feature : features) {
    pcl::FPFHSignature33 histogram;
    std::copy(feature.begin(), feature.end(), histogram.histogram);
    histograms->push_back(histogram);
  }
  implementation_->tree.setInputCloud(histograms);
}

FeatureIndex::~FeatureIndex() = default;
FeatureIndex::FeatureIndex(FeatureIndex&&) noexcept = default;

std::vector<int> FeatureIndex::nearest(const DescribedPoints::Feature& feature, int count) const {
  pcl::FPFHSignature33 histogram;
  std::copy(feature.begin(), feature.end(), histogram.histogram);
  pcl::Indices indices;
  std::vector<float> distances;
  implementation_->tree.nearestKSearch(histogram, static_cast<unsigned>(count), indices, distances);
  return {indices.begin(), indices.end()};
}

}  // namespace prehend::grasp
