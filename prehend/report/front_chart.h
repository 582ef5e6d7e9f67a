#pragma once

#include <string>
#include <vector>

// A measured speed-accuracy front on a page, with the point that was chosen of it.
namespace prehend::report {

class Page;

struct FrontPoint {
  double seconds = 0;
  double error = 0;  // in the front's unit
  double mesh = 0;   // m, mean error of a chain's meshes; 0: not said
};

struct DrawnFront {
  std::string subject;     // "chain", "shape"
  std::string error_name;  // what the error is, in words
  std::string error_unit;  // "m" is drawn in mm, "of ..." in percent, others as they are
  std::vector<FrontPoint> points;
  std::size_t chosen = 0;  // which of the points
  double budget = 0;       // s, that was asked for; 0: none
  double tolerance = 0;    // m, of the meshes; 0: none
  std::string asked_at;    // where, as a line of a task's file; empty: by a parameter or option
  std::string measured;    // of the chosen one, in words
  std::string knobs;       // the same
};

/// What was asked for and chosen, in one sentence.
std::string front_text(const DrawnFront& front);

/// That sentence, and the error over the time as charts with the chosen point marked and
/// the budget as a line; of a chain the meshes' error beside it.
/// @throws std::invalid_argument for a front without points or a chosen one that is not there,
/// std::runtime_error as draw_line_chart().
void add_front(Page& page, const DrawnFront& front);

}  // namespace prehend::report
