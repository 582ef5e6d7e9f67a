// The hold test: which engines keep a cube between two light jaws, at which masses and steps.

#include <cstdio>

#include "eval/touch/experiment.h"
#include "eval/touch/hold.h"
#include "prehend/simulation/engines/registry.h"

namespace {

using namespace prehend;
using namespace prehend::eval::touch;

struct Contender {
  std::string engine, solver;
  bool pads;
  bool world = false;  // simulation::World on that engine
};

std::string name_of(const Contender& contender) {
  if (contender.world) return "World on " + contender.engine;
  return contender.engine + " " + contender.solver + (contender.pads ? " with pads" : "");
}

HoldResult run(const simulation::engines::EngineRegistry& registry, const Contender& contender,
               const HoldTest& test) {
  if (contender.world) return run_world_hold(contender.engine, test);
  const auto engine = registry.create(contender.engine);
  return run_hold(*engine, test);
}

Row table_row(const Contender& contender, const HoldTest& test, const HoldResult& result) {
  return {{"engine", contender.engine},
          {"solver", contender.solver},
          {"pads", contender.pads},
          {"world", contender.world},
          {"mass_kg", test.mass},
          {"step_ms", 1e3 * test.step},
          {"held", result.held},
          {"slip_um", 1e6 * result.slip},
          {"creep_um_s", 1e6 * result.creep},
          {"jitter_um_s", 1e6 * result.jitter},
          {"us_per_step", 1e6 * result.step_time}};
}

Findings hold(const ExperimentOptions& options, report::Page& page) {
  const simulation::engines::EngineRegistry registry;
  std::vector<Contender> contenders;
  for (const std::string& name : registry.names()) {
    for (const std::string& solver : registry.create(name)->solvers()) {
      contenders.push_back({name, solver, false});
      if (name == "native") contenders.push_back({name, solver, true});
    }
    // With pads in sub-steps the engine's contact solver has nothing to do: one will do.
    if (name != "native") contenders.push_back({name, registry.create(name)->solvers()[0], true});
  }
  for (const std::string& name : registry.names()) contenders.push_back({name, "", true, true});
  const std::vector<double> masses{0.01, 0.05, 0.3, 1, 3, 10};
  const std::vector<double> steps = options.quick
                                        ? std::vector<double>{1e-2, 1e-3}
                                        : std::vector<double>{1e-2, 5e-3, 1e-3, 5e-4, 1e-4};
  // Sub-steps are of one length whatever the step, and take long.
  const std::vector<double> substepped_steps{1e-2, 1e-3};
  Findings findings;
  findings.title = "hold test";
  std::vector<Row> cells, sums;
  for (const Contender& contender : contenders) {
    int held = 0, still = 0, cell_count = 0;
    const bool substepped = contender.pads && !contender.world && contender.engine != "native";
    double worst_slip = 0, time = 0;
    for (const double mass : masses) {
      for (const double step : substepped ? substepped_steps : steps) {
        HoldTest test;
        test.mass = mass;
        test.step = step;
        test.solver = contender.solver;
        test.pads = contender.pads;
        const HoldResult result = run(registry, contender, test);
        ++cell_count;
        held += result.held;
        still += result.held && std::abs(result.slip) < 1e-6;
        if (result.held) worst_slip = std::max(worst_slip, std::abs(result.slip));
        time += result.step_time;
        cells.push_back(table_row(contender, test, result));
      }
    }
    const auto count = static_cast<double>(cell_count);
    sums.push_back({{"engine", contender.engine},
                    {"solver", contender.solver},
                    {"pads", contender.pads},
                    {"world", contender.world},
                    {"cells", count},
                    {"held", static_cast<double>(held)},
                    {"held_within_1_um", static_cast<double>(still)},
                    {"worst_slip_of_held_um", 1e6 * worst_slip},
                    {"mean_us_per_step", 1e6 * time / count}});
    findings.summary.push_back({name_of(contender), std::to_string(held) + " of " +
                                                        std::to_string(cell_count) + " held, " +
                                                        std::to_string(still) + " within 1 um"});
  }
  for (const auto& problem : registry.problems()) {
    findings.summary.push_back({problem.file.filename().string(), problem.reason});
  }
  page.add_paragraph(
      "A 50 mm cube between two 50 g jaws, friction 0.8, pressed with 1.2 m g / (2 mu), for 10 s. "
      "Slip is measured over the last 5 s.");
  add_table(page, sums);
  page.add_heading("Each cell");
  add_table(page, cells);
  findings.tables = {{"engines", sums}, {"runs", cells}};
  return findings;
}

}  // namespace

int main(int argc, char** argv) {
  return run_experiment(argc, argv, "Hold test of physics engines", hold);
}
