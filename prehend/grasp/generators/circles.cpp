#include "prehend/grasp/generators/generators.h"

namespace prehend::grasp {
namespace {

class Circles : public CandidateGenerator {
 public:
  std::string name() const override { return "circles"; }

  std::vector<Candidate> generate(const GraspTarget& target,
                                  const GeneratorOptions& options) const override {
    if (target.views != nullptr) {
      return sample_candidates(*target.views, target.centroid_W, target.table, target.hand.tip_z,
                               options.circles);
    }
    return sample_candidates(target.query_W.mesh(), target.centroid_W, target.table,
                             target.hand.tip_z, target.reachability, options.circles);
  }
};

}  // namespace

CandidateGenerator* create_circles() { return std::make_unique<Circles>().release(); }

}  // namespace prehend::grasp
