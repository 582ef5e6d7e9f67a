#pragma once

#include "prehend/contact/grasp_model.h"

namespace prehend::contact {

/// A box between two jaws with flat pads, the grasp of hold tests and work cycles.
struct ParallelGraspOptions {
  Eigen::Vector3d box_size{0.05, 0.05, 0.05};  // m
  double mass = 0.3;                           // kg, of the box
  double jaw_mass = 0.05;                      // kg, of each jaw
  bool coupled = false;   // one drive for both jaws; otherwise each has a slide of its own
  double opening = 0.06;  // m, between the pads' faces at the start
  PadGrid pad;
  TexelLaw law;
  double ground_friction = 0.5;
  bool on_ground = false;  // the box stands on z = 0; otherwise it floats at the origin
};

/// Frame G: y is the closing direction, the pads' rows run along z (row 0 at +z), columns along x.
/// Slide coordinates grow as jaws close: pad 0 at +y on slide 0, pad 1 at -y on slide 1 (or 0 when
/// coupled: each jaw then moves by half the coordinate and the slide's mass is half a jaw's, so
/// that its force is each jaw's). G is at the box's centre.
/// @throws std::invalid_argument for a size, mass or opening that is not positive.
GraspModel parallel_grasp(const ParallelGraspOptions& options);

}  // namespace prehend::contact
