#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

#include "prehend/grasp/generators/directions.h"
#include "prehend/grasp/generators/generators.h"
#include "prehend/grasp/generators/held_line.h"

namespace prehend::grasp {
namespace {

class BoxRays : public CandidateGenerator {
 public:
  std::string name() const override { return "boxes"; }

  std::vector<Candidate> generate(const GraspTarget& target,
                                  const GeneratorOptions& options) const override {
    // Rays along each edge of a side.
    const int grid = std::max(1, static_cast<int>(std::lround(std::sqrt(options.samples / 6.0))));
    const Eigen::Matrix3d axes = principal_axes(target.query_W.mesh());
    Eigen::AlignedBox3d box;
    for (const auto& v : target.query_W.mesh().vertices) box.extend(axes.transpose() * v);
    std::vector<Candidate> candidates;
    for (int side = 0; side < 6; ++side) {
      const int normal = side / 2, u = (normal + 1) % 3, v = (normal + 2) % 3;
      const double inward = side % 2 == 0 ? 1 : -1;
      for (int i = 0; i < grid; ++i) {
        for (int j = 0; j < grid; ++j) {
          Eigen::Vector3d start = inward > 0 ? box.min() : box.max();
          start[normal] -= inward * 0.01;  // m, outside
          start[u] = box.min()[u] + box.sizes()[u] * (i + 0.5) / grid;
          start[v] = box.min()[v] + box.sizes()[v] * (j + 0.5) / grid;
          add_ray(axes * start, inward * axes.col(normal), target, options, &candidates);
        }
      }
    }
    return candidates;
  }

 private:
  void add_ray(const Eigen::Vector3d& start_W, const Eigen::Vector3d& direction_W,
               const GraspTarget& target, const GeneratorOptions& options,
               std::vector<Candidate>* candidates) const {
    const auto hit = target.query_W.cast_ray(start_W, direction_W);
    if (!hit) return;
    Eigen::Vector3d approach = -hit->normal;
    if (const auto& fixed = target.reachability.approach_W) {
      if (approach.dot(*fixed) < std::numbers::sqrt2 / 2) return;  // more than 45 degrees off
      approach = *fixed;
    }
    const Eigen::Vector3d p_W = start_W + hit->distance * direction_W;
    const Eigen::Matrix3d frame = frame_about(approach);
    for (int roll = 0; roll < options.rolls; ++roll) {
      const double angle = std::numbers::pi * roll / options.rolls;
      const Eigen::Vector3d closing =
          std::cos(angle) * frame.col(1) - std::sin(angle) * frame.col(0);
      // The fingers come down beside what lies under the point, as wide as it is there.
      const Eigen::Vector3d below_W = p_W + options.least_engagement * approach;
      const auto line = line_through(target.query_W, below_W, closing);
      if (!line) continue;
      add_standoffs({p_W + (line->middle_W - below_W), closing, line->width}, approach, target,
                    options, candidates);
    }
  }
};

}  // namespace

CandidateGenerator* create_box_rays() { return std::make_unique<BoxRays>().release(); }

}  // namespace prehend::grasp
