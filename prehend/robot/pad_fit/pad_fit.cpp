#include "prehend/robot/pad_fit/pad_fit.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <Eigen/Cholesky>

#include "prehend/contact/pad_layout.h"
#include "prehend/geometry/errors.h"

namespace prehend::robot {
namespace {

using geometry::InputError;

constexpr double kLeastShare = 0.1;  // of the log's largest force: rows that count
constexpr std::size_t kLeastRows = 20;
constexpr double kAnswers = 5;  // deviations of a slope that is one

// One texel's counts = slope * force + lag * force rate + zero.
struct Line {
  bool is_there = false;
  double slope = 0, deviation = 0;  // counts/N of the texel
  double zero = 0;                  // counts
  double lag = 0;                   // s
  double noise = 0;                 // counts
};

// Of white noise second differences have 6 times the variance; rounding adds a twelfth. Where the
// press begins and ends they are no noise: beyond 4 deviations, by the median.
double noise_of(std::vector<double> jumps) {
  const auto middle = jumps.begin() + static_cast<std::ptrdiff_t>(jumps.size() / 2);
  std::nth_element(jumps.begin(), middle, jumps.end());
  const double most = 4 * std::max(1.0, *middle / 0.6745);
  double square = 0, rows = 0;
  for (const double jump : jumps) {
    if (jump > most) continue;
    square += jump * jump;
    ++rows;
  }
  return std::sqrt(std::max(0.0, square / (6 * rows) - 1.0 / 12));
}

Line line_of(const PressingLog& log, int texel, double most_force, int full_scale,
             bool& saturated) {
  Eigen::Matrix3d gram = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  double square = 0;
  std::vector<double> jumps;
  std::size_t rows = 0, full = 0;
  for (std::size_t i = 1; i + 1 < log.size(); ++i) {
    if (log.force[i] < kLeastShare * most_force) continue;
    const double count = log.count(i, texel);
    if (count >= full_scale) ++full;
    if (count >= full_scale || count == 0) continue;
    const double rate =
        (log.force[i + 1] - log.force[i - 1]) / (log.time[i + 1] - log.time[i - 1]) / log.texels;
    const Eigen::Vector3d x(log.force[i] / log.texels, rate, 1);
    gram += x * x.transpose();
    right += count * x;
    square += count * count;
    ++rows;
    const int before = log.count(i - 1, texel), after = log.count(i + 1, texel);
    if (before == 0 || after == 0 || after >= full_scale || before >= full_scale) continue;
    jumps.push_back(std::abs(before - 2 * count + after));
  }
  saturated = full > 0 && rows < kLeastRows;
  Line line;
  if (rows < kLeastRows || jumps.size() < kLeastRows / 2) return line;
  const Eigen::LDLT<Eigen::Matrix3d> factors(gram);
  const Eigen::Vector3d x = factors.solve(right);
  const double left = std::max(0.0, square - right.dot(x));
  const double variance = left / static_cast<double>(rows - 3);
  line.slope = x[0];
  line.deviation = std::sqrt(variance * factors.solve(Eigen::Vector3d::UnitX())[0]);
  line.zero = x[2];
  line.lag = -x[1] / x[0];
  line.noise = noise_of(jumps);
  line.is_there = line.slope > kAnswers * line.deviation;
  return line;
}

std::string list_of(const std::vector<double>& values, int columns) {
  std::string text = "[";
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (i > 0) text += i % static_cast<std::size_t>(columns) == 0 ? ",\n  " : ", ";
    text += fmt::format("{:.5g}", values[i]);
  }
  return text + "]";
}

const FittedValue* find(const std::vector<FittedValue>& values, const std::string& name) {
  const auto found = std::find_if(values.begin(), values.end(),
                                  [&](const FittedValue& value) { return value.name == name; });
  return found == values.end() ? nullptr : &*found;
}

std::string with_error(const std::vector<FittedValue>& values, const std::string& name) {
  const FittedValue* value = find(values, name);
  return value ? fmt::format("# {}, +- {:.2g}", value->unit, value->deviation) : "";
}

}  // namespace

