#pragma once

#include <string>
#include <vector>

#include "eval/touch/stage_cycle.h"
#include "prehend/report/page.h"

// The soft-contact paper's figures 4 to 8 beside what the same experiments give here: what each
// shows, said in our words, what agrees, what differs and why. All figures come from the runs.
namespace prehend::eval::touch {

/// Something that the paper's figure shows, and what the runs say of it.
struct Comparison {
  std::string shown;  // by the paper
  std::string here;   // measured
  bool agrees = false;
};

struct PaperFigure {
  std::string number;   // "4"
  std::string subject;  // "Real pads, 30 % covered: what the texels show"
  std::string paper;    // what the paper's figure shows
  std::vector<Comparison> comparisons;
  std::string differs;              // what differs, and why
  std::vector<std::string> charts;  // SVG
  std::vector<geometry::ColorImage> pictures;
  std::vector<std::string> captions;  // of the pictures
  bool agrees() const;
};

/// A run and the share of the pads' length that was on the box.
struct CoveredCycle {
  double coverage = 0;
  StageCycle cycle;
};

/// What the figures are made of. `real`: pads and drive as they are; `simulated`: ideal ones.
struct WorkCycleRuns {
  double grip_force = 0;  // N, that the pads were to feel
  CoveredCycle real, simulated;
  std::vector<CoveredCycle> by_coverage;  // ideal, from little to much
};

PaperFigure figure_4(const WorkCycleRuns& runs);
PaperFigure figure_5(const WorkCycleRuns& runs);
PaperFigure figure_6(const WorkCycleRuns& runs);
PaperFigure figure_7(const WorkCycleRuns& runs);
/// Presses a block with a cross and a square hole once, between ideal and realistic pads.
PaperFigure figure_8();

/// The figure on the left, the paper's and the comparison on the right.
void add_figure(const PaperFigure& figure, report::Page* page);

}  // namespace prehend::eval::touch
