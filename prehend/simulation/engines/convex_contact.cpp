#include "prehend/simulation/engines/convex_contact.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>
#include <boost/container/static_vector.hpp>

namespace prehend::simulation::engines {
namespace {

using Eigen::Vector3d;
using Kind = EngineShape::Kind;
// Without memory of their own: a step allocates nothing. Most: the corners of a cylinder.
using Points = boost::container::static_vector<Vector3d, 64>;

constexpr double kOnFace = 1e-6;       // m, how far beyond a face's border a point still counts
constexpr double kMerged = 1e-5;       // m, contacts nearer than this are one
constexpr double kPreferFaces = 1e-7;  // m, by which another direction must separate better
constexpr double kNormalToFace = 1e-9, kRounding = 1e-14;  // sines
constexpr int kRim = 8;                                    // corners that stand for a round face

// A core (point, segment, box or cylinder) with a layer of thickness `radius` round it, in place.
// Pieces are not met here.
struct Placed {
  Placed(const EngineShape& of, const geometry::RigidTransform& X)
      : shape(of), R(X.linear()), p(X.translation()) {
    if (of.kind == Kind::kSphere || of.kind == Kind::kCapsule) radius = of.radius;
  }

  // Farthest point of the core along `d`.
  Vector3d support(const Vector3d& d) const {
    const Vector3d s = R.transpose() * d;
    const double end = s.z() < 0 ? -0.5 * shape.length : 0.5 * shape.length;
    switch (shape.kind) {
      case Kind::kBox:
        return p + 0.5 * R * (s.array() < 0).select(-shape.size, shape.size);
      case Kind::kCylinder: {
        const double across = s.head<2>().norm();
        const double scale = across > 0 ? shape.radius / across : 0.0;
        return p + R * Vector3d(scale * s.x(), scale * s.y(), end);
      }
      case Kind::kCapsule:
        return p + end * R.col(2);
      case Kind::kSphere:
      case Kind::kConvexPieces:
        break;
    }
    return p;
  }

  // Nearest point of the core to `x`.
  Vector3d nearest(const Vector3d& x) const {
    const Vector3d s = R.transpose() * (x - p);
    const double z = std::clamp(s.z(), -0.5 * shape.length, 0.5 * shape.length);
    switch (shape.kind) {
      case Kind::kBox:
        return p + R * s.cwiseMax(-0.5 * shape.size).cwiseMin(0.5 * shape.size);
      case Kind::kCylinder: {
        const double across = s.head<2>().norm();
        const double scale = across > shape.radius ? shape.radius / across : 1.0;
        return p + R * Vector3d(scale * s.x(), scale * s.y(), z);
      }
      case Kind::kCapsule:
        return p + z * R.col(2);
      case Kind::kSphere:
      case Kind::kConvexPieces:
        break;
    }
    return p;
  }

  // Directions of flat faces and of straight edges or axes.
  void add_faces(Points& faces) const {
    if (shape.kind == Kind::kBox) faces.insert(faces.end(), {R.col(0), R.col(1), R.col(2)});
    if (shape.kind == Kind::kCylinder) faces.push_back(R.col(2));
  }
  void add_edges(Points& edges) const {
    if (shape.kind == Kind::kBox) edges.insert(edges.end(), {R.col(0), R.col(1), R.col(2)});
    if (shape.kind == Kind::kCylinder || shape.kind == Kind::kCapsule) edges.push_back(R.col(2));
  }

  // The axis of the box's or cylinder's flat face that looks along `d`, and the sine of the angle
  // between (a cosine does not tell small ones); -1: none.
  int face_axis(const Vector3d& d, double& sine) const {
    const Vector3d s = R.transpose() * d;
    int axis = -1;
    if (shape.kind == Kind::kBox) s.cwiseAbs().maxCoeff(&axis);
    if (shape.kind == Kind::kCylinder) axis = 2;
    sine = axis < 0 ? 1.0 : R.col(axis).cross(d).norm();
    return axis;
  }

