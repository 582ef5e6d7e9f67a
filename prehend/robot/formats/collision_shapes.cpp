#include "prehend/robot/formats/collision_shapes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <tuple>
#include <utility>

#include <fmt/format.h>
#include <Eigen/Eigenvalues>

#include "prehend/geometry/errors.h"
#include "prehend/robot/mesh_shape.h"
#include "prehend/surface/convex_pieces.h"

namespace prehend::robot::formats {
namespace {

using geometry::RigidTransform;
using geometry::TriangleMesh;
using Points = Eigen::Matrix3Xd;

constexpr double kClearly = 1.05;   // of two volumes: the link's own axes stay unless others gain
constexpr double kThinnest = 1e-4;  // m, a side of a box

struct Fitted {
  Shape shape;
  double volume = std::numeric_limits<double>::infinity();
};

/// The link's axes, and those along which the points are spread.
std::array<Eigen::Matrix3d, 2> frames_of(const Points& points) {
  const Points centred = points.colwise() - points.rowwise().mean();
  Eigen::Matrix3d axes =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(centred * centred.transpose()).eigenvectors();
  if (axes.determinant() < 0) axes.col(0) = -axes.col(0);
  return {Eigen::Matrix3d::Identity(), axes};
}

RigidTransform placed(const Eigen::Matrix3d& axes, const Eigen::Vector3d& center_in_axes) {
  RigidTransform X = RigidTransform::Identity();
  X.linear() = axes;
  X.translation() = axes * center_in_axes;
  return X;
}

Shape box_around(const Points& points) {
  Fitted best;
  for (const Eigen::Matrix3d& axes : frames_of(points)) {
    const Points turned = axes.transpose() * points;
    const Eigen::Vector3d low = turned.rowwise().minCoeff(), high = turned.rowwise().maxCoeff();
    const Eigen::Vector3d size = (high - low).cwiseMax(kThinnest);
    if (kClearly * size.prod() >= best.volume && std::isfinite(best.volume)) continue;
    best.volume = size.prod();
    best.shape.kind = Shape::Kind::kBox;
    best.shape.size = size;
    best.shape.X_LS = placed(axes, (low + high) / 2);
  }
  return best.shape;
}

Shape sphere_around(const Points& points) {
  constexpr int kSteps = 2000;
  Eigen::Vector3d center = (points.rowwise().minCoeff() + points.rowwise().maxCoeff()) / 2;
  Eigen::Index farthest = 0;
  for (int i = 1; i <= kSteps; ++i) {
    (points.colwise() - center).colwise().squaredNorm().maxCoeff(&farthest);
    center += (points.col(farthest) - center) / (i + 1);
  }
  Shape shape;
  shape.kind = Shape::Kind::kSphere;
  shape.radius = (points.colwise() - center).colwise().norm().maxCoeff();
  shape.X_LS.translation() = center;
  return shape;
}

/// Half of a capsule's middle and its centre along z: each point is below the cap over it.
std::pair<double, double> capsule_reach(const Points& turned, const Eigen::RowVectorXd& radii,
                                        double radius) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (Eigen::Index i = 0; i < turned.cols(); ++i) {
    const double cap = std::sqrt(std::max(0.0, radius * radius - radii[i] * radii[i]));
    low = std::min(low, turned(2, i) + cap);
    high = std::max(high, turned(2, i) - cap);
  }
  if (low > high) low = high = (low + high) / 2;  // one ball holds them
  return {high - low, (low + high) / 2};
}

/// A cylinder or capsule about the best of the axes of the frames.
Shape round_around(const Points& points, Shape::Kind kind) {
  Fitted best;
  for (const Eigen::Matrix3d& axes : frames_of(points)) {
    for (int along = 0; along < 3; ++along) {
      Eigen::Matrix3d turn;
      turn << axes.col((along + 1) % 3), axes.col((along + 2) % 3), axes.col(along);
      const Points turned = turn.transpose() * points;
      const Eigen::Vector3d low = turned.rowwise().minCoeff(), high = turned.rowwise().maxCoeff();
      Eigen::Vector3d middle = (low + high) / 2;
      const Eigen::RowVectorXd radii =
          (turned.topRows<2>().colwise() - middle.head<2>()).colwise().norm();
      const double radius = radii.maxCoeff();
      double length = high.z() - low.z(), volume = 0;
      if (kind == Shape::Kind::kCapsule) {
        std::tie(length, middle.z()) = capsule_reach(turned, radii, radius);
        volume = 4.0 / 3 * radius;
      }
      volume = std::numbers::pi * radius * radius * (volume + length);
      if (kClearly * volume >= best.volume && std::isfinite(best.volume)) continue;
      best.volume = volume;
      best.shape.kind = kind;
      best.shape.radius = radius;
      best.shape.length = length;
      best.shape.X_LS = placed(turn, middle);
    }
  }
  return best.shape;
}

class Maker {
 public:
  Maker(const LinkDescription& link, ShapeMeshes& meshes) : link_(link) {
    for (const Shape& shape : link.visuals) {
      TriangleMesh mesh = meshes.of(shape);
      if (mesh.triangles.empty()) continue;
      seen_.emplace_back(shape.mesh, geometry::transformed(mesh, shape.X_LS));
    }
    if (seen_.empty()) {
      throw geometry::InputError("Link '" + link.name + "' has nothing that is seen",
                                 "Give it a shape, or leave it out");
    }
  }

