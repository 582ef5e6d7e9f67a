#include "eval/grasp/chain_tradeoff.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <utility>

#include <Eigen/QR>

#include "prehend/fidelity/chain_settings.h"

namespace prehend::eval {
namespace {

using fidelity::Stage;

constexpr std::size_t kStages = 3;
constexpr std::size_t kLeftOut = 4;  // each fourth chain is foretold
constexpr double kShortest = 1e-6;   // s, that has a logarithm

bool is_left_out(const MeasuredChain& chain) {
  return (chain.levels[0] + chain.levels[1] + chain.levels[2]) % kLeftOut == 0;
}

std::array<Stage, kStages> stages_of(fidelity::ChainInput input) {
  return {fidelity::first_stage(input), Stage::kShape, Stage::kPlan};
}

using RowOf = std::function<Eigen::VectorXd(const MeasuredChain&)>;

// A mean, and an effect of each setting but a stage's first.
RowOf single_effects(const ChainGrid& grid) {
  const std::array sizes{grid.seeing.size(), grid.shape.size(), grid.plan.size()};
  return [sizes](const MeasuredChain& chain) {
    Eigen::VectorXd row = Eigen::VectorXd::Zero(
        static_cast<Eigen::Index>(1 + sizes[0] + sizes[1] + sizes[2] - sizes.size()));
    row[0] = 1;
    std::size_t first = 1;
    for (std::size_t stage = 0; stage < sizes.size(); ++stage) {
      if (chain.levels[stage] > 0) {
        row[static_cast<Eigen::Index>(first + chain.levels[stage] - 1)] = 1;
      }
      first += sizes[stage] - 1;
    }
    return row;
  };
}

// An effect of each two settings of two stages.
RowOf paired_effects(const ChainGrid& grid) {
  const std::array sizes{grid.seeing.size(), grid.shape.size(), grid.plan.size()};
  return [sizes](const MeasuredChain& chain) {
    Eigen::VectorXd row = Eigen::VectorXd::Zero(
        static_cast<Eigen::Index>(sizes[0] * sizes[1] + sizes[1] * sizes[2] + sizes[0] * sizes[2]));
    std::size_t first = 0;
    for (std::size_t a = 0; a < sizes.size(); ++a) {
      for (std::size_t b = a + 1; b < sizes.size(); ++b) {
        row[static_cast<Eigen::Index>(first + chain.levels[a] * sizes[b] + chain.levels[b])] = 1;
        first += sizes[a] * sizes[b];
      }
    }
    return row;
  };
}

// By the smallest effects that fit the chains that are not left out, by least squares.
std::function<double(const MeasuredChain&)> fitted(
    const RowOf& row_of, const std::vector<MeasuredChain>& measured,
    const std::function<double(const MeasuredChain&)>& value) {
  std::vector<Eigen::VectorXd> rows;
  std::vector<double> values;
  for (const MeasuredChain& chain : measured) {
    if (is_left_out(chain)) continue;
    rows.push_back(row_of(chain));
    values.push_back(value(chain));
  }
  Eigen::MatrixXd system(rows.size(), rows.front().size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    system.row(static_cast<Eigen::Index>(i)) = rows[i].transpose();
  }
  const Eigen::VectorXd effects = system.completeOrthogonalDecomposition().solve(
      Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size())));
  return [effects, row_of](const MeasuredChain& chain) { return row_of(chain).dot(effects); };
}

// A stage's time is the product of what each setting makes of it, and of what each two settings of
// two stages make of the rest.
std::function<double(const MeasuredChain&)> foretold_time(
    const ChainGrid& grid, const std::vector<MeasuredChain>& measured) {
  std::vector<std::function<double(const MeasuredChain&)>> logarithms;
  for (const Stage stage : stages_of(grid.input)) {
    const auto logarithm = [stage](const MeasuredChain& chain) {
      return std::log(std::max(kShortest, fidelity::stage_seconds(chain.setting, stage)));
    };
    const auto by_one = fitted(single_effects(grid), measured, logarithm);
    const auto by_two = fitted(paired_effects(grid), measured, [&](const MeasuredChain& chain) {
      return logarithm(chain) - by_one(chain);
    });
    logarithms.push_back(
        [by_one, by_two](const MeasuredChain& chain) { return by_one(chain) + by_two(chain); });
  }
  return [logarithms](const MeasuredChain& chain) {
    double total = 0;
    for (const auto& logarithm : logarithms) total += std::exp(logarithm(chain));
    return total;
  };
}

