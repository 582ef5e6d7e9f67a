#include "prehend/grasp/known/known_objects.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "prehend/geometry/errors.h"
#include "prehend/geometry/surface_samples.h"
#include "prehend/grasp/known/grasp_database.h"
#include "prehend/grasp/known/registration.h"
#include "prehend/grasp/known/size_estimate.h"
#include "prehend/text/told_apart.h"

namespace prehend::grasp {
namespace {

using geometry::InputError;
using geometry::RigidTransform;

constexpr std::size_t kLeastPoints = 30;  // that anything can be told from
constexpr double kLeastJudged = 0.3;      // share of the visible surface that has to be compared

struct Model {
  std::string hash, name;
  RegisteredModel registered;
};

std::vector<Eigen::Vector3d> finite_points(const geometry::PointCloud& cloud) {
  std::vector<Eigen::Vector3d> points;
  for (const Eigen::Vector3f& p : cloud.points) {
    if (geometry::is_finite(p)) points.push_back(p.cast<double>());
  }
  return points;
}

double diagonal(const std::vector<Eigen::Vector3d>& points) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& p : points) box.extend(p);
  return box.diagonal().norm();
}

RegisteredModel registered(const geometry::TriangleMesh& mesh, const RecognitionOptions& options) {
  constexpr int kLeast = 200, kMost = 20000;
  const double wanted = geometry::surface_area(mesh) / (options.spacing * options.spacing);
  const int count = static_cast<int>(std::clamp<double>(wanted, kLeast, kMost));
  DescribedPoints samples;
  for (const auto& sample : geometry::surface_samples(mesh, count, options.seed)) {
    const Eigen::Vector3i& corners = mesh.triangles[static_cast<std::size_t>(sample.triangle)];
    const auto corner = [&](int i) { return mesh.vertices[static_cast<std::size_t>(corners[i])]; };
    const Eigen::Vector3d normal =
        (corner(1) - corner(0)).cross(corner(2) - corner(0)).normalized();
    samples.points.push_back(sample.point);
    samples.normals.push_back(normal);
  }
  samples.features = features_of(samples.points, samples.normals, options.spacing);
  FeatureIndex index(samples.features);
  return {geometry::MeshQuery(mesh), std::move(samples), std::move(index)};
}

OrientedPoints every_nth(const DescribedPoints& points, std::size_t about) {
  OrientedPoints chosen;
  const std::size_t stride = (points.points.size() + about - 1) / about;
  for (std::size_t i = 0; i < points.points.size(); i += stride) {
    chosen.points.push_back(points.points[i]);
    chosen.normals.push_back(points.normals[i]);
  }
  return chosen;
}

// The nearest depth known around a pixel, NaN when there is none: at an object's outline the
// depth of what stands before counts.
double depth_around(const geometry::DepthImage& depth, const Eigen::Vector2d& pixel) {
  double nearest = std::numeric_limits<double>::quiet_NaN();
  if (!(pixel.cwiseAbs().maxCoeff() < 1e6)) return nearest;
  const int u = static_cast<int>(std::lround(pixel.x())),
            v = static_cast<int>(std::lround(pixel.y()));
  for (int dv = -1; dv <= 1; ++dv) {
    for (int du = -1; du <= 1; ++du) {
      if (!depth.contains(u + du, v + dv)) continue;
      const float z = depth.at(u + du, v + dv);
      if (std::isfinite(z) && !(nearest <= z)) nearest = z;
    }
  }
  return nearest;
}

struct Violation {
  double share = 0;   // of what can be judged
  double judged = 0;  // share of the visible surface
};

// Where the model should be seen, and what was seen there.
Violation violation_of(const RegisteredModel& model, const SeenObject& seen,
                       const RigidTransform& X_WO, double margin) {
  constexpr double kGrazing = 0.2;  // cosine; what is seen flatter is too uncertain
  constexpr double kOwn = 2e-3;     // m, by which the model may hide a point of its own
  const RigidTransform X_CO = seen.X_WC.inverse() * X_WO;
  const Eigen::Vector3d eye_O = X_CO.inverse().translation();
  int visible = 0, judged = 0, violated = 0;
  for (std::size_t i = 0; i < model.samples_O.points.size(); ++i) {
    const Eigen::Vector3d& p_O = model.samples_O.points[i];
    if (seen.table_W && seen.table_W->signed_distance(X_WO * p_O) < -margin) {
      ++visible;
      ++judged;
      ++violated;
      continue;
    }
    const Eigen::Vector3d p_C = X_CO * p_O;
    const Eigen::Vector3d way = p_O - eye_O;
    const double distance = way.norm();
    if (p_C.z() <= 0 || distance <= 0) continue;
    if (model.samples_O.normals[i].dot(-way) < kGrazing * distance) continue;
    if (model.surface_O.cast_ray(eye_O, way / distance, distance - kOwn)) continue;
    const Eigen::Vector2d pixel = seen.camera.project(p_C);
    if (!(pixel.x() >= 0 && pixel.y() >= 0 && pixel.x() <= seen.camera.width - 1 &&
          pixel.y() <= seen.camera.height - 1)) {
      continue;
    }
    ++visible;
    const double depth = depth_around(seen.depth, pixel);
    if (!(depth > p_C.z() - margin)) continue;  // unknown, or something stands before it
    ++judged;
    violated += depth > p_C.z() + margin;
  }
  Violation result;
  if (judged > 0) result.share = static_cast<double>(violated) / judged;
  if (visible > 0) result.judged = static_cast<double>(judged) / visible;
  return result;
}

