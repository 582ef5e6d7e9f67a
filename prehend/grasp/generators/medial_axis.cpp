#include <cmath>
#include <optional>

#include "prehend/geometry/surface_samples.h"
#include "prehend/grasp/generators/generators.h"
#include "prehend/grasp/generators/held_line.h"

namespace prehend::grasp {
namespace {

constexpr int kShrinkings = 30;
constexpr double kMedialSkin = 1e-6;      // m
constexpr double kLeastOpposition = 0.5;  // cosine: 120 degrees between the points of touch
// By how much of its radius a ball may reach through the surface. Between the facets of a round
// mesh there is no room for a ball that is tangent to one of them and exact.
constexpr double kTolerance = 0.1;

class MedialAxis : public CandidateGenerator {
 public:
  std::string name() const override { return "medial_axis"; }

  std::vector<Candidate> generate(const GraspTarget& target,
                                  const GeneratorOptions& options) const override {
    std::vector<Candidate> candidates;
    const auto& mesh = target.query_W.mesh();
    for (const auto& sample : geometry::surface_samples(mesh, options.samples, options.seed)) {
      const auto& t = mesh.triangles[sample.triangle];
      const Eigen::Vector3d& a = mesh.vertices[t[0]];
      const Eigen::Vector3d normal =
          (mesh.vertices[t[1]] - a).cross(mesh.vertices[t[2]] - a).normalized();
      const auto line = touching_line(target.query_W, sample.point, normal);
      if (!line) continue;
      for (const auto& approach : approaches_about(line->axis_W, target, options.approaches)) {
        add_standoffs(*line, approach, target, options, &candidates);
      }
    }
    return candidates;
  }

 private:
  // The line between the two points at which the largest ball inside that touches the surface at
  // `p` touches it; none when they are on the same side of the ball, as at an edge.
  static std::optional<HeldLine> touching_line(const geometry::SurfaceQuery& object,
                                               const Eigen::Vector3d& p,
                                               const Eigen::Vector3d& normal) {
    const auto exit = object.cast_ray(p - kMedialSkin * normal, -normal);
    if (!exit) return std::nullopt;
    Eigen::Vector3d other = p - (exit->distance + kMedialSkin) * normal;
    double radius = (p - other).norm() / 2;
    for (int i = 0; i < kShrinkings; ++i) {
      const Eigen::Vector3d center = p - radius * normal;
      const auto nearest = object.nearest(center);
      if (!nearest || nearest->distance > radius * (1 - kTolerance)) break;
      // The ball through p, tangent to the surface there, and through the nearer point.
      const Eigen::Vector3d between = p - nearest->point;
      const double depth = between.dot(normal);
      if (!(depth > kMedialSkin)) return std::nullopt;  // a concave edge at p itself
      other = nearest->point;
      radius = between.squaredNorm() / (2 * depth);
    }
    const Eigen::Vector3d center = p - radius * normal;
    if (!((other - center).dot(normal) < -kLeastOpposition * radius)) return std::nullopt;
    return HeldLine{(p + other) / 2, (p - other).normalized(), (p - other).norm()};
  }
};

}  // namespace

CandidateGenerator* create_medial_axis() { return std::make_unique<MedialAxis>().release(); }

}  // namespace prehend::grasp
