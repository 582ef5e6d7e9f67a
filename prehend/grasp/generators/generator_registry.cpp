#include "prehend/grasp/generators/generator_registry.h"

#include <algorithm>
#include <iterator>
#include <stdexcept>
#include <utility>

#include "prehend/grasp/generators/generators.h"

namespace prehend::grasp {
namespace {

using CreateGenerator = text::NamedPlugIns<CandidateGenerator>::Create;
constexpr std::pair<const char*, CreateGenerator> kGenerators[] = {
    {"circles", create_circles},         {"segments", create_segments},
    {"boxes", create_box_rays},          {"antipodal", create_antipodal},
    {"medial_axis", create_medial_axis},
};

CreateGenerator built_in(const std::string& name) {
  const auto found = std::find_if(std::begin(kGenerators), std::end(kGenerators),
                                  [&](const auto& entry) { return entry.first == name; });
  return found == std::end(kGenerators) ? nullptr : found->second;
}

/// What is wrong with a candidate that a hand should be put at; empty: nothing.
std::string fault_of(const Candidate& candidate) {
  constexpr double kOff = 1e-6;
  const Eigen::Matrix3d R = candidate.X_WG.linear();
  if (!candidate.X_WG.matrix().allFinite() || !candidate.approach_W.allFinite() ||
      (R.transpose() * R - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() > kOff ||
      R.determinant() < 0) {
    return "X_WG is no pose";
  }
  if ((R.col(2) - candidate.approach_W).cwiseAbs().maxCoeff() > kOff) {
    return "approach_W is not the z axis of X_WG";
  }
  return "";
}

class HeldToItsWord final : public CandidateGenerator {
 public:
  explicit HeldToItsWord(std::unique_ptr<CandidateGenerator> plug_in)
      : plug_in_(std::move(plug_in)) {}
  std::string name() const override { return plug_in_->name(); }
  std::vector<Candidate> generate(const GraspTarget& target,
                                  const GeneratorOptions& options) const override {
    std::vector<Candidate> candidates = plug_in_->generate(target, options);
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      const std::string fault = fault_of(candidates[i]);
      if (fault.empty()) continue;
      throw std::runtime_error("generator '" + name() + "', a plug-in: candidate " +
                               std::to_string(i) + ": " + fault);
    }
    return candidates;
  }

 private:
  std::unique_ptr<CandidateGenerator> plug_in_;
};

}  // namespace

GeneratorRegistry::GeneratorRegistry() : GeneratorRegistry(text::plug_in_folders("generator")) {}

GeneratorRegistry::GeneratorRegistry(const std::vector<std::filesystem::path>& folders)
    : generators_("generator", kGeneratorInterface, folders,
                  {std::begin(kGenerators), std::end(kGenerators)}) {}

std::unique_ptr<CandidateGenerator> GeneratorRegistry::create(const std::string& name) const {
  std::unique_ptr<CandidateGenerator> generator(generators_.find(name)());
  if (built_in(name) != nullptr) return generator;
  return std::make_unique<HeldToItsWord>(std::move(generator));
}

std::unique_ptr<CandidateGenerator> make_generator(const std::string& name) {
  if (const CreateGenerator create = built_in(name)) {
    return std::unique_ptr<CandidateGenerator>(create());
  }
  return GeneratorRegistry().create(name);
}

}  // namespace prehend::grasp
