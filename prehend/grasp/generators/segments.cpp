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
  explicit Segments(const GeneratorOptions& options) : options_(options) {}

  std::vector<Candidate> generate(const GraspTarget& target) const override {
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
      for (int roll = 0; roll < options_.rolls; ++roll) {
        const double angle = std::numbers::pi * roll / options_.rolls;
        const Eigen::Vector3d axis = std::cos(angle) * axes.col(1) + std::sin(angle) * axes.col(2);
        const auto line = line_through(target.query_W, p_W, axis);
        if (!line) continue;
        for (const auto& approach : approaches_about(axis, target, options_.approaches)) {
          add_standoffs(*line, approach, target, options_, &candidates);
        }
      }
    }
    return candidates;
  }

 private:
  GeneratorOptions options_;
};

}  // namespace

std::unique_ptr<CandidateGenerator> make_segments(const GeneratorOptions& options) {
  return std::make_unique<Segments>(options);
}

}  // namespace prehend::grasp
