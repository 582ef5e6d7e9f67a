#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "prehend/robot/hand_model.h"

// What a hand is told when somebody opens, closes or shapes it as a whole.
namespace prehend::control {

/// The preshape whose way of closing the hand's motors at `positions` [rad or m] are nearest to:
/// by which a hand that stands so closes. The first of several that are as near.
const robot::Preshape& nearest_preshape(const robot::HandModel& hand,
                                        const Eigen::Ref<const Eigen::VectorXd>& positions);

/// Where the motors end when the hand closes by `preshape` from `positions` without touching
/// anything: each group of motors that stop together as far as its first limit, at the preshape's
/// rates. Motors that stay in it stay.
Eigen::VectorXd closed_positions(const robot::HandModel& hand, const robot::Preshape& preshape,
                                 const Eigen::Ref<const Eigen::VectorXd>& positions);

/// The efforts [N m or N] of all motors by which each fingertip presses with `force` [N] along its
/// motors' ways, at `positions`: tau = |J^T F|, by robot::fingertip_ways(); of jaws on one motor
/// the force of both. Motors that move no fingertip get their greatest.
/// @throws std::invalid_argument for a force that is not positive, or more than a motor can, naming
/// it and how much it can.
std::vector<double> efforts_for(const robot::HandModel& hand,
                                const Eigen::Ref<const Eigen::VectorXd>& positions, double force);

/// The motor's current [A] by which a parallel gripper's fingers press with `force` [N] each.
/// @throws std::invalid_argument for a force that is not positive, or more than it can.
double current_for(const robot::GripperModel& gripper, double force);

}  // namespace prehend::control
