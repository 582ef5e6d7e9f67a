#pragma once

#include <string>

#include "prehend/fidelity/front.h"
#include "prehend/perception/segmentation.h"
#include "prehend/perception/stereo.h"
#include "prehend/perception/table.h"

// One budget for the whole chain from images, or from a recorded cloud, to ranked grasps: a front
// "chain" sets all stages at once, as it was measured on whole chains.
namespace prehend::fidelity {

/// What of the chain one part of the graph does; a knob of a chain has its stage's name before it,
/// as in seeing.stereo, shape.thinning, plan.samples.
enum class Stage {
  kSeeing,        // from images to segmented objects: see apply_seeing_setting()
  kSegmentation,  // from a recorded cloud to those: see apply_segmentation_setting()
  kShape,         // from those to meshes: shape_settings.h
  kPlan,          // from those to ranked grasps: plan_settings.h
  kMotion,        // of the arm: planning/chain_motion.h
  kSimulation,    // of what the pads will feel: the same
};
const char* to_string(Stage stage);

/// What a chain begins with.
enum class ChainInput { kImages, kCloud };
/// "images" or "cloud".
const char* to_string(ChainInput input);
/// @throws geometry::InputError for any other word.
ChainInput chain_input(const std::string& word);
/// That makes segmented objects of it.
Stage first_stage(ChainInput input);

/// What turns images into segmented objects.
struct SeeingOptions {
  int binning = 1;  // pixels of a side that are made one first, see perception/binning.h
  perception::StereoOptions stereo;
  perception::SegmentationOptions segmentation;
  perception::TableOptions table;
  int points = 0;  // of a recorded cloud, see apply_segmentation_setting(); 0: all
};

/// Sets the options that a setting chooses; all others stay as they are. Knobs (all optional):
///   stereo      semi_global | block_matching | eight_directions
///   clustering  euclidean | organized
///   search      all | narrow: disparities, see StereoOptions::narrow_search
///   binning     1 | 2 | 4; the least height of an object grows with it
///   table_leaf  m, 0.002 to 0.05: of the voxels in which the table is looked for
/// @throws geometry::InputError naming a knob that is unknown or has a value it cannot have.
void apply_seeing_setting(const Setting& setting, SeeingOptions* options);

/// The same of a recorded cloud. Knobs (optional):
///   clustering  euclidean | organized
///   points      1000 or more, or all: of a cloud that is an image about so many are looked at, by
///               perception::binning_to()
///   table_leaf  as of seeing
/// @throws as apply_seeing_setting().
void apply_segmentation_setting(const Setting& setting, SeeingOptions* options);

/// The knobs that a setting of `front` has for the stage, by the stage's own names; times and
/// errors stay those of the setting. A front of that stage alone is taken as it is.
/// @throws geometry::InputError when the front is of something else, as of chains that begin with
/// another input, or a knob is of no stage.
Setting stage_setting(const Front& front, const Setting& setting, Stage stage);

/// Whether the chain that was measured begins with that.
bool begins_with(const Setting& setting, ChainInput input);

/// Sets what makes segmented objects of the input that a chain's setting begins with.
/// @throws geometry::InputError as what sets that stage.
void apply_first_stage(const Front& front, const Setting& setting, SeeingOptions* options);

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
