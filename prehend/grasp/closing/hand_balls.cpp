#include "prehend/grasp/closing/hand_balls.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <stdexcept>

#include "prehend/geometry/errors.h"
#include "prehend/geometry/kept_by_mesh.h"
#include "prehend/grasp/closing/solid_balls.h"

namespace prehend::grasp {
namespace {

using Eigen::Vector3d;
using robot::CollisionShape;

constexpr int kLeafBalls = 4;

/// How a shape is covered: balls of `radius` at most `spacing` apart, so that a point of the face
/// between four of them lies 2 x tolerance beneath their tops.
struct Cover {
  double inset;    // m, of the centres beneath the face
  double radius;   // m, the inset and half of what lies between the tops
  double spacing;  // m

  Cover(double smallest_side, double tolerance) {
    inset = ball_inset(smallest_side);
    const double dip = std::min(2 * tolerance, inset / 2);
    spacing = std::sqrt(2 * (inset * inset - (inset - dip) * (inset - dip)));
    radius = inset + dip / 2;
  }
  int pieces(double length) const { return static_cast<int>(std::ceil(length / spacing - 1e-9)); }
};

double step(int i, int pieces, double length) {
  return pieces == 0 ? 0 : length * (static_cast<double>(i) / pieces - 0.5);
}

std::vector<Vector3d> on_box(const Vector3d& size, const Cover& cover) {
  const Vector3d inner = (size.array() - 2 * cover.inset).max(0);
  const Eigen::Vector3i n(cover.pieces(inner.x()), cover.pieces(inner.y()),
                          cover.pieces(inner.z()));
  std::vector<Vector3d> centers;
  for (int z = 0; z <= n.z(); ++z) {
    for (int y = 0; y <= n.y(); ++y) {
      for (int x = 0; x <= n.x(); ++x) {
        const bool within = x > 0 && x < n.x() && y > 0 && y < n.y() && z > 0 && z < n.z();
        if (within) continue;
        centers.emplace_back(step(x, n.x(), inner.x()), step(y, n.y(), inner.y()),
                             step(z, n.z(), inner.z()));
      }
    }
  }
  return centers;
}

std::vector<Vector3d> on_cylinder(double radius, double length, const Cover& cover) {
  const double inner = std::max(0.0, radius - cover.inset);
  const double height = std::max(0.0, length - 2 * cover.inset);
  const int slices = cover.pieces(height), rings = cover.pieces(inner);
  std::vector<Vector3d> centers;
  for (int z = 0; z <= slices; ++z) {
    const bool cap = z == 0 || z == slices;
    for (int ring = cap ? 0 : rings; ring <= rings; ++ring) {
      const double r = rings == 0 ? 0 : inner * ring / rings;
      const int around = std::max(1, cover.pieces(2 * std::numbers::pi * r));
      for (int i = 0; i < around; ++i) {
        const double angle = 2 * std::numbers::pi * i / around;
        centers.emplace_back(r * std::cos(angle), r * std::sin(angle), step(z, slices, height));
      }
    }
  }
  return centers;
}

void add_shape(const CollisionShape& shape, const std::string& link, double tolerance,
               LinkBalls& balls) {
  if (shape.kind == CollisionShape::Kind::kMesh) {
    static geometry::KeptByMesh<std::vector<SolidBall>> kept;
    for (const SolidBall& ball : kept.of(shape.solid, tolerance, balls_within)) {
      balls.centers.push_back(shape.X_LS * ball.center);
      balls.radii.push_back(ball.radius);
    }
    return;
  }
  const bool is_box = shape.kind == CollisionShape::Kind::kBox;
  const bool is_ball = shape.kind == CollisionShape::Kind::kSphere;
  const double smallest = is_box    ? shape.size.minCoeff()
                          : is_ball ? 2 * shape.radius
                                    : std::min(2 * shape.radius, shape.length);
  if (!(smallest > 0) || !std::isfinite(smallest)) {
    throw geometry::InputError("Link '" + link + "' of the hand has a shape without volume",
                               "Give positive sizes");
  }
  if (is_ball) {
    balls.centers.push_back(shape.X_LS.translation());
    balls.radii.push_back(shape.radius);
    return;
  }
  const Cover cover(smallest, tolerance);
  const std::vector<Vector3d> centers =
      is_box ? on_box(shape.size, cover) : on_cylinder(shape.radius, shape.length, cover);
  for (const Vector3d& center : centers) {
    balls.centers.push_back(shape.X_LS * center);
    balls.radii.push_back(cover.radius);
  }
}

/// Makes the tree over balls order[first .. last), splitting at the median of the longest side.
class TreeMaker {
 public:
  explicit TreeMaker(LinkBalls& link) : link_(link), order_(link.centers.size()) {
    std::iota(order_.begin(), order_.end(), 0);
    if (!order_.empty()) make(0, static_cast<int>(order_.size()));
    LinkBalls sorted;
    for (const int i : order_) {
      sorted.centers.push_back(link.centers[static_cast<std::size_t>(i)]);
      sorted.radii.push_back(link.radii[static_cast<std::size_t>(i)]);
    }
    link.centers = std::move(sorted.centers);
    link.radii = std::move(sorted.radii);
  }

