#pragma once

#include <map>
#include <string>
#include <vector>

#include "eval/grasp/extreme_case.h"

// Which extremes of the whole chain are run, and the maps of what came of them.
namespace prehend::eval {

/// One quantity that goes to its extremes.
struct ExtremeAxis {
  std::string name, unit;
  double ExtremeCase::*value;
  double scale = 1;  // of the unit that is shown
  std::vector<double> values;

  std::string text(std::size_t i) const;  // of a value, in the unit
};

/// Two that go there together.
struct ExtremePair {
  ExtremeAxis rows, columns;
};

/// The grid. `coarse`: the ends of each axis, for a test.
struct ExtremeGrid {
  std::vector<std::string> objects;
  std::vector<std::uint64_t> seeds;
  std::vector<ExtremeAxis> axes;   // each alone, of each object
  std::vector<ExtremePair> pairs;  // all objects in one cell

  /// Every case of it, each once.
  std::vector<ExtremeCase> cases() const;
};
ExtremeGrid extreme_grid(bool coarse);

/// Results by the case's name; a case that crashed has none.
using ExtremeResults = std::map<std::string, ExtremeResult>;

/// How many cases ended how.
struct ExtremeTotals {
  int cases = 0, crashed = 0, works = 0, refused = 0, said = 0, silent = 0;
  int sure = 0;              // had a mesh with confidence >= kConfident
  int without_a_reason = 0;  // refused, without a message

  double silent_share() const { return cases > 0 ? static_cast<double>(silent) / cases : 0; }
};
ExtremeTotals totals(const std::vector<ExtremeCase>& cases, const ExtremeResults& results);

/// The maps as one SVG, readable on any background.
std::string extremes_picture(const ExtremeGrid& grid, const ExtremeResults& results);

/// The page in Markdown, with `command` that makes it and where the picture is.
std::string extremes_page(const ExtremeGrid& grid, const ExtremeResults& results,
                          const std::string& command, const std::string& picture);

}  // namespace prehend::eval