std::string reason_against(const Recognition& recognition, const Violation& violation,
                           const RecognitionOptions& options) {
  if (recognition.explained < options.least_explained) {
    const auto [share, least] =
        text::told_apart(100 * recognition.explained, 100 * options.least_explained, 0);
    return fmt::format("explains {} % of the seen points, not {} %", share, least);
  }
  if (violation.judged < kLeastJudged) {
    const auto [share, least] = text::told_apart(100 * violation.judged, 100 * kLeastJudged, 0);
    return fmt::format("only {} % of what should be seen of it can be compared, not {} %", share,
                       least);
  }
  if (recognition.violated > options.most_violated) {
    const auto [share, most] =
        text::told_apart(100 * recognition.violated, 100 * options.most_violated, 0);
    return fmt::format(
        "{} % of what should be seen of it is free space or below the table, more than {} %", share,
        most);
  }
  return {};
}

// Puts the size into `recognition`; why it speaks against the model, or "".
std::string judge_size(const OrientedPoints& points, const RegisteredModel& model,
                       const RecognitionOptions& options, Recognition* recognition) {
  const SizeEstimate size = estimated_size(points, model, recognition->X_WO.inverse(),
                                           options.tolerance, options.spacing, options.correlation);
  constexpr double kDeviations = 3;
  int worst = 0;
  const Eigen::Vector3d excess = size.difference.cwiseAbs() - kDeviations * size.deviation;
  excess.maxCoeff(&worst);
  recognition->size_difference = size.difference(worst);
  recognition->size_deviation = size.deviation(worst);
  if (!(excess(worst) > options.size_margin)) return {};
  constexpr double kMillimetres = 1e3;
  return fmt::format(
      "what is seen is {:.0f} mm long where it is {:.0f} mm, a difference of {:.1f} +- {:.1f} mm",
      kMillimetres * (size.extent(worst) + size.difference(worst)),
      kMillimetres * size.extent(worst), kMillimetres * std::abs(size.difference(worst)),
      kMillimetres * size.deviation(worst));
}

}  // namespace

void RecognitionOptions::validate() const {
  const auto require = [](bool condition, const char* what) {
    if (!condition) throw std::invalid_argument(std::string("RecognitionOptions: ") + what);
  };
  const auto is_positive = [](double value) { return std::isfinite(value) && value > 0; };
  require(is_positive(spacing), "spacing must be positive and finite");
  require(is_positive(tolerance), "tolerance must be positive and finite");
  require(std::isfinite(size_margin) && size_margin >= 0, "size_margin must not be negative");
  require(is_positive(correlation), "correlation must be positive and finite");
  require(is_positive(free_margin), "free_margin must be positive and finite");
  require(least_explained >= 0 && least_explained <= 1, "least_explained must be in [0, 1]");
  require(most_violated >= 0 && most_violated <= 1, "most_violated must be in [0, 1]");
  require(samples > 0, "samples must be positive");
  require(refined > 0, "refined must be positive");
}

struct KnownObjects::Implementation {
  RecognitionOptions options;
  std::vector<Model> models;

  Recognition fit(const Model& model, const SeenObject& seen, const DescribedPoints& points,
                  const std::vector<Eigen::Vector3d>& all_points) const;
};

KnownObjects::KnownObjects(const RecognitionOptions& options)
    : implementation_(std::make_unique<Implementation>()) {
  options.validate();
  implementation_->options = options;
}

KnownObjects::~KnownObjects() = default;
KnownObjects::KnownObjects(KnownObjects&&) noexcept = default;
KnownObjects& KnownObjects::operator=(KnownObjects&&) noexcept = default;

std::size_t KnownObjects::size() const { return implementation_->models.size(); }

