#include "eval/touch/felt.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "prehend/text/require.h"

namespace prehend::eval::touch {
namespace {

void check_frame(const PadFrame& frame) {
  const text::Require require{"image_distance: "};
  require(frame.rows > 0 && frame.columns > 0 &&
              frame.force.size() ==
                  static_cast<std::size_t>(frame.rows) * static_cast<std::size_t>(frame.columns),
          "a frame must have rows * columns forces");
}

// A stretch of the pad's side on which neither grid has an edge.
struct Stretch {
  int a, b;      // the grids' cells there
  double share;  // of the side
};

// Cells are counted on the side divided into m * n parts, so that no edge is rounded.
std::vector<Stretch> common_stretches(int m, int n) {
  std::vector<Stretch> stretches;
  const long whole = static_cast<long>(m) * n;
  for (long at = 0; at < whole;) {
    const long i = at / n, k = at / m;
    const long next = std::min((i + 1) * n, (k + 1) * m);
    stretches.push_back({static_cast<int>(i), static_cast<int>(k),
                         static_cast<double>(next - at) / static_cast<double>(whole)});
    at = next;
  }
  return stretches;
}

double at(const PadFrame& frame, int row, int column) {
  return frame.force[static_cast<std::size_t>(row) * static_cast<std::size_t>(frame.columns) +
                     static_cast<std::size_t>(column)];
}

// Not a number where either is none: a run that diverged must not be passed over.
double larger(double a, double b) { return std::isnan(a) || a > b ? a : b; }

}  // namespace

double PadFrame::sum() const { return std::accumulate(force.begin(), force.end(), 0.0); }

double image_distance(const PadFrame& a, const PadFrame& b) {
  check_frame(a);
  check_frame(b);
  double distance = 0;
  const std::vector<Stretch> across = common_stretches(a.columns, b.columns);
  for (const Stretch& row : common_stretches(a.rows, b.rows)) {
    for (const Stretch& column : across) {
      // The face counts as of area 1.
      const double p_a = at(a, row.a, column.a) * a.rows * a.columns;
      const double p_b = at(b, row.b, column.b) * b.rows * b.columns;
      distance += row.share * column.share * std::abs(p_a - p_b);
    }
  }
  return distance;
}

bool FeltError::is_finite() const {
  return std::isfinite(image) && std::isfinite(sum) && std::isfinite(largest) &&
         std::isfinite(motion);
}

FeltError felt_error(const FeltRun& run, const FeltRun& reference) {
  const text::Require require{"felt_error: "};
  require(run.frames.size() == reference.frames.size() && run.path.size() == reference.path.size(),
          "the runs must have the same instants");
  double scale = 0;
  for (const auto& frame : reference.frames) {
    for (const PadFrame& pad : frame) scale = std::max(scale, pad.sum());
  }
  require(scale > 0 || reference.frames.empty(), "the reference must feel something");
  FeltError error;
  double images = 0, sums = 0, felt = 0;
  for (std::size_t i = 0; i < run.frames.size(); ++i) {
    require(run.frames[i].size() == reference.frames[i].size(), "the runs must have the same pads");
    for (std::size_t pad = 0; pad < run.frames[i].size(); ++pad) {
      const PadFrame &a = run.frames[i][pad], &b = reference.frames[i][pad];
      const double image = image_distance(a, b) / scale;
      if (a.sum() == 0 && b.sum() == 0) continue;
      const double sum = (a.sum() - b.sum()) / scale;
      images += image * image;
      sums += sum * sum;
      felt += 1;
      error.largest = larger(error.largest, image);
    }
  }
  error.image = std::sqrt(images / std::max(felt, 1.0));
  error.sum = std::sqrt(sums / std::max(felt, 1.0));
  for (std::size_t i = 0; i < run.path.size(); ++i) {
    error.motion = larger(error.motion, (run.path[i] - reference.path[i]).norm());
  }
  return error;
}

FeltError worst(const FeltError& a, const FeltError& b) {
  return {larger(a.image, b.image), larger(a.sum, b.sum), larger(a.largest, b.largest),
          larger(a.motion, b.motion)};
}

}  // namespace prehend::eval::touch
