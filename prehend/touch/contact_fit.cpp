#include "prehend/touch/contact_fit.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include "prehend/geometry/symmetric_solve.h"

namespace prehend::touch {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

struct SurfacePoints {
  Matrix3d R_PF;                 // F: z the mean normal, x along P's x as far as it can be
  std::vector<Vector3d> points;  // in units of `scale`, in F about the centre
  double scale = 1;              // m, root mean square of the texels' distances
  double depth = 0;              // m, mean
};

Matrix3d frame_about(const Vector3d& normal) {
  Vector3d x = Vector3d::UnitX() - normal.x() * normal;
  if (x.norm() < 0.1) x = Vector3d::UnitY() - normal.y() * normal;
  Matrix3d R;
  R.col(0) = x.normalized();
  R.col(2) = normal;
  R.col(1) = normal.cross(R.col(0));
  return R;
}

SurfacePoints surface_points(const FeltPad& pad, const FeltTexels& felt, const Vector3d& center_P) {
  Vector3d normal = Vector3d::Zero();
  for (std::size_t i = 0; i < felt.force.size(); ++i) {
    normal += felt.force[i] * pad.layout.normal(i);
  }
  SurfacePoints result;
  result.R_PF = frame_about(normal.norm() > 0 ? normal.normalized() : Vector3d::UnitZ());
  double square = 0;
  for (std::size_t i = 0; i < felt.force.size(); ++i) {
    if (felt.state[i] != Texel::kTouched) continue;
    const double depth =
        rest_depth(pad.law, pad.layout.scale[i], felt.force[i], pad.layout.thickness());
    if (depth >= pad.layout.thickness()) continue;  // bottomed out: it may be anywhere behind
    const Vector3d p_P = pad.layout.position(i) - depth * pad.layout.normal(i);
    result.points.emplace_back(result.R_PF.transpose() * (p_P - center_P));
    result.depth += depth;
    square += result.points.back().head<2>().squaredNorm();
  }
  if (result.points.empty()) return result;
  const auto count = static_cast<double>(result.points.size());
  result.depth /= count;
  if (square > 0) result.scale = std::sqrt(square / count);
  for (Vector3d& p : result.points) p /= result.scale;
  return result;
}

template <int Size>
Eigen::Matrix<double, Size, 1> basis(const Vector3d& p) {
  Eigen::Matrix<double, Size, 1> b;
  b.template head<3>() << 1, p.x(), p.y();
  if constexpr (Size == 6) {
    b.template tail<3>() << p.x() * p.x() / 2, p.x() * p.y(), p.y() * p.y() / 2;
  }
  return b;
}

template <int Size>
struct Fit {
  bool determined = false;
  Eigen::Matrix<double, Size, 1> x;  // in units of the points'
  Eigen::Matrix<double, Size, 1> deviation;
};

template <int Size>
Fit<Size> fit(const std::vector<Vector3d>& points, double least_deviation) {
  using Matrix = Eigen::Matrix<double, Size, Size>;
  using Vector = Eigen::Matrix<double, Size, 1>;
  Fit<Size> result;
  if (points.size() < Size) return result;
  Matrix A = Matrix::Zero();
  Vector right = Vector::Zero();
  for (const Vector3d& p : points) {
    const Vector b = basis<Size>(p);
    A += b * b.transpose();
    right += p.z() * b;
  }
  result.x = geometry::symmetric_solve<Size>(A, right);
  double left_over = 0;
  for (const Vector3d& p : points) {
    left_over += std::pow(p.z() - basis<Size>(p).dot(result.x), 2);
  }
  const auto freedom = static_cast<double>(points.size() - Size);
  const double deviation =
      std::max(least_deviation, freedom > 0 ? std::sqrt(left_over / freedom) : 0.0);
  constexpr double kSingular = 1e-6;  // of A's mean eigenvalue; coordinates are of size 1
  for (int k = 0; k < Size; ++k) {
    const Vector unit = Vector::Unit(k);
    const Vector column = geometry::symmetric_solve<Size>(A, unit);
    if ((A * column - unit).norm() > 1e-6 || !(column[k] > 0) ||
        column[k] > Size / (kSingular * A.trace())) {
      return result;
    }
    result.deviation[k] = deviation * std::sqrt(column[k]);
  }
  result.determined = true;
  return result;
}

FittedNormal normal_of(const SurfacePoints& surface, double u, double v, double deviation) {
  return {surface.R_PF * Vector3d(-u, -v, 1).normalized(), deviation};
}

// Shape operator I^-1 II of w(u, v) at the origin; both forms are symmetric, I positive definite.
FittedCurvature curvature_of(const SurfacePoints& surface, const Eigen::Matrix<double, 6, 1>& x,
                             double deviation) {
  const Eigen::Vector2d g(x[1], x[2]);
  Eigen::Matrix2d hessian;
  hessian << x[3], x[4], x[4], x[5];
  hessian /= surface.scale * std::sqrt(1 + g.squaredNorm());
  const Eigen::Matrix2d first = Eigen::Matrix2d::Identity() + g * g.transpose();
  const Eigen::Matrix2d S = first.inverse() * hessian;
  const double mean = S.trace() / 2;
  const double half = std::sqrt(std::max(0.0, mean * mean - S.determinant()));
  FittedCurvature result;
  result.largest = mean + half;
  result.smallest = mean - half;
  // (S - smallest) maps everything onto the direction of the largest.
  const Eigen::Matrix2d onto = S - result.smallest * Eigen::Matrix2d::Identity();
  const Eigen::Vector2d d = onto.col(0).norm() >= onto.col(1).norm() ? onto.col(0) : onto.col(1);
  if (half > 0)
    result.direction = Vector3d(d.x(), d.y(), g.dot(d));
  else
    result.direction = Vector3d(1, 0, g.x());
  result.direction = surface.R_PF * result.direction.normalized();
  result.deviation = deviation;
  return result;
}

}  // namespace