void KnownObjects::add(const std::string& name, const geometry::TriangleMesh& mesh_O) {
  const bool is_finite = std::all_of(mesh_O.vertices.begin(), mesh_O.vertices.end(),
                                     [](const Eigen::Vector3d& v) { return v.allFinite(); });
  if (!is_finite) {
    throw InputError("the mesh of known object '" + name + "' has vertices that are not finite",
                     "Repair its file");
  }
  implementation_->models.push_back(
      {content_hash(mesh_O), name, registered(mesh_O, implementation_->options)});
}

// The pose of the best fitness among those refined.
Recognition KnownObjects::Implementation::fit(
    const Model& model, const SeenObject& seen, const DescribedPoints& points,
    const std::vector<Eigen::Vector3d>& all_points) const {
  const double distance = 0.35 * diagonal(points.points);
  const auto poses = consensus_poses(points, model.registered,
                                     {.spacing = options.spacing,
                                      .least_distance = distance,
                                      .tolerance = options.tolerance,
                                      .samples = options.samples,
                                      .kept = options.refined,
                                      .seed = options.seed});
  Recognition best;
  best.hash = model.hash;
  best.name = model.name;
  best.reason = "no pose of it agrees with two of the seen points";
  double best_fitness = -std::numeric_limits<double>::infinity();
  const geometry::MeshQuery& surface_O = model.registered.surface_O;
  // Coarsely first, with few points: most poses are in the basins of few.
  constexpr std::size_t kCoarse = 80, kFine = 300;
  const OrientedPoints few = every_nth(points, kCoarse), some = every_nth(points, kFine);
  std::vector<std::pair<double, RigidTransform>> coarse;
  for (const RigidTransform& pose : poses) {
    const RigidTransform X_OW = refined_pose(few, surface_O, pose, options.tolerance);
    coarse.emplace_back(explained_by(few.points, surface_O, X_OW, options.tolerance).share, X_OW);
  }
  std::stable_sort(coarse.begin(), coarse.end(),
                   [](const auto& a, const auto& b) { return a.first > b.first; });
  const std::size_t finalists = static_cast<std::size_t>((options.refined + 4) / 5);
  for (std::size_t i = 0; i < std::min(coarse.size(), finalists); ++i) {
    // Points in frame S are in the world here.
    const RigidTransform X_OW = refined_pose(some, surface_O, coarse[i].second, options.tolerance);
    const Explained explained = explained_by(all_points, surface_O, X_OW, options.tolerance);
    Recognition one = best;
    one.X_WO = X_OW.inverse();
    one.explained = explained.share;
    one.residual = explained.residual;
    const Violation violation = violation_of(model.registered, seen, one.X_WO, options.free_margin);
    one.violated = violation.share;
    // Of equal fits, as of symmetric objects, the closer one.
    const double fitness = one.fitness() - one.residual / options.tolerance * 1e-2;
    if (fitness <= best_fitness) continue;
    best_fitness = fitness;
    one.reason = reason_against(one, violation, options);
    best = one;
  }
  if (best.reason.empty()) {
    best.reason =
        judge_size(OrientedPoints{points.points, points.normals}, model.registered, options, &best);
  }
  best.accepted = best.reason.empty();
  return best;
}

std::vector<Recognition> KnownObjects::recognise(const SeenObject& seen) const {
  const RecognitionOptions& options = implementation_->options;
  if (seen.depth.width != seen.camera.width || seen.depth.height != seen.camera.height ||
      seen.depth.empty()) {
    throw InputError(
        fmt::format("the depth image has {} x {} pixels, the camera {} x {}", seen.depth.width,
                    seen.depth.height, seen.camera.width, seen.camera.height),
        "Give the depth image of the whole view in which the object was seen");
  }
  const std::vector<Eigen::Vector3d> all_points =
      thinned(finite_points(seen.cloud_W), options.spacing);
  DescribedPoints points;
  points.points = all_points;
  points.normals = normals_towards(seen.X_WC.translation(), options.spacing, points.points);
  if (points.points.size() < kLeastPoints) {
    throw InputError(fmt::format("{} points, one every {} m, are too few to recognise an object by",
                                 points.points.size(), options.spacing),
                     "Look from nearer, or set a smaller spacing");
  }
  points.features = features_of(points.points, points.normals, options.spacing);
  std::vector<Recognition> recognitions;
  for (const Model& model : implementation_->models) {
    recognitions.push_back(implementation_->fit(model, seen, points, all_points));
  }
  std::stable_sort(recognitions.begin(), recognitions.end(),
                   [](const Recognition& a, const Recognition& b) {
                     if (a.accepted != b.accepted) return a.accepted;
                     return a.fitness() > b.fitness();
                   });
  return recognitions;
}

}  // namespace prehend::grasp
