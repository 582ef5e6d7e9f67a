#include "prehend/planning/remedy_levers.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <fmt/format.h>

#include "prehend/grasp/solid.h"

namespace prehend::planning {
namespace {

using grasp::Reason;
using Change = RemedyChange;

constexpr double kLengthStep = 1e-3;     // m, of opening and air
constexpr int kLengthSteps = 100;        // more than a hand's width helps nobody
constexpr double kForceStep = 1;         // N
constexpr int kForceSteps = 500;         // industrial grippers of this size end there
constexpr double kFrictionStep = 0.05;   //
constexpr double kMostFriction = 1.2;    // rubber on a dry, rough surface
constexpr double kMassStep = 0.05;       // of the mass
constexpr int kMassSteps = 19;           //
constexpr double kMotorStep = 0.1;       // of the torque
constexpr int kMotorSteps = 40;          //
constexpr double kWorkspaceStep = 0.01;  // m
constexpr int kWorkspaceSteps = 50;

// Of some reasons in a ledger.
class Fell {
 public:
  Fell(const std::vector<grasp::Rejection>& ledger, std::initializer_list<Reason> reasons) {
    for (const grasp::Rejection& one : ledger) {
      if (std::find(reasons.begin(), reasons.end(), one.reason) == reasons.end()) continue;
      count_ += one.count;
      if (one.miss && (!least_ || one.miss->size() < *least_)) least_ = one.miss->size();
    }
  }
  explicit operator bool() const { return count_ > 0; }
  /// Steps that make up for the nearest miss.
  int first(double step, int most) const {
    if (!least_ || !std::isfinite(*least_)) return 1;
    return static_cast<int>(std::clamp(std::ceil(*least_ / step - 1e-9), 1.0, double(most)));
  }

