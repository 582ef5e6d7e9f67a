// A collision checker in a shared library: a turned box round each body, by separating axes.

#include <array>

#include "prehend/motion/collision_checker.h"

namespace {

using Eigen::Vector3d;
using prehend::geometry::RigidTransform;
using prehend::motion::CheckedBody;
using prehend::motion::ConvexBody;

/// A box that holds a body, in the axes of its frame.
struct Box final : CheckedBody {
  ConvexBody body;  // a box about the origin
  Vector3d center_S = Vector3d::Zero();

  RigidTransform at(const RigidTransform& X_BS) const {
    return X_BS * Eigen::Translation3d(center_S);
  }
};

class TurnedBoxes final : public prehend::motion::CollisionChecker {
 public:
  std::string name() const override { return "turned_boxes"; }
  std::string about() const override { return "boxes round the links' shapes, by separating axes"; }

  std::unique_ptr<CheckedBody> body(const ConvexBody& body) const override {
    auto box = std::make_unique<Box>();
    for (int k = 0; k < 3; ++k) {
      const double high = support(body, Vector3d::Unit(k)),
                   low = -support(body, -Vector3d::Unit(k));
      box->center_S[k] = (high + low) / 2;
      box->body.size[k] = high - low;
    }
    return box;
  }

  /// S. Gottschalk, M. C. Lin, D. Manocha, "OBBTree", SIGGRAPH 1996: two boxes are apart along an
  /// axis of one of them or across an edge of each. How far they are is at least what it is along
  /// one of these 15; corners are farther than that.
  bool are_nearer(const CheckedBody& a, const RigidTransform& X_BA, const CheckedBody& b,
                  const RigidTransform& X_BB, double gap) const override {
    const auto &one = static_cast<const Box&>(a), &other = static_cast<const Box&>(b);
    const RigidTransform X_B1 = one.at(X_BA), X_B2 = other.at(X_BB);
    const auto are_apart_along = [&](const Vector3d& axis) {
      if (axis.squaredNorm() < 1e-12) return false;  // parallel edges
      const Vector3d unit = axis.normalized();
      return separation(one.body, X_B1, other.body, X_B2, unit) > gap ||
             separation(one.body, X_B1, other.body, X_B2, -unit) > gap;
    };
    for (int i = 0; i < 3; ++i) {
      if (are_apart_along(X_B1.linear().col(i)) || are_apart_along(X_B2.linear().col(i))) {
        return false;
      }
    }
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        if (are_apart_along(X_B1.linear().col(i).cross(X_B2.linear().col(j)))) return false;
      }
    }
    return true;
  }
};

}  // namespace

extern "C" {

int prehend_checker_interface() { return prehend::motion::kCheckerInterface; }

prehend::motion::CollisionChecker* prehend_create_checker() { return new TurnedBoxes; }
}
