#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "prehend/control/failed_attempts.h"
#include "prehend/control/surprise.h"

namespace prehend::control {

/// How a motion that was started goes on.
enum class MotionStatus { kMoving, kReached, kContact, kFailed };

enum class Phase { kWaiting, kApproach, kGrasp, kLift, kMove, kRelease, kDone, kFailed };

/// "waiting", "approach", ... as in msgs.CycleState.phase.
std::string to_string(Phase phase);

struct CycleResult {
  bool success = false;
  std::string reason;   // in words, for success too
  int grasp_index = 0;  // in the list given to start(), or to take_plan() since
  int attempts = 0;
  int plans = 1;  // that were used: 1 + those taken after a new look
};

/// What every cycle tells of itself, whatever robot it moves: how far it is, what surprised it, how
/// it ended.
class Cycle {
 public:
  virtual ~Cycle() = default;

  virtual Phase phase() const = 0;
  bool finished() const { return phase() == Phase::kDone || phase() == Phase::kFailed; }
  const std::string& detail() const { return detail_; }  // in words
  int grasp_index() const { return grasp_index_; }       // as CycleResult's
  const CycleResult& result() const { return result_; }  // final once finished()
  const std::vector<Surprise>& surprises() const { return surprises_; }
  /// Seconds of each phase in the order they were entered.
  const std::vector<std::pair<std::string, double>>& phase_times() const { return phase_times_; }

  /// Set while it waits for a new plan: of what was seen at this time [s] or later.
  virtual std::optional<double> looks_since() const = 0;
  /// Stops all motion and ends as failed.
  virtual void abort(const std::string& reason) = 0;

 protected:
  explicit Cycle(const SurpriseTolerances& tolerances) : tolerances_(tolerances) {}

  /// As before the first grasp.
  void clear();
  /// The clock of the percepts goes on to `time` [s].
  void advance_to(double time);
  double now() const { return now_; }               // s
  double spent() const { return now_ - entered_; }  // s, since the present step was entered

  /// @pre phase() is already that of the new step
  void entered(const std::string& detail);
  void begin_attempt(int grasp_index);
  void add_surprise(SurpriseKind kind, double predicted, double felt, const std::string& reaction);
  /// No attempt fails as predicted: `kind` is the surprise of one that had none. `step`: how far it
  /// had come.
  void fail_attempt(int step, const std::string& reason, SurpriseKind kind,
                    const std::string& reaction);
  const std::string& failure() const { return failure_; }  // of the present attempt
  const FailedAttempts& failed_attempts() const { return failed_attempts_; }

  std::string detail_ = "waiting for a plan";
  CycleResult result_;
  std::vector<Surprise> surprises_;
  double entered_ = 0;  // s, when the present step was

 private:
  SurpriseTolerances tolerances_;
  double now_ = 0;  // s
  int grasp_index_ = 0;
  std::string failure_;
  FailedAttempts failed_attempts_;
  std::size_t attempts_surprises_ = 0;  // that there were when the attempt began
  std::vector<std::pair<std::string, double>> phase_times_;
};

}  // namespace prehend::control
