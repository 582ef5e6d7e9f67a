#pragma once

#include <optional>
#include <string>
#include <vector>

namespace prehend::control {

/// One thing that a cycle relies on: a sensor's data, a device's state, the server of a motion.
struct InputAge {
  std::string name;           // in words: "the gripper's state"
  std::optional<double> age;  // s, of the newest word of it, by the cycle's clock; unset: none came
  double limit = 0;           // s, > 0, beyond which it counts as lost
};

/// Those that have not come or are older than their limit. An age below minus the limit is not
/// fresh either: clocks disagree, and nothing says how old that input is.
std::vector<InputAge> stale_inputs(const std::vector<InputAge>& inputs);
/// "the wrist's force (0.31 s old, at most 0.25 s), the carrier's state (nothing has come)".
std::string describe(const std::vector<InputAge>& stale);
/// The same without ages: "the wrist's force, the carrier's state".
std::string names_of(const std::vector<InputAge>& inputs);

/// Tells when a cycle has lost what it relies on, so that nothing moves on old data.
///
/// An input is lost when its age exceeds its limit. Two things are no loss: an input that is old
/// when the watch begins gets its limit from then on, and while the cycle's own process is held up,
/// or stalls again and again, inputs may be older by that, as the clock is heard before what waits
/// with it: by the last stall, or by several up to four times the shortest limit, until steps have
/// been on time for as long as that limit. What has never come is lost at once.
class InputWatch {
 public:
  /// The cycle moves from `now` [s] on.
  void begin(double now);
  /// What is lost at `now` [s]; empty: go on. Call it once a step.
  std::vector<InputAge> lost(double now, const std::vector<InputAge>& inputs);

 private:
  void note_stall(double now, double shortest_limit);

  double begun_ = 0;       // s
  double last_ = 0;        // s, of the step before
  double stalled_ = 0;     // s, by which inputs may be older
  double last_stall_ = 0;  // s, when the last one ended
};

}  // namespace prehend::control
