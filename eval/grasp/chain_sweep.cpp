#include "eval/grasp/chain_sweep.h"

#include <cstdio>
#include <cstdlib>
#include <map>
#include <vector>

#include <fmt/format.h>

#include "eval/case_runs.h"
#include "eval/grasp/chain_tradeoff.h"
#include "eval/grasp/plan_tradeoff.h"
#include "eval/text_files.h"
#include "prehend/fidelity/front.h"
#include "prehend/geometry/errors.h"
#include "prehend/report/charts.h"
#include "prehend/report/page.h"

namespace prehend::eval {
namespace {

std::string grid_in_words(const ChainGrid& grid) {
  std::string words;
  for (std::size_t i = 0; i < grid.size(); ++i) words += to_string(grid.setting(i)) + "; ";
  return words;
}

std::string foretold_in_words(const Foretold& foretold) {
  return fmt::format(
      "Foretold by the others, of {} chains that were left out: the time to within {:.1f} % at "
      "worst "
      "({:.1f} % in the mean), the mesh's error to {:.1f} % ({:.1f} %), the share that is not "
      "lifted "
      "to {:.3f} ({:.3f}) of the views.",
      foretold.chains, 100 * foretold.worst_time, 100 * foretold.mean_time,
      100 * foretold.worst_mesh, 100 * foretold.mean_mesh, foretold.worst_not_lifted,
      foretold.mean_not_lifted);
}

void write_page(const ChainSweep& sweep, const std::vector<MeasuredChain>& measured,
                const fidelity::Front& front, const std::string& foretold) {
  const bool of_images = sweep.input == fidelity::ChainInput::kImages;
  report::LineChart chart{
      of_images ? "From images to ranked grasps" : "From a cloud to ranked grasps",
      "processor time [ms]",
      "not lifted at the first attempt [%]",
      {},
      {}};
  report::Series all{"chains", {}, {}, false}, best{"front", {}, {}, true};
  std::string csv = std::string("milliseconds,") + fidelity::to_string(first_stage(sweep.input)) +
                    "_ms,shape_ms,plan_ms,lifted,views,meshes,mesh_mm,knobs\n";
  for (const MeasuredChain& chain : measured) {
    const auto& others = chain.setting.other_errors;
    all.points.emplace_back(1e3 * chain.setting.seconds, 100 * chain.setting.error);
    csv += fmt::format("{:.2f},{:.2f},{:.2f},{:.2f},{},{},{},{:.3f},\"{}\"\n",
                       1e3 * chain.setting.seconds, 1e3 * others[1].second, 1e3 * others[2].second,
                       1e3 * others[3].second, chain.lifted, chain.views, chain.meshes,
                       1e3 * others[0].second, to_string(chain.setting));
  }
  std::vector<std::vector<std::string>> rows;
  for (const fidelity::Setting& setting : front.settings) {
    best.points.emplace_back(1e3 * setting.seconds, 100 * setting.error);
    rows.push_back(
        {fmt::format("{:.0f}", 1e3 * setting.seconds), fmt::format("{:.1f}", 100 * setting.error),
         fmt::format("{:.2f}", 1e3 * setting.other_errors[0].second), to_string(setting)});
  }
  chart.series = {all, best};
  report::Page page("One budget for the whole chain");
  page.add_paragraph("Measured on: " + front.machine + ". Error: " + front.error_name + ".");
  page.add_chart(report::draw_line_chart(chart),
                 "Every chain that was measured, and those that nothing beats");
  page.add_table({"time [ms]", "not lifted [%]", "mesh off by [mm]", "setting"}, rows);
  page.add_paragraph(foretold);
  write_text(sweep.runs.out / "chain.csv", csv);
  page.write(sweep.runs.out / "index.html");
}

}  // namespace

int sweep_chains(const ChainSweep& sweep) {
  const PlatformUnderTest platform(sweep.platform);
  const ChainGrid grid = chain_grid(sweep.input, platform.hand(), sweep.quick);
  const std::vector<DataSet> sets = data_sets_to_evaluate({});
  const std::vector<Case> cases = views_to_sweep(sets, sweep.quick);
  std::vector<std::string> names;
  for (const Case& one : cases) {
    names.push_back(
        fmt::format("{}_{}_{}", platform.name(), to_string(sweep.input), one.result_name()));
  }
  CaseRunOptions runs = sweep.runs;
  runs.setting = grid_in_words(grid);
  std::printf("%zu chains on each of %zu views\n", grid.size(), cases.size());
  const std::vector<std::vector<ChainTrial>> views = found_results(run_cases(
      runs, names, read_chain_trials, [&](int i) { return run_chains(cases[i], platform, grid); },
      [&](const std::vector<ChainTrial>& known) { return known.size() == grid.size(); }));
  if (views.size() != cases.size()) return EXIT_FAILURE;
  const std::vector<MeasuredChain> measured = measured_chains(grid, views);
  const fidelity::Front front =
      chain_front(sweep.input, measured, platform.name(),
                  fmt::format("{}, processor time, {} rendered views, {} chains", sweep.machine,
                              cases.size(), grid.size()));
  const std::filesystem::path file =
      sweep.quick ? sweep.runs.out / sweep.front.filename() : sweep.front;
  fidelity::write_front(file, front);
  const std::string foretold = foretold_in_words(foretell(grid, measured));
  write_page(sweep, measured, front, foretold);
  for (const fidelity::Setting& setting : front.settings) {
    std::printf("%6.0f ms, %4.1f %% not lifted, mesh off by %.2f mm: %s\n", 1e3 * setting.seconds,
                100 * setting.error, 1e3 * setting.other_errors[0].second,
                to_string(setting).c_str());
  }
  std::printf("%s\n%s\n%s\n", foretold.c_str(), file.c_str(),
              (sweep.runs.out / "index.html").c_str());
  return EXIT_SUCCESS;
}

}  // namespace prehend::eval
