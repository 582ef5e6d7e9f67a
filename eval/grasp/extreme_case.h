#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "eval/case_result.h"
#include "eval/data_sets.h"
#include "eval/grasp/platform_under_test.h"

// The whole chain on one depth picture that is far from the usual in some way.
namespace prehend::eval {

/// What is seen, and what is grasped. The defaults are the middle from which one value, or two, go
/// to an extreme.
struct ExtremeCase {
  std::string object = "can";  // of household_objects()
  double size = 0.1;           // m, its longest side, to which it is scaled
  double points = 3e5;         // of the whole picture, which is 4 : 3 and 50 degrees wide
  double distance = 0.7;       // m from the camera to the object's middle
  double noise = 0.001;        // m, standard deviation of each depth
  double outliers = 0;         // share of the pixels whose depth is 0.5 to 1.5 times the true one
  double tilt = 0;             // degrees of the table against what the camera's pose says is level
  double elevation = 40;       // degrees of the camera over the table
  double mass = 0.2;           // kg
  double friction = 0.7;       // dynamic, of the object with the pads
  std::uint64_t seed = 1;      // of noise, outliers, textures, and of the turn on the table

  /// All of it: unique and fit for a file name.
  std::string name() const;
};

/// How a case ended.
enum class ExtremeOutcome {
  kWorks,    // the mesh is right and the object was lifted, carried and put down
  kRefused,  // nothing was found, predicted or planned, with its reason
  kSaid,     // the mesh is wrong with low confidence, or the grasp failed and the cycle says so
  kSilent,   // the mesh is wrong with confidence, or it was dropped while success was said
};
const char* to_string(ExtremeOutcome outcome);

/// From this confidence on a mesh that is wrong counts as wrong in silence.
inline constexpr double kConfident = 0.9;

struct ExtremeResult {
  ExtremeOutcome outcome = ExtremeOutcome::kRefused;
  std::string stage;    // that refused, or where it went wrong: "view", "shape", "plan" ...
  std::string message;  // why, in words; empty when it works
  double confidence = kUnknown;
  double mesh_error = kUnknown;  // m, mean, of the two directions the larger
  bool planned = false, lifted = false;
  double see_seconds = 0;    // of processor: table, segmentation
  double rest_seconds = 0;   // of processor: shape, mesh, plan, simulation
  double memory = kUnknown;  // bytes, the most that the process had in this case
};

/// The largest mesh_error of a right mesh of an object of that size [m]: 5 mm; of one under 50 mm a
/// tenth of its size, of one over 100 mm a twentieth.
double right_within(double size);

/// What the rest of the result comes to, for an object of that size [m].
ExtremeOutcome outcome_of(const ExtremeResult& result, double size);

/// Renders the depth picture and runs what ships on it: table and segmentation, completion with its
/// confidence, mesh, plan, and the cycle in simulation. The camera's pose is known; where the table
/// is tilted, up is not its normal, but the platform stands on it and weight pulls along its
/// normal. Where no object has the truth's pixels, the largest that was found is taken for it.
/// @throws geometry::InputError for an object that household_objects() has not.
ExtremeResult run_extreme_case(const ExtremeCase& extreme, const PlatformUnderTest& platform);

/// As YAML, and back. @throws geometry::InputError for a text that is no result.
std::string to_text(const ExtremeResult& result);
ExtremeResult read_extreme_result(const std::string& text);

}  // namespace prehend::eval
