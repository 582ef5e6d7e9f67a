#include "prehend/grasp/closing/closing_registry.h"

#include <cmath>
#include <stdexcept>
#include <utility>

#include "prehend/geometry/errors.h"
#include "prehend/grasp/closing/finger_closing.h"
#include "prehend/grasp/closing/pad_closing.h"

namespace prehend::grasp {
namespace {

class Pads final : public ClosingMethod {
 public:
  std::string name() const override { return "pads"; }
  std::string misfit(const robot::HandModel& hand) const override {
    return hand.gripper ? "" : "it names no parallel gripper with pads (`gripper`)";
  }
  std::unique_ptr<Closing> make(const ClosingTask& task,
                                const MakeClosing& /*built_in*/) const override {
    return std::make_unique<PadClosing>(task);
  }
};

class Fingers final : public ClosingMethod {
 public:
  std::string name() const override { return "fingers"; }
  // Whoever drives a parallel gripper asks grasps for an opening and a force.
  std::string misfit(const robot::HandModel& hand) const override {
    return hand.gripper ? "it is a parallel gripper, driven by opening and force" : "";
  }
  std::unique_ptr<Closing> make(const ClosingTask& task,
                                const MakeClosing& /*built_in*/) const override {
    return std::make_unique<FingerClosing>(task);
  }
};

std::shared_ptr<const ClosingMethod> built_in_method(const std::string& name) {
  if (name == "pads") return std::make_shared<Pads>();
  if (name == "fingers") return std::make_shared<Fingers>();
  return nullptr;
}
ClosingMethod* create_pads() { return std::make_unique<Pads>().release(); }
ClosingMethod* create_fingers() { return std::make_unique<Fingers>().release(); }

/// A plug-in's closing, whose grasps others index by the hand's motors and joints.
class ClosingHeldToItsWord final : public Closing {
 public:
  ClosingHeldToItsWord(std::string name, std::unique_ptr<Closing> plug_in,
                       const robot::HandModel& hand)
      : name_(std::move(name)), plug_in_(std::move(plug_in)), hand_(hand) {}

  HandReach reach(const robot::Preshape& preshape) const override {
    return plug_in_->reach(preshape);
  }
  std::optional<Refusal> evaluate(const Candidate& candidate, const robot::Preshape& preshape,
                                  ClosedGrasp* closed) const override {
    auto refusal = plug_in_->evaluate(candidate, preshape, closed);
    if (!refusal) require_grasp(closed->grasp);
    return refusal;
  }
  std::optional<Refusal> refine(ClosedGrasp* closed) const override {
    auto refusal = plug_in_->refine(closed);
    if (refusal) return refusal;
    require_grasp(closed->grasp);
    require(closed->grasp.closed_all.size() == static_cast<Eigen::Index>(hand_.model.joints.size()),
            "closed_all has not a position for each joint");
    return refusal;
  }
  bool bounds_score() const override { return plug_in_->bounds_score(); }
  bool same(const Grasp& a, const Grasp& b) const override { return plug_in_->same(a, b); }
  bool holds(const Grasp& grasp, const geometry::RigidTransform& X_WG,
             double friction) const override {
    return plug_in_->holds(grasp, X_WG, friction);
  }
  Eigen::VectorXd stops(const Grasp& grasp) const override {
    Eigen::VectorXd stops = plug_in_->stops(grasp);
    require(stops.size() == 0 || stops.size() == hand_.size(), "stops have not one for each motor");
    return stops;
  }
  std::span<const Reason> stages() const override { return plug_in_->stages(); }
  std::string too_wide(double narrowest) const override { return plug_in_->too_wide(narrowest); }
  std::string explain(Reason reason) const override { return plug_in_->explain(reason); }

 private:
  void require(bool is_so, const char* otherwise) const {
    if (!is_so) {
      throw std::runtime_error("closing '" + name_ + "', a plug-in: its grasp's " + otherwise);
    }
  }
  void require_grasp(const Grasp& grasp) const {
    require(grasp.X_WG.matrix().allFinite() && grasp.X_WH.matrix().allFinite(),
            "X_WG or X_WH is no pose");
    require(grasp.open.size() == hand_.size(), "open has not a position for each motor");
    require(grasp.closed.size() == hand_.size(), "closed has not a position for each motor");
    require(std::isfinite(grasp.score), "score is no number");
  }

  std::string name_;
  std::unique_ptr<Closing> plug_in_;
  const robot::HandModel& hand_;
};

class MethodHeldToItsWord final : public ClosingMethod {
 public:
  explicit MethodHeldToItsWord(std::unique_ptr<ClosingMethod> plug_in)
      : plug_in_(std::move(plug_in)) {}
  std::string name() const override { return plug_in_->name(); }
  std::string misfit(const robot::HandModel& hand) const override { return plug_in_->misfit(hand); }
  std::unique_ptr<Closing> make(const ClosingTask& task,
                                const MakeClosing& built_in) const override {
    std::unique_ptr<Closing> closing = plug_in_->make(task, built_in);
    if (!closing) throw std::runtime_error("closing '" + name() + "', a plug-in, makes nothing");
    return std::make_unique<ClosingHeldToItsWord>(name(), std::move(closing), *task.hand.hand);
  }

 private:
  std::unique_ptr<ClosingMethod> plug_in_;
};

/// @throws std::invalid_argument as a misfit's words.
std::unique_ptr<Closing> make_built_in(const std::string& name, const ClosingTask& task) {
  const auto method = built_in_method(name);
  if (!method) throw std::invalid_argument("there is no closing '" + name + "' built in");
  const std::string misfit = method->misfit(*task.hand.hand);
  if (!misfit.empty()) {
    throw std::invalid_argument("hand '" + task.hand.hand->name + "' cannot close by '" + name +
                                "': " + misfit);
  }
  return method->make(task, make_built_in);
}

}  // namespace

ClosingRegistry::ClosingRegistry() : ClosingRegistry(text::plug_in_folders("closing")) {}

ClosingRegistry::ClosingRegistry(const std::vector<std::filesystem::path>& folders)
    : methods_("closing", kClosingInterface, folders,
               {{"pads", create_pads}, {"fingers", create_fingers}}) {}

std::shared_ptr<const ClosingMethod> ClosingRegistry::create(const std::string& name) const {
  std::unique_ptr<ClosingMethod> method(methods_.find(name)());
  if (built_in_method(name)) return method;
  return std::make_shared<MethodHeldToItsWord>(std::move(method));
}

std::shared_ptr<const ClosingMethod> closing_method(const robot::HandModel& hand) {
  const std::string name = hand.closing_method();
  std::shared_ptr<const ClosingMethod> method = built_in_method(name);
  if (!method) {
    try {
      method = ClosingRegistry().create(name);
    } catch (const std::invalid_argument& error) {
      throw geometry::InputError("hand '" + hand.name + "': " + error.what(),
                                 "Correct `closing` in its file, or name its plug-in's folder in "
                                 "PREHEND_CLOSINGS");
    }
  }
  const std::string misfit = method->misfit(hand);
  if (misfit.empty()) return method;
  throw geometry::InputError("hand '" + hand.name + "' cannot close by '" + name + "': " + misfit,
                             "Correct `closing` in its file, or leave it out");
}

std::unique_ptr<Closing> make_closing(const ClosingTask& task) {
  return task.hand.method->make(task, make_built_in);
}

}  // namespace prehend::grasp
