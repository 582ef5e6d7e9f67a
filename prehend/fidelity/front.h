#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "prehend/geometry/errors.h"

// Measured speed–accuracy fronts, and the choice of a point on one.
namespace prehend::fidelity {

/// One measured setting of a stage.
struct Setting {
  std::vector<std::pair<std::string, std::string>> knobs;  // name, value; in a fixed order
  double seconds = 0;  // that it took on the machine it was measured on, one thread
  double error = 0;    // in the front's unit
  /// What else was measured; the names are those of Front::other_errors, in their order.
  std::vector<std::pair<std::string, double>> other_errors{};
};

/// The settings of which none is both slower and less accurate than another, fastest first: along
/// it the error falls, or another of the errors.
struct Front {
  std::string subject;     // e.g. "shape"
  std::string error_name;  // what `error` measures, e.g. "mean distance of the truth to the mesh"
  std::string error_unit = "m";
  /// Name and meaning, with its unit, of what each setting says beside `error` and nothing is
  /// chosen by, e.g. "motion", "largest distance of the object [m]".
  std::vector<std::pair<std::string, std::string>> other_errors;
  std::string machine;  // on which it was measured, and how
  std::vector<Setting> settings;
};

/// A budget or tolerance that no setting of the front keeps. what() names the nearest one.
class UnreachableError : public geometry::InputError {
 public:
  UnreachableError(const std::string& thing, const std::string& mend, Setting nearest)
      : InputError(thing, mend), nearest_(std::move(nearest)) {}
  const Setting& nearest() const { return nearest_; }

 private:
  Setting nearest_;
};

/// "thinning 0.04, refine yes".
std::string to_string(const Setting& setting);

/// Those of `measured` that no other one beats in both, fastest first; of equals the first.
/// @throws std::invalid_argument when a time or error is not finite and >= 0.
std::vector<Setting> pareto_front(std::vector<Setting> measured);

/// The most accurate setting that takes at most `seconds`.
/// @throws UnreachableError naming the fastest, std::invalid_argument for an empty front or a
/// budget that is not positive.
const Setting& within_budget(const Front& front, double seconds);

/// The fastest setting whose error is at most `error` [the front's unit].
/// @throws UnreachableError naming the most accurate, std::invalid_argument as within_budget.
const Setting& within_tolerance(const Front& front, double error);

/// As within_budget() or within_tolerance(): exactly one of them is above 0.
/// @throws UnreachableError as they do, geometry::InputError when both are above 0,
/// std::invalid_argument when none is.
const Setting& choose(const Front& front, double budget, double tolerance);

/// Reads what write_front() wrote. @throws geometry::InputError naming file and key: missing or
/// foreign file, missing or unknown key, a number that is none, settings that are no front.
Front read_front(const std::filesystem::path& file);

/// Writes YAML, whole or not at all. @throws geometry::InputError when it cannot.
void write_front(const std::filesystem::path& file, const Front& front);

}  // namespace prehend::fidelity
