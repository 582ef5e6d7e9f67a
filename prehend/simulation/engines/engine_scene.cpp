#include <cmath>

#include "prehend/contact/require.h"
#include "prehend/contact/texel.h"
#include "prehend/simulation/engines/engine.h"

namespace prehend::simulation::engines {
namespace {

using contact::require;
using contact::require_not_negative;
using contact::require_positive;

constexpr double kLeastVolume = 1e-7;  // of its extent cubed, that a piece must have
constexpr double kDent = 1e-4;         // of its extent, that a piece may have by rounding

void validate_piece(const geometry::TriangleMesh& piece, const std::string& owner) {
  for (const Eigen::Vector3d& p : piece.vertices) require(p.allFinite(), owner, "finite");
  require(!piece.empty() && geometry::find_defects(piece).watertight(), owner, "a closed mesh");
  const double extent = geometry::bounds(piece).sizes().maxCoeff();
  const double volume = geometry::mass_properties(piece).volume;
  require(volume > kLeastVolume * extent * extent * extent, owner,
          "a solid with its triangles outward");
  for (const Eigen::Vector3i& t : piece.triangles) {
    const Eigen::Vector3d& a = piece.vertices[t[0]];
    const Eigen::Vector3d n = (piece.vertices[t[1]] - a).cross(piece.vertices[t[2]] - a);
    if (n.norm() < kDent * kDent * extent * extent) continue;  // a sliver has no direction
    for (const Eigen::Vector3d& p : piece.vertices) {
      require(n.normalized().dot(p - a) <= kDent * extent, owner, "convex");
    }
  }
}

void validate_shape(const EngineShape& shape, const std::string& owner) {
  switch (shape.kind) {
    case EngineShape::Kind::kBox:
      for (int axis = 0; axis < 3; ++axis) require_positive(shape.size[axis], owner + "size");
      return;
    case EngineShape::Kind::kCylinder:
    case EngineShape::Kind::kCapsule:
      require_positive(shape.length, owner + "length");
      [[fallthrough]];
    case EngineShape::Kind::kSphere:
      require_positive(shape.radius, owner + "radius");
      return;
    case EngineShape::Kind::kConvexPieces:
      require(shape.pieces && !shape.pieces->empty(), owner + "pieces", "at least one");
      for (std::size_t i = 0; i < shape.pieces->size(); ++i) {
        validate_piece((*shape.pieces)[i], owner + "pieces[" + std::to_string(i) + "]");
      }
  }
}

}  // namespace

void validate(const EngineScene& scene) {
  require_positive(scene.step, "EngineScene::step");
  require(scene.gravity.allFinite(), "EngineScene::gravity", "finite");
  require_not_negative(scene.ground_friction, "EngineScene::ground_friction");
  for (const EngineBody& body : scene.bodies) {
    const std::string owner = "body '" + body.name + "'.";
    require_positive(body.mass, owner + "mass");
    require_not_negative(body.friction, owner + "friction");
    require(body.X_WB.matrix().allFinite(), owner + "X_WB", "finite");
    require(body.velocity.allFinite(), owner + "velocity", "finite");
    require(body.angular_velocity.allFinite(), owner + "angular_velocity", "finite");
    validate_shape(body.shape, owner);
    require(body.X_BS.matrix().allFinite(), owner + "X_BS", "finite");
    require(body.moments.allFinite() && body.moments.minCoeff() >= 0 &&
                (body.moments.isZero(0) || body.moments.minCoeff() > 0),
            owner + "moments", "three positive numbers, or zero for those of the shape");
    require(!body.moments.isZero(0) || body.X_BS.matrix().isIdentity(1e-12), owner + "moments",
            "given when the shape is not centred at the body's origin");
    require(!body.moments.isZero(0) || body.shape.kind != EngineShape::Kind::kConvexPieces,
            owner + "moments", "given with pieces");
  }
  const int count = static_cast<int>(scene.bodies.size());
  std::vector<bool> joined(scene.bodies.size(), false);
  for (std::size_t j = 0; j < scene.joints.size(); ++j) {
    const EngineJoint& joint = scene.joints[j];
    const std::string owner = "joint " + std::to_string(j) + ".";
    require(joint.body >= 0 && joint.body < count, owner + "body", "the index of a body");
    require(joint.parent >= -1 && joint.parent < joint.body, owner + "parent",
            "-1 or the index of a body before the joint's");
    require(!joined[joint.body], owner + "body", "joined once only");
    joined[joint.body] = true;
    require(joint.axis_W.allFinite() && std::abs(joint.axis_W.norm() - 1) < 1e-9, owner + "axis_W",
            "a unit vector");
    require(joint.anchor_W.allFinite(), owner + "anchor_W", "finite");
    require(!scene.bodies[joint.body].is_fixed, owner + "body", "a body that is not fixed");
    require(joint.follows >= -1 && joint.follows < static_cast<int>(j), owner + "follows",
            "-1 or an earlier joint");
    require(joint.follows < 0 || scene.joints[joint.follows].follows < 0, owner + "follows",
            "a joint that follows none");
    require(std::isfinite(joint.ratio), owner + "ratio", "finite");
  }
  for (std::size_t p = 0; p < scene.pads.size(); ++p) {
    const std::string owner = "pad " + std::to_string(p) + ".";
    require(scene.pads[p].body >= 0 && scene.pads[p].body < count, owner + "body",
            "the index of a body");
    require(scene.pads[p].X_BP.matrix().allFinite(), owner + "X_BP", "finite");
    contact::validate(scene.pads[p].law);
  }
}

}  // namespace prehend::simulation::engines
