#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "prehend/geometry/mesh_query.h"
#include "prehend/geometry/plane.h"
#include "prehend/grasp/grasp.h"
#include "prehend/grasp/planner_options.h"
#include "prehend/grasp/solid.h"

namespace prehend::grasp {

/// A candidate that a hand has closed on, and what its closing keeps to refine it.
struct ClosedGrasp {
  Grasp grasp;
  std::shared_ptr<const void> kept;
};

/// A way to close a hand, on one solid: the object that is planned on, or what it may be instead.
/// Const calls may run at once. Adding one: a file here, and a line in closing.cpp.
class Closing {
 public:
  explicit Closing(Solid solid) : solid_(std::move(solid)), query_(solid_.mesh_W) {}
  virtual ~Closing() = default;

  const Solid& solid() const { return solid_; }
  const geometry::MeshQuery& query() const { return query_; }

  /// What a generator must know of the hand in a preshape.
  virtual HandReach reach(const robot::Preshape& preshape) const = 0;
  /// Closes the hand at the candidate. Fills `closed`, with a score, unless there is a reason not
  /// to.
  virtual std::optional<Refusal> evaluate(const Candidate& candidate,
                                          const robot::Preshape& preshape,
                                          ClosedGrasp* closed) const = 0;
  /// Quality, forces, contacts and score as they are, which takes many times as long as all else.
  virtual std::optional<Refusal> refine(ClosedGrasp* closed) const = 0;
  /// Whether the score of evaluate() is never below that of refine().
  virtual bool bounds_score() const = 0;
  /// Whether two grasps come to the same, so that one of them is enough.
  virtual bool same(const Grasp& a, const Grasp& b) const = 0;
  /// Whether the grasp, executed with the tool at `X_WG` instead, holds the solid with `friction`:
  /// the open hand meets nothing on its way, closes, and carries the weight.
  virtual bool holds(const Grasp& grasp, const geometry::RigidTransform& X_WG,
                     double friction) const = 0;
  /// Its reasons in the order of its tests: who fails late was nearly a grasp.
  virtual std::span<const Reason> stages() const = 0;
  /// Says that nothing of this outline's width [m], its narrowest, fits into the hand; empty: it
  /// does, or is not known.
  virtual std::string too_wide(double /*narrowest*/) const { return ""; }
  /// The reason in words with this hand's figures; empty: it has none.
  virtual std::string explain(Reason /*reason*/) const { return ""; }

 private:
  Solid solid_;
  geometry::MeshQuery query_;
};

/// The way of this hand: "pads" (pad_closing.h) of a parallel gripper with pads, else "fingers"
/// (finger_closing.h). Refers to hand and options, which are validated.
std::unique_ptr<Closing> make_closing(Solid solid, const geometry::Plane& table,
                                      const Obstacles& obstacles, const HandToClose& hand,
                                      const Reachability& reachability,
                                      const PlannerOptions& options);

}  // namespace prehend::grasp
