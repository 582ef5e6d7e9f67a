#pragma once

#include <memory>
#include <random>
#include <string>
#include <vector>

#include "eval/belief/hand_closing.h"
#include "prehend/belief/object_belief.h"
#include "prehend/belief/probe.h"
#include "prehend/geometry/mesh_query.h"
#include "prehend/grasp/planner_options.h"

namespace prehend::eval {

/// What a belief is told of the touches.
enum class Told {
  kContacts,  // where something was touched
  kEmpty,     // and what it went through
};

/// By how much what is told is wrong, standard.
struct TouchNoise {
  double place = 0.0005;  // m, of where a contact is felt along its normal, or of the hand's root
  double normal = 0.05;   // rad, of a fingertip's contact's normal
};

/// Touches an object that is fixed where the belief wants it.
class Toucher {
 public:
  virtual ~Toucher() = default;
  /// One act, and what it found out: evidence is added, and not taken in yet.
  /// @return why there is no act; empty: there was one.
  virtual std::string touch(const geometry::MeshQuery& truth_W, Told told,
                            belief::ObjectBelief* belief) = 0;
};

/// A ball that is moved straight until it meets something, belief::best_probe().
class FingertipToucher : public Toucher {
 public:
  FingertipToucher(const TouchNoise& noise, std::uint64_t seed) : noise_(noise), random_(seed) {}
  std::string touch(const geometry::MeshQuery& truth_W, Told told,
                    belief::ObjectBelief* belief) override;

 private:
  TouchNoise noise_;
  std::mt19937_64 random_;
};

/// A hand made ready to plan grasps with.
class TouchingHand {
 public:
  /// @param name of a platform or a hand of config/robots. Of a platform's grasps only those that
  /// its arm reaches are taken.
  /// @throws geometry::InputError with the nearest name; for a hand without pads.
  explicit TouchingHand(const std::string& name);
  TouchingHand(const TouchingHand&) = delete;  // what is made ready refers to the model

  const robot::HandModel& model() const { return model_; }
  const grasp::HandToClose& to_close() const { return *to_close_; }
  const belief::HandEvidence& evidence() const { return *evidence_; }
  /// Planned on the believed shape, best first.
  std::vector<grasp::Grasp> grasps(const belief::ObjectBelief& belief) const;

 private:
  robot::HandModel model_;
  grasp::PlannerOptions options_;
  grasp::Reachability reachability_;
  std::unique_ptr<grasp::HandToClose> to_close_;
  std::unique_ptr<belief::HandEvidence> evidence_;
};

/// Closes a hand: first as the best grasp of the believed shape, then as those that touch most of
/// what is not sure.
class HandToucher : public Toucher {
 public:
  HandToucher(const TouchingHand& hand, const TouchNoise& noise, std::uint64_t seed)
      : hand_(hand), noise_(noise), random_(seed) {}
  std::string touch(const geometry::MeshQuery& truth_W, Told told,
                    belief::ObjectBelief* belief) override;

 private:
  const grasp::Grasp* chosen(const std::vector<grasp::Grasp>& grasps,
                             const belief::ObjectBelief& belief) const;

  const TouchingHand& hand_;
  TouchNoise noise_;
  std::mt19937_64 random_;
  std::vector<geometry::RigidTransform> touched_;  // X_WH of those made
};

}  // namespace prehend::eval
