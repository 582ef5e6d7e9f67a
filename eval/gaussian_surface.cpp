#include "eval/gaussian_surface.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

#include "prehend/surface/marching_cubes.h"

namespace prehend::eval {
namespace {

/// What is known of the function.
struct Samples {
  std::vector<Eigen::Vector3f> points;
  std::vector<double> values;

  void add(const Eigen::Vector3d& p, double value) {
    points.push_back(p.cast<float>());
    values.push_back(value);
  }
};

void add_swept(const geometry::SweptSpace& swept, int most, Samples* samples) {
  if (swept.empty()) return;
  std::vector<Eigen::Vector3d> inside;
  for (int z = 0; z < swept.size().z(); ++z) {
    for (int y = 0; y < swept.size().y(); ++y) {
      for (int x = 0; x < swept.size().x(); ++x) {
        const Eigen::Vector3d p = swept.center(x, y, z);
        if (swept.depth(p) > swept.spacing()) inside.push_back(p);
      }
    }
  }
  const std::size_t step = 1 + inside.size() / static_cast<std::size_t>(most);
  for (std::size_t i = 0; i < inside.size(); i += step) samples->add(inside[i], 1);
}

Samples samples_of(const geometry::PointCloud& seen_W, const std::vector<belief::Contact>& contacts,
                   const geometry::SweptSpace& swept, const geometry::Plane& table_W,
                   const Eigen::AlignedBox3d& box_W, const GaussianSurfaceOptions& options) {
  constexpr std::size_t kWithSides = 6;  // one in so many seen points has a point on either side
  constexpr int kUnder = 5;              // points under the support, along either axis
  Samples samples;
  const std::size_t step = 1 + seen_W.size() / static_cast<std::size_t>(options.seen_points);
  std::size_t count = 0;
  for (std::size_t i = 0; i < seen_W.size(); i += step) {
    const Eigen::Vector3d p = seen_W.points[i].cast<double>();
    const Eigen::Vector3d n = seen_W.normals[i].cast<double>();
    samples.add(p, 0);
    if (count++ % kWithSides != 0) continue;
    samples.add(p + options.offset * n, 1);
    samples.add(p - options.offset * n, -1);
  }
  for (const belief::Contact& contact : contacts) {
    samples.add(contact.p_W, 0);
    samples.add(contact.p_W + options.offset * contact.normal_W, 1);
    samples.add(contact.p_W - options.offset * contact.normal_W, -1);
  }
  add_swept(swept, options.empty_points, &samples);
  for (int i = 0; i < kUnder; ++i) {
    for (int j = 0; j < kUnder; ++j) {
      const Eigen::Vector3d share((i + 0.5) / kUnder, (j + 0.5) / kUnder, 0);
      const Eigen::Vector3d p = box_W.min() + share.cwiseProduct(box_W.sizes());
      samples.add(table_W.project(p) - options.offset * table_W.normal, 1);
    }
  }
  return samples;
}

}  // namespace

geometry::TriangleMesh gaussian_surface(const geometry::PointCloud& seen_W,
                                        const std::vector<belief::Contact>& contacts,
                                        const geometry::SweptSpace& swept,
                                        const geometry::Plane& table_W,
                                        const Eigen::AlignedBox3d& box_W,
                                        const GaussianSurfaceOptions& options) {
  const Samples samples = samples_of(seen_W, contacts, swept, table_W, box_W, options);
  const auto count = static_cast<Eigen::Index>(samples.points.size());
  Eigen::Matrix3Xf points(3, count);
  Eigen::VectorXd values(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    points.col(i) = samples.points[i];
    values[i] = samples.values[i] - 1;  // far away it is outside
  }
  const double longest = box_W.sizes().norm();
  const auto R = static_cast<float>(longest);
  const auto covariances = [&](const Eigen::Vector3f& p) -> Eigen::ArrayXf {
    const Eigen::ArrayXf r = (points.colwise() - p).colwise().norm().transpose().array().min(R) / R;
    return 2 * r.cube() - 3 * r.square() + 1;
  };
  Eigen::MatrixXd covariance(count, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    covariance.col(i) = covariances(points.col(i)).matrix().cast<double>();
    covariance(i, i) += options.deviation * options.deviation;
  }
  const Eigen::ArrayXf weights = covariance.ldlt().solve(values).cast<float>().array();

  const double spacing = box_W.sizes().maxCoeff() / (options.resolution - 1);
  const Eigen::Vector3i size =
      (box_W.sizes() / spacing).array().ceil().matrix().cast<int>().array() + 1;
  surface::ScalarGrid field(size);
  for (int z = 0; z < size.z(); ++z) {
    for (int y = 0; y < size.y(); ++y) {
      for (int x = 0; x < size.x(); ++x) {
        const Eigen::Vector3d p = box_W.min() + spacing * Eigen::Vector3d(x, y, z);
        // Cut at the table itself, not at the grid's next node.
        const auto height = static_cast<float>(table_W.signed_distance(p) / options.offset);
        field.at(x, y, z) =
            height < -1 ? -1.f
                        : std::min(height, -1.f - (covariances(p.cast<float>()) * weights).sum());
      }
    }
  }
  geometry::TriangleMesh mesh = surface::marching_cubes(field, 0);
  for (Eigen::Vector3d& vertex : mesh.vertices) vertex = box_W.min() + spacing * vertex;
  return mesh;
}

}  // namespace prehend::eval
