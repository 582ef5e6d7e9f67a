#include "prehend/robot/pad_fit/foam_fit.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include <ceres/ceres.h>
#include <fmt/format.h>
#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "prehend/contact/foam_texel.h"
#include "prehend/contact/require.h"
#include "prehend/geometry/errors.h"

namespace prehend::robot {
namespace {

using contact::FoamMemory;
using contact::TexelLaw;
using geometry::InputError;

constexpr double kFaceUnit = 1e-4;  // m, of the face among the unknowns
constexpr int kGrid = 12;           // times and depths to begin from

// One unknown: its logarithm is fitted, the face's value itself.
struct Unknown {
  std::string name, unit;
  double value, least, most;
  std::string mend;
};

struct Presses {
  int count = 0;
  double most_force = 0;           // N
  std::size_t first_touch = 0;     // sample
  double stiffness = 0, face = 0;  // N/m of the pad, m: a first guess
};

Presses presses_of(const PressingLog& log) {
  Presses found;
  found.most_force = *std::max_element(log.force.begin(), log.force.end());
  const double most = found.most_force;
  if (!(most > 0)) {
    throw InputError(log.name + ": no force is positive", "Turn the force's sign, or press");
  }
  bool under = false;
  for (const double force : log.force) {
    if (!under && force > 0.3 * most) {
      under = true;
      ++found.count;
    } else if (under && force < 0.15 * most) {
      under = false;
    }
  }
  if (found.count < 2) {
    throw InputError(fmt::format("{} holds {} press{}: too few to tell the foam from chance",
                                 log.name, found.count, found.count == 1 ? "" : "es"),
                     "Press and let go three times or more, to different depths");
  }
  // A line through the first press on its way up.
  while (log.force[found.first_touch] < 0.05 * most) ++found.first_touch;
  double n = 0, d = 0, f = 0, dd = 0, df = 0;
  const double origin = log.depth[found.first_touch];
  for (std::size_t i = found.first_touch; i < log.size() && log.force[i] < 0.5 * most; ++i) {
    const double x = log.depth[i] - origin;
    n += 1;
    d += x;
    f += log.force[i];
    dd += x * x;
    df += x * log.force[i];
  }
  const double spread = n * dd - d * d;
  found.stiffness = spread > 0 ? (n * df - d * f) / spread : 0;
  if (!(found.stiffness > 0)) {
    throw InputError(log.name + ": in the first press the force does not grow with the depth",
                     "Turn the depth's sign (into the pad is positive), or press more slowly");
  }
  found.face = origin - (f / n - found.stiffness * d / n) / found.stiffness;
  return found;
}

// Of the depth at row `i` [m/s], between the rows beside it.
double rate_at(const PressingLog& log, std::size_t i) {
  const std::size_t before = i > 0 ? i - 1 : i, after = std::min(i + 1, log.size() - 1);
  return (log.depth[after] - log.depth[before]) / (log.time[after] - log.time[before]);
}

double longest_step(const PressingLog& log) {
  double most = 0;
  for (std::size_t i = 1; i < log.size(); ++i) most = std::max(most, log.time[i] - log.time[i - 1]);
  return most;
}

std::vector<Unknown> unknowns_of(const FoamFitOptions& options, const PressingLog& log, double face,
                                 double deepest) {
  const double duration = log.time.back() - log.time.front();
  const double step = duration / static_cast<double>(log.size());
  std::vector<Unknown> unknowns{
      {"face", "m", face, 0, 0, "Begin before the first touch"},
      {"stiffness", "N/m", 1, 1e-2, 1e7, "Press deeper"},
      {"damping", "N s/m", options.law.damping, 1e-4, 1e5, "Press at two speeds or more"}};
  for (int i = 0; i < options.creep_terms; ++i) {
    const std::string name = fmt::format("creep[{}]", i);
    const std::string mend =
        fmt::format("Hold presses for longer than the foam creeps, or fit less: --creep-terms {}",
                    options.creep_terms - 1);
    unknowns.push_back({name + ".share", "", 0.1, 1e-4, 20, mend});
    unknowns.push_back({name + ".time", "s", 1, 0.5 * step, 10 * duration, mend});
  }
  for (int i = 0; i < options.hysteresis_terms; ++i) {
    const std::string name = fmt::format("hysteresis[{}]", i);
    const std::string mend = fmt::format(
        "Turn back within presses, at several depths, or fit less: --hysteresis-terms {}",
        options.hysteresis_terms - 1);
    unknowns.push_back({name + ".share", "", 0.1, 1e-4, 20, mend});
    unknowns.push_back({name + ".depth", "m", 1e-4, 1e-3 * deepest, deepest, mend});
  }
  return unknowns;
}

TexelLaw law_of(const std::vector<Unknown>& unknowns, const FoamFitOptions& options) {
  TexelLaw law = options.law;
  law.stiffness = unknowns[1].value;
  law.damping = unknowns[2].value;
  law.memory = {};
  std::size_t at = 3;
  for (int i = 0; i < options.creep_terms; ++i, at += 2) {
    law.memory.creep.push_back({unknowns[at].value, unknowns[at + 1].value});
  }
  for (int i = 0; i < options.hysteresis_terms; ++i, at += 2) {
    law.memory.hysteresis.push_back({unknowns[at].value, unknowns[at + 1].value});
  }
  return law;
}

// For each choice of times and depths from a grid the shares follow linearly; the best choice.
void begin_from_grid(const PressingLog& log, const FoamFitOptions& options, double deepest,
                     std::vector<Unknown>& unknowns) {
  const double face = unknowns[0].value;
  const double duration = log.time.back() - log.time.front();
  const double step = duration / static_cast<double>(log.size());
  // Columns: elastic, damper, creep of each time, slider of each depth; then the force.
  const int columns = 2 + 2 * kGrid;
  std::vector<double> times(kGrid), depths(kGrid);
  for (int k = 0; k < kGrid; ++k) {
    const double part = static_cast<double>(k) / (kGrid - 1);
    times[k] = 3 * step * std::pow(duration / (6 * step), part);
    depths[k] = 0.01 * deepest * std::pow(60, part);
  }
  Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(columns + 1, columns + 1);
  Eigen::VectorXd row = Eigen::VectorXd::Zero(columns + 1);
  double before = std::max(0.0, log.depth[0] - face);
  for (std::size_t i = 1; i < log.size(); ++i) {
    const double h = log.time[i] - log.time[i - 1];
    const double depth = std::max(0.0, log.depth[i] - face), change = depth - before;
    row[0] = depth;
    row[1] = depth > 0 && before > 0 ? rate_at(log, i) : 0;
    for (int k = 0; k < kGrid; ++k) {
      const double x = h / times[k];
      row[2 + k] = std::exp(-x) * row[2 + k] - std::expm1(-x) / x * change;
      row[2 + kGrid + k] = std::clamp(row[2 + kGrid + k] + change, -depths[k], depths[k]);
    }
    before = depth;
    if (depth == 0) continue;
    row[columns] = log.force[i];
    gram.selfadjointView<Eigen::Lower>().rankUpdate(row);
  }
  gram = gram.selfadjointView<Eigen::Lower>();
  double best = std::numeric_limits<double>::infinity();
  std::vector<int> chosen{0, 1};
  const std::function<void(int, int, int)> choose = [&](int creep, int slip, int next) {
    if (creep > 0 || slip > 0) {
      const int end = creep > 0 ? 2 + kGrid : 2 + 2 * kGrid;
      for (int c = creep > 0 ? next : std::max(next, 2 + kGrid); c < end; ++c) {
        chosen.push_back(c);
        choose(creep > 0 ? creep - 1 : 0, creep > 0 ? slip : slip - 1, c + 1);
        chosen.pop_back();
      }
      return;
    }
    const Eigen::MatrixXd A = gram(chosen, chosen);
    const Eigen::VectorXd b = gram(chosen, std::vector<int>{columns});
    const Eigen::VectorXd x = A.ldlt().solve(b);
    if (!x.allFinite() || x[0] <= 0) return;
    for (Eigen::Index k = 2; k < x.size(); ++k) {
      if (x[k] <= 0) return;
    }
    const double left = gram(columns, columns) - b.dot(x);
    if (left >= best) return;
    best = left;
    unknowns[1].value = x[0] / options.reference_texels;
    unknowns[2].value =
        std::max(x[1] / options.reference_texels, 1e-3 * options.law.damping + 1e-3);
    for (std::size_t k = 2; k < chosen.size(); ++k) {
      const int c = chosen[k] - 2;
      unknowns[2 * k - 1].value = x[static_cast<Eigen::Index>(k)] / x[0];
      unknowns[2 * k].value = c < kGrid ? times[c] : depths[c - kGrid];
    }
  };
  choose(options.creep_terms, options.hysteresis_terms, 2);
}

// Residuals of the whole log over all unknowns, of which some are held.
struct Residuals {
  const PressingLog* log;
  const FoamFitOptions* options;
  std::vector<Unknown> unknowns;
  std::vector<std::size_t> free;
  double scale;  // N