  // What the shape has foremost along `d`: corners of a face in turn, two ends of a line, a point.
  // On the surface when `d` is normal to it.
  Points foremost(const Vector3d& d) const {
    const Vector3d s = R.transpose() * d;
    Points points;
    const auto add = [&](const Vector3d& p_S) { points.push_back(p + R * p_S + radius * d); };
    const double end = 0.5 * shape.length;
    switch (shape.kind) {
      case Kind::kBox: {
        int k;
        s.cwiseAbs().maxCoeff(&k);
        const Vector3d half = 0.5 * shape.size;
        for (int i = 0; i < 4; ++i) {
          Vector3d corner;
          corner[k] = s[k] < 0 ? -half[k] : half[k];
          corner[(k + 1) % 3] = (i == 0 || i == 3 ? -1 : 1) * half[(k + 1) % 3];
          corner[(k + 2) % 3] = (i < 2 ? -1 : 1) * half[(k + 2) % 3];
          add(corner);
        }
        break;
      }
      case Kind::kCylinder:
        if (std::abs(s.z()) > 0.7) {
          for (int i = 0; i < kRim; ++i) {
            const double angle = 2 * M_PI * i / kRim;
            add({shape.radius * std::cos(angle), shape.radius * std::sin(angle),
                 std::copysign(end, s.z())});
          }
        } else {
          const Eigen::Vector2d side = shape.radius * s.head<2>().normalized();
          add({side.x(), side.y(), end});
          add({side.x(), side.y(), -end});
        }
        break;
      case Kind::kCapsule:
        add({0, 0, end});
        add({0, 0, -end});
        break;
      case Kind::kSphere:
      case Kind::kConvexPieces:
        add(Vector3d::Zero());
    }
    return points;
  }

  // All corners, rims and ends, for steps in which a body turns onto another of its faces.
  Points corners(const Vector3d& d) const {
    Points points = foremost(d);
    if (shape.kind == Kind::kBox || shape.kind == Kind::kCylinder) {
      for (int k = 0; k < 3; ++k) {
        for (const double sign : {1.0, -1.0}) {
          const Points more = foremost(sign * R.col(k));
          const bool rim = more.size() == kRim || shape.kind == Kind::kBox;
          if (rim) points.insert(points.end(), more.begin(), more.end());
        }
      }
    }
    return points;
  }

  // The edge or line that is foremost along `d`; both ends equal where it is a point.
  std::pair<Vector3d, Vector3d> foremost_edge(const Vector3d& d) const {
    const Vector3d s = R.transpose() * d;
    if (shape.kind == Kind::kBox) {
      int k;
      s.cwiseAbs().minCoeff(&k);
      Vector3d from = support(d), to = from;
      const double along = R.col(k).dot(from - p);
      to -= 2 * along * R.col(k);
      return {from, to};
    }
    const Vector3d on_surface = support(d) + radius * d;
    const bool across = std::abs(s.z()) < 0.1;
    if ((shape.kind == Kind::kCylinder || shape.kind == Kind::kCapsule) && across) {
      const double along = R.col(2).dot(on_surface - p);
      return {on_surface, on_surface - 2 * along * R.col(2)};
    }
    return {on_surface, on_surface};
  }

  // Whether the line through `x` along the face's axis meets the face.
  bool covers(const Vector3d& x, int axis) const {
    const Vector3d s = R.transpose() * (x - p);
    if (shape.kind == Kind::kCylinder) return s.head<2>().norm() <= shape.radius + kOnFace;
    for (int k = 0; k < 3; ++k) {
      if (k != axis && std::abs(s[k]) > 0.5 * shape.size[k] + kOnFace) return false;
    }
    return true;
  }

  const EngineShape& shape;
  Eigen::Matrix3d R;
  Vector3d p;
  double radius = 0;
};

class Pair {
 public:
  Pair(const Placed& a, const Placed& b, double margin, std::vector<ConvexContact>& contacts)
      : a_(a), b_(b), margin_(margin), contacts_(contacts), first_(contacts.size()) {}

  void find() {
    if (!find_normal()) return;
    // The face whose normal it is bears the other; B's where both do.
    double sine_a, sine_b;
    const int face_a = a_.face_axis(-n_, sine_a), face_b = b_.face_axis(n_, sine_b);
    if (sine_b < kNormalToFace && sine_b <= sine_a + kRounding) {
      lie_on_face(b_, face_b, n_, a_);
    } else if (sine_a < kNormalToFace) {
      lie_on_face(a_, face_a, -n_, b_);
    }
    if (contacts_.size() == first_) touch_edges();
  }

 private:
  double separation(const Vector3d& n) const {
    return n.dot(a_.support(-n)) - n.dot(b_.support(n)) - a_.radius - b_.radius;
  }

