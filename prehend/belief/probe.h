#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "prehend/belief/object_belief.h"

namespace prehend::belief {

/// What feels the object: a fingertip, moved straight until it meets something.
struct ProbeOptions {
  double radius = 0.006;           // m, > 0, of the fingertip, a ball
  double reach = 0.08;             // m, > 0, from where it starts to where the surface is thought
  double beyond = 0.04;            // m, > 0, that it goes on when nothing is there
  double clearance = 0.004;        // m, >= 0, that it keeps to the support
  double deviation = 0.001;        // m, > 0, standard, of where it feels a contact
  double steepest_from_below = 0;  // rad, >= 0, by which it may come from below the horizontal

  void validate() const;  ///< @throws std::invalid_argument naming the field.
};

/// A straight motion of the fingertip's centre.
struct Probe {
  Eigen::Vector3d start_W = Eigen::Vector3d::Zero();  // m
  Eigen::Vector3d end_W = Eigen::Vector3d::Zero();    // m, where it stops if nothing is met
  Eigen::Vector3d at_W = Eigen::Vector3d::Zero();     // m, on the surface, where it is expected
  double gain = 0;  // m^2, see ObjectBelief::expected_gain(), per site: the mean variance it takes
};

/// The probe that would tell most of the surface: on a part of it that was not seen, along its
/// normal, free on its way as far as is believed. None when no part of it can be reached.
/// About 30 ms.
std::optional<Probe> best_probe(const ObjectBelief& belief, const ProbeOptions& options = {});

/// The same, so many at most, the best first, and each at least `apart` [m] from those before it:
/// for a hand that cannot make all of them. @throws std::invalid_argument for a count that is not
/// positive, and as best_probe().
std::vector<Probe> best_probes(const ObjectBelief& belief, int count,
                               const ProbeOptions& options = {}, double apart = 0.015);

/// What that motion found: all that the fingertip went through is empty, up to where its centre is
/// now, and there it touches the object, if it does.
void add_probe(const Probe& probe, const Eigen::Vector3d& stopped_W,
               const std::optional<Contact>& contact, double radius, ObjectBelief* belief);

}  // namespace prehend::belief