  CollisionShapes made(CollisionKind kind, double concavity) {
    switch (kind) {
      case CollisionKind::kBox:
        return {{box_around(points())}, {}};
      case CollisionKind::kSphere:
        return {{sphere_around(points())}, {}};
      case CollisionKind::kCylinder:
        return {{round_around(points(), Shape::Kind::kCylinder)}, {}};
      case CollisionKind::kCapsule:
        return {{round_around(points(), Shape::Kind::kCapsule)}, {}};
      case CollisionKind::kHull: {
        std::vector<Eigen::Vector3d> all;
        for (const auto& [name, mesh] : seen_) {
          all.insert(all.end(), mesh.vertices.begin(), mesh.vertices.end());
        }
        add(hull_of(all), "hull");
        break;
      }
      case CollisionKind::kPieces:
        for (const auto& [name, mesh] : seen_) add_pieces(name, mesh, concavity);
    }
    return std::move(made_);
  }

 private:
  Points points() const {
    Eigen::Index count = 0, at = 0;
    for (const auto& [name, mesh] : seen_) count += static_cast<Eigen::Index>(mesh.vertices.size());
    Points all(3, count);
    for (const auto& [name, mesh] : seen_) {
      for (const Eigen::Vector3d& p : mesh.vertices) all.col(at++) = p;
    }
    return all;
  }

  TriangleMesh hull_of(const std::vector<Eigen::Vector3d>& all) const {
    TriangleMesh hull = geometry::convex_hull(all);
    if (hull.triangles.empty() || !(geometry::mass_properties(hull).volume > 0)) {
      throw geometry::InputError("What is seen of link '" + link_.name + "' lies in a plane",
                                 "Ask for a box");
    }
    return hull;
  }

  void add_pieces(const std::string& name, const TriangleMesh& mesh, double concavity) {
    const std::string its = name.empty() ? "a shape" : "its mesh '" + name + "'";
    const SolidMesh solid = solid_mesh(mesh, its);
    if (!solid.remark.empty()) made_.remarks.push_back(solid.remark);
    surface::ConvexPiecesOptions options;
    options.concavity = concavity;
    options.max_voxels = 128;
    surface::ConvexPieces cut = surface::convex_pieces(*solid.mesh, options);
    if (cut.concavity > concavity) {
      made_.remarks.push_back(
          fmt::format("{} is held within {:.1f} mm only", its, 1000 * cut.concavity));
    }
    for (TriangleMesh& piece : cut.pieces) add(std::move(piece), "piece");
  }

  void add(TriangleMesh mesh, const char* kind) {
    Shape shape;
    shape.kind = Shape::Kind::kMesh;
    shape.mesh = fmt::format("{}_{}_{}", link_.name, kind, made_.shapes.size());
    shape.surface = std::make_shared<const TriangleMesh>(std::move(mesh));
    made_.shapes.push_back(std::move(shape));
  }

  const LinkDescription& link_;
  std::vector<std::pair<std::string, TriangleMesh>> seen_;  // in the link's frame, by their files
  CollisionShapes made_;
};

}  // namespace

const std::vector<std::string>& collision_kinds() {
  static const std::vector<std::string> kKinds{"box",     "sphere", "cylinder",
                                               "capsule", "hull",   "pieces"};
  return kKinds;
}

CollisionShapes collision_shapes(const LinkDescription& link, ShapeMeshes& meshes,
                                 CollisionKind kind, double concavity) {
  return Maker(link, meshes).made(kind, concavity);
}

}  // namespace prehend::robot::formats
