#include "prehend/belief/shape_hypothesis.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <optional>
#include <set>
#include <stdexcept>
#include <utility>

#include <Eigen/Geometry>

#include "prehend/belief/point_cells.h"

namespace prehend::belief {
namespace {

using shape::PointOrigin;

struct Plane {
  Eigen::Vector3d point, normal;
};

Eigen::Vector3d mirrored_at(const Plane& plane, const Eigen::Vector3d& p) {
  return p - 2 * plane.normal.dot(p - plane.point) * plane.normal;
}

/// The planes of a mirror, and where a point of an origin comes from and goes to by them.
struct Mirror {
  Plane first, second;
  bool has_second = false;

  Eigen::Vector3d map(PointOrigin origin, const Eigen::Vector3d& p) const {
    switch (origin) {
      case PointOrigin::kSeen:
        return p;
      case PointOrigin::kMirrored:
        return mirrored_at(first, p);
      case PointOrigin::kMirroredSecond:
        return has_second ? mirrored_at(second, p) : p;
      case PointOrigin::kMirroredBoth:
        return has_second ? mirrored_at(second, mirrored_at(first, p)) : mirrored_at(first, p);
    }
    return p;
  }
  Eigen::Vector3d unmap(PointOrigin origin, const Eigen::Vector3d& p) const {
    if (origin != PointOrigin::kMirroredBoth) return map(origin, p);
    return mirrored_at(first, has_second ? mirrored_at(second, p) : p);
  }
};

/// The plane, its normal rotated about `axis` through its foot of `center`.
Plane turned(const Plane& plane, const Eigen::Vector3d& center, const Eigen::Vector3d& axis,
             double angle) {
  const Eigen::Vector3d foot = center - plane.normal.dot(center - plane.point) * plane.normal;
  return {foot, Eigen::AngleAxisd(angle, axis) * plane.normal};
}

class Motions {
 public:
  Motions(ShapeHypothesis& hypothesis, const geometry::Plane& table_W,
          const Eigen::Vector3d& viewpoint_W)
      : hypothesis_(hypothesis), up_(table_W.normal), viewpoint_(viewpoint_W) {
    for (const Eigen::Vector3f& p : hypothesis.points.cloud_W.points) {
      box_.extend(p.cast<double>());
    }
  }

  double extent() const { return box_.sizes().maxCoeff(); }

  void of_planes(const shape::CompletedShape& shape, const ShapePrior& prior) {
    Mirror mirror{{shape.symmetry.point_W, shape.symmetry.normal_W}, {}, false};
    if (shape.second_symmetry) {
      mirror.second = {shape.second_symmetry->point_W, shape.second_symmetry->normal_W};
      mirror.has_second = true;
    }
    of_plane(mirror, &Mirror::first, prior);
    if (mirror.has_second) of_plane(mirror, &Mirror::second, prior);
  }

  /// Of all that was not seen: the axis is shifted, the radius grows.
  void of_axis(const ShapePrior& prior) {
    const Eigen::Vector3d center = box_.center();
    const Eigen::Vector3d x = up_.unitOrthogonal(), y = up_.cross(x);
    for (const Eigen::Vector3d& along : {x, y}) {
      add([&](surface::SurfaceOrigin, PointOrigin, const Eigen::Vector3d&) -> Eigen::Vector3d {
        return prior.axis_shift * extent() * along;
      });
    }
    add([&](surface::SurfaceOrigin, PointOrigin, const Eigen::Vector3d& p) -> Eigen::Vector3d {
      const Eigen::Vector3d from_axis = p - center - up_.dot(p - center) * up_;
      return prior.radius * extent() * from_axis.normalized();
    });
  }

