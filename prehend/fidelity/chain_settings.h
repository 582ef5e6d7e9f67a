#pragma once

#include <string>

#include "prehend/fidelity/front.h"
#include "prehend/perception/segmentation.h"
#include "prehend/perception/stereo.h"

// One budget for the whole chain from images to ranked grasps: the front "chain" sets all stages at
// once, as it was measured on whole chains.
namespace prehend::fidelity {

/// What of the chain one part of the graph does; a knob of a chain has its stage's name before it,
/// as in seeing.stereo, shape.thinning, plan.samples.
enum class Stage {
  kSeeing,  // from images to segmented objects: see apply_seeing_setting()
  kShape,   // from those to meshes: shape_settings.h
  kPlan,    // from those to ranked grasps: plan_settings.h
};
const char* to_string(Stage stage);

/// What turns images into segmented objects.
struct SeeingOptions {
  int binning = 1;  // pixels of a side that are made one first, see perception/binning.h
  perception::StereoOptions stereo;
  perception::SegmentationOptions segmentation;
};

/// Sets the options that a setting chooses; all others stay as they are. Knobs (all optional):
///   stereo      semi_global | block_matching | eight_directions
///   clustering  euclidean | organized
///   search      all | narrow: disparities, see StereoOptions::narrow_search
///   binning     1 | 2 | 4; the least height of an object grows with it
/// @throws geometry::InputError naming a knob that is unknown or has a value it cannot have.
void apply_seeing_setting(const Setting& setting, SeeingOptions* options);

/// The same of a cloud, which is neither matched nor binned: its clustering alone.
void apply_seeing_setting(const Setting& setting, perception::SegmentationOptions* options);

/// The knobs that a setting of `front` has for the stage, by the stage's own names; times and
/// errors stay those of the setting. A front of that stage alone is taken as it is.
/// @throws geometry::InputError when the front is of something else, or a knob is of no stage.
Setting stage_setting(const Front& front, const Setting& setting, Stage stage);

/// Of the time of a chain's setting, what the stage took [s].
/// @throws geometry::InputError when the front does not say.
double stage_seconds(const Setting& setting, Stage stage);

/// What a setting measured, in words: "60 ms, 2.1 mm", or of a chain also what was not lifted.
std::string measured_text(const Front& front, const Setting& setting);

/// What a tolerance is of: the setting's error, of a chain that of its meshes [m].
/// @throws geometry::InputError when the front of a chain does not say.
double tolerated_error(const Front& front, const Setting& setting);

/// As choose(); but the tolerance of a chain is a length [m], of the mean distance of the true
/// surface to the mesh: the fastest setting of the front that keeps it.
/// @throws as choose().
const Setting& choose_for_stage(const Front& front, double budget, double tolerance);

}  // namespace prehend::fidelity