  void consider(Vector3d n, double advantage) {
    const double length = n.norm();
    if (length < 1e-9) return;
    n /= length;
    for (const double sign : {1.0, -1.0}) {
      const double s = separation(sign * n);
      if (s <= best_ + advantage) continue;
      best_ = s;
      n_ = sign * n;
    }
  }

  bool find_normal() {
    Points faces, edges_a, edges_b;
    a_.add_faces(faces);
    b_.add_faces(faces);
    a_.add_edges(edges_a);
    b_.add_edges(edges_b);
    for (const Vector3d& n : faces) consider(n, 0);
    if (best_ > margin_) return false;
    const Vector3d apart = a_.p - b_.p;
    consider(apart, kPreferFaces);
    for (const Points* axes : {&edges_a, &edges_b}) {
      for (const Vector3d& u : *axes) consider(apart - apart.dot(u) * u, kPreferFaces);
    }
    Vector3d on_a = a_.p, on_b = b_.p;
    for (int i = 0; i < 50; ++i) {
      on_b = b_.nearest(on_a);
      const Vector3d next = a_.nearest(on_b);
      const bool still = (next - on_a).squaredNorm() < 1e-24;
      on_a = next;
      if (still) break;
    }
    consider(on_a - on_b, kPreferFaces);
    for (const Vector3d& u : edges_a) {
      for (const Vector3d& v : edges_b) {
        const Vector3d n = u.cross(v);
        if (n.squaredNorm() > 1e-6) consider(n, kPreferFaces);
      }
    }
    // Coincident centres of what is round.
    if (!std::isfinite(best_)) consider(Vector3d::UnitZ(), 0);
    return best_ <= margin_;
  }

  void add(const Vector3d& p, double depth) {
    if (depth < -margin_) return;
    for (std::size_t i = first_; i < contacts_.size(); ++i) {
      if ((contacts_[i].p_W - p).squaredNorm() < kMerged * kMerged) return;
    }
    contacts_.push_back({p, n_, depth});
  }

  // `out`: the face's outward normal. Corners of what lies on it within its border, its corners
  // within those of a face that lies on it, and crossings of borders.
  void lie_on_face(const Placed& base, int axis, const Vector3d& out, const Placed& other) {
    const Points corners = base.foremost(out), lying = other.foremost(-out);
    const double height = out.dot(base.support(out));
    const auto add_lying = [&](const Vector3d& x) {
      const double gap = out.dot(x) - height;
      add(x - 0.5 * gap * out, -gap);
    };
    for (const Vector3d& x : lying) {
      if (base.covers(x, axis)) add_lying(x);
    }
    double sine;
    const int other_axis = other.face_axis(-out, sine);
    const bool face_on_face = lying.size() > 2 && other_axis >= 0;
    if (face_on_face && sine < 0.8) {
      const Vector3d facing = other.R.col(other_axis);
      const Vector3d on_other = other.support(-out);
      for (const Vector3d& x : corners) {
        // Along `out` up to the other's face.
        const double gap = facing.dot(on_other - x) / facing.dot(out);
        const Vector3d met = x + gap * out;
        if (other.covers(met, other_axis)) add(x + 0.5 * gap * out, -gap);
      }
    }
    const std::size_t borders = lying.size() < 3 ? lying.size() - 1 : lying.size();
    for (std::size_t i = 0; i < borders; ++i) {
      const Vector3d& from = lying[i];
      const Vector3d along = lying[(i + 1) % lying.size()] - from;
      for (std::size_t j = 0; j < corners.size(); ++j) {
        const Vector3d side = corners[(j + 1) % corners.size()] - corners[j];
        const Vector3d inward = out.cross(side);  // in the face
        const double slope = inward.dot(along);
        if (std::abs(slope) < 1e-12) continue;
        const double t = inward.dot(corners[j] - from) / slope;
        if (t <= 0 || t >= 1) continue;
        const Vector3d x = from + t * along;
        const double s = side.dot(x - corners[j]) / side.squaredNorm();
        if (s >= 0 && s <= 1) add_lying(x);
      }
    }
    for (const Vector3d& x : other.corners(-out)) {
      if (out.dot(x) - height < margin_ && base.covers(x, axis)) add_lying(x);
    }
    // A tilted round face reaches farther between its corners.
    if (lying.size() == kRim) {
      const Vector3d lowest = other.support(-out);
      if (sine > kNormalToFace && base.covers(lowest, axis)) add_lying(lowest);
    }
  }