 private:
  int make(int first, int last) {
    const int index = static_cast<int>(link_.nodes.size());
    link_.nodes.emplace_back();
    Eigen::AlignedBox3d box;
    for (int i = first; i < last; ++i) box.extend(center(i));
    LinkBalls::Node node;
    node.center = box.center();
    for (int i = first; i < last; ++i) {
      node.radius =
          std::max(node.radius,
                   (center(i) - node.center).norm() +
                       link_.radii[static_cast<std::size_t>(order_[static_cast<std::size_t>(i)])]);
    }
    if (last - first <= kLeafBalls) {
      node.first = first;
      node.last = last;
    } else {
      Eigen::Index axis = 0;
      box.sizes().maxCoeff(&axis);
      const int middle = first + (last - first) / 2;
      std::nth_element(order_.begin() + first, order_.begin() + middle, order_.begin() + last,
                       [&](int a, int b) {
                         const double pa = link_.centers[static_cast<std::size_t>(a)][axis];
                         const double pb = link_.centers[static_cast<std::size_t>(b)][axis];
                         return pa != pb ? pa < pb : a < b;
                       });
      node.first = make(first, middle);
      node.right = make(middle, last);
    }
    link_.nodes[static_cast<std::size_t>(index)] = node;
    return index;
  }
  const Vector3d& center(int i) const {
    return link_.centers[static_cast<std::size_t>(order_[static_cast<std::size_t>(i)])];
  }

  LinkBalls& link_;
  std::vector<int> order_;
};

}  // namespace

HandBalls make_hand_balls(const robot::HandModel& hand, double tolerance) {
  if (!(tolerance > 0) || !std::isfinite(tolerance)) {
    throw std::invalid_argument("make_hand_balls: tolerance must be positive and finite");
  }
  HandBalls result;
  for (const robot::Link& link : hand.model.links) {
    LinkBalls balls;
    for (const CollisionShape& shape : link.shapes) add_shape(shape, link.name, tolerance, balls);
    TreeMaker{balls};
    for (std::size_t i = 0; i < balls.centers.size(); ++i) {
      balls.reach = std::max(balls.reach, balls.centers[i].norm() + balls.radii[i]);
    }
    result.links.push_back(std::move(balls));
  }
  // Along each way from a link to the root: what is beyond a joint is at most as far from it as all
  // offsets between are long, prismatic ones as far as their limits let them.
  for (std::size_t l = 0; l < hand.model.links.size(); ++l) {
    std::vector<double> reach(hand.model.joints.size(), 0);
    double length = result.links[l].reach;
    for (int link = static_cast<int>(l); const auto above = hand.model.joint_above(link);) {
      const robot::Joint& joint = hand.model.joints[static_cast<std::size_t>(*above)];
      double& here = reach[static_cast<std::size_t>(*above)];
      if (joint.kind == robot::Joint::Kind::kRevolute) here = length;
      if (joint.kind == robot::Joint::Kind::kPrismatic) {
        here = 1;
        length += std::max(std::abs(joint.lower), std::abs(joint.upper));
      }
      length += joint.X_PJ.translation().norm();
      link = joint.parent;
    }
    result.reach.push_back(std::move(reach));
  }
  return result;
}

}  // namespace prehend::grasp