double mesh_error(const fidelity::Setting& setting) { return setting.other_errors.front().second; }
double mesh_error(const MeasuredChain& chain) { return mesh_error(chain.setting); }

}  // namespace

std::vector<MeasuredChain> measured_chains(const ChainGrid& grid,
                                           const std::vector<std::vector<ChainTrial>>& views) {
  std::vector<MeasuredChain> measured;
  for (std::size_t i = 0; i < grid.size(); ++i) {
    MeasuredChain& chain = measured.emplace_back();
    chain.setting = grid.setting(i);
    chain.levels = grid.levels(i);
    chain.views = static_cast<int>(views.size());
    std::array<double, 3> seconds{};
    double mesh = 0;
    for (const std::vector<ChainTrial>& view : views) {
      const ChainTrial& trial = view.at(i);
      for (std::size_t stage = 0; stage < seconds.size(); ++stage) {
        seconds[stage] += trial.seconds[stage] / chain.views;
      }
      chain.lifted += trial.lifted;
      if (std::isnan(trial.mesh_error)) continue;
      mesh += trial.mesh_error;
      ++chain.meshes;
    }
    chain.setting.seconds = seconds[0] + seconds[1] + seconds[2];
    chain.setting.error = static_cast<double>(chain.views - chain.lifted) / chain.views;
    chain.setting.other_errors = {{"mesh", chain.meshes > 0 ? mesh / chain.meshes : kUnknown}};
    const auto stages = stages_of(grid.input);
    for (std::size_t stage = 0; stage < kStages; ++stage) {
      chain.setting.other_errors.emplace_back(fidelity::to_string(stages[stage]), seconds[stage]);
    }
  }
  return measured;
}

fidelity::Front chain_front(fidelity::ChainInput input, const std::vector<MeasuredChain>& measured,
                            const std::string& platform, const std::string& machine) {
  int most = 0;
  for (const MeasuredChain& chain : measured) most = std::max(most, chain.meshes);
  std::vector<fidelity::Setting> settings;
  for (const MeasuredChain& chain : measured) {
    if (chain.meshes == most) settings.push_back(chain.setting);
  }
  fidelity::Front front;
  front.subject = "chain";
  const bool of_images = input == fidelity::ChainInput::kImages;
  front.error_name = "share of views that " + platform + " did not lift at the first attempt, of " +
                     (of_images ? "images" : "clouds");
  front.error_unit = "of views";
  front.other_errors = {
      {"mesh", "mean distance of the true surface to the mesh [m]"},
      of_images ? std::pair{"seeing", "of the time, from images to objects [s]"}
                : std::pair{"segmentation", "of the time, from a cloud to objects [s]"},
      {"shape", "of the time, from those to meshes [s]"},
      {"plan", "of the time, to ranked grasps with the arm's motions and predicted touch [s]"}};
  front.machine = machine;
  std::stable_sort(settings.begin(), settings.end(),
                   [](const auto& a, const auto& b) { return a.seconds < b.seconds; });
  for (const fidelity::Setting& setting : settings) {
    const bool is_beaten = std::any_of(
        front.settings.begin(), front.settings.end(), [&](const fidelity::Setting& faster) {
          return faster.error <= setting.error && mesh_error(faster) <= mesh_error(setting);
        });
    if (!is_beaten) front.settings.push_back(setting);
  }
  return front;
}

Foretold foretell(const ChainGrid& grid, const std::vector<MeasuredChain>& measured) {
  const auto time = foretold_time(grid, measured);
  const auto mesh = fitted(single_effects(grid), measured,
                           [](const MeasuredChain& chain) { return mesh_error(chain); });
  const auto not_lifted = fitted(single_effects(grid), measured,
                                 [](const MeasuredChain& chain) { return chain.setting.error; });
  Foretold result;
  for (const MeasuredChain& chain : measured) {
    if (!is_left_out(chain)) continue;
    ++result.chains;
    const auto count = [](double off, double* worst, double* sum) {
      *worst = std::max(*worst, off);
      *sum += off;
    };
    count(std::abs(time(chain) / chain.setting.seconds - 1), &result.worst_time, &result.mean_time);
    count(std::abs(mesh(chain) / mesh_error(chain) - 1), &result.worst_mesh, &result.mean_mesh);
    count(std::abs(not_lifted(chain) - chain.setting.error), &result.worst_not_lifted,
          &result.mean_not_lifted);
  }
  for (double* mean : {&result.mean_time, &result.mean_mesh, &result.mean_not_lifted}) {
    *mean /= std::max(1, result.chains);
  }
  return result;
}

}  // namespace prehend::eval
