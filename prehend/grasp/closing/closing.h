#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>

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
  // Of an object that is wider by the prediction than what fits into the open hand, closed on in
  // case the prediction is wrong: its width, and what fits.
  std::optional<Miss> too_wide;
};

/// What a hand is closed on, and how. All of it outlives the closing.
struct ClosingTask {
  const Solid& solid;                     // the object, or what it may be instead
  const geometry::SurfaceQuery& query_W;  // its surface
  geometry::Plane table;
  const Obstacles& obstacles;
  const HandToClose& hand;
  const Reachability& reachability;
  const PlannerOptions& options;  // validated
};

/// A hand that closes on one solid. Const calls may run at once. Pure virtual where it is not
/// inline, so that closings in shared libraries need nothing of prehend linked to them.
class Closing {
 public:
  virtual ~Closing() = default;

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
  /// rad or m, of the motors, where they stop when the grasp is executed as it is; empty: the hand
  /// meets nothing, or it cannot be told.
  virtual Eigen::VectorXd stops(const Grasp& /*grasp*/) const { return {}; }
  /// Its reasons in the order of its tests: who fails late was nearly a grasp.
  virtual std::span<const Reason> stages() const = 0;
  /// Says that nothing of this outline's width [m], its narrowest, fits into the hand; empty: it
  /// does, or is not known.
  virtual std::string too_wide(double /*narrowest*/) const { return ""; }
  /// The reason in words with figures; empty: to_string() of it says all.
  virtual std::string explain(Reason /*reason*/) const { return ""; }
};

/// Makes a closing that is built in.
using MakeClosing =
    std::function<std::unique_ptr<Closing>(const std::string& name, const ClosingTask& task)>;

/// A method of closing hands, chosen by name in a hand's file (`closing`). Recipe for another one:
/// README.md of prehend/grasp.
class ClosingMethod {
 public:
  virtual ~ClosingMethod() = default;
  virtual std::string name() const = 0;  // by which it is chosen: "fingers"
  /// Why this hand cannot close so ("it has no pads"); empty: it can.
  virtual std::string misfit(const robot::HandModel& hand) const = 0;
  /// @param built_in makes those that are built in, for methods that change what these do.
  /// @pre misfit(*task.hand.hand) is empty.
  virtual std::unique_ptr<Closing> make(const ClosingTask& task,
                                        const MakeClosing& built_in) const = 0;
};

/// Of ClosingMethod, Closing and what they are given: a plug-in that was built for another one is
/// not loaded.
constexpr int kClosingInterface = 4;

}  // namespace prehend::grasp
