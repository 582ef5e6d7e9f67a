#include "eval/belief/belief_truth.h"

#include <random>

#include <Eigen/Geometry>

#include "prehend/geometry/surface_samples.h"
#include "prehend/surface/deviation.h"

namespace prehend::eval {
namespace {

constexpr int kSamples = 6000;         // on each surface
constexpr int kVolumeSamples = 12000;  // in the box of both
constexpr double kSupport = 0.003;     // m over the support: what is lower cannot be touched

}  // namespace

BeliefTruth::BeliefTruth(const Case& one, const Eigen::Vector3d& viewpoint_W)
    : mesh_(geometry::transformed(*one.data_set->mesh_B, one.X_WB())), query_(mesh_) {
  std::vector<geometry::MeshQuery> others;
  for (const auto& other : one.data_set->viewing.others_B) {
    others.emplace_back(geometry::transformed(*other, one.X_WB()));
  }
  for (const auto& sample : geometry::surface_samples(mesh_, kSamples, one.seed)) {
    all_.push_back(sample.point);
    const Eigen::Vector3d away = viewpoint_W - sample.point;
    const double distance = away.norm();
    const Eigen::Vector3d direction = away / distance;
    const Eigen::Vector3d from = sample.point + 5e-4 * direction;
    bool hidden = query_.cast_ray(from, direction, distance).has_value();
    for (const auto& other : others) {
      hidden = hidden || other.cast_ray(from, direction, distance).has_value();
    }
    if (hidden && sample.point.z() > kSupport) unseen_.push_back(sample.point);
  }
}

void BeliefTruth::measure(const geometry::TriangleMesh& mesh_W, std::uint64_t seed,
                          BeliefStep* step) const {
  const geometry::MeshQuery believed(mesh_W);
  step->unseen = surface::deviation(unseen_, believed).mean;
  std::vector<Eigen::Vector3d> samples;
  for (const auto& sample : geometry::surface_samples(mesh_W, kSamples, seed)) {
    samples.push_back(sample.point);
  }
  step->chamfer =
      0.5 * (surface::deviation(all_, believed).mean + surface::deviation(samples, query_).mean);
  Eigen::AlignedBox3d box = query_.box();
  box.extend(believed.box());
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  int both = 0, either = 0;
  for (int i = 0; i < kVolumeSamples; ++i) {
    const Eigen::Vector3d share(unit(random), unit(random), unit(random));
    const Eigen::Vector3d p = box.min() + share.cwiseProduct(box.sizes());
    const bool in_truth = query_.contains(p), in_believed = believed.contains(p);
    both += in_truth && in_believed;
    either += in_truth || in_believed;
  }
  step->jaccard = either > 0 ? static_cast<double>(both) / either : 0;
}

}  // namespace prehend::eval
