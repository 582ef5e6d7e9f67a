#include "prehend/motion/fcl_checker.h"

#include <exception>

#include <fcl/geometry/shape/box.h>
#include <fcl/geometry/shape/convex.h>
#include <fcl/geometry/shape/cylinder.h>
#include <fcl/geometry/shape/sphere.h>
#include <fcl/narrowphase/distance.h>

namespace prehend::motion {
namespace {

using Geometry = fcl::CollisionGeometry<double>;

struct FclBody final : CheckedBody {
  std::unique_ptr<Geometry> geometry;
  ConvexBody body;
};

std::unique_ptr<Geometry> fcl_geometry(const ConvexBody& body) {
  switch (body.kind) {
    case ConvexBody::Kind::kSphere:
      return std::make_unique<fcl::Sphere<double>>(body.radius);
    case ConvexBody::Kind::kCylinder:
      return std::make_unique<fcl::Cylinder<double>>(body.radius, body.length);
    case ConvexBody::Kind::kPoints:
      // Without faces it looks at all points for the farthest in a direction, which is all it does.
      return std::make_unique<fcl::Convex<double>>(body.points, 0,
                                                   std::make_shared<const std::vector<int>>());
    case ConvexBody::Kind::kBox:
      break;
  }
  return std::make_unique<fcl::Box<double>>(body.size);
}

}  // namespace

std::string FclChecker::about() const {
  return "the links' shapes by the Flexible Collision Library (Pan et al., ICRA 2012)";
}

std::unique_ptr<CheckedBody> FclChecker::body(const ConvexBody& body) const {
  auto result = std::make_unique<FclBody>();
  result->geometry = fcl_geometry(body);
  result->geometry->computeLocalAABB();
  result->body = body;
  return result;
}

bool FclChecker::are_nearer(const CheckedBody& a, const geometry::RigidTransform& X_BA,
                            const CheckedBody& b, const geometry::RigidTransform& X_BB,
                            double gap) const {
  const auto& of_a = static_cast<const FclBody&>(a);
  const auto& of_b = static_cast<const FclBody&>(b);
  // Each of its two solvers sometimes gives up, or gives points that are not the nearest, where the
  // other does not. One proof is enough.
  for (const auto solver : {fcl::GST_LIBCCD, fcl::GST_INDEP}) {
    fcl::DistanceRequest<double> request;
    request.enable_nearest_points = true;
    request.gjk_solver_type = solver;
    fcl::DistanceResult<double> result;
    try {
      const double distance =
          fcl::distance(of_a.geometry.get(), X_BA, of_b.geometry.get(), X_BB, request, result);
      if (distance <= gap) return true;  // so near are two points of theirs
    } catch (const std::exception&) {
      continue;
    }
    const Eigen::Vector3d way = (result.nearest_points[1] - result.nearest_points[0]).normalized();
    if (separation(of_a.body, X_BA, of_b.body, X_BB, way) > gap) return false;
  }
  return true;
}

}  // namespace prehend::motion
