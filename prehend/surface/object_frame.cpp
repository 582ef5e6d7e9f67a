#include "prehend/surface/object_frame.h"

#include <cmath>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

namespace prehend::surface {
namespace {

/// Central moments of the points.
struct Moments {
  explicit Moments(const std::vector<Eigen::Vector3f>& points) {
    // Sums of the products of coordinates about the first point, in one pass.
    const Eigen::Vector3d reference = points.front().cast<double>();
    double first[3] = {};
    double raw_second[6] = {};
    double raw_third[10] = {};
    for (const Eigen::Vector3f& p : points) {
      const double r[3] = {p.x() - reference.x(), p.y() - reference.y(), p.z() - reference.z()};
      int i = 0;
      int j = 0;
      for (int a = 0; a < 3; ++a) {
        first[a] += r[a];
        for (int b = a; b < 3; ++b) {
          const double product = r[a] * r[b];
          raw_second[i++] += product;
          for (int c = b; c < 3; ++c) raw_third[j++] += product * r[c];
        }
      }
    }
    const auto n = static_cast<double>(points.size());
    const Eigen::Vector3d m(first[0] / n, first[1] / n, first[2] / n);
    mean = reference + m;
    int i = 0;
    for (int a = 0; a < 3; ++a) {
      for (int b = a; b < 3; ++b, ++i) {
        covariance(a, b) = covariance(b, a) = raw_second[i] / n - m[a] * m[b];
      }
    }
    i = 0;
    for (int a = 0; a < 3; ++a) {
      for (int b = a; b < 3; ++b) {
        for (int c = b; c < 3; ++c, ++i) {
          third[i] = raw_third[i] / n - m[a] * covariance(b, c) - m[b] * covariance(a, c) -
                     m[c] * covariance(a, b) - m[a] * m[b] * m[c];
        }
      }
    }
  }

  /// `axis` or its opposite, so that the points reach out further along it.
  Eigen::Vector3d signed_axis(const Eigen::Vector3d& axis) const {
    double along = 0;
    int i = 0;
    for (int a = 0; a < 3; ++a) {
      for (int b = a; b < 3; ++b) {
        for (int c = b; c < 3; ++c, ++i) {
          const int different = 1 + (a != b) + (b != c);
          const int permutations = different == 3 ? 6 : different == 2 ? 3 : 1;
          along += permutations * third[i] * axis[a] * axis[b] * axis[c];
        }
      }
    }
    return along < 0 ? Eigen::Vector3d(-axis) : axis;
  }

  Eigen::Vector3d mean;
  Eigen::Matrix3d covariance;
  double third[10];  // xxx xxy xxz xyy xyz xzz yyy yyz yzz zzz
};

}  // namespace

geometry::RigidTransform object_frame(const std::vector<Eigen::Vector3f>& points_W,
                                      const std::optional<geometry::Plane>& table_W) {
  const Moments moments(points_W);
  const Eigen::Vector3d& mean = moments.mean;
  Eigen::Matrix3d covariance = moments.covariance;
  const double scale = covariance.trace();
  if (scale > 0) covariance /= scale;

  Eigen::Matrix3d axes;
  if (table_W) {
    axes.col(2) = table_W->normal.normalized();
    const Eigen::Vector3d u = axes.col(2).unitOrthogonal();
    const Eigen::Vector3d v = axes.col(2).cross(u);
    // Angle of the greatest variance in the plane of u and v.
    const double angle =
        0.5 * std::atan2(2 * u.dot(covariance * v), u.dot(covariance * u) - v.dot(covariance * v));
    axes.col(0) = std::cos(angle) * u + std::sin(angle) * v;
  } else {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance);
    axes.col(2) = moments.signed_axis(solver.eigenvectors().col(0));
    axes.col(0) = solver.eigenvectors().col(2);
  }
  axes.col(0) = moments.signed_axis(axes.col(0));
  axes.col(1) = axes.col(2).cross(axes.col(0));

  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3f& p : points_W) {
    box.extend(Eigen::Vector3d(axes.transpose() * (p.cast<double>() - mean)));
  }
  geometry::RigidTransform X_WF = geometry::RigidTransform::Identity();
  X_WF.linear() = axes;
  X_WF.translation() = mean + axes * box.center();
  return X_WF;
}

}  // namespace prehend::surface