  void take(const double* x) {
    for (std::size_t k = 0; k < free.size(); ++k) {
      unknowns[free[k]].value = free[k] == 0 ? kFaceUnit * x[k] : std::exp(x[k]);
    }
  }
  std::vector<double> start() const {
    std::vector<double> x;
    for (const std::size_t k : free) {
      x.push_back(k == 0 ? unknowns[k].value / kFaceUnit
                         : std::log(std::clamp(unknowns[k].value, 1.001 * unknowns[k].least,
                                               0.999 * unknowns[k].most)));
    }
    return x;
  }
  bool operator()(double const* const* x, double* residuals) const {
    Residuals at = *this;
    at.take(x[0]);
    const std::vector<double> forces = predicted_forces(
        *log, law_of(at.unknowns, *options), options->reference_texels, at.unknowns[0].value);
    for (std::size_t i = 0; i < forces.size(); ++i) {
      residuals[i] = (forces[i] - log->force[i]) / scale;
    }
    return true;
  }
};

class Progress : public ceres::IterationCallback {
 public:
  Progress(const FoamFitOptions& options, std::size_t samples)
      : options_(options), samples_(samples) {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary& summary) override {
    if (options_.progress) {
      options_.progress(summary.iteration,
                        std::sqrt(2 * summary.cost / static_cast<double>(samples_)));
    }
    return ceres::SOLVER_CONTINUE;
  }

