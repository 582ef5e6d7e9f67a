// A generator and a method of closing that do not keep what they promise.

#include <limits>

#include "prehend/grasp/closing/closing.h"
#include "prehend/grasp/generators/generator.h"

namespace {

using namespace prehend::grasp;

class NoPoses final : public CandidateGenerator {
 public:
  std::string name() const override { return "no_poses"; }
  std::vector<Candidate> generate(const GraspTarget& /*target*/,
                                  const GeneratorOptions& options) const override {
    std::vector<Candidate> candidates(2);
    Candidate& last = candidates.back();
    last.X_WG.linear() = Eigen::Vector3d(1, -1, -1).asDiagonal();
    if (options.seed == 1) last.X_WG.translation().x() = std::numeric_limits<double>::quiet_NaN();
    candidates.front().X_WG.linear() = last.X_WG.linear();
    if (options.seed == 2) last.X_WG.linear() *= 1.01;
    if (options.seed == 3) last.approach_W = Eigen::Vector3d::UnitX();
    return candidates;
  }
};

/// Takes every candidate for a grasp, and says nothing of it.
class Everything final : public Closing {
 public:
  HandReach reach(const prehend::robot::Preshape& /*preshape*/) const override { return {}; }
  std::optional<Refusal> evaluate(const Candidate& /*candidate*/,
                                  const prehend::robot::Preshape& /*preshape*/,
                                  ClosedGrasp* /*closed*/) const override {
    return std::nullopt;
  }
  std::optional<Refusal> refine(ClosedGrasp* /*closed*/) const override { return std::nullopt; }
  bool bounds_score() const override { return true; }
  bool same(const Grasp& /*a*/, const Grasp& /*b*/) const override { return false; }
  bool holds(const Grasp& /*grasp*/, const prehend::geometry::RigidTransform& /*X_WG*/,
             double /*friction*/) const override {
    return true;
  }
  std::span<const Reason> stages() const override { return {}; }
};

class EverythingMethod final : public ClosingMethod {
 public:
  std::string name() const override { return "everything"; }
  std::string misfit(const prehend::robot::HandModel& /*hand*/) const override { return ""; }
  std::unique_ptr<Closing> make(const ClosingTask& /*task*/,
                                const MakeClosing& /*built_in*/) const override {
    return std::make_unique<Everything>();
  }
};

}  // namespace

extern "C" {

int prehend_generator_interface() { return kGeneratorInterface; }
CandidateGenerator* prehend_create_generator() { return new NoPoses; }
int prehend_closing_interface() { return kClosingInterface; }
ClosingMethod* prehend_create_closing() { return new EverythingMethod; }
}
