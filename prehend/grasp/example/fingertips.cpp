// A method of closing in a shared library: the built-in fingers, where generators ask no deeper
// than half a pad, and only where nothing but the last links touches.

#include <algorithm>

#include "prehend/grasp/closing/closing.h"

namespace {

using prehend::grasp::Candidate;
using prehend::grasp::ClosedGrasp;
using prehend::grasp::Closing;
using prehend::grasp::ClosingTask;
using prehend::grasp::Grasp;
using prehend::grasp::GraspContact;
using prehend::grasp::HandReach;
using prehend::grasp::MakeClosing;
using prehend::grasp::Reason;
using prehend::grasp::Refusal;
using prehend::robot::HandModel;
using prehend::robot::Preshape;

class ClosingByTips final : public Closing {
 public:
  ClosingByTips(std::unique_ptr<Closing> fingers, const HandModel& hand)
      : fingers_(std::move(fingers)), hand_(hand) {
    const std::span<const Reason> before = fingers_->stages();
    stages_.assign(before.begin(), before.end());
    stages_.push_back(Reason::kFinger);
  }

  HandReach reach(const Preshape& preshape) const override {
    HandReach reach = fingers_->reach(preshape);
    reach.pad_length /= 2;
    return reach;
  }
  std::optional<Refusal> evaluate(const Candidate& candidate, const Preshape& preshape,
                                  ClosedGrasp* closed) const override {
    if (auto refusal = fingers_->evaluate(candidate, preshape, closed)) return refusal;
    const auto is_at_tip = [&](const GraspContact& contact) {
      return contact.finger >= 0 &&
             hand_.fingers[static_cast<std::size_t>(contact.finger)].links.back() == contact.link;
    };
    const auto& contacts = closed->grasp.contacts;
    if (std::all_of(contacts.begin(), contacts.end(), is_at_tip)) return std::nullopt;
    return Refusal{Reason::kFinger, {}};
  }
  std::optional<Refusal> refine(ClosedGrasp* closed) const override {
    return fingers_->refine(closed);
  }
  bool bounds_score() const override { return fingers_->bounds_score(); }
  bool same(const Grasp& a, const Grasp& b) const override { return fingers_->same(a, b); }
  bool holds(const Grasp& grasp, const prehend::geometry::RigidTransform& X_WG,
             double friction) const override {
    return fingers_->holds(grasp, X_WG, friction);
  }
  Eigen::VectorXd stops(const Grasp& grasp) const override { return fingers_->stops(grasp); }
  std::span<const Reason> stages() const override { return stages_; }
  std::string explain(Reason reason) const override {
    return reason == Reason::kFinger ? "more than fingertips would touch it" : "";
  }

 private:
  std::unique_ptr<Closing> fingers_;
  const HandModel& hand_;
  std::vector<Reason> stages_;
};

class Fingertips final : public prehend::grasp::ClosingMethod {
 public:
  std::string name() const override { return "fingertips"; }
  std::string misfit(const HandModel& hand) const override {
    return hand.gripper ? "it closes by pads, and has no fingertips" : "";
  }
  std::unique_ptr<Closing> make(const ClosingTask& task,
                                const MakeClosing& built_in) const override {
    return std::make_unique<ClosingByTips>(built_in("fingers", task), *task.hand.hand);
  }
};

}  // namespace

extern "C" {

int prehend_closing_interface() { return prehend::grasp::kClosingInterface; }

prehend::grasp::ClosingMethod* prehend_create_closing() { return new Fingertips; }
}
