#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "prehend/grasp/generators/generators.h"
#include "prehend/grasp/generators/held_line.h"

namespace prehend::grasp {
namespace {

constexpr int kStations = 5;  // along the longest axis

class Segments : public CandidateGenerator {
 public:
  std::string name() const override { return "segments"; }

  std::vector<Candidate> generate(const GraspTarget& target,
                                  const GeneratorOptions& options) const override {
    const Eigen::Matrix3d axes = principal_axes(target.query_W.mesh());
    double lower = std::numeric_limits<double>::infinity(), upper = -lower;
    for (const auto& v : target.query_W.mesh().vertices) {
      const double along = axes.col(0).dot(v - target.centroid_W);
      lower = std::min(lower, along);
      upper = std::max(upper, along);
    }
    std::vector<Candidate> candidates;
    for (int station = 0; station < kStations; ++station) {
      const double share = (station + 1.0) / (kStations + 1);
      const Eigen::Vector3d p_W =
          target.centroid_W + (lower + share * (upper - lower)) * axes.col(0);
      for (int roll = 0; roll < options.rolls; ++roll) {
        const double angle = std::numbers::pi * roll / options.rolls;
        const Eigen::Vector3d axis = std::cos(angle) * axes.col(1) + std::sin(angle) * axes.col(2);
        const auto line = line_through(target.query_W, p_W, axis);
        if (!line) continue;
        for (const auto& approach : approaches_about(axis, target, options.approaches)) {
          add_standoffs(*line, approach, target, options, &candidates);
        }
      }
    }
    return candidates;
  }
};

}  // namespace

CandidateGenerator* create_segments() { return std::make_unique<Segments>().release(); }

}  // namespace prehend::grasp
