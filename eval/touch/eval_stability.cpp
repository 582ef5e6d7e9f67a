// Soft contact at its extremes: masses, constants of the law, steps, sizes, forces, texels, impacts
// and what is refused. Writes the table of docs/touch_extremes.md.

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "eval/text_files.h"
#include "eval/touch/experiment.h"
#include "eval/touch/extremes.h"
#include "eval/touch/stability_map.h"

namespace {

using namespace prehend::eval::touch;

// A 50 mm to 60 mm box gripped, lifted and held for 10 s in the worlds that ship.
std::vector<Row> draw_maps(bool quick, Findings& findings, prehend::report::Page& page) {
  std::vector<Row> rows;
  page.add_heading("What the worlds hold");
  page.add_paragraph(
      "A box gripped, lifted and held for 10 s: slip in the last 5 s. Green: held. Amber: a limit, "
      "with its reason. Red: lost. Grey: refused.");
  const auto maps =
      stability_maps(quick, [](const std::string& world) { spdlog::info("map of {}", world); });
  for (const StabilityMap& map : maps) {
    page.add_chart(prehend::report::draw_cell_map(cell_map(map)), map.world);
    using Outcome = MapCell::Outcome;
    findings.summary.push_back(
        {map.world,
         fmt::format("{} held, {} limits, {} refused, {} lost, of {}", map.count(Outcome::kHeld),
                     map.count(Outcome::kLimit), map.count(Outcome::kRefused),
                     map.count(Outcome::kLost), map.cells.size())});
    for (const MapCell& cell : map.cells) {
      rows.push_back({{"world", map.world},
                      {"mass_kg", cell.mass},
                      {"step_ms", 1e3 * cell.step},
                      {"held", cell.outcome == Outcome::kHeld},
                      {"slip_um", 1e6 * cell.hold.slip},
                      {"why_not", cell.why}});
    }
  }
  return rows;
}

Findings stability(const ExperimentOptions& options, prehend::report::Page& page) {
  Findings findings;
  findings.title = "stability";
  std::vector<Row> rows;
  std::vector<ExtremeResult> results;
  int as_expected = 0;
  const std::vector<Extreme> cases = extremes();
  for (const Extreme& extreme : cases) {
    results.push_back(run_extreme(extreme));
    const ExtremeResult& result = results.back();
    const bool ok = is_as_expected(extreme, result);
    as_expected += ok;
    rows.push_back({{"what", extreme.subject},
                    {"value", extreme.value},
                    {"as_expected", ok},
                    {"refused", result.refused},
                    {"stable", result.stable},
                    {"held", result.held},
                    {"sliding_mm_s", 1e3 * result.sliding},
                    {"energy_growth", result.energy_growth},
                    {"speed_at_end_m_s", result.final_speed},
                    {"error_um", 1e6 * result.error}});
  }
  add_table(page, rows);
  findings.summary = {{"cases", static_cast<double>(cases.size())},
                      {"as_expected", static_cast<double>(as_expected)}};
  findings.tables = {{"extremes", rows}, {"maps", draw_maps(options.quick, findings, page)}};
  if (!options.out.empty()) {
    prehend::eval::write_text(options.out / "touch_extremes.md", extremes_markdown(cases, results));
  }
  return findings;
}

}  // namespace

int main(int argc, char** argv) {
  return run_experiment(argc, argv, "Soft contact at its extremes", stability);
}
