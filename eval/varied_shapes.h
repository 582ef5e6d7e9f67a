#pragma once

#include <cstdint>
#include <memory>
#include <random>

#include <Eigen/Core>

#include "prehend/geometry/triangle_mesh.h"

namespace prehend::eval {

/// Numbers from a seed, the same with every standard library.
class Drawn {
 public:
  explicit Drawn(std::uint64_t seed) : engine_(seed) {}
  /// Uniform in [low, high).
  double between(double low, double high);
  /// The logarithm uniform in [low, high): as many small as large lengths. 0 < low <= high.
  double length(double low, double high);
  /// Uniform in 0, 1, ... count - 1.
  int one_of(int count);
  bool chance(double probability);

 private:
  std::mt19937_64 engine_;
};

/// What is drawn: boxes, cylinders, bowls, cups, bottles, profiles (L, T) that stand or lie, rings,
/// tools (a shaft with a head across), wedges, capsules that lie, surfaces of revolution of a
/// random outline.
enum class DrawnKind {
  kBox,
  kCylinder,
  kBowl,
  kCup,
  kBottle,
  kProfileL,
  kProfileT,
  kRing,
  kTool,
  kWedge,
  kCapsule,
  kRevolution
};
inline constexpr int kDrawnKinds = 12;
const char* name_of(DrawnKind kind);

/// A solid of its own, standing on z = 0 with the middle of its bounds on the z axis [m].
struct DrawnSolid {
  std::shared_ptr<const geometry::TriangleMesh> mesh;  // closed, manifold
  bool symmetric = true;                               // has a vertical plane of symmetry
  bool round = false;                                  // about the vertical
};

/// A solid whose longest side is `size` [m], of random proportions; none is thinner than 5 mm or a
/// twelfth of its size or higher than 0.4 m.
DrawnSolid drawn_solid(DrawnKind kind, double size, Drawn& drawn);

/// A box of the given sides [m] with its edges rounded a little.
DrawnSolid drawn_box(const Eigen::Vector3d& sides);
/// An upright cylinder [m].
DrawnSolid drawn_cylinder(double radius, double height);

/// `mesh` turned about the vertical by `yaw` [rad], then moved.
std::shared_ptr<const geometry::TriangleMesh> placed(const geometry::TriangleMesh& mesh,
                                                     const Eigen::Vector3d& offset, double yaw = 0);

}  // namespace prehend::eval
