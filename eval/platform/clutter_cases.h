#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "eval/data_sets.h"
#include "eval/view_segmentation.h"
#include "prehend/simulation/clutter_scene.h"

namespace prehend::eval {

/// The bodies of `sets` that stand alone, as they rest: no larger than 0.2 m, and narrow enough for
/// jaws that open by `widest` [m], across one horizontal direction. Masses as
/// simulation::mass_of_volume() says.
/// @throws geometry::InputError when no set will do.
std::vector<simulation::ClutterSolid> clutter_solids(const std::vector<DataSet>& sets,
                                                     double widest);

/// A scene that is told by its number.
struct ClutterCase {
  std::string name;  // "scene_007_stacked"
  std::string kind;  // apart, touching, stacked, leaning, hidden, tumbled, mixed
  simulation::ClutterOptions options;
  double varied = 0;  // of camera, light and noise
};

/// `count` of them: 1 to 12 bodies by turns, each kind as often as the others, on the part of the
/// table where the task clear_table puts nothing.
std::vector<ClutterCase> clutter_cases(int count, std::uint64_t seed);

/// Makes the case's scene, looks at it by that sensor, and segments it. Its group is the kind.
ViewSegmentation clutter_view(const ClutterCase& one,
                              const std::vector<simulation::ClutterSolid>& solids,
                              DepthSensor sensor,
                              const perception::SegmentationOptions& segmentation = {});

}  // namespace prehend::eval