 private:
  void of_plane(const Mirror& mirror, Plane Mirror::*which, const ShapePrior& prior) {
    const Plane& plane = mirror.*which;
    const auto changed = [&](const Plane& other) {
      Mirror result = mirror;
      result.*which = other;
      return result;
    };
    // A level plane leans about any axis along it, and does not turn.
    const Eigen::Vector3d across = up_.cross(plane.normal);
    const Eigen::Vector3d lean = across.norm() > 1e-3 ? across.normalized() : up_.unitOrthogonal();
    const std::pair<Mirror, Mirror> ways[] = {
        {changed({plane.point + prior.plane_shift * extent() * plane.normal, plane.normal}),
         changed({plane.point - prior.plane_shift * extent() * plane.normal, plane.normal})},
        {changed(turned(plane, box_.center(), up_, prior.plane_turn)),
         changed(turned(plane, box_.center(), up_, -prior.plane_turn))},
        {changed(turned(plane, box_.center(), lean, prior.plane_tilt)),
         changed(turned(plane, box_.center(), lean, -prior.plane_tilt))}};
    const PointOrigin of_this =
        which == &Mirror::first ? PointOrigin::kMirrored : PointOrigin::kMirroredSecond;
    const auto over = [&](const Eigen::Vector3d& p) { return plane.normal.dot(p - plane.point); };
    double reach = 0;
    for (const Eigen::Vector3f& p : hypothesis_.points.cloud_W.points) {
      reach = std::max(reach, std::abs(over(p.cast<double>())));
    }
    // From the side that was seen to the one that was mirrored.
    const double away = over(viewpoint_) > 0 ? -1 : 1;
    const auto share = [&](const Eigen::Vector3d& p) {
      return reach > 0 ? std::clamp(0.5 + 0.5 * away * over(p) / reach, 0.0, 1.0) : 0.0;
    };
    for (const auto& [more, less] : ways) {
      add([&, &m = more, &l = less](surface::SurfaceOrigin basis, PointOrigin origin,
                                    const Eigen::Vector3d& p) -> Eigen::Vector3d {
        // What closes a side between the two goes with the mirrored one as far as it is there.
        const bool is_between = basis == surface::SurfaceOrigin::kAssumed;
        const PointOrigin mapped = is_between ? of_this : origin;
        const Eigen::Vector3d from = mirror.unmap(mapped, p);
        return (is_between ? share(p) : 1) * 0.5 * (m.map(mapped, from) - l.map(mapped, from));
      });
    }
  }

  using Motion =
      std::function<Eigen::Vector3d(surface::SurfaceOrigin, PointOrigin, const Eigen::Vector3d&)>;
  void add(const Motion& motion) {
    const surface::ShapeCloud& points = hypothesis_.points;
    const auto count = static_cast<Eigen::Index>(points.cloud_W.size());
    Eigen::Matrix3Xf moved = Eigen::Matrix3Xf::Zero(3, count);
    for (Eigen::Index i = 0; i < count; ++i) {
      if (points.basis[i] == surface::SurfaceOrigin::kSeen) continue;
      const Eigen::Vector3d p = points.cloud_W.points[i].cast<double>();
      moved.col(i) = motion(points.basis[i], points.origin[i], p).cast<float>();
    }
    hypothesis_.motions.push_back(std::move(moved));
  }

