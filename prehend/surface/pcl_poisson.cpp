#include "prehend/surface/pcl_poisson.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include <pcl/point_types.h>
#include <pcl/surface/poisson.h>
#include <Eigen/Geometry>

namespace prehend::surface {
namespace {

using geometry::TriangleMesh;

void check(const PclPoissonOptions& options) {
  const auto require = [](bool condition, const std::string& what) {
    if (!condition) throw std::invalid_argument("PclPoissonOptions." + what);
  };
  require(options.depth >= 3 && options.depth <= 10, "depth must be in [3, 10]");
  require(options.samples_per_node >= 1 && options.samples_per_node <= 20,
          "samples_per_node must be in [1, 20]");
  require(options.point_weight >= 0 && std::isfinite(options.point_weight),
          "point_weight must be >= 0");
  require(options.scale >= 1.05 && options.scale <= 3, "scale must be in [1.05, 3]");
}

/// Cloud brought to unit size about the origin, so that PCL's single precision does not matter.
struct Normalization {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  double size = 1;
};

Normalization normalization_of(const geometry::PointCloud& cloud) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3f& p : cloud.points) box.extend(p.cast<double>());
  return {box.center(), box.sizes().maxCoeff()};
}

}  // namespace

TriangleMesh pcl_poisson(const geometry::PointCloud& cloud, const PclPoissonOptions& options) {
  check(options);
  const Normalization normalization = normalization_of(cloud);
  auto input = std::make_shared<pcl::PointCloud<pcl::PointNormal>>();
  input->reserve(cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    pcl::PointNormal point;
    point.getVector3fMap() =
        ((cloud.points[i].cast<double>() - normalization.center) / normalization.size)
            .cast<float>();
    point.getNormalVector3fMap() = cloud.normals[i];
    input->push_back(point);
  }
  pcl::Poisson<pcl::PointNormal> poisson;
  poisson.setInputCloud(input);
  poisson.setDepth(options.depth);
  poisson.setMinDepth(std::min(options.depth, 5));
  // Blocks smaller than the tree would leave seams.
  poisson.setSolverDivide(options.depth);
  poisson.setIsoDivide(options.depth);
  poisson.setSamplesPerNode(static_cast<float>(options.samples_per_node));
  poisson.setPointWeight(static_cast<float>(options.point_weight));
  poisson.setScale(static_cast<float>(options.scale));
  poisson.setManifold(true);
  poisson.setOutputPolygons(false);
  poisson.setThreads(1);
  pcl::PointCloud<pcl::PointNormal> vertices;
  std::vector<pcl::Vertices> polygons;
  poisson.performReconstruction(vertices, polygons);

  TriangleMesh mesh;
  for (const auto& vertex : vertices) {
    mesh.vertices.push_back(normalization.center +
                            normalization.size * vertex.getVector3fMap().cast<double>());
  }
  for (const pcl::Vertices& polygon : polygons) {
    if (polygon.vertices.size() != 3) continue;
    mesh.triangles.emplace_back(polygon.vertices[0], polygon.vertices[1], polygon.vertices[2]);
  }
  return mesh;
}

}  // namespace prehend::surface