  void touch_edges() {
    const auto [a0, a1] = a_.foremost_edge(-n_);
    const auto [b0, b1] = b_.foremost_edge(n_);
    const Vector3d u = a1 - a0, v = b1 - b0;
    const double uu = u.squaredNorm(), vv = v.squaredNorm(), uv = u.dot(v);
    // Bindings by name: clang takes them no other way.
    const auto middle = [&, a0 = a0, b0 = b0](double s, double t) {
      add(0.5 * (a0 + s * u + b0 + t * v), -best_);
    };
    const auto clamped = [](double x) { return std::clamp(x, 0.0, 1.0); };
    if (uu > 0 && vv > 0 && uu * vv - uv * uv > 4e-4 * uu * vv) {
      const double s =
          clamped(((b0 - a0).dot(u) * vv - (b0 - a0).dot(v) * uv) / (uu * vv - uv * uv));
      const double t = clamped((a0 + s * u - b0).dot(v) / vv);
      middle(uu > 0 ? clamped((b0 + t * v - a0).dot(u) / uu) : 0.0, t);
    } else if (uu > 0 && vv > 0) {
      // Nearly parallel: the ends of the overlap.
      double t0 = clamped((b0 - a0).dot(u) / uu), t1 = clamped((b1 - a0).dot(u) / uu);
      for (const double s : {t0, t1}) middle(s, clamped((a0 + s * u - b0).dot(v) / vv));
    } else {
      const double s = uu > 0 ? clamped((b0 - a0).dot(u) / uu) : 0.0;
      const double t = vv > 0 ? clamped((a0 - b0).dot(v) / vv) : 0.0;
      middle(s, t);
    }
  }

  const Placed& a_;
  const Placed& b_;
  double margin_;
  std::vector<ConvexContact>& contacts_;
  std::size_t first_;
  double best_ = -std::numeric_limits<double>::infinity();
  Vector3d n_ = Vector3d::UnitZ();
};

}  // namespace

double bounding_radius(const EngineShape& shape) {
  switch (shape.kind) {
    case Kind::kBox:
      return 0.5 * shape.size.norm();
    case Kind::kSphere:
      return shape.radius;
    case Kind::kCylinder:
      return std::hypot(shape.radius, 0.5 * shape.length);
    case Kind::kCapsule:
      return shape.radius + 0.5 * shape.length;
    case Kind::kConvexPieces: {
      double farthest = 0;
      for (const geometry::TriangleMesh& piece : *shape.pieces) {
        for (const Vector3d& p : piece.vertices) farthest = std::max(farthest, p.norm());
      }
      return farthest;
    }
  }
  return 0;
}

void find_contacts(const EngineShape& a, const geometry::RigidTransform& X_WA, const EngineShape& b,
                   const geometry::RigidTransform& X_WB, double margin,
                   std::vector<ConvexContact>& contacts) {
  const double reach = bounding_radius(a) + bounding_radius(b) + margin;
  if ((X_WA.translation() - X_WB.translation()).squaredNorm() > reach * reach) return;
  const Placed placed_a(a, X_WA), placed_b(b, X_WB);
  Pair(placed_a, placed_b, margin, contacts).find();
}

void find_ground_contacts(const EngineShape& a, const geometry::RigidTransform& X_WA, double margin,
                          std::vector<ConvexContact>& contacts) {
  if (X_WA.translation().z() > bounding_radius(a) + margin) return;
  const Placed placed(a, X_WA);
  const Vector3d down = -Vector3d::UnitZ();
  Points points = placed.corners(down);
  const bool tilted = std::abs(placed.R(2, 2)) < 1 - 1e-9;
  if (a.kind == Kind::kCylinder && tilted) points.push_back(placed.support(down));
  const std::size_t first = contacts.size();
  for (const Vector3d& x : points) {
    if (x.z() > margin) continue;
    const Vector3d p(x.x(), x.y(), 0.5 * x.z());
    const bool known = std::any_of(
        contacts.begin() + static_cast<std::ptrdiff_t>(first), contacts.end(),
        [&](const ConvexContact& c) { return (c.p_W - p).squaredNorm() < kMerged * kMerged; });
    if (!known) contacts.push_back({p, Vector3d::UnitZ(), -x.z()});
  }
}

}  // namespace prehend::simulation::engines
