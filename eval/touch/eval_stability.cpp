// Soft contact at its extremes: masses, constants of the law, steps, sizes, forces, texels, impacts
// and what is refused. Writes the table of docs/touch_extremes.md.

#include "eval/text_files.h"
#include "eval/touch/experiment.h"
#include "eval/touch/extremes.h"

namespace {

using namespace prehend::eval::touch;

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
    const bool ok = extreme.refused.empty()
                        ? result.stable
                        : result.message.find(extreme.refused) != std::string::npos;
    as_expected += ok;
    rows.push_back({{"what", extreme.subject},
                    {"value", extreme.value},
                    {"as_expected", ok},
                    {"refused", result.refused},
                    {"stable", result.stable},
                    {"energy_growth", result.energy_growth},
                    {"speed_at_end_m_s", result.final_speed},
                    {"error_um", 1e6 * result.error}});
  }
  add_table(page, rows);
  findings.summary = {{"cases", static_cast<double>(cases.size())},
                      {"stable_or_refused", static_cast<double>(as_expected)}};
  findings.tables = {{"extremes", rows}};
  if (!options.out.empty()) {
    prehend::eval::write_text(options.out / "touch_extremes.md", extremes_markdown(cases, results));
  }
  return findings;
}

}  // namespace

int main(int argc, char** argv) {
  return run_experiment(argc, argv, "Soft contact at its extremes", stability);
}
