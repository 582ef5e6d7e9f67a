#include "prehend/surface/model.h"

#include <chrono>
#include <cmath>
#include <numeric>
#include <optional>
#include <string>
#include <utility>

#include "prehend/geometry/errors.h"
#include "prehend/geometry/mesh_query.h"
#include "prehend/surface/deviation.h"
#include "prehend/surface/point_order.h"
#include "prehend/surface/shape_cloud.h"
#include "prehend/surface/solid_hull.h"
#include "prehend/surface/vertex_origin.h"

namespace prehend::surface {
namespace {

constexpr std::size_t kMostMeasured = 4000;  // seen points

class Stopwatch {
 public:
  double lap() {
    const auto now = std::chrono::steady_clock::now();
    const double seconds = std::chrono::duration<double>(now - start_).count();
    start_ = now;
    return seconds;
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// Up to about kMostMeasured seen points, the same for any order of the shape's.
std::vector<Eigen::Vector3d> seen_sample(const shape::CompletedShape& shape) {
  std::vector<Eigen::Vector3f> seen;
  for (std::size_t i = 0; i < shape.cloud_W.size(); ++i) {
    if (shape.origin[i] == shape::PointOrigin::kSeen) seen.push_back(shape.cloud_W.points[i]);
  }
  const std::vector<int> order = canonical_order(seen);
  const std::size_t step = 1 + seen.size() / kMostMeasured;
  std::vector<Eigen::Vector3d> sample;
  for (std::size_t i = 0; i < order.size(); i += step) {
    sample.push_back(seen[order[i]].cast<double>());
  }
  return sample;
}

/// The convex hull of the points of an origin and of their feet on the table; none without volume.
std::optional<geometry::TriangleMesh> standing_hull(const shape::CompletedShape& shape,
                                                    const geometry::Plane& table_W,
                                                    bool only_seen) {
  constexpr std::size_t kMostVertices = 500;
  std::vector<Eigen::Vector3d> points;
  for (std::size_t i = 0; i < shape.cloud_W.size(); ++i) {
    if (only_seen && shape.origin[i] != shape::PointOrigin::kSeen) continue;
    if (!geometry::is_finite(shape.cloud_W.points[i])) continue;
    points.push_back(shape.cloud_W.points[i].cast<double>());
    points.push_back(table_W.project(points.back()));
  }
  return solid_hull(points, kMostVertices);
}

/// shape_cloud(), reconstruct(), of a shape or of one of its alternatives; `whole`, the shape,
/// knows where nothing can be. `normals_seconds` is filled when given. @throws geometry::InputError
/// as reconstruct() does.
geometry::TriangleMesh surface_of(const shape::CompletedShape& shape,
                                  const geometry::Plane& table_W,
                                  const shape::CompletedShape& whole, const ModelOptions& options,
                                  double* normals_seconds = nullptr) {
  Stopwatch stopwatch;
  const ShapeCloud points = shape_cloud(shape, table_W, options.points());
  if (normals_seconds) *normals_seconds = stopwatch.lap();
  const bool cut = options.keep_out_of_empty_space && !whole.seen_space.empty_until.empty();
  EmptySpace empty;
  if (cut) empty.seen = {&whole.seen_space};
  return reconstruct(points.cloud_W, table_W, options.surface, empty, whole.bounds_W);
}

/// The surface, or what stands in for it; `substitute` says what and why.
geometry::TriangleMesh mesh_at_any_rate(const shape::CompletedShape& shape,
                                        const geometry::Plane& table_W, const ModelOptions& options,
                                        double* normals_seconds, std::string& substitute) {
  try {
    return surface_of(shape, table_W, shape, options, normals_seconds);
  } catch (const geometry::InputError& error) {
    substitute = error.problem();
  }
  for (const shape::CompletedShape& other : shape.alternatives) {
    try {
      geometry::TriangleMesh mesh = surface_of(other, table_W, shape, options);
      substitute += "; an alternative plane of symmetry stands in";
      return mesh;
    } catch (const geometry::InputError&) {
      // The next one, or the hull.
    }
  }
  for (const bool only_seen : {true, false}) {
    if (auto hull = standing_hull(shape, table_W, only_seen)) {
      substitute += "; the convex hull of what was seen and its foot on the table stands in";
      return std::move(*hull);
    }
  }
  throw geometry::InputError(
      "What was seen of the object, " + std::to_string(shape.cloud_W.size()) +
          " points, has no volume over the table",
      "Look at it from another side or from nearer, so that more of it is seen");
}

/// Of an alternative, where the winner's is 1: by their votes; other methods have none that tells.
double vote_weight(const shape::CompletedShape& other, const shape::CompletedShape& winner) {
  if (winner.method != shape::CompletionMethod::kMirror) return 1;
  return std::exp((winner.symmetry.vote - other.symmetry.vote) / shape::kVoteScale);
}

}  // namespace

ModelOptions::ModelOptions(double finest_detail) {
  // Sparser points are smoothed over so much of a small ball in noise that it shrinks.
  constexpr double kPointsOverNodes = 1.0;
  cloud.least_spacing = kPointsOverNodes * finest_detail;
  surface.fast_poisson.least_spacing = finest_detail;
}

geometry::TriangleMesh mesh_of(const shape::CompletedShape& shape, const geometry::Plane& table_W,
                               const ModelOptions& options, double* normals_seconds) {
  return surface_of(shape, table_W, shape, options, normals_seconds);
}

ObjectModel model_of_shape(geometry::TriangleMesh mesh_W, const shape::CompletedShape& shape,
                           const ConvexPiecesOptions& options, ModelTimes* times) {
  ModelTimes spent;
  Stopwatch stopwatch;
  ObjectModel model;
  model.mesh_W = std::move(mesh_W);
  model.defects = geometry::find_defects(model.mesh_W);
  model.convex_pieces_W = convex_pieces(model.mesh_W, options).pieces;
  spent.convex_pieces = stopwatch.lap();

  model.mass_properties = geometry::mass_properties(model.mesh_W);
  VertexBasis basis = vertex_basis(model.mesh_W, shape, spacing_of(shape.cloud_W));
  model.vertex_origin = std::move(basis.origin);
  model.vertex_confidence = std::move(basis.confidence);
  model.guessed_area = guessed_area(model.mesh_W, model.vertex_origin);
  model.seen_deviation = deviation(seen_sample(shape), geometry::MeshQuery(model.mesh_W)).mean;
  spent.properties = stopwatch.lap();
  if (times) *times = spent;
  return model;
}

ObjectModel make_object_model(const shape::CompletedShape& shape, const geometry::Plane& table_W,
                              const ModelOptions& options, ModelTimes* times) {
  Stopwatch stopwatch;
  std::string substitute;
  double normals = 0;
  geometry::TriangleMesh mesh_W = mesh_at_any_rate(shape, table_W, options, &normals, substitute);
  const double poisson = stopwatch.lap() - normals;
  ModelTimes spent;
  ObjectModel model = model_of_shape(std::move(mesh_W), shape, options.convex_pieces, &spent);
  model.substitute = std::move(substitute);
  spent.normals = normals;
  spent.poisson = poisson;
  stopwatch.lap();
  std::vector<double> weights{1};
  for (const shape::CompletedShape& other : shape.alternatives) {
    try {
      model.alternatives_W.push_back(surface_of(other, table_W, shape, options));
      weights.push_back(vote_weight(other, shape));
    } catch (const geometry::InputError&) {
      // A shape that gives no mesh is no alternative; that of the winner counts.
    }
  }
  const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
  for (const double weight : weights) model.shape_weights.push_back(weight / sum);
  spent.alternatives = stopwatch.lap();
  if (times) *times = spent;
  return model;
}

ObjectModel model_of_mesh(geometry::TriangleMesh mesh_W, const ConvexPiecesOptions& options) {
  ObjectModel model;
  model.mesh_W = std::move(mesh_W);
  model.defects = geometry::find_defects(model.mesh_W);
  if (model.defects.watertight()) {
    model.convex_pieces_W = convex_pieces(model.mesh_W, options).pieces;
  } else {
    model.convex_pieces_W = {geometry::convex_hull(model.mesh_W.vertices)};
  }
  model.mass_properties = geometry::mass_properties(
      model.defects.watertight() ? model.mesh_W : model.convex_pieces_W.front());
  if (!(model.mass_properties.volume > 0)) {
    throw geometry::InputError("The mesh has no volume (" + model.defects.to_string() + ")",
                               "Give a closed mesh with its triangles outwards");
  }
  return model;
}

ObjectModel moved(const ObjectModel& model_O, const geometry::RigidTransform& X_WO) {
  ObjectModel model = model_O;
  model.mesh_W = geometry::transformed(model_O.mesh_W, X_WO);
  for (auto& piece : model.convex_pieces_W) piece = geometry::transformed(piece, X_WO);
  for (auto& mesh : model.alternatives_W) mesh = geometry::transformed(mesh, X_WO);
  geometry::MassProperties& mass = model.mass_properties;
  mass.center_of_mass = X_WO * mass.center_of_mass;
  mass.unit_density_inertia = X_WO.linear() * mass.unit_density_inertia * X_WO.linear().transpose();
  return model;
}

}  // namespace prehend::surface