 private:
  int count_ = 0;
  std::optional<double> least_;
};

Lever opening_lever(const GraspCase& planned, const Fell& fell) {
  const double now = planned.hand.gripper->max_opening;
  const auto value = [now](int steps) { return now + steps * kLengthStep; };
  return {
      Change::kOpening,
      now,
      kLengthSteps,
      fell.first(kLengthStep, kLengthSteps),
      value,
      [value](int steps, GraspCase* changed) { changed->hand.gripper->max_opening = value(steps); },
      [value](int steps) {
        return fmt::format("{} mm more opening ({:.0f} mm)", steps, 1e3 * value(steps));
      }};
}

std::optional<Lever> friction_lever(const GraspCase& planned) {
  const bool pads = planned.hand.gripper.has_value();
  const double now = pads ? planned.options.pads.friction : planned.hand.friction;
  const int most = static_cast<int>(std::floor((kMostFriction - now) / kFrictionStep + 1e-9));
  if (most < 1) return std::nullopt;
  const auto value = [now](int steps) { return now + steps * kFrictionStep; };
  return Lever{Change::kFriction,
               now,
               most,
               1,
               value,
               [value, pads](int steps, GraspCase* changed) {
                 (pads ? changed->options.pads.friction : changed->hand.friction) = value(steps);
               },
               [value, now](int steps) {
                 return fmt::format("a friction of {:.2f} instead of {:.2f}", value(steps), now);
               }};
}

Lever force_lever(const GraspCase& planned, const Fell& fell) {
  const robot::GripperModel& gripper = *planned.hand.gripper;
  const auto at_current = [&gripper](double current) {
    return current * gripper.force_per_current - gripper.friction_force;
  };
  const double asked = planned.options.pads.largest_force;
  const double now = asked > 0 ? asked : at_current(gripper.nominal_current);
  const double largest = at_current(gripper.max_current);
  const double friction = planned.options.pads.friction;
  const auto value = [now](int steps) { return now + steps * kForceStep; };
  return {Change::kForce,
          now,
          kForceSteps,
          fell.first(kForceStep, kForceSteps),
          value,
          [value](int steps, GraspCase* changed) {
            changed->options.pads.largest_force = value(steps);
          },
          [=](int steps) {
            return fmt::format(
                "{} N more force of each pad at a friction of {:.2f} ({:.0f} N; the gripper's "
                "largest current gives {:.0f} N)",
                steps, friction, value(steps), largest);
          }};
}

// An object that is lighter as a whole: it was planned as a hollow one already.
Lever mass_lever(const GraspCase& planned) {
  const double density = planned.options.density * planned.options.hollow_share;
  const double now = grasp::make_solid(planned.object->mesh_W, density).mass;
  const auto share = [](int steps) { return 1 - steps * kMassStep; };
  return {Change::kMass,
          now,
          kMassSteps,
          1,
          [=](int steps) { return now * share(steps); },
          [=](int steps, GraspCase* changed) { changed->options.density = density * share(steps); },
          [=](int steps) {
            return fmt::format("{:.3g} kg instead of {:.3g} kg", now * share(steps), now);
          }};
}

Lever motors_lever(const Fell& fell) {
  const auto value = [](int steps) { return 1 + steps * kMotorStep; };
  return {
      Change::kMotors,
      1,
      kMotorSteps,
      fell.first(kMotorStep, kMotorSteps),
      value,
      [value](int steps, GraspCase* changed) {
        for (auto& joint : changed->hand.model.joints) joint.max_effort *= value(steps);
      },
      [value](int steps) { return fmt::format("{:.1f} times the motors' torque", value(steps)); }};
}

Lever air_lever(const Fell& fell) {
  return {Change::kAir,
          0,
          kLengthSteps,
          fell.first(kLengthStep, kLengthSteps),
          [](int steps) { return steps * kLengthStep; },
          [](int steps, GraspCase* changed) { changed->table_W.offset -= steps * kLengthStep; },
          [](int steps) {
            return fmt::format("{} mm of air under it (on a stand, or over the table's edge)",
                               steps);
          }};
}

Lever neighbours_lever() {
  static const grasp::Obstacles nothing;
  return {Change::kNeighbours,
          1,
          1,
          1,
          [](int) { return 0.0; },
          [](int, GraspCase* changed) { changed->obstacles = &nothing; },
          [](int) { return std::string("nothing beside it"); }};
}

Lever approach_lever(const GraspCase& planned) {
  const bool arm = static_cast<bool>(planned.options.reaches);
  return {Change::kApproach,
          0,
          arm ? 2 : 1,
          1,
          [](int steps) { return steps; },
          [](int steps, GraspCase* changed) {
            changed->reachability.approach_W.reset();
            if (steps > 1) changed->options.reaches = nullptr;
          },
          [](int steps) {
            return std::string("an approach from any side") +
                   (steps > 1 ? " by an arm that reaches it so" : "");
          }};
}

Lever workspace_lever(const Fell& fell) {
  return {Change::kWorkspace,
          0,
          kWorkspaceSteps,
          fell.first(kWorkspaceStep, kWorkspaceSteps),
          [](int steps) { return steps * kWorkspaceStep; },
          [](int steps, GraspCase* changed) {
            Eigen::AlignedBox3d& box = changed->reachability.workspace_W;
            box.min().array() -= steps * kWorkspaceStep;
            box.max().array() += steps * kWorkspaceStep;
          },
          [](int steps) {
            return fmt::format("a workspace {:.0f} mm larger on every side",
                               1e3 * steps * kWorkspaceStep);
          }};
}

}  // namespace

std::vector<Lever> levers_for(const GraspCase& planned,
                              const std::vector<grasp::Rejection>& ledger) {
  const auto fell = [&ledger](std::initializer_list<Reason> reasons) {
    return Fell(ledger, reasons);
  };
  const bool pads = planned.hand.gripper.has_value();
  const Fell heavy = fell({Reason::kTooHeavy, Reason::kTooWeak});
  // Of what is flat, pads meet nothing that far over the table.
  const Fell table = fell({Reason::kTable, Reason::kFingerTable, Reason::kNothing});
  std::vector<Lever> levers;
  if (const Fell wide = fell({Reason::kTooWide}); wide && pads) {
    levers.push_back(opening_lever(planned, wide));
  }
  if (heavy && pads) levers.push_back(force_lever(planned, heavy));
  if (heavy) levers.push_back(mass_lever(planned));
  if (heavy && !pads) levers.push_back(motors_lever(heavy));
  if (table) levers.push_back(air_lever(table));
  if (fell({Reason::kObstacle, Reason::kFingerObstacle})) levers.push_back(neighbours_lever());
  if (fell({Reason::kDirection})) levers.push_back(approach_lever(planned));
  if (const Fell out = fell({Reason::kWorkspace}); out) levers.push_back(workspace_lever(out));
  if (heavy || fell({Reason::kNotClosed})) {
    if (auto lever = friction_lever(planned)) levers.push_back(std::move(*lever));
  }
  return levers;
}

}  // namespace prehend::planning