ContactFit fit_contact(const FeltPad& pad, const FeltTexels& felt, const Vector3d& center_P,
                       const ContactFitOptions& options) {
  const SurfacePoints surface = surface_points(pad, felt, center_P);
  const std::size_t count = surface.points.size();
  const double least = options.gain_deviation * surface.depth / surface.scale;
  ContactFit result;
  const Fit<6> quadric = fit<6>(surface.points, least);
  double deviation = 0;  // 1/m
  if (quadric.determined) {
    deviation = quadric.deviation.tail<3>().maxCoeff() / surface.scale;
    if (deviation <= options.largest_curvature_deviation) {
      result.curvature = curvature_of(surface, quadric.x, deviation);
    } else {
      result.no_curvature = fmt::format("the touched texels leave +-{:.0f} 1/m", deviation);
    }
  } else {
    result.no_curvature = count < 6
                              ? fmt::format("{} texels to fit, 6 are needed", count)
                              : "the touched texels lie on a curve that a quadric does not leave";
  }
  // A curved surface's tangent plane, not the plane through all of it, where both are known.
  double tilt = 0;  // rad
  if (result.curvature) {
    tilt = quadric.deviation.segment<2>(1).norm();
    result.normal = normal_of(surface, quadric.x[1], quadric.x[2], tilt);
  } else {
    const Fit<3> plane = fit<3>(surface.points, least);
    if (!plane.determined) {
      result.no_normal = count < 3 ? fmt::format("{} texels to fit, 3 are needed", count)
                                   : "the touched texels lie on one line";
      return result;
    }
    tilt = plane.deviation.tail<2>().norm();
    result.normal = normal_of(surface, plane.x[1], plane.x[2], tilt);
  }
  if (tilt > options.largest_tilt_deviation) {
    result.normal.reset();
    result.no_normal = fmt::format("the touched texels leave +-{:.2f} rad", tilt);
  }
  return result;
}

}  // namespace prehend::touch
