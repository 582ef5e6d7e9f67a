#include "prehend/grasp/generators/generators.h"

namespace prehend::grasp {
namespace {

class Circles : public CandidateGenerator {
 public:
  explicit Circles(const GeneratorOptions& options) : options_(options.circles) {}

  std::vector<Candidate> generate(const GraspTarget& target) const override {
    if (target.views != nullptr) {
      return sample_candidates(*target.views, target.centroid_W, target.table, target.hand.tip_z,
                               options_);
    }
    return sample_candidates(target.query_W.mesh(), target.centroid_W, target.table,
                             target.hand.tip_z, target.reachability, options_);
  }

 private:
  CandidateOptions options_;
};

}  // namespace

std::unique_ptr<CandidateGenerator> make_circles(const GeneratorOptions& options) {
  return std::make_unique<Circles>(options);
}

}  // namespace prehend::grasp