  ShapeHypothesis& hypothesis_;
  Eigen::Vector3d up_, viewpoint_;
  Eigen::AlignedBox3d box_;
};

/// The nearest point, a seen one before any other; none where there is none in the cells' reach.
std::optional<std::size_t> nearest_of(const surface::ShapeCloud& cloud, const PointCells& cells,
                                      const Eigen::Vector3f& p) {
  std::optional<std::size_t> best;
  float least = 0;
  bool is_seen = false;
  cells.each_near(p, [&](std::size_t i, float squared) {
    const bool seen = cloud.basis[i] == surface::SurfaceOrigin::kSeen;
    if (is_seen && !seen) return;
    if (best && seen == is_seen && squared >= least) return;
    best = i;
    least = squared;
    is_seen = seen;
  });
  return best;
}

/// Points spread over the mesh, `across` of them along its longest side, with normals. Its foot is
/// left out: what stands on the table follows from the sides (closing.h).
geometry::PointCloud spread_over(const geometry::TriangleMesh& mesh, double across,
                                 const geometry::Plane& table_W) {
  constexpr double kFootFaces = -0.7;  // cosine, beside the table's normal
  const double side = geometry::bounds(mesh).sizes().maxCoeff() / across;
  const std::vector<Eigen::Vector3d> normals = geometry::vertex_normals(mesh);
  std::set<std::array<int, 4>> taken;
  geometry::PointCloud cloud;
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    if (table_W.signed_distance(mesh.vertices[i]) < 2 * side &&
        normals[i].dot(table_W.normal) < kFootFaces) {
      continue;
    }
    const Eigen::Vector3i cell = (mesh.vertices[i] / side).array().floor().matrix().cast<int>();
    int axis = 0;
    normals[i].cwiseAbs().maxCoeff(&axis);
    // Both sides of a thin wall may be in one cell.
    const int facing = 2 * axis + (normals[i][axis] < 0 ? 1 : 0);
    if (!taken.insert({cell.x(), cell.y(), cell.z(), facing}).second) continue;
    cloud.points.push_back(mesh.vertices[i].cast<float>());
    cloud.normals.push_back(normals[i].cast<float>());
  }
  return cloud;
}

/// The surface of `shape` as points, with what each rests on. `lost`: the share of the seen points
/// that the surface does not go through, as that of a head whose neck nobody saw.
surface::ShapeCloud surface_points(const shape::CompletedShape& shape,
                                   const shape::CompletedShape& whole,
                                   const geometry::Plane& table_W,
                                   const surface::SurfaceOptions& surface, double* lost) {
  constexpr double kAcross = 64;
  constexpr double kNear = 2.5;  // spacings
  const surface::ShapeCloud made_of = surface::shape_cloud(shape, table_W);
  surface::EmptySpace empty;
  if (!whole.seen_space.empty_until.empty()) empty.seen = {&whole.seen_space};
  const geometry::TriangleMesh mesh =
      surface::reconstruct(made_of.cloud_W, table_W, surface, empty, shape.bounds_W);
  surface::ShapeCloud points;
  points.cloud_W = spread_over(mesh, kAcross, table_W);
  const double near = kNear * surface::spacing_of(made_of.cloud_W);
  const PointCells cells(made_of.cloud_W.points, near);
  for (const Eigen::Vector3f& p : points.cloud_W.points) {
    const std::optional<std::size_t> nearest = nearest_of(made_of, cells, p);
    points.basis.push_back(nearest ? made_of.basis[*nearest] : surface::SurfaceOrigin::kAssumed);
    points.origin.push_back(nearest ? made_of.origin[*nearest] : PointOrigin::kMirrored);
  }
  const PointCells made(points.cloud_W.points, 2 * near);
  double seen = 0, missed = 0;
  for (std::size_t i = 0; i < made_of.cloud_W.size(); ++i) {
    if (made_of.basis[i] != surface::SurfaceOrigin::kSeen) continue;
    ++seen;
    bool is_on = false;
    made.each_near(made_of.cloud_W.points[i], [&](std::size_t, float) { is_on = true; });
    if (!is_on) ++missed;
  }
  *lost = seen > 0 ? missed / seen : 0;
  return points;
}

bool is_mirrored_below(const shape::CompletedShape& shape, const geometry::Plane& table_W) {
  constexpr double kLevel = 0.99;  // cosine
  const bool is_mirror = shape.method == shape::CompletionMethod::kMirror ||
                         shape.method == shape::CompletionMethod::kRefusedMirror;
  return is_mirror && shape.second_symmetry &&
         std::abs(shape.second_symmetry->normal_W.dot(table_W.normal)) > kLevel;
}

}  // namespace

