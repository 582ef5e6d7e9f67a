#include <cmath>
#include <numbers>
#include <random>

#include "prehend/geometry/surface_samples.h"
#include "prehend/grasp/generators/directions.h"
#include "prehend/grasp/generators/generators.h"
#include "prehend/grasp/generators/held_line.h"

namespace prehend::grasp {
namespace {

constexpr int kTriesPerSample = 8;
constexpr double kSkin = 1e-6;  // m, that a ray starts below the surface

class Antipodal : public CandidateGenerator {
 public:
  std::string name() const override { return "antipodal"; }

  std::vector<Candidate> generate(const GraspTarget& target,
                                  const GeneratorOptions& options) const override {
    std::vector<Candidate> candidates;
    const double cone = std::atan(options.friction);  // rad, half the angle
    const auto& mesh = target.query_W.mesh();
    std::mt19937_64 random(options.seed);
    const auto uniform = [&random] { return static_cast<double>(random() >> 11) * 0x1.0p-53; };
    for (const auto& sample : geometry::surface_samples(mesh, options.samples, options.seed)) {
      const auto& t = mesh.triangles[sample.triangle];
      const Eigen::Vector3d& a = mesh.vertices[t[0]];
      const Eigen::Vector3d normal =
          (mesh.vertices[t[1]] - a).cross(mesh.vertices[t[2]] - a).normalized();
      const Eigen::Matrix3d frame = frame_about(-normal);
      for (int attempt = 0; attempt < kTriesPerSample; ++attempt) {
        // Straight in first, then anywhere in the cone of friction.
        const double tilt = attempt == 0 ? 0 : cone * std::sqrt(uniform());
        const double turn = attempt == 0 ? 0 : 2 * std::numbers::pi * uniform();
        const Eigen::Vector3d direction =
            frame * Eigen::Vector3d(std::sin(tilt) * std::cos(turn),
                                    std::sin(tilt) * std::sin(turn), std::cos(tilt));
        const auto exit = target.query_W.cast_ray(sample.point + kSkin * direction, direction);
        if (!exit || !(exit->normal.dot(direction) > std::cos(cone))) continue;
        const double width = exit->distance + kSkin;
        const HeldLine line{sample.point + width / 2 * direction, direction, width};
        for (const auto& approach : approaches_about(direction, target, options.approaches)) {
          add_standoffs(line, approach, target, options, &candidates);
        }
        break;
      }
    }
    return candidates;
  }
};

}  // namespace

CandidateGenerator* create_antipodal() { return std::make_unique<Antipodal>().release(); }

}  // namespace prehend::grasp