PadFit fit_pad(const PressingLog& log, const PadFitOptions& options) {
  if (log.texels != options.rows * options.columns) {
    throw InputError(fmt::format("{} has {} texels, the pad {} x {}", log.name, log.texels,
                                 options.rows, options.columns),
                     "Give the pad's --rows and --columns");
  }
  PadFit fit;
  FoamFitOptions foam = options.foam;
  foam.reference_texels =
      log.texels * options.texel_pitch * options.texel_pitch / contact::kReferenceTexelArea;
  fit.foam = fit_foam(log, foam);
  fit.remarks = fit.foam.remarks;
  const int texels = log.texels;
  std::vector<Line> lines;
  std::string silent, full;
  for (int i = 0; i < texels; ++i) {
    bool saturated = false;
    lines.push_back(line_of(log, i, fit.foam.most_force, options.full_scale, saturated));
    if (saturated) full += fmt::format("{}{}", full.empty() ? "" : ", ", i);
    if (!lines.back().is_there) silent += fmt::format("{}{}", silent.empty() ? "" : ", ", i);
  }
  if (!full.empty()) {
    throw InputError(
        fmt::format("{}: texel {} is at full scale in nearly every press", log.name, full),
        "Press less hard");
  }
  double sum = 0, square = 0, lag = 0, noise = 0;
  int alive = 0;
  for (const Line& line : lines) {
    if (!line.is_there) continue;
    ++alive;
    sum += line.slope;
    square += line.deviation * line.deviation;
    lag += line.lag;
    noise += line.noise * line.noise;
  }
  if (alive == 0) {
    throw InputError(log.name + ": no texel's count grows with the force",
                     "Check that force and frames are of the same pad and clock");
  }
  if (!silent.empty()) fit.remarks.push_back("texels that do not answer, gain 0: " + silent);
  const double mean = sum / alive;
  PadCalibration& calibration = fit.calibration;
  calibration.rows = options.rows;
  calibration.columns = options.columns;
  calibration.newton_per_count = 1 / mean;
  calibration.noise = std::sqrt(noise / alive);
  for (const Line& line : lines) {
    calibration.gains.push_back(line.is_there ? line.slope / mean : 0);
    calibration.zeros.push_back(line.is_there ? line.zero : 0);
    fit.gain_deviations.push_back(line.is_there ? line.deviation / mean : 0);
  }
  calibration.stiffness = fit.foam.law.stiffness;
  if (find(fit.foam.values, "damping")) calibration.damping = fit.foam.law.damping;
  calibration.memory = fit.foam.law.memory;
  fit.values = {{"newton_per_count", "N", 1 / mean, std::sqrt(square) / alive / (mean * mean)},
                {"noise", "counts", calibration.noise, 0},
                {"lag", "s", lag / alive, 0}};
  fit.values.insert(fit.values.end(), fit.foam.values.begin(), fit.foam.values.end());
  return fit;
}

std::string to_yaml(const PadFit& fit, const std::string& from) {
  const PadCalibration& c = fit.calibration;
  const auto error = [&](const std::string& name) { return with_error(fit.values, name); };
  std::string text = fmt::format(
      "# A pad as measured, found by `prehend calibrate tactile` in {}: {} presses up to {:.3g} N; "
      "its "
      "forces\n"
      "# are met to {:.2g} N. For `tactile: {{calibration: FILE}}` and the driver's "
      "`calibration`.\n",
      from, fit.foam.presses, fit.foam.most_force, fit.foam.off);
  for (const std::string& remark : fit.remarks) text += "# " + remark + "\n";
  text += fmt::format("rows: {}\ncolumns: {}\n", c.rows, c.columns);
  text +=
      fmt::format("newton_per_count: {:.6g}  {}\n", c.newton_per_count, error("newton_per_count"));
  text += fmt::format("noise: {:.3g}  # counts\n", c.noise);
  const double deviation =
      fit.gain_deviations.empty()
          ? 0
          : *std::max_element(fit.gain_deviations.begin(), fit.gain_deviations.end());
  text += fmt::format("gains:  # each +- {:.2g} at most\n  {}\n", deviation,
                      list_of(c.gains, c.columns));
  text += fmt::format("zeros:  # counts\n  {}\nlaw:\n", list_of(c.zeros, c.columns));
  text += fmt::format("  stiffness: {:.6g}  {}\n", c.stiffness.value_or(0), error("stiffness"));
  if (c.damping) text += fmt::format("  damping: {:.6g}  {}\n", *c.damping, error("damping"));
  const auto add_terms = [&](const char* kind, const char* second, const auto& terms, auto other) {
    if (!terms.empty()) text += fmt::format("  {}:\n", kind);
    for (std::size_t i = 0; i < terms.size(); ++i) {
      const std::string name = fmt::format("{}[{}].", kind, i);
      text += fmt::format("    - share: {:.6g}  {}\n      {}: {:.6g}  {}\n", terms[i].share,
                          error(name + "share"), second, terms[i].*other, error(name + second));
    }
  };
  add_terms("creep", "time", c.memory.creep, &contact::FoamMemory::Creep::time);
  add_terms("hysteresis", "depth", c.memory.hysteresis, &contact::FoamMemory::Hysteresis::depth);
  return text;
}

}  // namespace prehend::robot