void ShapePrior::validate() const {
  const auto require = [](bool holds, const char* name) {
    if (!holds) throw std::invalid_argument(std::string("ShapePrior.") + name + " is out of range");
  };
  const auto positive = [&](double value, const char* name) {
    require(value > 0 && std::isfinite(value), name);
  };
  positive(seen, "seen");
  positive(predicted, "predicted");
  positive(assumed, "assumed");
  positive(correlation_length, "correlation_length");
  positive(detail_length, "detail_length");
  require(detail >= 0 && detail <= 1, "detail");
  positive(aside_share, "aside_share");
  positive(least_aside, "least_aside");
  positive(vote_scale, "vote_scale");
  positive(score_scale, "score_scale");
  for (const auto& [value, name] : {std::pair{predicted_share, "predicted_share"},
                                    {assumed_share, "assumed_share"},
                                    {plane_shift, "plane_shift"},
                                    {plane_turn, "plane_turn"},
                                    {plane_tilt, "plane_tilt"},
                                    {axis_shift, "axis_shift"},
                                    {radius, "radius"},
                                    {lost, "lost"},
                                    {normal_scale, "normal_scale"}}) {
    require(value >= 0 && std::isfinite(value), name);
  }
  for (const auto& [value, name] : {std::pair{rotation, "rotation"},
                                    {extrusion, "extrusion"},
                                    {convex_hull, "convex_hull"},
                                    {mirrored_below, "mirrored_below"}}) {
    require(std::isfinite(value), name);
  }
}

double log_prior(const PriorTerms& terms, const ShapePrior& prior) {
  const double kept = -prior.lost * terms.lost;
  switch (terms.method) {
    case shape::CompletionMethod::kMirror:
    case shape::CompletionMethod::kRefusedMirror:
      return kept - terms.worse / prior.vote_scale +
             (terms.mirrored_below ? prior.mirrored_below : 0);
    case shape::CompletionMethod::kRotation:
      return kept + prior.rotation - terms.worse / prior.score_scale;
    case shape::CompletionMethod::kExtrusion:
      return kept + prior.extrusion - terms.worse / prior.score_scale;
    case shape::CompletionMethod::kConvexHull:
      return kept + prior.convex_hull - terms.worse / prior.score_scale;
  }
  return kept;
}

ShapeHypothesis hypothesis_of(const shape::CompletedShape& shape,
                              const shape::CompletedShape& whole, const geometry::Plane& table_W,
                              const ShapePrior& prior, const surface::SurfaceOptions& surface) {
  prior.validate();
  ShapeHypothesis hypothesis;
  hypothesis.name = name(shape.method);
  double lost = 0;
  hypothesis.points = surface_points(shape, whole, table_W, surface, &lost);
  hypothesis.bounds_W = shape.bounds_W;
  Motions motions(hypothesis, table_W, shape.viewpoint_W);
  const double extent = motions.extent();
  hypothesis.correlation_length = prior.correlation_length * extent;
  hypothesis.detail_length = prior.detail_length * extent;
  hypothesis.detail = prior.detail;
  for (const surface::SurfaceOrigin basis : hypothesis.points.basis) {
    const double deviation = basis == surface::SurfaceOrigin::kSeen ? prior.seen
                             : basis == surface::SurfaceOrigin::kPredicted
                                 ? prior.predicted + prior.predicted_share * extent
                                 : prior.assumed + prior.assumed_share * extent;
    hypothesis.deviation.push_back(static_cast<float>(deviation));
  }
  switch (shape.method) {
    case shape::CompletionMethod::kMirror:
    case shape::CompletionMethod::kRefusedMirror:
      motions.of_planes(shape, prior);
      break;
    case shape::CompletionMethod::kRotation:
      motions.of_axis(prior);
      break;
    case shape::CompletionMethod::kExtrusion:
    case shape::CompletionMethod::kConvexHull:
      break;
  }
  hypothesis.prior_terms = {shape.method, is_mirrored_below(shape, table_W),
                            shape.symmetry.vote - whole.symmetry.vote, lost};
  if (hypothesis.prior_terms.mirrored_below) hypothesis.name = "mirror, below as above";
  hypothesis.log_prior = log_prior(hypothesis.prior_terms, prior);
  hypothesis.aside = std::max(prior.least_aside, prior.aside_share * extent);
  hypothesis.normal_scale = prior.normal_scale;
  for (std::size_t i = 0; i < hypothesis.deviation.size(); ++i) {
    float variance = hypothesis.deviation[i] * hypothesis.deviation[i];
    for (const Eigen::Matrix3Xf& motion : hypothesis.motions) {
      const float along = hypothesis.points.cloud_W.normals[i].dot(motion.col(i));
      variance += along * along;
    }
    hypothesis.variance.push_back(variance);
  }
  return hypothesis;
}

}  // namespace prehend::belief
