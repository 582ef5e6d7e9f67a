// A generator in a shared library: straight at the table onto the object's top, over its middle.

#include <algorithm>
#include <cmath>
#include <numbers>

#include "prehend/grasp/generators/generator.h"

namespace {

using Eigen::Vector3d;
using prehend::grasp::Candidate;
using prehend::grasp::GeneratorOptions;
using prehend::grasp::GraspTarget;

class FromTheTop final : public prehend::grasp::CandidateGenerator {
 public:
  std::string name() const override { return "from_the_top"; }

  std::vector<Candidate> generate(const GraspTarget& target,
                                  const GeneratorOptions& options) const override {
    std::vector<Candidate> candidates;
    Candidate candidate;
    const Vector3d down = candidate.approach_W = -target.table.normal;
    if (!target.reachability.reaches_direction(down)) return candidates;
    // The hand comes down over the centroid, to where a ray from above meets the object.
    const double above = target.query_W.box().diagonal().norm() + 0.01;  // m
    const auto top = target.query_W.cast_ray(target.centroid_W - above * down, down);
    if (!top) return candidates;
    const Vector3d top_W = target.centroid_W + (top->distance - above) * down;
    const double deepest = std::min(target.hand.pad_length,
                                    target.table.signed_distance(top_W) - options.table_clearance);
    const Vector3d across = down.unitOrthogonal();
    for (int roll = 0; roll < options.rolls; ++roll) {
      candidate.roll = std::numbers::pi * roll / options.rolls;
      const Vector3d closing = Eigen::AngleAxisd(candidate.roll, down) * across;
      candidate.X_WG.linear() << closing.cross(down), closing, down;
      for (int i = 1; i <= options.standoffs; ++i) {
        const Vector3d tip_W = top_W + deepest * i / options.standoffs * down;
        candidate.X_WG.translation() = tip_W - target.hand.tip_z * down;
        candidate.standoff = (target.centroid_W - tip_W).dot(down);
        candidates.push_back(candidate);
      }
    }
    return candidates;
  }
};

}  // namespace

extern "C" {

int prehend_generator_interface() { return prehend::grasp::kGeneratorInterface; }

prehend::grasp::CandidateGenerator* prehend_create_generator() { return new FromTheTop; }
}