 private:
  const FoamFitOptions& options_;
  std::size_t samples_;
};

struct Solution {
  std::vector<double> deviations;  // of each free unknown: relative, the face's in m
  double off = 0;                  // N
};

// Rows that follow one another are off alike: fewer of them count.
double correlation_factor(const std::vector<double>& residuals) {
  double square = 0, product = 0;
  for (std::size_t i = 0; i + 1 < residuals.size(); ++i) {
    square += residuals[i] * residuals[i];
    product += residuals[i] * residuals[i + 1];
  }
  const double rho = square > 0 ? std::clamp(product / square, 0.0, 0.999) : 0;
  return (1 + rho) / (1 - rho);
}

Solution solve(Residuals& residuals) {
  const int samples = static_cast<int>(residuals.log->size());
  const int size = static_cast<int>(residuals.free.size());
  ceres::NumericDiffOptions steps;
  steps.relative_step_size = 1e-4;
  auto* cost = new ceres::DynamicNumericDiffCostFunction<Residuals, ceres::CENTRAL>(
      new Residuals(residuals), ceres::TAKE_OWNERSHIP, steps);
  cost->AddParameterBlock(size);
  cost->SetNumResiduals(samples);
  std::vector<double> x = residuals.start();
  ceres::Problem problem;
  problem.AddResidualBlock(cost, nullptr, x.data());
  for (int k = 0; k < size; ++k) {
    const Unknown& unknown = residuals.unknowns[residuals.free[k]];
    if (residuals.free[k] == 0) continue;
    problem.SetParameterLowerBound(x.data(), k, std::log(unknown.least));
    problem.SetParameterUpperBound(x.data(), k, std::log(unknown.most));
  }
  Progress progress(*residuals.options, residuals.log->size());
  ceres::Solver::Options how;
  how.linear_solver_type = ceres::DENSE_QR;
  how.max_num_iterations = 100;
  how.function_tolerance = 1e-10;
  how.logging_type = ceres::SILENT;
  how.callbacks.push_back(&progress);
  ceres::Solver::Summary summary;
  ceres::Solve(how, &problem, &summary);
  residuals.take(x.data());

  std::vector<double> off;
  ceres::CRSMatrix sparse;
  problem.Evaluate({}, nullptr, &off, nullptr, &sparse);
  Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(samples, size);
  for (int r = 0; r < sparse.num_rows; ++r) {
    for (int k = sparse.rows[r]; k < sparse.rows[r + 1]; ++k) {
      jacobian(r, sparse.cols[k]) = sparse.values[k];
    }
  }
  double square = 0;
  for (const double r : off) square += r * r;
  const double variance = square / std::max(1, samples - size) * correlation_factor(off);
  // By columns of one length, so that what none of the rows depends on shows.
  const Eigen::VectorXd length = jacobian.colwise().norm().cwiseMax(1e-12);
  const Eigen::MatrixXd normed = jacobian * length.cwiseInverse().asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(normed.transpose() * normed);
  Solution solution;
  for (int k = 0; k < size; ++k) {
    double sum = 0;
    for (int j = 0; j < size; ++j) {
      const double v = eigen.eigenvectors()(k, j);
      sum += v * v / std::max(eigen.eigenvalues()[j], 1e-14);
    }
    const double deviation = std::sqrt(variance * sum) / length[k];
    solution.deviations.push_back(residuals.free[k] == 0 ? kFaceUnit * deviation : deviation);
  }
  solution.off = residuals.scale * std::sqrt(square / samples);
  return solution;
}

bool is_undetermined(const Unknown& unknown, double deviation, const FoamFitOptions& options) {
  return !(deviation <= options.most_deviation) || unknown.value < 1.01 * unknown.least ||
         unknown.value > 0.99 * unknown.most;
}

}  // namespace

std::vector<double> predicted_forces(const PressingLog& log, const TexelLaw& law,
                                     double reference_texels, double face) {
  // The damper's part by the rate at each row; the texel's own would be that of the way to it.
  TexelLaw undamped = law;
  undamped.damping = 0;
  contact::FoamTexel texel(undamped);
  std::vector<double> forces;
  forces.reserve(log.size());
  double before = log.time.front() - longest_step(log);
  for (std::size_t i = 0; i < log.size(); ++i) {
    const double force = texel.press(log.time[i] - before, log.depth[i] - face);
    const double damped = force > 0 ? std::max(0.0, force + law.damping * rate_at(log, i)) : 0.0;
    forces.push_back(reference_texels * damped);
    before = log.time[i];
  }
  return forces;
}

FoamFit fit_foam(const PressingLog& log, const FoamFitOptions& options) {
  contact::require_positive(options.reference_texels, "FoamFitOptions::reference_texels");
  contact::require(options.creep_terms >= 0 && options.creep_terms <= 3,
                   "FoamFitOptions::creep_terms", "0 to 3");
  contact::require(options.hysteresis_terms >= 0 && options.hysteresis_terms <= 3,
                   "FoamFitOptions::hysteresis_terms", "0 to 3");
  const Presses presses = presses_of(log);
  const double deepest = *std::max_element(log.depth.begin(), log.depth.end()) - presses.face;
  Residuals residuals{
      &log, &options, unknowns_of(options, log, presses.face, deepest), {}, presses.most_force};
  residuals.unknowns[1].value = presses.stiffness / options.reference_texels;
  begin_from_grid(log, options, deepest, residuals.unknowns);
  for (std::size_t k = 0; k < residuals.unknowns.size(); ++k) residuals.free.push_back(k);
  if (log.size() < 5 * residuals.free.size()) {
    throw InputError(
        fmt::format("{} has {} rows for {} unknowns", log.name, log.size(), residuals.free.size()),
        "Log for longer");
  }
  FoamFit fit;
  fit.presses = presses.count;
  fit.most_force = presses.most_force;
  Solution solution = solve(residuals);
  if (Unknown& damping = residuals.unknowns[2];
      is_undetermined(damping, solution.deviations[2], options)) {
    fit.remarks.push_back(
        fmt::format("damping is not determined by this log and stays {} N s/m. {}",
                    options.law.damping, damping.mend));
    damping.value = options.law.damping;
    residuals.free.erase(residuals.free.begin() + 2);
    solution = solve(residuals);
  }
  const Unknown* worst = nullptr;
  double most = 0;
  for (std::size_t k = 0; k < residuals.free.size(); ++k) {
    const Unknown& unknown = residuals.unknowns[residuals.free[k]];
    const double deviation = solution.deviations[k];
    if (residuals.free[k] == 0) {
      fit.face = unknown.value;
      fit.face_deviation = deviation;
      continue;
    }
    if (is_undetermined(unknown, deviation, options) && (!worst || deviation > most)) {
      worst = &unknown;
      most = deviation;
    }
    fit.values.push_back({unknown.name, unknown.unit, unknown.value, deviation * unknown.value});
  }
  if (worst) {
    throw InputError(fmt::format("{} does not determine {}: {:.3g} {} +- {:.1g} %", log.name,
                                 worst->name, worst->value, worst->unit, 100 * most),
                     worst->mend);
  }
  fit.law = law_of(residuals.unknowns, options);
  fit.off = solution.off;
  return fit;
}

FoamCheck check_foam(const PressingLog& log, const TexelLaw& law, double reference_texels) {
  FoamFitOptions options;
  options.reference_texels = reference_texels;
  const Presses presses = presses_of(log);
  // The face alone, by golden section round the first guess.
  const auto off_at = [&](double face) {
    const std::vector<double> forces = predicted_forces(log, law, reference_texels, face);
    double sum = 0;
    for (std::size_t i = 0; i < forces.size(); ++i) sum += std::pow(forces[i] - log.force[i], 2);
    return std::sqrt(sum / static_cast<double>(forces.size()));
  };
  const double width = 0.3 * presses.most_force / (law.stiffness * reference_texels);
  double low = presses.face - width, high = presses.face + width;
  constexpr double kGolden = 0.6180339887498949;
  while (high - low > 1e-9) {
    const double a = high - kGolden * (high - low), b = low + kGolden * (high - low);
    if (off_at(a) < off_at(b)) {
      high = b;
    } else {
      low = a;
    }
  }
  FoamCheck check;
  check.face = 0.5 * (low + high);
  check.off = off_at(check.face);
  check.most_force = presses.most_force;
  const std::vector<double> forces = predicted_forces(log, law, reference_texels, check.face);
  for (std::size_t i = 0; i < forces.size(); ++i) {
    check.most_off = std::max(check.most_off, std::abs(forces[i] - log.force[i]));
  }
  return check;
}

}  // namespace prehend::robot
