#pragma once

#include <limits>
#include <string>
#include <vector>

#include "prehend/simulation/world.h"

namespace prehend::simulation {

/// Something of a scene and how a World or RobotWorld models it.
struct ModelledPart {
  std::string what;  // "carton", "left pad", "drive", ...
  std::string how;
};

/// LeftOutPart::error of what nobody knows a bound of.
inline constexpr double kNoBound = std::numeric_limits<double>::quiet_NaN();

/// Something that a world leaves out or simplifies.
struct LeftOutPart {
  std::string what;
  std::string rule;        // field of ModelRules; empty: no model of it exists
  double error = 0;        // the error's bound, in `unit`; 0: bitwise the same; kNoBound
  std::string unit;        // "m"
  std::string error_text;  // "none: bitwise the same", "at most 12 um of sinking into the table"
  std::string why;
};

/// What a scene becomes, at its start.
struct Explanation {
  std::vector<ModelledPart> modelled;
  std::vector<LeftOutPart> left_out;
  /// Rules that are off: what they would leave out is modelled in full.
  std::vector<std::string> rules_off;
  /// What of the robot's files was read in another way than it stands there, and keys of the scene
  /// that have no effect on it.
  std::vector<std::string> remarks;
};

/// Builds the scene's world, with its robot if it has one, and tells what is in it. @throws as
/// World's and RobotWorld's constructors.
Explanation explain(const Scene& scene);

}  // namespace prehend::simulation
